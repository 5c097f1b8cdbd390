"""Artefacts of maps scanned row by row along x: offsets between rows, and scars along them.

The instrument drifts between rows, and may lose the surface temporarily within a row.
"""

from collections.abc import Iterator

import numpy as np

from roughcontact.surface.levelling.robust import robust_scale, row_medians

_MAX_SCAR_ROWS = 4  # wider features are structure
_MIN_SCAR_LENGTH = 16  # points along the line; shorter features may be spikes


def line_offsets(values: np.ndarray, *, method: str) -> np.ndarray:
    """Return the offset (ny,) of each row of a scanned map (m, NaN missing), 0 for rows without heights.

    `median`: that of the row. `matched-steps`: the sum of the medians of h_j - h_(j-1), 0 without common
    points, in which structure that continues from row to row cancels but errors accumulate. The mean of the
    map is unchanged.
    """
    rows = np.flatnonzero((~np.isnan(values)).any(axis=1))
    offsets = np.zeros(len(values))
    if method == "median":
        offsets[rows] = row_medians(values[rows])
    else:
        steps = row_medians(np.diff(values[rows], axis=0), empty=0.0)
        offsets[rows] = np.concatenate([[0.0], np.cumsum(steps)])
    offsets[rows] -= offsets[rows].mean()
    return offsets


def find_scars(values: np.ndarray, *, threshold: float) -> np.ndarray:
    """Return the mask of scars: pieces of one to four rows that deviate from the rows before and after.

    At least 16 consecutive points lie above both (or below both) rows by more than half of `threshold`
    standard deviations of neighbouring rows, and their median by more than `threshold`. Grooves and ridges
    along x of up to four points count as well.
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
            excess = lowest[1:-1] - around  # rows j+1 ... j+count against rows j and j+count+1
            for row, start, stop in _long_runs(excess > threshold / 2 * scale):
                if np.median(excess[row, start:stop]) > threshold * scale:
                    scars[row + 1 : row + 1 + count, start:stop] = True
    return scars


def _long_runs(mask: np.ndarray) -> Iterator[tuple[int, int, int]]:
    """Return (row, begin, end) of the runs along x that are long enough for a scar."""
    edges = np.diff(np.pad(mask, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, start = np.nonzero(edges == 1)
    stop = np.nonzero(edges == -1)[1]
    long = stop - start >= _MIN_SCAR_LENGTH
    return zip(row[long], start[long], stop[long], strict=True)
