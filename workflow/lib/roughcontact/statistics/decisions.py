"""Yes or no, and when it is decided: whether the gap is closed to a fluid, and whether a body yields.

Both are monotone in the load: a gap that is closed for certain stays closed under more of it, and a body that
yields goes on; what is certainly open, or elastic, was so under less.
"""

import numpy as np

from roughcontact.arguments.answers import ALLOWED_VALUES, AREA, ENDS, GAP, PEAK, PRESSURE
from roughcontact.arguments.variables import Numbers, has_number
from roughcontact.statistics.kinds import facts_of_numbers
from roughcontact.surface.roughness.texture import LAY

CLOSED = 1e-9  # m; an opening below it, some molecules, is closed
# m2/s, of a leak that counts as none: for a liquid as water a tenth of the tightness class L0.01 of EN 13555,
# 0.01 mg/(s m)
TIGHT = 1e-12
# contact area below which a gap is open, with a lay and without (Str). Of the parts of the measured maps of
# `benchmarks/results/bank` below it, 3 × 3 a map, along x and along y, 1273 of 1292 and 637 of 642 are open.
OPEN_BELOW = (0.1, 0.3)
# share of the parts of a window that may differ from the window itself, and the least number of parts: where
# all but two of eight parts of those maps are as the window, the ninth is in 2944 of 3029 cases
_MAX_DIFFERENT, _MIN_PARTS = 0.25, 6
_REACHED = 1 - 1e-9  # of the hardness: what reaches it up to rounding has reached it


def closed_opening(numbers: Numbers, axis: str) -> np.ndarray:
    """Return per load the narrowest place (m) up to which a gap is closed along an axis.

    That is `CLOSED`, or the wider one that leaks `TIGHT`: a leak goes with the cube of its narrowest place.

    Examples
    --------
    >>> narrowest = {"critical_constriction_x": [1e-7], "mean_pressure": [1e6]}
    >>> closed_opening(narrowest | {"leak_rate_x": [8e-12]}, "x"), closed_opening(narrowest, "x")
    (array([5.e-08]), array([1.e-09]))
    """
    opening, leak = (_of_loads(numbers, f"{name}_{axis}") for name in ("critical_constriction", "leak_rate"))
    with np.errstate(divide="ignore", invalid="ignore"):
        by_cube = np.where(leak > 0, leak / opening**3, _number(numbers, "leak_rate_by_cube"))
        return np.fmax(CLOSED, np.cbrt(TIGHT / by_cube))


def lifting_pressure(numbers: Numbers, name: str = "leak") -> float:
    """Return the mean pressure (Pa) below which a fluid opens what an allowed value is of; 0 for none."""
    of_seal = ALLOWED_VALUES[name].answer == "sealing"
    return float(np.nan_to_num(_number(numbers, "fluid_pressure"))) if of_seal else 0.0


def is_lifted(numbers: Numbers, name: str = "leak") -> np.ndarray:
    """Return per load whether the fluid presses more than the bodies, and opens what a value is of.

    Examples
    --------
    >>> seal = {"fluid_pressure": 5e5, "mean_pressure": [2e5, 1e6]}
    >>> is_lifted(seal), is_lifted(seal, "gap")
    (array([ True, False]), array([False, False]))
    """
    return _of_loads(numbers, "mean_pressure") < lifting_pressure(numbers, name)


def gap_is_closed(numbers: Numbers, axis: str) -> np.ndarray:
    """Return per load 1 where the gap is closed along an axis for certain, 0 where it is open, else NaN.

    It is closed in full contact, and where the upper end of the narrowest place is at most `closed_opening`,
    open where its lower end is above; either where nearly all parts of the window, which are smaller, are as
    the window. Where the upper end of the contact area is below `OPEN_BELOW` the gap is open around islands,
    and its narrowest place is known at least as well as its mean. A fluid opens what it lifts (`is_lifted`).

    Examples
    --------
    >>> narrowest = {"critical_constriction_x": [5e-8, 2e-8, 0.0], "mean_pressure": [1e5, 2e5, 3e5]}
    >>> ends = {f"critical_constriction_x_{suffix}": [0.0, 0.0, 0.0] for suffix in ("lower", "upper")}
    >>> area = {"relative_contact_area_upper": [0.08, 0.4, 0.9], "Str": 0.2}
    >>> ends["critical_constriction_x_upper"] = [1e-7, 5e-8, 5e-10]
    >>> gap_is_closed(narrowest | ends | area, "x")
    array([ 0., nan,  1.])
    """
    name = f"critical_constriction_{axis}"
    value, lower, upper = (_of_loads(numbers, f"{name}{suffix}") for suffix in ENDS)
    limit = closed_opening(numbers, axis)
    full = _of_loads(numbers, f"{AREA}_lower") >= 1
    without_lay = float(np.asarray(numbers.get("Str", np.nan))) > LAY
    # with a lay, or where its direction is unknown, the lower of both limits
    areas, upper_areas = (_of_loads(numbers, f"{AREA}{suffix}") for suffix in ("", "_upper"))
    has_islands = (value > CLOSED) & (upper_areas < OPEN_BELOW[without_lay])
    # an overview tells of the mean gap, and not of the narrowest place of this map
    of_map = f"{GAP}_alone" if has_number(numbers, f"{GAP}_alone") else GAP
    mean, *bounds = (_of_loads(numbers, f"{of_map}{suffix}") for suffix in ENDS)
    with np.errstate(divide="ignore", invalid="ignore"):  # no gap is left of full contact
        lowest, highest = (np.where(has_islands, value * bound / mean, np.nan) for bound in bounds)
    closed_parts, open_parts = _shares(numbers, f"{name}_parts", limit)
    yes = full | (np.fmin(upper, highest) <= limit)
    # parts that agree decide nothing against a contact area at which gaps are open
    expected = (limit > CLOSED) | ~(areas < OPEN_BELOW[without_lay])
    yes |= (value <= limit) & (closed_parts >= 1 - _MAX_DIFFERENT) & expected
    no = (np.fmax(lower, lowest) > limit) | (has_islands & (limit <= CLOSED))
    no |= (value > limit) & (open_parts >= 1 - _MAX_DIFFERENT)
    lifted = is_lifted(numbers)
    return _monotone(numbers, yes=yes & ~lifted, no=no | lifted)


