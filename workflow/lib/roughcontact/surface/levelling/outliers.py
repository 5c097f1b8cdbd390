"""Outlier rejection: isolated spikes, dead lines, and sentinel values for 'not measured'.

Ridges, steps, pits and scratches are kept, however high, because the highest points carry the load.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from roughcontact.arguments.maps import dimensions
from roughcontact.kernels.choose import library_available
from roughcontact.kernels.compiled import median_filter
from roughcontact.surface.levelling.polynomial import fit_polynomial
from roughcontact.surface.levelling.robust import robust_scale, row_medians

_MAX_SPIKE_POINTS = 12  # a larger group is structure (a pit, a particle)
_EXTREME_FACTOR = 10  # in units of the threshold
_MEDIAN_HALF_WIDTH, _RING_HALF_WIDTH = 2, 5  # of the median window and of the ring around it, points
_PROFILE_RING_HALF_WIDTH = 30  # wider in a profile, where the ring has fewer points
_SENTINEL_POINTS = 64  # in a smaller map a single height may well lie far from the few others
_MIN_LINE_POINTS = 8  # measured points of a line that may be dead
_MIN_BUMP_SCORE = 0.35  # mean of 4 f (1 - f) over a bump and its neighbours: see `_drop_bumps`
_MIN_RING_SHARE = 0.25  # measured share of the ring that defines the surroundings of a point
_MAX_ROUNDS = 10  # a thoroughly disturbed map may not converge
_COUNT_CHUNK = 2**20  # points counted at a time
_GATHER_CHUNK = 20_000  # neighbourhoods gathered at a time
_PLANE_POINTS = 20_000  # sufficient for the tilt of a map: 250 000 give the same outliers


def find_outliers(values: np.ndarray, *, threshold: float) -> tuple[np.ndarray, dict[str, int]]:
    """Return the mask of spikes, sentinels and dead lines in a map (ny, nx; m), and their number by kind.

    * `spike`: a group of up to 12 points, all too high or all too low, that deviate from the median of 5 x 5
      points (5 of a profile) by more than `threshold` standard deviations, both of this difference over the
      map (Davies and Gather 1993, J. Am. Stat. Assoc. 88, 782) and of the ring of 11 x 11 points (56); or by
      ten times as much. Bumps, whose flanks extend over a few points, carry load and are kept.
    * `sentinel`: the lowest or highest value, in at most a third of the points, farther from all others than
      their range.
    * `dead_line`: rows or columns of one single value among others that vary, farther from their neighbours
      than usual.
    """
    counts: Counter[str] = Counter()
    outliers = np.zeros(values.shape, dtype=bool)
    finders: dict[str, Callable[[np.ndarray], np.ndarray]] = {
        "spike": partial(_spikes, threshold=threshold),
        "sentinel": _sentinels,
        "dead_line": lambda heights: _dead_rows(heights) | _dead_rows(heights.T).T,
    }
    # repeatedly: an extreme spike may mask a smaller one by widening the spread around it
    for _ in range(_MAX_ROUNDS):
        previous_counts = counts.copy()
        for outlier_kind, finder in finders.items():
            new = finder(np.where(outliers, np.nan, values) if outliers.any() else values)
            if new.any():
                counts[outlier_kind] += int(new.sum())
                outliers |= new
        if counts == previous_counts:
            break
    return outliers, counts


def _sentinels(values: np.ndarray) -> np.ndarray:
    """Return the mask of points whose value is farther from all others than the range of these."""
    result = np.zeros(values.shape, dtype=bool)
    searching = values.size >= _SENTINEL_POINTS
    while searching:  # one after the other: a distant sentinel masks a closer one
        searching = False
        for sign in (1, -1):
            remaining = sign * values[~result & ~np.isnan(values)]
            extreme = remaining.min()
            remaining = remaining[remaining > extreme]
            sentinel = values == sign * extreme  # one value, at however many points
            if (
                remaining.size
                and remaining.min() - extreme > np.ptp(remaining) > 0
                and sentinel.sum() <= values.size / 3  # more of one value is a plateau of the surface
            ):
                result |= sentinel
                searching = True
    return result


def _dead_rows(values: np.ndarray) -> np.ndarray:
    """Return the mask of rows with a single value that deviate from their neighbours."""
    result = np.zeros(values.shape, dtype=bool)
    is_measured = ~np.isnan(values)
    has_points = is_measured.sum(axis=1) >= _MIN_LINE_POINTS
    low = values.min(axis=1, initial=np.inf, where=is_measured)
    constant = has_points & (low == values.max(axis=1, initial=-np.inf, where=is_measured))
    alive = np.flatnonzero(has_points & ~constant)
    # if all lines are constant, the surface is flat or has an exact lay
    if has_points.sum() < _MIN_LINE_POINTS or not constant.any() or alive.size < has_points.sum() / 2:
        return result
    # a dead line is farther from its neighbours than lines usually are
    usual = row_medians(np.abs(values[alive[1:]] - values[alive[:-1]]))
    usual = np.median(usual[~np.isnan(usual)])
    for row in np.flatnonzero(constant):
        index = np.searchsorted(alive, row)
        neighbours = alive[max(index - 1, 0) : index + 1]
        if np.nanmin(row_medians(np.abs(values[neighbours] - low[row]))) > usual:
            result[row] = is_measured[row]
    return result


def _spikes(values: np.ndarray, threshold: float) -> np.ndarray:
    """Return the mask of points, alone or in small groups, that deviate from their surroundings."""
    result = np.zeros(values.shape, dtype=bool)
    if max(values.shape) <= 2 * _MEDIAN_HALF_WIDTH or np.isnan(values).all():
        return result
    ring_half_width = _PROFILE_RING_HALF_WIDTH if dimensions(values.shape) == 1 else _RING_HALF_WIDTH
    # the ring needs a border beyond the map as wide as it reaches
    half_widths, border = (
        [min(half_width, n - 1) for n in values.shape] for half_width in (_MEDIAN_HALF_WIDTH, ring_half_width)
    )
    # memory may not hold more than is needed of a large map: arrays are deleted or reused early
    residual = _subtract_tilt(values)
    missing = np.isnan(residual)
    heights = residual[~missing]
    floor = 1e-12 * np.ptp(heights)  # heights that differ by rounding alone are no spikes
    heights -= np.median(heights)
    global_scale = robust_scale(heights, overwrite=True)
    del heights
    # islands as small as a spike neither replace missing points nor are surroundings: they would be their own
    islands = _small_groups(~missing) > 0 if missing.any() else missing
    reference = ~(missing | islands)
    if not reference.any():
        reference = ~missing
    field = _extended_beyond_border(_replace_missing(residual, reference, half_widths), half_widths, border)
    del residual
    reference = np.pad(reference, [(b, b) for b in border], mode="reflect")
    inner = tuple(slice(b, b + n) for b, n in zip(border, values.shape, strict=True))
    medians = _medians(field, half_widths, border)
    deviation = np.subtract(field[inner], medians, out=medians)
    deviation[missing] = 0
    scale = robust_scale(deviation[~missing], overwrite=True)
    # extreme spikes exceed disturbed patches that are too large for a group
    for limit in (threshold, _EXTREME_FACTOR * threshold):
        smallest_deviation = max(limit * scale, floor)
        groups = _small_groups(deviation > smallest_deviation)
        is_spike = _drop_bumps(groups, deviation, field, missing, border) > 0
        is_spike |= _small_groups(deviation < -smallest_deviation) > 0
        where = np.argwhere(is_spike)
        if where.size:
            spread, coverage = _ring(field, reference, where, half_widths, border)
            # points without surroundings are compared with the whole map
            spread = np.where(coverage < _MIN_RING_SHARE, np.maximum(spread, global_scale), spread)
            worst = np.abs(deviation[tuple(where.T)]) > limit * spread
            result[tuple(where[worst & (spread > floor)].T)] = True
    return result


def _medians(field: np.ndarray, half_widths: list[int], border: list[int]) -> np.ndarray:
    """Return the medians of a neighbourhood of each point that is not on the border."""
    if half_widths == [_MEDIAN_HALF_WIDTH] * 2 and library_available():
        medians, border = median_filter(field), [b - _MEDIAN_HALF_WIDTH for b in border]
    else:
        from scipy import ndimage

        medians = ndimage.median_filter(field, size=[2 * n + 1 for n in half_widths])
    return medians[tuple(slice(b, n - b) for b, n in zip(border, medians.shape, strict=True))]


def _replace_missing(residual: np.ndarray, reference: np.ndarray, half_widths: list[int]) -> np.ndarray:
    """Return the heights with missing points replaced, for the median filter only.

    A missing point takes the median of the nearest measured neighbourhood.
    """
    from scipy import ndimage

    missing = np.isnan(residual)
    if not missing.any():
        return residual
    nearest = ndimage.distance_transform_edt(~reference, return_distances=False, return_indices=True)
    references, reference_index = np.unique(
        np.ravel_multi_index(nearest[:, missing], residual.shape), return_inverse=True
    )
    del nearest
    border = [(n, n) for n in half_widths]
    padded_residual = np.pad(np.where(reference, residual, np.nan), border, constant_values=np.nan)
    positions = np.stack(np.unravel_index(references, residual.shape), axis=-1) + half_widths
    medians = np.empty(references.size)
    for block, index in _neighbourhoods(positions, _offsets(half_widths)):
        medians[block] = np.nanmedian(padded_residual[index], axis=1)
    result = residual.copy()
    result[missing] = medians[reference_index]
    return result


def _extended_beyond_border(residual: np.ndarray, half_widths: list[int], border: list[int]) -> np.ndarray:
    """Return the heights extended beyond each border by point reflection, which continues slopes.

    The reflection is about the median of neighbouring border points, so that a spike on the border is not
    repeated.
    """
    from scipy import ndimage

    for axis in (0, 1):
        heights = residual if axis == 0 else residual.T
        count, along = border[axis], 2 * half_widths[1 - axis] + 1
        if count:
            top, last = (ndimage.median_filter(heights[row], size=along) for row in (0, -1))
            upper, lower = 2 * top - heights[count:0:-1], 2 * last - heights[-2 : -2 - count : -1]
            heights = np.concatenate([upper, heights, lower])
        residual = heights if axis == 0 else heights.T
    return residual


def _offsets(half_widths: list[int]) -> np.ndarray:
    """Return the points (number, 2) of a rectangle, row by row, relative to its middle."""
    return np.argwhere(np.ones([2 * n + 1 for n in half_widths])) - half_widths


def _neighbourhoods(
    positions: np.ndarray, offsets: np.ndarray
) -> Iterator[tuple[slice, tuple[np.ndarray, np.ndarray]]]:
    """Yield blocks of positions (number, 2), and the indices of the points at the offsets from each."""
    for start in range(0, len(positions), _GATHER_CHUNK):
        block = slice(start, start + _GATHER_CHUNK)
        index = positions[block, None, :] + offsets
        yield block, (index[..., 0], index[..., 1])


def _small_groups(candidates: np.ndarray) -> np.ndarray:
    """Return labels of the connected groups of candidates no larger than a spike; 0 elsewhere."""
    from scipy import ndimage

    groups, count = ndimage.label(candidates, structure=np.ones((3, 3)))
    sizes = np.zeros(count + 1, int)
    for rows in np.array_split(groups, -(-groups.size // _COUNT_CHUNK), axis=0):
        counts = np.bincount(rows.ravel())
        sizes[: counts.size] += counts
    small = sizes <= _MAX_SPIKE_POINTS
    small[0] = False
    groups[~small[groups]] = 0
    return groups


def _drop_bumps(
    groups: np.ndarray, deviation: np.ndarray, field: np.ndarray, missing: np.ndarray, border: list[int]
) -> np.ndarray:
    """Return the groups whose mean of 4 f (1 - f) around the highest point is below `_MIN_BUMP_SCORE`.

    f is the height relative to the highest point (1) and the median of the ring at three and four points (0);
    the mean is 0 for a spike and a small block, well above it for a bell with a standard deviation of one or
    two points.
    """
    from scipy import ndimage

    where = np.argwhere(groups)
    if not where.size:
        return groups
    of_point = groups[tuple(where.T)]
    numbers, counts = np.unique(of_point, return_counts=True)
    # points sorted by height within each group; the last one is its peak
    order = np.lexsort((deviation[tuple(where.T)], of_point))
    peaks = where[order[np.cumsum(counts) - 1]]
    reach = [min(2 * _MEDIAN_HALF_WIDTH, f) for f in border]
    offsets, sides = _offsets(reach), [2 * r + 1 for r in reach]
    ring = np.abs(offsets).max(axis=1).reshape(sides) > _MEDIAN_HALF_WIDTH
    padded_missing = np.pad(missing, [(b, b) for b in border])
    cross = np.zeros((3, 3, 3), dtype=bool)
    cross[1] = ndimage.generate_binary_structure(2, 1)  # windows are not connected with one another
    is_bump = np.zeros(numbers.size, dtype=bool)
    for block, index in _neighbourhoods(peaks + border, offsets):
        window = field[index].reshape(-1, *sides)
        base = np.median(window[:, ring], axis=1)[:, None, None]
        height = window[:, reach[0], reach[1]][:, None, None] - base
        share = (window - base) / np.where(height > 0, height, np.inf)
        tops, _ = ndimage.label(share >= 0.5, structure=cross)
        top = (tops == tops[:, reach[0], reach[1]][:, None, None]) & (tops > 0)
        around = ndimage.binary_dilation(top, structure=cross) & ~padded_missing[index].reshape(top.shape)
        share = np.maximum(share, 0)  # a moat around a bump does not count against it
        straddling = np.sum(4 * share * (1 - share) * around, axis=(1, 2))
        is_bump[block] = straddling >= _MIN_BUMP_SCORE * np.maximum(around.sum(axis=(1, 2)), 1)
    groups[tuple(where[np.isin(of_point, numbers[is_bump])].T)] = 0
    return groups


def _ring(
    field: np.ndarray, is_reference: np.ndarray, where: np.ndarray, half_widths: list[int], border: list[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the standard deviation of the heights in the ring around each point, and the measured share."""
    offsets = _offsets(border)
    offsets = offsets[(np.abs(offsets) > half_widths).any(axis=1)]
    spread, coverage = np.empty(len(where)), np.empty(len(where))
    for block, index in _neighbourhoods(where + border, offsets):
        ring = field[index]
        deviation = np.abs(ring - np.median(ring, axis=1, keepdims=True))
        # 90 % of a normal distribution lie within 1.645 standard deviations, which a few spikes do not change
        spread[block] = np.quantile(deviation, 0.9, axis=1) / 1.645
        coverage[block] = is_reference[index].mean(axis=1)
    return spread, coverage


def _subtract_tilt(values: np.ndarray) -> np.ndarray:
    """Return the heights less the tilt of the map, fitted to a subset of the points."""
    stride = max(1, int(np.sqrt(values.size / _PLANE_POINTS)))
    y, x = (np.arange(n, dtype=float) for n in values.shape)
    thin = values[::stride, ::stride]
    if np.isnan(thin).all():
        return values
    _, tilt = fit_polynomial(thin, (y[::stride], x[::stride]), order=1, robust=True)
    tilt_plane = tilt["slope_y"]["value"] * y[:, None] + tilt["slope_x"]["value"] * x[None, :]
    return np.subtract(values, tilt_plane, out=tilt_plane)
