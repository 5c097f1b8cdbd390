"""The period of the lay, the spacing of grooves or dimples, and the sides with a whole number of them."""

import math

import numpy as np

from roughcontact.kernels.fourier import sums_of_products
from roughcontact.surface.window.sides import is_friendly

_MIN_CORRELATION = 0.3  # autocorrelation after one period that a surface with a lay period must reach
_MAXIMUM_SHARE = 0.8  # of the highest maximum: the first maximum that reaches it marks the period
_MAX_LINES = 64  # evaluated
_MIN_PERIODS = 4  # that must fit into the map
_SHORTEST = 0.7  # share of a side that is left at least
_TOLERANCE = 0.1  # periods: deviation of a side from a whole number of them


def lay_period(values: np.ndarray, axis: int) -> float | None:
    """Return the period of the lay, in points, along an axis of a map without missing points, or None.

    It is the lag of the first maximum of the autocorrelation (mean over lines) beyond its zero that reaches
    0.8 of the highest one; that must reach 0.3, and more than four periods must fit into the map.
    """
    from scipy.signal import find_peaks

    lines = np.moveaxis(values, axis, -1)
    lines = lines[:: max(1, len(lines) // _MAX_LINES)]  # so many lines show a period as well as all of them
    points = lines.shape[-1]
    lines = lines - lines.mean(axis=1, keepdims=True)
    reach = points // _MIN_PERIODS
    # by the number of pairs at each shift, so that the correlation does not fall with it
    correlation = sums_of_products(lines)[: reach + 1] / (points - np.arange(reach + 1))
    # the maximum at shift 0 ends where the correlation changes sign
    negative = np.nonzero(correlation < 0)[0]
    if not negative.size:
        return None
    highest = correlation[negative[0] :].max()
    # later maxima may be a little higher by chance; the first that is nearly as high is one period
    maxima, _ = find_peaks(correlation, height=_MAXIMUM_SHARE * highest)
    later = maxima[maxima > negative[0]]
    if highest < _MIN_CORRELATION * correlation[0] or not later.size:
        return None
    top = int(later[0])
    lower, peak, upper = correlation[top - 1 : top + 2]
    # the vertex of the parabola through the maximum and its neighbours
    return float(top + (lower - upper) / (2 * (lower - 2 * peak + upper)))


def side_of_whole_periods(longest: int, period: float | None) -> int:
    """Return the longest side (points) with a fast transform and whole periods, else `longest`."""
    if period is None:
        return longest
    sides = np.arange(longest, math.ceil(_SHORTEST * longest) - 1, -1)
    is_whole = np.abs(sides / period - np.rint(sides / period)) <= _TOLERANCE
    return next(filter(is_friendly, sides[is_whole].tolist()), longest)
