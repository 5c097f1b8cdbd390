"""What would halve the interval of a surface: one line, from the components of the contact area."""

import json
import math

import numpy as np
import scipy
import xarray as xr

from roughcontact.quantities import counted_noun, number, percent, quantity
from roughcontact.statistics.outcome import CheckName
from roughcontact.statistics.precision import relative_half_width
from roughcontact.uncertainty.combination import SOURCES
from roughcontact.uncertainty.random_effects import student
from roughcontact.uncertainty.scales import AREA, from_scale, to_scale

_TYPICAL_AREA = 0.1  # the load with the contact area nearest to it is improved
_MOST_MAPS = 100
_LONGEST_FIELD = 10.0  # over the length of the map
ADVICE = {
    "solver": "set contact.tolerance to a tenth",
    "discretisation": "measure with pixels half as large",
    "instrument": "repeat the measurement and average, or state the instrument more narrowly",
    "material": "state contact modulus and load twice as narrowly",
    "unresolved": "measure with pixels half as large, or state instrument.finer_spectrum",
}
_LONGER_FIELD = "measure a field 3 times as long"


def half_width_of_mean(scatter: float, maps: int, shared: float) -> float:
    """Return the median relative half-width of the mean of so many maps, with the errors that all share."""
    freedom = np.array(maps - 1.0)
    factor = float(student(freedom) * median_of_chi(freedom))
    return math.hypot(factor * scatter / math.sqrt(maps), shared)


def median_of_chi(freedom: np.ndarray) -> np.ndarray:
    """Return the median of an estimated standard deviation over the true one, by its degrees of freedom."""
    return np.sqrt(2 * scipy.special.gammaincinv(freedom / 2, 0.5) / freedom)


def maps_to_halve(scatter: float, half_width: float, shared: float) -> int | None:
    """Return how many maps in all bring the relative half-width to half; None for more than a hundred.

    Examples
    --------
    Student's factors of n - 1 over the root of n, times the median of chi over its degrees of freedom
    (tables of both distributions): 1.14 of 5 maps.

    >>> maps_to_halve(0.1, 0.23, 0.0), maps_to_halve(0.1, 0.2, 0.1)
    (5, None)
    """
    counts = range(2, _MOST_MAPS + 1)
    return next((n for n in counts if half_width_of_mean(scatter, n, shared) <= half_width / 2), None)


def with_halving(statistics: xr.Dataset, scatter: np.ndarray | None) -> xr.Dataset:
    """Return the statistics with the attribute `halve`; `scatter` (load) is that of maps of this size."""
    line = halving_line(statistics, scatter)
    return statistics.assign_attrs(halve=line) if line else statistics


def halving_line(statistics: xr.Dataset, scatter: np.ndarray | None) -> str:
    """Return what would halve the interval of the contact area near 10 %; empty without an interval.

    `scatter` (load) is the standard deviation of the area between maps of this size, on its scale.
    """
    if f"{AREA}_components" not in statistics:
        return ""
    areas = np.maximum(statistics[AREA].values, 1e-300)
    load = int(np.abs(np.log(areas / _TYPICAL_AREA)).argmin())
    at_load = statistics.isel(load=load)
    value, lower, upper = (float(at_load[f"{AREA}{end}"]) for end in ("", "_lower", "_upper"))
    half_width = float(relative_half_width(value, lower, upper))
    widths = _relative_widths(at_load, value)
    first, advice = _advice(statistics)
    if not math.isfinite(half_width) or not widths.get("window", 0.0) < math.inf:
        return "; ".join([*first, _LONGER_FIELD])
    if "window" in widths:
        of_area = math.nan if scatter is None else float(np.ravel(scatter)[load]) * _slope(value)
        shared = math.sqrt(sum(width**2 for source, width in widths.items() if source != "window"))
        advice["window"] = _more_places(of_area, half_width, shared, widths["window"])
    by_size = sorted(widths, key=widths.__getitem__, reverse=True)
    actions = [*first]
    for rank, source in enumerate(by_size, start=1):
        actions.append(advice[source])
        remaining = math.sqrt(sum(widths[name] ** 2 for name in by_size[rank:]))
        if remaining <= half_width / 2:
            break
    return "; ".join(dict.fromkeys(actions))


def _advice(statistics: xr.Dataset) -> tuple[list[str], dict[str, str]]:
    """Return what comes first, if anything, and source -> what halves its part, by checks and settings."""
    attrs, advice = statistics.attrs, {**ADVICE}
    doubted = {entry["check"] for entry in json.loads(attrs.get("reasons", "[]"))}
    if not any(key.startswith("instrument_") for key in attrs):
        advice["instrument"] = (  # of rounded heights, or a suspected noise
            "export the heights in finer steps, or measure the place twice (repeat_of), which tells the noise"
        )
    if CheckName.SMOOTHED in doubted:
        advice = dict.fromkeys(advice, "state the lens (instrument.numerical_aperture)")
    if CheckName.ISOLATED_PEAK not in doubted or "summit_x" not in attrs:
        return [], advice
    x, y = (quantity(float(attrs[f"summit_{axis}"]), "m") for axis in "xy")
    return [f"clean the summit at ({x}, {y})"], advice


def _slope(area: float) -> float:
    """Return d ln A over d of the scale of the area."""
    middle, step = to_scale(AREA, np.array(area)), 1e-3
    ends = np.log(from_scale(AREA, middle + np.array([-step, step])))
    return float(ends[1] - ends[0]) / (2 * step)


def _relative_widths(at_load: xr.Dataset, value: float) -> dict[str, float]:
    """Return the half-width of each source over the value; infinite where nothing bounds it."""
    unbounded = at_load[f"{AREA}_components"].isnull().any("component").values
    widths = np.where(unbounded, np.inf, at_load[f"{AREA}_uncertainty"].values / value)
    by_source = dict(zip(at_load["source"].values, map(float, widths), strict=True))
    return {source: by_source[source] for source in SOURCES if not math.isnan(by_source[source])}


def _more_places(scatter: float, half_width: float, shared: float, of_window: float) -> str:
    """Return how many more maps of this size, or how much longer a field, halve the interval."""
    if math.isnan(scatter):
        return _LONGER_FIELD
    target = half_width / 2 if shared < half_width / 2 else math.hypot(shared, of_window / 2)
    maps = maps_to_halve(scatter, 2 * target, shared)
    longer = of_window / math.sqrt(max(target**2 - shared**2, 1e-300))
    field = f"a field {number(longer, digits=2)} times as long" if longer <= _LONGEST_FIELD else ""
    if maps is None:
        return f"measure {field}" if field else "measure more places"
    promised = half_width_of_mean(scatter, maps, shared)
    text = f" (their mean: to about ± {percent(promised)})" if promised < 1 else ""
    action = f"measure {counted_noun(maps - 1, 'more place')} of this size{text}"
    return f"{action}, or {field}" if field else action
