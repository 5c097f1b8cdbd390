"""Whether the gap is open from end to end, and the narrowest place that a fluid must pass."""

import numpy as np

from roughcontact.connectivity import runs_around
from roughcontact.kernels.choose import library_is_there
from roughcontact.kernels.compiled import Regions

_PIECES = 16  # of the points, the highest first
_SAMPLE = 4096  # points by which the pieces are cut


def percolation_columns(gap: np.ndarray) -> dict[str, float]:
    """Return whether a periodic gap lets a fluid through along each axis, and its critical constriction.

    A gap percolates along x where some connected region of it runs around the period along x, whatever it
    does along y; then a fluid that is pressed along x comes through. The critical constriction is the largest
    height that such a path keeps everywhere: the largest level at which what is at least as high still runs
    around [1]_. It is a height of one point of the map, found exactly: points are taken up, the highest
    first, until their regions run around.

    Parameters
    ----------
    gap : array (ny, nx), m
        periodic; zero or less where the surfaces touch.

    Returns
    -------
    dict
        `gap_percolates_x`, `gap_percolates_y` (0 or 1), `critical_constriction_x`, `critical_constriction_y`
        (m; 0 where nothing percolates). An axis of a single point is one along which nothing varies.

    References
    ----------
    .. [1] Persson and Yang (2008), Theory of the leak-rate of seals, J. Phys. Condens. Matter 20, 315011.

    Examples
    --------
    Two channels along x, the higher one with a narrow place:

    >>> import numpy as np
    >>> gap = np.array([[3.0, 3.0, 1.0, 3.0], [0, 0, 0, 0], [2.0, 2.0, 2.0, 2.0], [0, 0, 0, 0]])
    >>> percolation_columns(gap)["critical_constriction_x"], percolation_columns(gap)["gap_percolates_y"]
    (2.0, 0)
    """
    y, x = _levels(gap) if library_is_there() else _levels_by_bisection(gap)
    return {
        "gap_percolates_x": int(x > 0),
        "gap_percolates_y": int(y > 0),
        "critical_constriction_x": x,
        "critical_constriction_y": y,
    }


def half_way_levels(gap: np.ndarray) -> dict[str, float]:
    """Return the largest heights that ways keep which are half as long as a map and lie within it.

    A way around the period has to match at its seam, where a groove that leaves the map is cut. One that
    crosses half of the map, anywhere in it, does not.

    Parameters
    ----------
    gap : array (ny, nx), m
        zero or less where the surfaces touch.

    Returns
    -------
    dict
        `critical_constriction_x`, `critical_constriction_y` (m; 0 where there is no such way): of three
        halves of the map that overlap, cut across the axis, that with the best way from edge to edge.

    Examples
    --------
    A groove that leaves at another place than it enters, and so ends at the seam:

    >>> import numpy as np
    >>> gap = np.zeros((4, 8))
    >>> gap[[0, 0, 1, 1, 2, 2, 3, 3], range(8)] = gap[[0, 1, 2], [2, 4, 6]] = 2.0
    >>> half_way_levels(gap)["critical_constriction_x"], percolation_columns(gap)["critical_constriction_x"]
    (2.0, 0.0)
    """
    return {
        f"critical_constriction_{axis}": max(
            _from_edge_to_edge(half) for half in _halves(gap if axis == "y" else gap.T)
        )
        for axis in "xy"
    }


def _halves(gap: np.ndarray) -> list[np.ndarray]:
    """Return three halves of a map along its first axis, which overlap; a single point is no less."""
    points = gap.shape[0]
    half = max(points // 2, 1)
    return [gap[start : start + half] for start in sorted({0, (points - half) // 2, points - half})]


def _from_edge_to_edge(gap: np.ndarray) -> float:
    """Return the largest height that a way keeps from the first row to the last, within the map."""
    # an open row joins both ends, a closed column parts both sides
    closed = np.zeros((gap.shape[0] + 1, gap.shape[1] + 1))
    closed[:-1, :-1] = gap
    closed[-1, :-1] = gap.max()
    return percolation_columns(closed)["critical_constriction_y"]


def _levels(gap: np.ndarray) -> tuple[float, float]:
    """Return the critical constriction along y and along x.

    The points of a piece are taken up row by row, which is quick; only that by which a region runs around is
    taken up once more in order.
    """
    heights = gap.ravel()
    is_open = runs_around(gap > 0)
    found = [0.0, 0.0]
    if not any(is_open):
        return 0.0, 0.0
    sample = heights[:: max(1, heights.size // _SAMPLE)]
    cuts = np.quantile(sample[sample > 0], np.arange(_PIECES - 1, 0, -1) / _PIECES) if sample.any() else []
    regions, above = Regions(gap), np.inf
    for least in (*cuts, np.nextafter(0.0, 1.0)):
        # an axis that is closed need not be looked for
        known = bool(found[0]) or not is_open[0], bool(found[1]) or not is_open[1]
        if all(known):
            break
        points = np.flatnonzero((heights >= least) & (heights < above))
        if any(regions.take_up(points, known)):
            regions = Regions(gap)
            regions.take_up(np.flatnonzero(heights >= above), known)
            here = regions.take_up(points[np.argsort(-heights[points])], known)
            found = [max(pair) for pair in zip(found, here, strict=True)]
        above = least
    return found[0], found[1]


def _levels_by_bisection(gap: np.ndarray) -> tuple[float, float]:
    """Return the same without compiled kernels, in several times the time."""
    heights = gap[gap > 0]
    # of each axis, y and x: a level at which it is open, one at which it is not
    is_open, closed = [0.0, 0.0], [np.inf, np.inf]
    if heights.size:
        _narrow(gap, float(heights.min()), is_open, closed)
    percolates = [level > 0 for level in is_open]
    for axis in (0, 1):
        between = heights[heights > is_open[axis]] if percolates[axis] else heights[:0]
        while between.size:
            _narrow(gap, float(np.partition(between, between.size // 2)[between.size // 2]), is_open, closed)
            between = between[(between > is_open[axis]) & (between < closed[axis])]
    return is_open[0], is_open[1]


def _narrow(gap: np.ndarray, level: float, is_open: list[float], closed: list[float]) -> None:
    """Move the levels of both axes to what is found of `level`, where it lies between them."""
    around = runs_around(gap >= level)
    for axis in (0, 1):
        if around[axis]:
            is_open[axis] = max(is_open[axis], level)
        else:
            closed[axis] = min(closed[axis], level)
