"""Percolation of the gap, and the narrowest place that a fluid must pass."""

from bisect import bisect_left

import numpy as np

from roughcontact.kernels.choose import library_available
from roughcontact.kernels.compiled import Regions
from roughcontact.statistics.sealing.connectivity import percolates

_SAMPLE = 4096  # points that narrow the range of levels before all heights in that range are sorted


def percolation_columns(gap: np.ndarray) -> dict[str, float]:
    """Return whether a periodic gap (ny, nx; m) percolates along x and y, and its critical constrictions (m).

    This is the largest height that an open path around the period keeps everywhere (Persson and Yang 2008, J.
    Phys. Condens. Matter 20, 315011), exactly, by bisection; 0 without percolation.
    """
    levels = dict(zip("xy", reversed(_levels(gap)), strict=True))
    is_open = {f"gap_percolates_{axis}": int(level > 0) for axis, level in levels.items()}
    return is_open | {f"critical_constriction_{axis}": level for axis, level in levels.items()}


def half_way_levels(gap: np.ndarray) -> dict[str, float]:
    """Return the critical constrictions (m) of paths within a map (y, x; m) that are half as long as the map.

    A path around the period has to match at its seam, where a groove that leaves the map is cut; the largest
    of three overlapping halves does not.

    Examples
    --------
    A groove that leaves at another place than it enters, and so ends at the seam:

    >>> import numpy as np
    >>> gap = np.zeros((4, 8))
    >>> gap[[0, 0, 1, 1, 2, 2, 3, 3], range(8)] = gap[[0, 1, 2], [2, 4, 6]] = 2.0
    >>> half_way_levels(gap)["critical_constriction_x"], percolation_columns(gap)["critical_constriction_x"]
    (2.0, 0.0)
    """
    return {f"critical_constriction_{axis}": _best_half(gap if axis == "y" else gap.T) for axis in "xy"}


def _best_half(gap: np.ndarray) -> float:
    """Return the largest critical constriction, from end to end, of three halves along the first axis."""
    points = gap.shape[0]
    half = max(points // 2, 1)  # a single point is no less
    level = 0.0
    for start in sorted({0, (points - half) // 2, points - half}):
        # an open row joins both ends, a closed column separates both sides
        extended_gap = np.zeros((half + 1, gap.shape[1] + 1))
        extended_gap[:-1, :-1] = gap[start : start + half]
        extended_gap[-1, :-1] = extended_gap.max()
        (level,) = _levels(extended_gap, axes=(0,), above=level)
    return level


def _levels(gap: np.ndarray, *, axes: tuple[int, ...] = (0, 1), above: float = 0.0) -> list[float]:
    """Return the critical constriction along y and along x; `above` where it is no larger."""
    regions = Regions(gap) if library_available() else None

    def open_along(level: float) -> tuple[bool, bool]:
        """Return whether a region at least this high runs around along y, and along x."""
        return regions.percolates(level) if regions else percolates(gap >= level)

    heights = gap.ravel()
    # of each axis: a level at which it is open, or `above`, and one at which it is closed
    is_open, closed_above = [above, above], [np.inf, np.inf]

    def is_closed(level: float, axis: int) -> bool:
        """Return whether an axis is closed at a level, which narrows the range of both."""
        for side, around in enumerate(open_along(level)):
            if around:
                is_open[side] = max(is_open[side], level)
            else:
                closed_above[side] = min(closed_above[side], level)
        return is_open[axis] < level

    # the next number above the level: open there means open at all
    lowest = open_along(np.nextafter(heights.dtype.type(above), heights.dtype.type(np.inf)))
    sample = heights[:: max(1, heights.size // _SAMPLE)]
    for axis in axes:
        # a sample brackets the level cheaply; all heights within the bracket find it exactly
        for values in (sample, heights) if lowest[axis] else ():
            levels = np.sort(values[(values > is_open[axis]) & (values < closed_above[axis])])
            bisect_left(range(levels.size), True, key=lambda i: is_closed(float(levels[i]), axis))
    return [is_open[axis] for axis in axes]
