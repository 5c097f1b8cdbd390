"""How well each answer is known: the width of its 95 % interval, as a number and in words."""

import math

import numpy as np
import xarray as xr

from roughcontact.quantities import Unit, number
from roughcontact.variables import ANSWERS, Numbers

PERCENT, FACTOR, MAGNITUDE = 30, 3.0, 10.0  # widest: half-width in percent of the value, end over value
# percents are rounded up: unrounded 90 % of such answers of measured maps hold, rounded 93 %
_STEP, _SMALLEST_PERCENTS = 5, 10
_CONDUCTANCE = "conductance_per_conductivity"
_HARDNESS_ROUNDING = 1e-9


def relative_half_width(
    value: np.ndarray | float, lower: np.ndarray | float, upper: np.ndarray | float
) -> np.ndarray:
    """Return the larger half-width of an interval over the value; NaN without a value or an end.

    Examples
    --------
    >>> relative_half_width(np.array([2.0, 2.0]), np.array([1.5, 1.5]), np.array([2.4, np.nan])).tolist()
    [0.25, nan]
    """
    positive = np.where(np.greater(value, 0), value, np.nan)
    half_width = np.maximum(np.subtract(value, lower), np.subtract(upper, value))
    return np.where(half_width == 0, 0.0, half_width / positive)  # of a gap that is closed everywhere, too


def precision(value: float, lower: float, upper: float) -> tuple[str, float]:
    """Return the class of precision of a number with an interval, and its percents, factor or bound.

    Examples
    --------
    >>> [precision(1.0, *ends) for ends in ((0.98, 1.01), (0.83, 1.1), (0.5, 1.2), (0.2, 3.0), (0.0, 1.5))]
    [('percent', 10.0), ('percent', 20.0), ('factor', 2.0), ('magnitude', 10.0), ('at most', 1.5)]
    """
    if lower == value == upper:
        return "exactly", 0.0
    if value > 0 and not math.isnan(lower + upper):
        half_width, factor = max(value - lower, upper - value) / value, math.inf
        percents = max(_SMALLEST_PERCENTS, _STEP * math.ceil(100 * half_width / _STEP - 1e-9))
        if percents <= PERCENT:
            return "percent", float(percents)
        if lower > 0:
            factor = max(upper / value, value / lower)
        if factor <= MAGNITUDE:
            return ("factor", factor) if factor <= FACTOR else ("magnitude", MAGNITUDE)
    if math.isfinite(upper):
        return "at most", upper
    return ("at least", lower) if lower > 0 else ("not", math.nan)


def precision_in_words(value: float, lower: float, upper: float, unit: Unit) -> str:
    """Return how well a number is known by its interval; empty without an interval."""
    if math.isnan(lower) and math.isnan(upper):
        return ""
    precision_class, limit = precision(value, lower, upper)
    if precision_class == "percent":
        return f"to ± {limit:.0f} %"
    if precision_class == "factor":
        return f"to a factor {number(limit, digits=2)}"
    if precision_class in ("at most", "at least"):
        trivial = unit.symbol == "%" and limit * unit.factor >= 99.95  # all of the area
        bound = unit.text(float(f"{limit:.3g}"))
        return "not by this map" if trivial else f"not by this map: {precision_class} {bound}"
    return {"exactly": "exactly", "magnitude": "order of magnitude"}.get(precision_class, "not by this map")


def gap_is_decided(numbers: Numbers, axis: str) -> np.ndarray:
    """Return per load 1 where the interval of the narrowest place is all open or all closed, 0 where not.

    NaN without an interval; one without an upper end is open there.
    """
    name = f"critical_constriction_{axis}"
    per_load = next(numbers[name_] for name_ in ("mean_pressure", "mean_gap") if name_ in numbers)
    unknown = np.full(np.shape(per_load), np.nan)
    lower, upper = (np.asarray(numbers.get(f"{name}_{end}", unknown), float) for end in ("lower", "upper"))
    one_sided = (lower > 0) | (upper <= 0)
    return np.where(np.isnan(lower), np.nan, one_sided)


def yield_is_decided(numbers: Numbers) -> np.ndarray:
    """Return per load 1 where the interval of the largest pressure lies on one side of the hardness, else 0.

    Where points carry the hardness, all parts of the window must, or the lower end; NaN if one is unknown.
    """
    limit = float(numbers.get("hardness", np.nan)) * (1 - _HARDNESS_ROUNDING)
    value, lower, upper = (
        np.asarray(numbers.get(f"max_pressure{end}", np.nan), float) for end in ("", "_lower", "_upper")
    )
    everywhere_above = lower >= limit
    if "max_pressure_parts" in numbers:
        subwindows = np.asarray(numbers["max_pressure_parts"], float)
        judged = np.isfinite(subwindows).any(axis=0)
        everywhere_above = everywhere_above | (judged & (np.fmin.reduce(subwindows, axis=0) >= limit))
    one_sided = np.where(value >= limit, everywhere_above, upper < limit)
    return np.where((np.isnan(lower) & np.isnan(upper)) | np.isnan(limit), np.nan, one_sided)


def with_precision(statistics: xr.Dataset) -> xr.Dataset:
    """Return the statistics with `{answer}_known` (load): the relative half-width of each answer.

    Of sealing and yield, which are yes or no, it is 0 where the interval lies on one side, else NaN.
    """
    precision_columns = {}
    for answer in ANSWERS:
        name = _CONDUCTANCE if answer == "conductance" else answer
        if f"{name}_lower" in statistics:
            value, lower, upper = (statistics[f"{name}{end}"].values for end in ("", "_lower", "_upper"))
            precision_columns[answer] = relative_half_width(value, lower, upper)
    if "critical_constriction_x_lower" in statistics:
        decided = [gap_is_decided(statistics, axis) for axis in "xy"]
        precision_columns["sealing"] = np.where((decided[0] == 1) & (decided[1] == 1), 0.0, np.nan)
    if "hardness" in statistics and "max_pressure_lower" in statistics:
        precision_columns["yield"] = np.where(yield_is_decided(statistics) == 1, 0.0, np.nan)
    return statistics.assign(
        {f"{answer}_known": ("load", values) for answer, values in precision_columns.items()}
    )
