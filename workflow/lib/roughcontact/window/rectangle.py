"""The largest rectangle of a map without missing points."""

import numpy as np


def largest_rectangle(good: np.ndarray, sides: np.ndarray) -> tuple[int, int, int, int]:
    """Return the rectangle of good points that holds the largest window.

    Row by row, the tallest column of good points that ends in each cell is widened as far as it goes; one of
    these holds the largest rectangle [1]_. The work is a few array operations per row.

    Parameters
    ----------
    good : bool array (ny, nx)
    sides : int array
        `sides[n]` is the side of the window that fits into n points; its area is what counts.

    Returns
    -------
    y0, x0 : int
        first row and column.
    height, width : int
        points along y and x; 0 where there is no good point.

    References
    ----------
    .. [1] Vandevoorde, D. (1998), Dr. Dobb's Journal 23(4): the maximal rectangle problem.

    Examples
    --------
    >>> import numpy as np
    >>> good = np.array([[1, 1, 0, 1], [1, 1, 1, 1], [0, 1, 1, 1]], dtype=bool)
    >>> largest_rectangle(good, np.arange(5))
    (1, 1, 2, 3)
    """
    ny, nx = good.shape
    if good.all():  # as many rows as its side needs
        return (
            (0, 0, int(np.argmax(sides[: ny + 1] == sides[ny])), nx)
            if sides[ny] * sides[nx]
            else (0, 0, 0, 0)
        )
    columns = np.arange(nx)
    tall = np.zeros(nx, dtype=int)
    left = np.zeros(nx, dtype=int)
    right = np.full(nx, nx)
    best, best_area = (0, 0, 0, 0), 0
    for row in range(ny):
        here = good[row]
        if not here.any():
            tall[:], left[:], right[:] = 0, 0, nx
            continue
        # one past the last bad cell to the left, and the first bad cell to the right
        from_left = np.maximum.accumulate(np.where(here, 0, columns + 1))
        to_right = np.minimum.accumulate(np.where(here, nx, columns)[::-1])[::-1]
        tall = np.where(here, tall + 1, 0)
        left = np.where(here, np.maximum(left, from_left), 0)
        right = np.where(here, np.minimum(right, to_right), nx)
        area = np.where(here, sides[tall] * sides[right - left], 0)
        column = int(np.argmax(area))
        if area[column] > best_area:
            best_area = int(area[column])
            y0, x0 = row + 1 - tall[column], left[column]
            best = (int(y0), int(x0), int(tall[column]), int(right[column] - x0))
    return best
