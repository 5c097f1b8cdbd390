"""Search for the part of a map that makes the best periodic window: which position, which size.

Every candidate gets a score: the expected harm to the contact area, in parts of one, as a weighted sum of six
numbers that are zero for an ideal window. Candidates are all pairs of a range of rows and a range of columns;
running sums over the map give the numbers of all pairs at once, so that the search costs less than a solve.
"""

import math
from typing import NamedTuple

import numpy as np

# what each part adds to the score
WEIGHTS = {
    "height_mismatch": 0.05,
    "slope_mismatch": 0.05,
    "missing": 1.0,
    "stationarity": 0.1,
    "representativeness": 0.5,
    "size": 0.5,
}
SHORTEST_SIDE = 0.7  # of the largest rectangle's: windows with shorter sides are not tried
_SIDES = 5  # tried along each axis
_PLACES = 5  # tried along each axis
_WHOLE_PERIODS = 0.1  # of a lay period: what a side may be off a whole number of them
_PERIODIC = 0.3  # autocorrelation after one period from which on a surface has a lay period
_AS_HIGH = 0.8  # of the highest maximum: the first that reaches it is one period away
_LINES = 64  # lines that are looked at for the lay period
_COARSEST = 8  # blocks of the longest octave along the shorter side, at least


class Candidate(NamedTuple):
    """A part of the map: first row and column, rows and columns of the window without its bands, its score,
    and the parts of it before weighting."""

    start: tuple[int, int]
    sides: tuple[int, int]
    score: float
    parts: dict[str, float]


class _Ranges(NamedTuple):
    """Ranges of points along an axis: first point, points of the window, points of its band."""

    first: np.ndarray
    side: np.ndarray
    band: np.ndarray

    @property
    def end(self):
        return self.first + self.side + self.band


def search_window(values, filled, largest, *, friendly, band) -> list[Candidate]:
    """Return the best place for each size of the periodic window, the best of all first.

    Sides are at least 0.7 of those of the largest rectangle; along an axis with a lay period (`lay_period`)
    they are whole numbers of it, to a tenth, where such a side transforms well. Places are spread evenly over
    the map. The largest rectangle itself is always among the candidates. The score is the sum of `WEIGHTS`
    times

    * `height_mismatch`: mean square step of the heights across the seams, over twice their variance: 0 for
      ends that meet, 1 for ends that know nothing of one another
    * `slope_mismatch`: the same of the slopes across the seams
    * `missing`: share of points that were filled in
    * `stationarity`: standard deviation of ln(rms gradient) among the quarters of the window
    * `representativeness`: rms over the octaves of the spectrum of ln(amplitude in the window / on the whole
      map), each octave weighted with its share of the mean square gradient
    * `size`: sqrt(area of the largest rectangle / area) - 1, by which the sampling error grows.

    Parameters
    ----------
    values : array (ny, nx), m
        NaN where missing; no candidate has such a point.
    filled : array (ny, nx)
        not 0 where a point was filled in.
    largest : (start, sides)
        of the window in the largest rectangle, rows first.
    friendly, band : callable
        of a side: whether it transforms well, and the points that it needs beyond itself for blending.

    Notes
    -----
    Octaves are differences between means over blocks of 2^k and of 2^(k + 1) points.
    """
    start, sides = largest
    used = tuple(slice(s, s + n + band(n)) for s, n in zip(start, sides, strict=True))
    ranges = []
    for axis, points in enumerate(values.shape):
        period = lay_period(values[used], axis)
        tried = _tried_sides(sides[axis], period, friendly)
        places = [(first, n, band(n)) for n in tried for first in _places(points - n - band(n))]
        places.append((start[axis], sides[axis], band(sides[axis])))
        ranges.append(_Ranges(*np.array(places).T))
    parts, good = _judge(values, filled, *ranges, math.prod(sides))
    score = sum(WEIGHTS[name] * part for name, part in parts.items())
    # rounded, so that rounding errors do not decide between equals
    score = np.where(good, np.round(score, 9), np.inf)

    places = [tuple(each.first.size - 1 for each in ranges)]  # the largest rectangle
    for ny in np.unique(ranges[0].side):
        for nx in np.unique(ranges[1].side):
            rows, columns = np.nonzero(ranges[0].side == ny)[0], np.nonzero(ranges[1].side == nx)[0]
            some = score[np.ix_(rows, columns)]
            best = np.unravel_index(np.argmin(some), some.shape)
            places.append((int(rows[best[0]]), int(columns[best[1]])))
    found = {}
    for place in places:
        if np.isfinite(score[place]):
            candidate = _candidate(ranges, place, score, parts)
            found.setdefault((candidate.start, candidate.sides), candidate)
    return sorted(found.values(), key=lambda candidate: candidate.score)


