"""What is allowed: the totals of a seal or a joint, and whether they hold, by their intervals over the loads.

What may be allowed is a row of `arguments.answers.ALLOWED_VALUES`, what is a total one of `TOTALS`.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from roughcontact.arguments.answers import ALLOWED_VALUES, ENDS, OPPOSITE_ENDS, TOTALS
from roughcontact.arguments.variables import Numbers
from roughcontact.statistics.decisions import is_lifted, lifting_pressure
from roughcontact.statistics.kinds import reason_without_flow

Ends = Sequence[npt.ArrayLike] | np.ndarray  # value, lower and upper end (load)
# ratio of two loads between which a power law gives bounds, to 4 % of a load for gaps and 10 % for leaks;
# ten times apart a leak falls by it to what it allows at two thirds of the load
_CLOSE = 2.0 * (1 + 1e-9)


def compare(
    load: npt.ArrayLike, ends: Ends, *, allowed: float, trend: int = -1
) -> tuple[np.ndarray, np.ndarray]:
    """Return where a number is at most what is `allowed` (load), and from which load on, with its bounds (3).

    The first is 1 where the whole interval of the number, by its value, lower and upper end, is at most what
    is allowed, 0 where it is above, else NaN. Then come the load from which on the number holds (up to which,
    if it rises), and the bounds of that load by the interval. Beyond the loads nothing is known: the first of
    these is the first load where the number holds at all of them, NaN where at none; the bounds are what the
    loads prove, else 0 or NaN.

    It falls with the load, or another abscissa (`trend` -1), or rises (1): what one load decides, heavier or
    lighter ones share, also those without a number. An end that is not known bounds nothing. Between two
    loads it is the power law through both, beside a value of 0 nothing is; where one is more than twice the
    other, the bounds are these loads.

    Examples
    --------
    A leak that falls as the square of the load, known to a factor 2, of which 1 is allowed:

    >>> load = np.array([1.0, 2.0, 4.0])
    >>> holds, from_load = compare(load, (4 / load**2, 2 / load**2, 8 / load**2), allowed=1.0)
    >>> holds, from_load.round(2)
    (array([ 0., nan,  1.]), array([2.  , 1.41, 2.83]))
    """
    # from where it is least likely to hold to where it is most
    order = np.argsort(-trend * np.asarray(load, float), kind="stable")
    loads = np.asarray(load, float)[order]
    value, lower, upper = (np.asarray(values, float)[order] for values in ends)
    # a monotone number cannot be lower at a load than at the next one, whatever each interval says
    lower = np.maximum.accumulate(np.nan_to_num(lower, nan=-np.inf)[::-1])[::-1]
    upper = np.minimum.accumulate(np.nan_to_num(upper, nan=np.inf, posinf=np.inf))
    holds = np.full(loads.shape, np.nan)
    agree = lower <= upper  # ends that contradict each other decide nothing
    holds[order] = np.where(agree & (upper <= allowed), 1.0, np.where(agree & (lower > allowed), 0.0, np.nan))
    everywhere, nowhere = (0.0, np.nan) if trend < 0 else (np.nan, 0.0)  # nothing bounds it beyond the loads
    of_lower = _crossing(loads, lower, allowed, beyond=(everywhere, loads[-1]), side=0, close=_CLOSE)
    of_upper = _crossing(loads, upper, allowed, beyond=(loads[0], nowhere), close=_CLOSE)
    known = ~np.isnan(value)  # what is not known of a load follows from the others
    crossing = np.nan
    if known.any():
        crossing = _crossing(loads[known], value[known], allowed, beyond=(loads[known][0], np.nan))
    return holds, np.array([crossing, *((of_lower, of_upper) if trend < 0 else (of_upper, of_lower))])


def _crossing(
    loads: np.ndarray,
    end: np.ndarray,
    allowed: float,
    *,
    beyond: tuple[float, float],
    side: int = 1,
    close: float = np.inf,
) -> float:
    """Return the load from which on an end is at most what is allowed.

    `beyond` has what is returned where that is everywhere, and nowhere; of two loads without a power law
    between them, or with a ratio above `close`, `side` 1 is the one where it holds.
    """
    above = np.flatnonzero(~(end <= allowed))
    if not above.size:
        return beyond[0]
    if (last := above[-1]) == end.size - 1:
        return beyond[1]
    (start, stop), ratio = end[last : last + 2], loads[last + 1] / loads[last]
    # no power law passes through zero or infinity
    if not (stop > 0 and np.isfinite(start) and max(ratio, 1 / ratio) <= close):
        return float(loads[last + side])
    # between two loads the number is a power of the load
    return float(loads[last] * ratio ** (np.log(start / allowed) / np.log(start / stop)))


def with_allowed(
    statistics: xr.Dataset, settings: Mapping[str, Any], *, area: float | None = None
) -> xr.Dataset:
    """Return statistics with the totals of seal and joint, and whether what is allowed holds.

    `settings` is their section (SI), `area` (m2) that of the contact, for joints without one. Added:
    `joint_area`, `TOTALS`, and for each allowed value `allowed_{name}`, `{name}_holds` (load: 1, 0, NaN
    where it is not decided) and `{name}_holds_from` (Pa), the mean pressure from which on it holds (up to
    which, of a pressure), with `_lower` and `_upper`.

    Examples
    --------
    >>> leaks = {f"leak_rate_x{suffix}": ("load", [4e-9, 1e-9]) for suffix in ENDS}
    >>> statistics = xr.Dataset(leaks, {"mean_pressure": ("load", [1e6, 2e6])})
    >>> found = with_allowed(statistics, {"seal": {"perimeter": 0.1, "allowed_leak": 2e-10}})
    >>> found["leak_holds"].values, round(found["leak_holds_from"].item() / 1e6, 2)
    (array([0., 1.]), 1.41)
    """
    properties: dict[str, Any] = {"area": area}
    required = {f"allowed_{name}": limit for name, limit in (settings.get("requirement") or {}).items()}
    for section in (settings, settings.get("seal") or {}, settings.get("joint") or {}, required):
        properties |= {key: entry for key, entry in section.items() if entry is not None}
    complete = statistics.assign(_totals(statistics, properties))
    joint_area = (settings.get("joint") or {}).get("area")
    columns: dict[str, Any] = {"joint_area": joint_area} if joint_area else {}
    for name, allowed in ALLOWED_VALUES.items():
        limit = properties.get(f"allowed_{name}")
        if limit is None or not any(number in complete for number in allowed.numbers):
            continue
        if allowed.answer == "sealing" and reason_without_flow(statistics):  # that is not judged
            continue
        loads, bounds = complete["mean_pressure"].values, compared_ends(complete, name)
        holds, from_load = compare(loads, bounds, allowed=limit**allowed.sense, trend=allowed.trend)
        # what the fluid lifts does not hold, whatever the gap without it
        holds = np.where(is_lifted(complete, name), 0.0, holds)
        from_load = np.maximum(from_load, lifting_pressure(complete, name))
        columns |= {f"allowed_{name}": limit, f"{name}_holds": ("load", holds)}
        columns |= {f"{name}_holds_from{suffix}": load for suffix, load in zip(ENDS, from_load, strict=True)}
    return complete.assign(columns)


def compared_ends(statistics: Numbers, name: str) -> np.ndarray:
    """Return what is compared with an allowed value, by its value, lower and upper end (3, load).

    It is the largest of its numbers, NaN for an end that is not there; the reciprocal of what has to be at
    least as large, so that it is at most what is allowed.
    """
    allowed = ALLOWED_VALUES[name]
    numbers = [number for number in allowed.numbers if number in statistics]
    nan = np.full(np.shape(statistics[numbers[0]]), np.nan)
    bounds = [
        np.max([statistics.get(f"{number}{suffix}", nan) for number in numbers], axis=0) for suffix in ENDS
    ]
    with np.errstate(divide="ignore"):
        # the ends of a reciprocal change places
        return np.array(bounds) if allowed.sense > 0 else 1 / np.array(bounds)[[0, 2, 1]]


def _totals(statistics: xr.Dataset, properties: Mapping[str, Any]) -> dict[str, xr.DataArray]:
    """Return the totals, with their ends, of what is stated of seal or joint."""
    numbers = statistics.assign(_resistance_of_joint(statistics))
    return {
        f"{total}{suffix}": numbers[f"{name}{suffix}"]
        * np.prod([properties[key] ** power for key, power in powers.items()])
        for total, (name, powers) in TOTALS.items()
        for suffix in ENDS
        if f"{name}{suffix}" in numbers and all(properties.get(key) for key in powers)
    }


def _resistance_of_joint(statistics: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return the thermal resistance times area: of the contact alone, or with film and gas."""
    if "joint_conductance" not in statistics:
        names = {f"resistance_of_joint{suffix}": f"thermal_resistance{suffix}" for suffix in ENDS}
        return {key: statistics[name] for key, name in names.items() if name in statistics}
    with np.errstate(divide="ignore"):
        resistances = {
            f"resistance_of_joint{suffix}": 1 / statistics[name]
            for suffix in ENDS
            if (name := f"joint_conductance{OPPOSITE_ENDS[suffix]}") in statistics
        }
    if (lower := "resistance_of_joint_lower") in resistances:
        # a conductance without an upper end leaves a resistance down to none
        resistances[lower] = resistances[lower].fillna(0.0)
    return resistances
