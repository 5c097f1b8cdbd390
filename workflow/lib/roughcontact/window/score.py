"""The score of a window candidate: expected relative error of the contact area.

It is a weighted sum of six terms that vanish for an ideal window. Candidates are all pairs of a range of rows
and a range of columns. Running sums over the map give the terms of all pairs at once: the cost is one pass
over the map per octave of its spectrum, independent of the number of candidates.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

# weight of each term of the score
WEIGHTS = {
    "height_mismatch": 0.05,
    "slope_mismatch": 0.05,
    "missing": 1.0,
    "stationarity": 0.1,
    "representativeness": 0.5,
    "size": 0.5,
}
_MIN_COARSE_BLOCKS = 8  # of the longest octave, along the shorter side of the map


class Ranges(NamedTuple):
    """Ranges along an axis: first point, points of the window, points of the blending band beyond it."""

    first: np.ndarray
    side: np.ndarray
    band: np.ndarray

    @property
    def end(self) -> np.ndarray:
        """Return the index after the last point of each range, its band included."""
        return self.first + self.side + self.band


def score_parts(
    values: np.ndarray, filled: np.ndarray, rows: Ranges, columns: Ranges, largest_area: int
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Return the terms of the score for all pairs of rows and columns, without their `WEIGHTS`.

    * `height_mismatch`: mean square height step across the seams, over twice the variance of the heights: 0
      for matching ends, 1 for uncorrelated ends
    * `slope_mismatch`: the same for the slopes
    * `missing`: share of points with nonzero `filled`
    * `stationarity`: standard deviation of ln(rms gradient) among the quarters of the window
    * `representativeness`: rms, over the octaves of the spectrum, of ln(amplitude in the window / on the
      whole map), each octave weighted with its share of the mean square gradient
    * `size`: sqrt(`largest_area` / area) - 1, the relative increase of the sampling error; `largest_area`
      (points) is that of the window in the largest rectangle

    The second array (rows, columns) is True for windows without missing points.

    Examples
    --------
    >>> import numpy as np
    >>> wave = np.cos(2 * np.pi * np.arange(48) / 16) + np.zeros((48, 1))
    >>> side = Ranges(first=np.array([0, 0]), side=np.array([32, 40]), band=np.array([0, 0]))
    >>> parts, good = score_parts(wave, np.zeros((48, 48)), side, side, 40 * 40)
    >>> print(np.round(parts["size"], 3), good.all())
    [[0.25  0.118]
     [0.118 0.   ]] True
    """
    missing = np.isnan(values)
    heights = np.where(missing, 0.0, values - values[~missing].mean())
    edges = [(each.first, each.end) for each in (rows, columns)]
    points = (rows.end - rows.first)[:, None] * (columns.end - columns.first)[None, :]
    good = _means(missing, edges) == 0 if missing.any() else np.ones(points.shape, dtype=bool)
    height_mismatch, slope_mismatch = _mismatch(heights, rows, columns)
    stationarity, representativeness = _spectrum(heights, missing, rows, columns)
    area = rows.side[:, None] * columns.side[None, :]
    parts = {
        "height_mismatch": height_mismatch,
        "slope_mismatch": slope_mismatch,
        "missing": _means(filled != 0, edges) if filled.any() else np.zeros(points.shape),
        "stationarity": stationarity,
        "representativeness": representativeness,
        "size": np.sqrt(largest_area / area) - 1,
    }
    return parts, good


def _mismatch(heights: np.ndarray, rows: Ranges, columns: Ranges) -> list[np.ndarray]:
    """Return mean square mismatches of heights and slopes at the seams, over those of uncorrelated ends."""
    found = []
    for lines, along, across in ((heights, columns, rows), (heights.T, rows, columns)):
        if lines.shape[1] < 2:
            continue
        # two points on each side of the seam; half of the band lies before the window
        begin = along.first + along.band // 2
        end = begin + along.side - 1
        one, two, three, four = (
            lines[:, at] for at in (begin, np.minimum(begin + 1, end), np.maximum(end - 1, begin), end)
        )
        steps = (one - four) ** 2, (two - one - four + three) ** 2
        scales = 2 * np.mean(lines**2), 2 * np.mean(np.diff(lines, axis=1) ** 2)
        places = np.arange(begin.size)
        edges = [(across.first, across.end), (places, places + 1)]
        parts = [_means(s, edges) / (scale or 1.0) for s, scale in zip(steps, scales, strict=True)]
        found.append(parts if lines is heights else [part.T for part in parts])
    return [np.mean(parts, axis=0) for parts in zip(*found, strict=True)]