def lay_period(values, axis) -> float | None:
    """Return the period of the lay along an axis in points, or None where there is none.

    The place of the first maximum of the autocorrelation along the axis (mean over lines), after it has gone
    below zero, that comes near the highest one (0.8 of it). It must reach 0.3, and at least four periods must
    fit into the map.

    Parameters
    ----------
    values : array (ny, nx)
    axis : {0, 1}
    """
    lines = np.moveaxis(values, axis, -1)
    lines = lines[:: max(1, len(lines) // _LINES)]
    points = lines.shape[-1]
    lines = lines - lines.mean(axis=1, keepdims=True)
    power = np.mean(np.abs(np.fft.rfft(lines, 2 * points)) ** 2, axis=0)
    reach = points // 4
    correlation = np.fft.irfft(power, 2 * points)[: reach + 1] / (points - np.arange(reach + 1))
    negative = np.nonzero(correlation < 0)[0]
    if not negative.size:
        return None
    later = correlation[negative[0] :]
    if later.max() < _PERIODIC * correlation[0]:
        return None
    top = negative[0] + int(np.argmax(later >= _AS_HIGH * later.max()))
    while top < reach and correlation[top + 1] > correlation[top]:
        top += 1
    if top == reach:
        return None
    before, at, after = correlation[top - 1 : top + 2]
    return float(top + (before - after) / (2 * (before - 2 * at + after)))


def _tried_sides(longest, period, friendly):
    """Return the sides that are tried along an axis, the longest first."""
    sides = [n for n in range(longest, math.ceil(SHORTEST_SIDE * longest) - 1, -1) if friendly(n)]
    if period is not None:
        sides = [n for n in sides if abs(n / period - round(n / period)) <= _WHOLE_PERIODS] or sides
    picked = np.linspace(0, len(sides) - 1, min(_SIDES, len(sides))).round().astype(int)
    return [sides[i] for i in picked]


def _places(room):
    """Return the first points along an axis on which a window has so much room."""
    return np.unique(np.linspace(0, room, _PLACES).round().astype(int)) if room >= 0 else []


def _candidate(ranges, place, score, parts):
    return Candidate(
        tuple(int(each.first[i]) for each, i in zip(ranges, place, strict=True)),
        tuple(int(each.side[i]) for each, i in zip(ranges, place, strict=True)),
        float(score[place]),
        {name: float(part[place]) for name, part in parts.items()},
    )


def _judge(values, filled, rows, columns, largest_area):
    """Return the parts of the score of all pairs of rows and columns, and which have no missing point."""
    missing = np.isnan(values)
    heights = np.where(missing, 0.0, values - values[~missing].mean())
    edges = [(each.first, each.end) for each in (rows, columns)]
    points = (rows.end - rows.first)[:, None] * (columns.end - columns.first)[None, :]
    good = _means(missing, edges) == 0 if missing.any() else np.ones(points.shape, dtype=bool)
    heights_apart, slopes_apart = _mismatch(heights, rows, columns)
    stationarity, representativeness = _spectrum(heights, missing, rows, columns)
    area = rows.side[:, None] * columns.side[None, :]
    parts = {
        "height_mismatch": heights_apart,
        "slope_mismatch": slopes_apart,
        "missing": _means(filled != 0, edges) if filled.any() else np.zeros(points.shape),
        "stationarity": stationarity,
        "representativeness": representativeness,
        "size": np.sqrt(largest_area / area) - 1,
    }
    return parts, good


def _mismatch(heights, rows, columns):
    """Return the mean square mismatch of heights and slopes over all seams, over that of unrelated ends."""
    found = []
    for lines, along, across in ((heights, columns, rows), (heights.T, rows, columns)):
        if lines.shape[1] < 2:
            continue
        # neighbours across the seam, and those next to them: the window lies in the middle of its band
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


def _spectrum(heights, missing, rows, columns):
    """Return how the gradient varies among the quarters, and how far octaves differ from the whole map's."""
    level, known, block = heights, ~missing, (1, 1)
    octaves = []
    while not octaves or min((n for n in level.shape if n > 1), default=0) >= 2 * _COARSEST:
        factors = tuple(2 if n > 1 else 1 for n in level.shape)
        coarse, complete = _blocks(level, factors), _blocks(known, factors) == 1
        trimmed = level[tuple(slice(n * f) for n, f in zip(coarse.shape, factors, strict=True))]
        detail = (trimmed - _repeat(coarse, factors)) ** 2 * _repeat(complete, factors)
        mean = detail.sum() / max(np.count_nonzero(complete) * math.prod(factors), 1)
        if mean > 0:
            octaves.append((4.0 ** -len(octaves) * mean, mean, *_quarters(detail, rows, columns, block)))
        level, known = coarse, complete
        block = tuple(b * f for b, f in zip(block, factors, strict=True))
        if mean == 0:
            break
    shape = (rows.first.size, columns.first.size)
    off, gradients = np.zeros(shape), np.zeros((4, *shape))
    total = sum(octave[0] for octave in octaves)
    for gradient, mean, whole, quarters in octaves:
        off += gradient / total * _log(whole / mean) ** 2
        gradients += gradient / total * quarters / mean
    return np.std(_log(gradients), axis=0), np.sqrt(off)


def _log(power):
    """Return the logarithm of the amplitude of a power, which may be zero."""
    return 0.5 * np.log(np.maximum(power, 1e-12))


def _quarters(detail, rows, columns, block):
    """Return the means of `detail`, a point of which is a block of points of the map, over all pairs of
    ranges and over the quarters of each (4, rows, columns)."""
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


def _running_sums(values):
    """Return the running sums of an array over both axes, with a leading row and column of zeros."""
    sums = np.zeros((values.shape[0] + 1, values.shape[1] + 1))
    np.cumsum(np.cumsum(values, axis=0, dtype=float), axis=1, out=sums[1:, 1:])
    return sums


def _means(values, edges, *, summed=False):
    """Return the means over all pairs of ranges; edges: (first, end) of the rows and of the columns."""
    sums = values if summed else _running_sums(values)
    (top, bottom), (left, right) = edges
    inside = (sums[bottom[:, None], right] - sums[top[:, None], right] - sums[bottom[:, None], left]) + sums[
        top[:, None], left
    ]
    return inside / ((bottom - top)[:, None] * (right - left))


def _blocks(values, factors):
    """Return the means over blocks of so many points (1 or 2); a point left over at the end is left out."""
    for axis, factor in enumerate(factors):
        if factor > 1:
            lines = np.moveaxis(values, axis, 0)
            even = len(lines) // 2 * 2
            values = np.moveaxis(0.5 * lines[0:even:2] + 0.5 * lines[1:even:2], 0, axis)
    return values


def _repeat(values, factors):
    """Return the array with each point repeated along both axes."""
    for axis, factor in enumerate(factors):
        if factor > 1:
            values = np.repeat(values, factor, axis=axis)
    return values
