"""Whether the gap is open from end to end, and the narrowest place that a fluid must pass."""

import numpy as np

from roughcontact.connectivity import runs_around


def percolation_columns(gap: np.ndarray) -> dict[str, float]:
    """Return whether a periodic gap lets a fluid through along each axis, and its critical constriction.

    A gap percolates along x where some connected region of it runs around the period along x, whatever it
    does along y; then a fluid that is pressed along x comes through. The critical constriction is the largest
    height that such a path keeps everywhere: the largest level at which what is at least as high still runs
    around [1]_. It is a height of one point of the map, found exactly, by bisection of all its heights.

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
    return {
        "gap_percolates_x": int(percolates[1]),
        "gap_percolates_y": int(percolates[0]),
        "critical_constriction_x": is_open[1],
        "critical_constriction_y": is_open[0],
    }


def _narrow(gap: np.ndarray, level: float, is_open: list[float], closed: list[float]) -> None:
    """Move the levels of both axes to what is found of `level`, where it lies between them."""
    around = runs_around(gap >= level)
    for axis in (0, 1):
        if around[axis]:
            is_open[axis] = max(is_open[axis], level)
        else:
            closed[axis] = min(closed[axis], level)
