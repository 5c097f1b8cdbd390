"""Artefacts of scanned maps: offsets between lines, and scars along them.

A scanning instrument measures a map line by line, each row (along x) without interruption. It drifts between
rows, and may lose the surface temporarily within a row.
"""

from collections.abc import Iterator

import numpy as np

from roughcontact.levelling.robust import robust_scale

_MAX_SCAR_ROWS = 4  # wider features are structure
_MIN_SCAR_LENGTH = 16  # points along the line; shorter features may be spikes


def line_offsets(values: np.ndarray, *, method: str) -> np.ndarray:
    """Return the offset (m) of each row of a scanned map (m, NaN where missing); 0 for rows without heights.

    * `median`: o_j = median over x of h_j.
    * `matched-steps`: o_j - o_(j-1) = median over x of (h_j - h_(j-1)), zero between rows without common
      points. Structure that continues from row to row cancels, so that a row across a deep valley is not
      raised; but the errors of the steps accumulate.

    The mean over the rows is subtracted, so that the mean height of the map does not change.

    Examples
    --------
    >>> import numpy as np
    >>> groove = np.array([0.0, 0.0, -5.0, -5.0])
    >>> rows = np.stack([groove, groove + 1.0, groove + 2.0])
    >>> print(line_offsets(rows, method="matched-steps"))
    [-1.  0.  1.]
    """
    measured = ~np.isnan(values)
    rows = np.nonzero(measured.any(axis=1))[0]
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
    """Find scars: pieces of one to four neighbouring rows that deviate from the rows before and after.

    A point of such a piece lies above both the row before and the row after the piece (or below both), by
    more than half of `threshold` standard deviations; at least 16 consecutive points along the row do so, and
    the median of their deviations exceeds `threshold` standard deviations. The standard deviation is that of
    the differences of neighbouring rows, from their median absolute value.

    A groove or a ridge along x no wider than four points cannot be distinguished from a scar and is found as
    well. A map of fewer than three rows, or of fewer than 16 columns, has no scars.

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
    if ny < 3 or nx < _MIN_SCAR_LENGTH or not steps.size:
        return scars
    scale = robust_scale(steps - np.median(steps))
    if not scale > 1e-12 * np.ptp(values[~np.isnan(values)]):
        return scars
    for sign in (1, -1):
        heights = sign * values
        # minimum over a piece of `count` rows, indexed by the first row of the piece
        lowest = heights
        for count in range(1, min(_MAX_SCAR_ROWS, ny - 2) + 1):
            if count > 1:
                lowest = np.minimum(lowest[:-1], heights[count - 1 :])
            around = np.maximum(heights[: ny - count - 1], heights[count + 1 :])
            out = lowest[1:-1] - around  # rows j+1 ... j+count against rows j and j+count+1
            for row, begin, end in _long_runs(out > threshold / 2 * scale):
                if np.median(out[row, begin:end]) > threshold * scale:
                    scars[row + 1 : row + 1 + count, begin:end] = True
    return scars


def _long_runs(marked: np.ndarray) -> Iterator[tuple[int, int, int]]:
    """Return (row, begin, end) of the runs along x that are long enough for a scar."""
    edges = np.diff(np.pad(marked, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, begin = np.nonzero(edges == 1)
    end = np.nonzero(edges == -1)[1]
    long = end - begin >= _MIN_SCAR_LENGTH
    return zip(row[long], begin[long], end[long], strict=True)