def _spectrum(
    heights: np.ndarray, missing: np.ndarray, rows: Ranges, columns: Ranges
) -> tuple[np.ndarray, np.ndarray]:
    """Return the terms `stationarity` and `representativeness`.

    An octave is the difference between the means over blocks of 2^k and of 2^(k + 1) points.
    """
    averaged, known, block = heights, ~missing, [1, 1]
    octaves: list[tuple] = []
    while not octaves or min((n for n in averaged.shape if n > 1), default=0) >= 2 * _MIN_COARSE_BLOCKS:
        factors = tuple(2 if n > 1 else 1 for n in averaged.shape)
        coarse, complete = _blocks(averaged, factors), _blocks(known, factors) == 1
        trimmed = averaged[tuple(slice(n * f) for n, f in zip(coarse.shape, factors, strict=True))]
        detail = (trimmed - _repeat(coarse, factors)) ** 2 * _repeat(complete, factors)
        mean = detail.sum() / max(np.count_nonzero(complete) * math.prod(factors), 1)
        if mean > 0:
            octaves.append((4.0 ** -len(octaves) * mean, mean, *_quarters(detail, rows, columns, block)))
        averaged, known = coarse, complete
        block = [b * f for b, f in zip(block, factors, strict=True)]
        if mean == 0:
            break
    shape = (rows.first.size, columns.first.size)
    off, gradients = np.zeros(shape), np.zeros((4, *shape))
    total = sum(octave[0] for octave in octaves)
    for gradient, mean, whole, quarters in octaves:
        off += gradient / total * _log(whole / mean) ** 2
        gradients += gradient / total * quarters / mean
    return np.std(_log(gradients), axis=0), np.sqrt(off)


def _log(power: np.ndarray) -> np.ndarray:
    """Return the logarithm of the amplitude that belongs to a power, with a floor for zero power."""
    return 0.5 * np.log(np.maximum(power, 1e-12))


def _quarters(
    detail: np.ndarray, rows: Ranges, columns: Ranges, block: Sequence[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the means of `detail` over all pairs of ranges, and over the quarters of each.

    A point of `detail` is a block of points of the map; the quarters have the shape (4, rows, columns).
    """
    edges = []
    for each, points, n in zip((rows, columns), block, detail.shape, strict=True):
        begin = np.minimum(-(-each.first // points), n - 1)
        end = np.clip(each.end // points, begin + 1, n)
        middle = np.maximum((begin + end) // 2, begin + (end - begin < 2))  # a single point has no halves
        edges.append(((begin, end), (begin, middle), (end - (end - middle).clip(1), end)))
    sums = _running_sums(detail)
    whole, *quarters = (
        _means(sums, (r, c), summed=True)
        for r, c in (
            (edges[0][0], edges[1][0]),
            *((r, c) for r in edges[0][1:] for c in edges[1][1:]),
        )
    )
    return whole, np.array(quarters)


def _running_sums(values: np.ndarray) -> np.ndarray:
    """Return the running sums of an array over both axes, with a leading row and column of zeros."""
    sums = np.zeros((values.shape[0] + 1, values.shape[1] + 1))
    np.cumsum(np.cumsum(values, axis=0, dtype=float), axis=1, out=sums[1:, 1:])
    return sums


def _means(
    values: np.ndarray, edges: Sequence[tuple[np.ndarray, np.ndarray]], *, summed: bool = False
) -> np.ndarray:
    """Return the means over all pairs of ranges, given (first, end) of the rows and of the columns."""
    sums = values if summed else _running_sums(values)
    (top, bottom), (left, right) = edges
    inside = (sums[bottom[:, None], right] - sums[top[:, None], right] - sums[bottom[:, None], left]) + sums[
        top[:, None], left
    ]
    return inside / ((bottom - top)[:, None] * (right - left))


def _blocks(values: np.ndarray, factors: Sequence[int]) -> np.ndarray:
    """Return means over blocks of 1 or 2 points along each axis; an odd last point is dropped."""
    for axis, factor in enumerate(factors):
        if factor > 1:
            lines = np.moveaxis(values, axis, 0)
            even = len(lines) // 2 * 2
            values = np.moveaxis(0.5 * lines[0:even:2] + 0.5 * lines[1:even:2], 0, axis)
    return values


def _repeat(values: np.ndarray, factors: Sequence[int]) -> np.ndarray:
    """Return the array with each point repeated along both axes."""
    for axis, factor in enumerate(factors):
        if factor > 1:
            values = np.repeat(values, factor, axis=axis)
    return values
