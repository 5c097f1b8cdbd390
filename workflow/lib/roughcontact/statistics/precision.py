"""How well each answer is known: the width of its 95 % interval, as a number and in words."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ANSWERS, ENDS
from roughcontact.arguments.quantities import number
from roughcontact.statistics.decisions import gap_is_closed, is_yielding

PERCENT, FACTOR, MAGNITUDE = 30, 3.0, 10.0  # widest: half-width in percent of the value, end over value
# percents and factors are rounded up: unrounded 90 % of such answers of measured maps hold, rounded 93 %
_STEP, _SMALLEST_PERCENTS, _STEP_OF_FACTOR = 5, 10, 0.1


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


def widened(value_and_ends: Sequence[Any], factors: Sequence[Any]) -> tuple[Any, Any]:
    """Return the ends of the interval of a product, from those of one factor and of another, independent one.

    `factors` are the ends of the other over its value. Distances on the logarithm add in quadrature.

    Examples
    --------
    >>> [float(end) for end in widened((2.0, 1.0, 4.0), (1.0, 1.0))]
    [1.0, 4.0]
    """
    value, lower, upper = value_and_ends
    with np.errstate(divide="ignore", invalid="ignore"):
        # independent factors: their logarithms add in squares
        below = np.exp(np.hypot(np.log(lower / value), np.log(factors[0])))
        above = np.exp(np.hypot(np.log(upper / value), np.log(factors[1])))
        return value / below, value * above


def precision(value: float, lower: float, upper: float) -> tuple[str, float]:
    """Return the class of precision of a number with an interval, and its percents or factor.

    Examples
    --------
    >>> [precision(1.0, *ends) for ends in ((0.98, 1.01), (0.83, 1.1), (0.49, 1.2), (0.2, 3.0), (0.0, 1.5))]
    [('percent', 10.0), ('percent', 20.0), ('factor', 2.1), ('magnitude', 10.0), ('not', nan)]
    """
    if lower == value == upper:  # of a gap that is closed everywhere, of full contact
        return "percent", float(_SMALLEST_PERCENTS)
    if value > 0 and math.isfinite(lower + upper):
        half_width = max(value - lower, upper - value) / value
        percents = max(_SMALLEST_PERCENTS, _rounded_up(100 * half_width, _STEP))
        if percents <= PERCENT:
            return "percent", float(percents)
        factor = max(upper / value, value / lower) if lower > 0 else math.inf
        if factor <= MAGNITUDE:
            factor = _rounded_up(factor, _STEP_OF_FACTOR)
            return ("factor", factor) if factor <= FACTOR else ("magnitude", MAGNITUDE)
    return "not", math.nan


def _rounded_up(width: float, step: float) -> float:
    """Return the least multiple of a step that is not narrower than a width, up to rounding errors."""
    return round(step * math.ceil(width / step - 1e-9), 9)


def is_known(value: float, lower: float, upper: float) -> bool:
    """Return whether an interval leaves the order of magnitude of a number, or less, open."""
    return precision(value, lower, upper)[0] != "not"


def precision_in_words(value: float, lower: float, upper: float) -> str:
    """Return how well a number is known by its interval; empty without one.

    Examples
    --------
    >>> precision_in_words(1.0, 0.83, 1.1)
    'to ± 20 %'
    """
    if math.isnan(lower) and math.isnan(upper):
        return ""
    kind, limit = precision(value, lower, upper)
    if kind == "percent":
        return f"to ± {limit:.0f} %"
    if kind == "factor":
        return f"to a factor {number(limit, digits=2)}"
    return "order of magnitude" if kind == "magnitude" else "worse than a factor of 10"


def add_precision(statistics: xr.Dataset) -> xr.Dataset:
    """Return the statistics with `{answer}_known` (load): the relative half-width of each answer.

    Of sealing and yield, which are yes or no, it is 0 where they are decided (`decisions`), else NaN.
    """
    widths = {}
    for name, answer in ANSWERS.items():
        if f"{answer.quantity}_lower" in statistics:
            ends = (statistics[f"{answer.quantity}{suffix}"].values for suffix in ENDS)
            widths[name] = relative_half_width(*ends)
    if "critical_constriction_x_lower" in statistics:
        # 0 times a decision: NaN where there is none
        widths["sealing"] = 0 * np.add(*(gap_is_closed(statistics, axis) for axis in "xy"))
    if "hardness" in statistics and "max_pressure_lower" in statistics:
        widths["yield"] = 0 * is_yielding(statistics)
    return statistics.assign({f"{answer}_known": ("load", width) for answer, width in widths.items()})
