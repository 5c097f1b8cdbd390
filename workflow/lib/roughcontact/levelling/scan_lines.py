"""Faults of scanned maps: lines that are shifted against one another, and scars along them.

A scanning instrument takes the map line by line, each row (along x) in one go. Between rows it drifts, and
within a row it may lose the surface for a while.
"""

from collections.abc import Iterator

import numpy as np

from roughcontact.levelling.robust import robust_scale

_SCAR_ROWS = 4  # a wider fault is structure
_SCAR_LENGTH = 16  # points along the line; a shorter fault is no scar (it may be a spike)


def line_offsets(values: np.ndarray, *, method: str) -> np.ndarray:
    """Return by how much each row of a scanned map is shifted.

    * `median`: o_j = median over x of h_j, the height at which half of the row lies.
    * `matched-steps`: o_j - o_(j-1) = median over x of (h_j - h_(j-1)). Structure that goes on from row to
      row cancels, so that a row across a deep valley is not lifted; but the errors of the steps add up.

    The mean over the rows is taken off: the offsets shift rows against one another, not the map.

    Parameters
    ----------
    values : array (ny, nx), m
        NaN where missing.
    method : {"median", "matched-steps"}
        how the rows are compared.

    Returns
    -------
    array (ny,), m
        0 for rows without heights. Rows that share no measured point with the row before are not shifted
        against it by `matched-steps`.

    Examples
    --------
    >>> import numpy as np
    >>> groove = np.array([0.0, 0.0, -5.0, -5.0])
    >>> rows = np.stack([groove, groove + 1.0, groove + 2.0])
    >>> print(line_offsets(rows, method="matched-steps"))
    [-1.  0.  1.]
    """
    known = ~np.isnan(values)
    rows = np.nonzero(known.any(axis=1))[0]
    offsets = np.zeros(len(values))
    if method == "median":
        offsets[rows] = np.nanmedian(values[rows], axis=1)
    else:
        steps = np.diff(values[rows], axis=0)
        shared = ~np.isnan(steps).all(axis=1)
        step = np.zeros(len(steps))
        step[shared] = np.nanmedian(steps[shared], axis=1)
        offsets[rows] = np.concatenate([[0.0], np.cumsum(step)])
    offsets[rows] -= offsets[rows].mean()
    return offsets


def find_scars(values: np.ndarray, *, threshold: float) -> np.ndarray:
    """Find scars: pieces of one to four neighbouring rows that stick out against the rows before and after.

    A point of such a piece lies above both the row before and the row after the piece (or below both), by
    more than half of `threshold` standard deviations; at least 16 such points follow one another along the
    row, and their median is above `threshold` standard deviations. The standard deviation is that of the
    differences of neighbouring rows, from their median absolute value.

    A groove or a ridge along x that is no wider than four points looks the same and is found as well. A map
    of fewer than three rows, or of fewer than 16 columns, has no scars.

    Parameters
    ----------
    values : array (ny, nx), m
        NaN where missing.
    threshold : float
        standard deviations.

    Returns
    -------
    bool array (ny, nx)
        true on scars.

    Examples
    --------
    >>> import numpy as np
    >>> values = np.random.default_rng(0).standard_normal((20, 40))
    >>> values[10, 5:35] += 50
    >>> int(find_scars(values, threshold=5.0).sum())
    30
    """
    ny, nx = values.shape
    scars = np.zeros(values.shape, dtype=bool)
    steps = np.diff(values, axis=0)
    steps = steps[~np.isnan(steps)]
    if ny < 3 or nx < _SCAR_LENGTH or not steps.size:
        return scars
    scale = robust_scale(steps - np.median(steps))
    if not scale > 1e-12 * np.ptp(values[~np.isnan(values)]):
        return scars
    for sign in (1, -1):
        heights = sign * values
        # the lowest of a piece of so many rows, from the row on at which the piece begins
        lowest = heights
        for count in range(1, min(_SCAR_ROWS, ny - 2) + 1):
            if count > 1:
                lowest = np.minimum(lowest[:-1], heights[count - 1 :])
            around = np.maximum(heights[: ny - count - 1], heights[count + 1 :])
            out = lowest[1:-1] - around  # piece of the rows j+1 ... j+count against j and j+count+1
            for row, begin, end in _long_runs(out > threshold / 2 * scale):
                if np.median(out[row, begin:end]) > threshold * scale:
                    scars[row + 1 : row + 1 + count, begin:end] = True
    return scars


def _long_runs(marked: np.ndarray) -> Iterator[tuple[int, int, int]]:
    """Return (row, begin, end) of the runs along x that are long enough for a scar."""
    edges = np.diff(np.pad(marked, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, begin = np.nonzero(edges == 1)
    end = np.nonzero(edges == -1)[1]
    long = end - begin >= _SCAR_LENGTH
    return zip(row[long], begin[long], end[long], strict=True)