def _shares(numbers: Numbers, name: str, limit: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the shares of the parts of a window that are closed, and open; NaN where too few were solved."""
    parts = np.asarray(numbers.get(name, np.full((1, limit.size), np.nan)), float)
    count = np.isfinite(parts).sum(axis=0)
    solved = np.where(count >= _MIN_PARTS, count, np.nan)
    return (parts <= limit).sum(axis=0) / solved, (parts > limit).sum(axis=0) / solved


def is_yielding(numbers: Numbers) -> np.ndarray:
    """Return per load 1 where a body yields for certain, 0 where it does not, else NaN.

    It yields where the stress below the surface does; where the largest pressure reaches the hardness in all
    parts of the window, or so far beyond first yield that its lower end would, as the elastic one goes
    on to rise. It does not where the upper end is below the hardness. Of a hardness with a range both ends
    have to be reached, or neither.

    Examples
    --------
    >>> peak = {f"max_pressure{suffix}": [1e9, 2e9, 2e9] for suffix in ("", "_lower", "_upper")}
    >>> loads = {"mean_pressure": [1e5, 1e6, 1e7], "hardness": 2e9, "first_yield_pressure": 5e5}
    >>> is_yielding(peak | loads | {"max_pressure_lower": [7e8, 9e8, 1e9]})
    array([ 0., nan, nan])
    >>> is_yielding(peak | loads | {"max_pressure_lower": [7e8, 9e8, 1.2e9]})
    array([ 0., nan,  1.])
    """
    limit = _number(numbers, "hardness") * _REACHED
    softest = np.nan_to_num(_number(numbers, "hardness_lower") * _REACHED, nan=limit)
    hardest = np.nan_to_num(_number(numbers, "hardness_upper") * _REACHED, nan=limit)
    value, lower, upper = (_of_loads(numbers, f"{PEAK}{suffix}") for suffix in ENDS)
    below = _of_loads(numbers, "volume_above_yield")  # infinite where all of a body yields
    yield_ratio = _of_loads(numbers, "mean_pressure") / _number(numbers, "first_yield_pressure")
    # between two loads the largest pressure rises at least by this power
    rise = np.maximum(yield_ratio, 1.0) ** facts_of_numbers(numbers).power_of_largest_pressure
    of_spot = 1.5 * _of_loads(numbers, f"{PRESSURE}_lower")  # the largest of a smooth one (Hertz)
    everywhere = (lower * np.nan_to_num(rise, nan=1.0) >= softest) | (of_spot >= softest)
    if f"{PEAK}_parts" in numbers:
        parts = np.asarray(numbers[f"{PEAK}_parts"], float)
        everywhere |= np.isfinite(parts).any(axis=0) & (np.fmin.reduce(parts, axis=0) >= limit)
    # where the range of hardness has an upper end, that has to be reached
    if hardest > limit:
        everywhere &= upper >= hardest
    elastic = (value < limit) & (upper < softest) & ~(below > 0)
    if np.isnan(limit):  # the stress below the surface is all that is known
        elastic = below == 0
    return _monotone(numbers, yes=(below > 0) | ((value >= limit) & everywhere), no=elastic)


def _monotone(numbers: Numbers, *, yes: np.ndarray, no: np.ndarray) -> np.ndarray:
    """Return 1 from the lightest load on that is decided yes, 0 up to the heaviest that is decided no.

    Where the two contradict each other, neither is.
    """
    # yielding, and the closing of a gap, are not undone by more load
    order = np.argsort(_of_loads(numbers, "mean_pressure"), kind="stable")
    from_here = np.logical_or.accumulate(yes[order])
    up_to_here = np.logical_or.accumulate(no[order][::-1])[::-1]
    decision = np.full(order.shape, np.nan)
    decision[order] = np.where(from_here & ~up_to_here, 1.0, np.where(up_to_here & ~from_here, 0.0, np.nan))
    return decision


def _of_loads(numbers: Numbers, name: str) -> np.ndarray:
    """Return a number of the loads, NaN at all of them where there is none."""
    per_load = next(numbers[key] for key in ("mean_pressure", "mean_gap", PEAK) if key in numbers)
    shape = np.atleast_1d(np.asarray(per_load, float)).shape
    if name not in numbers:  # looked for first: xarray takes 20 ms to say that a name is unknown
        return np.full(shape, np.nan)
    return np.broadcast_to(np.asarray(numbers[name], float), shape)


def _number(numbers: Numbers, name: str) -> float:
    """Return a number of the surface, NaN where there is none."""
    return float(np.asarray(numbers.get(name, np.nan)))
