"""Points that are no surface: isolated spikes, dead lines, and values that stand for 'not measured'.

The rules are careful: a ridge, a step, a pit or a scratch is surface, however high. Only what cannot be a
surface is taken out, since the highest points carry the load.
"""

import numpy as np

from roughcontact.levelling.polynomial import fit_polynomial
from roughcontact.levelling.robust import robust_scale

_SPIKE_SIZE = 12  # points; a larger group is structure (a pit, a particle)
_FAR_SPIKE = 10  # thresholds
_NEAR, _FAR = 2, 5  # half widths of the window of the median and of the ring around it, maps
_FAR_PROFILE = 30  # half width of the ring in a profile, which has fewer points in it
_SENTINEL_POINTS = 64  # in a smaller map one height may well lie far from the few others
_LINE = 8  # points that a line must have to be called dead
_BELL = 0.35  # mean of 4 f (1 - f) over a bump and its neighbours: see `_without_bumps`
_LEAST_RING = 0.25  # share of the ring that must be measured to be the surroundings of a point
_MOST_ROUNDS = 10  # what is disturbed through and through has no end
_COUNTED = 2**20  # points that are counted at a time
_AT_ONCE = 20_000  # neighbourhoods gathered at a time
_PLANE_POINTS = 20_000  # enough to find the tilt of a map: outliers are the same as from 250 000


def find_outliers(
    values: np.ndarray, *, threshold: float, bumps: bool = False
) -> tuple[np.ndarray, dict[str, int]]:
    """Find points that are no surface.

    * `spike`: a point off the median of its 5 x 5 neighbourhood by more than `threshold` standard
      deviations, both of this difference over the whole map and of the heights in the 11 x 11 ring around,
      in a group of no more than 12 such points, all too high or all too low; or by ten times as much,
      in a group of no more than 12 points that are so far off. In a profile the neighbourhood has 5 points,
      the ring 56. The first standard deviation is 1.4826 times the median absolute deviation [1]_, the second
      is the distance from their median that 90 % of the ring keep, over 1.645: the same for normal heights,
      larger beside steps and ridges. A high group with the shape of a bump, whose sides come down over a few
      points, is surface and stays, however narrow: it carries load. Where less than a quarter of the ring is
      measured, the spread of all heights counts as well.
    * `sentinel`: the lowest or the highest value, in at most a third of the points, farther from all others
      than these are from each other. It stands for 'not measured' (a -1 among 440 ... 520).
    * `dead_line`: whole rows or columns of one single value among others that vary, standing off their
      neighbours by more than lines usually do.

    The rules are applied to what they leave until they find nothing more, ten times at most: a far spike
    hides a near one in the spread of its surroundings.

    Parameters
    ----------
    values : array (ny, nx), m
        NaN where missing.
    threshold : float
        standard deviations.
    bumps : bool
        take out high groups with the shape of a bump as well.

    Returns
    -------
    outliers : bool array (ny, nx)
    kinds : dict
        number of points of each kind that occurs.

    References
    ----------
    .. [1] Davies, L., Gather, U. (1993), J. Am. Stat. Assoc. 88, 782: median and median absolute deviation
       as outlier rule.

    Examples
    --------
    >>> import numpy as np
    >>> values = np.random.default_rng(0).standard_normal((40, 40))
    >>> values[20, 30] = 100.0
    >>> outliers, kinds = find_outliers(values, threshold=8.0)
    >>> np.argwhere(outliers).tolist(), kinds
    ([[20, 30]], {'spike': 1})
    """
    found: dict[str, int] = {}
    outliers = np.zeros(values.shape, dtype=bool)
    for _ in range(_MOST_ROUNDS):
        before = found.copy()
        for kind, finder in (
            ("spike", lambda v, gone: _spikes(v, gone, threshold, bumps=bumps)),
            ("sentinel", lambda v, gone: _sentinels(_left(v, gone))),
            ("dead_line", lambda v, gone: _dead_lines(_left(v, gone))),
        ):
            new = finder(values, outliers)
            if new.any():
                found[kind] = found.get(kind, 0) + int(new.sum())
                outliers |= new
        if found == before:
            break
    return outliers, found


def _left(values: np.ndarray, gone: np.ndarray) -> np.ndarray:
    """Return the heights without those that are gone; the same array where none is."""
    return np.where(gone, np.nan, values) if gone.any() else values


def _sentinels(values: np.ndarray) -> np.ndarray:
    """Return where a value stands that is farther from all others than these are from each other."""
    result = np.zeros(values.shape, dtype=bool)
    found = values.size >= _SENTINEL_POINTS
    while found:  # one after the other: a far one hides a near one
        found = False
        for sign in (1, -1):
            rest = sign * values[~result & ~np.isnan(values)]
            extreme = rest.min()
            rest = rest[rest > extreme]
            at = values == sign * extreme
            if rest.size and rest.min() - extreme > np.ptp(rest) > 0 and at.sum() <= values.size / 3:
                result |= at
                found = True
    return result


def _dead_lines(values: np.ndarray) -> np.ndarray:
    """Return the rows and columns of one single value among others that vary."""
    return _dead_rows(values) | _dead_rows(values.T).T


def _dead_rows(values: np.ndarray) -> np.ndarray:
    """Return the rows of one single value that stand off their neighbours."""
    result = np.zeros(values.shape, dtype=bool)
    known = ~np.isnan(values)
    measured = known.sum(axis=1) >= _LINE
    rows = np.nonzero(measured)[0]
    if rows.size < _LINE:
        return result
    low = np.min(np.where(known, values, np.inf), axis=1)
    high = np.max(np.where(known, values, -np.inf), axis=1)
    constant = measured & (low == high)
    alive = np.nonzero(measured & ~constant)[0]
    # lines that are all constant are a surface with an exact lay, or flat
    if not constant.any() or alive.size < rows.size / 2:
        return result
    usual = _step(values[alive[1:]], values[alive[:-1]])
    usual = np.median(usual[~np.isnan(usual)])
    for row in np.nonzero(constant)[0]:
        after = np.searchsorted(alive, row)
        neighbours = alive[max(after - 1, 0) : after + 1]
        steps = _step(values[neighbours], np.full(values.shape[1], low[row]))
        if np.nanmin(steps) > usual:
            result[row] = known[row]
    return result


def _step(lines: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the median distance of each line from its counterpart; NaN where they share no point."""
    difference = np.abs(lines - others)
    result = np.full(len(difference), np.nan)
    some = ~np.isnan(difference).all(axis=1)
    result[some] = np.nanmedian(difference[some], axis=1)
    return result


def _spikes(values: np.ndarray, gone: np.ndarray, threshold: float, *, bumps: bool) -> np.ndarray:
    """Return the points that stand off their surroundings, alone or in small groups, of those not gone."""
    from scipy import ndimage

    result = np.zeros(values.shape, dtype=bool)
    profile = min(values.shape) == 1
    if max(values.shape) <= 2 * _NEAR or (gone | np.isnan(values)).all():
        return result
    near = [min(_NEAR, n - 1) for n in values.shape]
    far = [min(_FAR_PROFILE if profile else _FAR, n - 1) for n in values.shape]
    # of a large map there is no room for what is needed no more, nor for what another array tells as well
    residual = _without_tilt(_left(values, gone))
    missing = np.isnan(residual)
    heights = residual[~missing]
    floor = 1e-12 * np.ptp(heights)
    heights -= np.median(heights)
    everywhere = robust_scale(heights, overwrite=True)
    del heights
    lending = _lending(missing)
    padded = _beyond_the_border(_stand_ins(residual, lending, near), near, far)
    del residual
    surrounded = np.pad(lending, [(f, f) for f in far], mode="reflect")
    del lending
    size = [2 * n + 1 for n in near]
    inner = tuple(slice(f, f + n) for f, n in zip(far, values.shape, strict=True))
    medians = ndimage.median_filter(padded, size=size)
    signed = np.subtract(padded, medians, out=medians)[inner]
    del medians
    signed[missing] = 0
    scale = robust_scale(signed[~missing], overwrite=True)
    # far spikes stand out of patches that are disturbed as a whole, and too large for a group
    for limit in (threshold, _FAR_SPIKE * threshold):
        least = max(limit * scale, floor)
        groups = _small_groups(signed > least)
        if not bumps:
            groups = _without_bumps(groups, signed, padded, missing, far)
        found = groups > 0
        groups = _small_groups(signed < -least)
        found |= groups > 0
        del groups
        where = np.argwhere(found)
        if where.size:
            spread, measured = _ring(padded, surrounded, where, near, far)
            # what has no surroundings is held against the whole map
            spread = np.where(measured < _LEAST_RING, np.maximum(spread, everywhere), spread)
            worst = np.abs(signed[tuple(where.T)]) > limit * spread
            result[tuple(where[worst & (spread > floor)].T)] = True
    return result


def _lending(missing: np.ndarray) -> np.ndarray:
    """Return the measured points that stand in for missing ones and surround others.

    Islands as small as a spike do not: they would be their own surroundings.
    """
    islands = _small_groups(~missing) > 0 if missing.any() else missing
    lending = ~(missing | islands)
    return lending if lending.any() else ~missing


def _stand_ins(residual: np.ndarray, lending: np.ndarray, near: list[int]) -> np.ndarray:
    """Return the heights with those of missing points replaced, for the medians only.

    The median of the nearest measured neighbourhood stands in.
    """
    from scipy import ndimage

    missing = np.isnan(residual)
    if not missing.any():
        return residual
    nearest = ndimage.distance_transform_edt(~lending, return_distances=False, return_indices=True)
    lenders, which = np.unique(np.ravel_multi_index(nearest[:, missing], residual.shape), return_inverse=True)
    del nearest
    steps = np.meshgrid(*(np.arange(-n, n + 1) for n in near), indexing="ij")
    offsets = np.stack(steps, axis=-1).reshape(-1, 2)
    bordered = np.pad(residual, [(n, n) for n in near], constant_values=np.nan)
    bordered[tuple(slice(n, n + side) for n, side in zip(near, residual.shape, strict=True))][~lending] = (
        np.nan
    )
    medians = np.empty(lenders.size)
    for start in range(0, lenders.size, _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        places = np.stack(np.unravel_index(lenders[part], residual.shape), axis=-1)
        index = places[:, None, :] + offsets[None, :, :] + np.asarray(near)
        medians[part] = np.nanmedian(bordered[index[..., 0], index[..., 1]], axis=1)
    filled = residual.copy()
    filled[missing] = medians[which]
    return filled


def _beyond_the_border(residual: np.ndarray, near: list[int], far: list[int]) -> np.ndarray:
    """Return the heights with as many points beyond each border, reflected with the opposite sign.

    A slope goes on beyond the border. What is reflected there is the median of neighbouring points on the
    border, so that a spike on it stays alone.
    """
    from scipy import ndimage

    for axis in (0, 1):
        heights = residual if axis == 0 else residual.T
        count, along = far[axis], 2 * near[1 - axis] + 1
        if count:
            first, last = (ndimage.median_filter(heights[end], size=along) for end in (0, -1))
            before, after = 2 * first - heights[count:0:-1], 2 * last - heights[-2 : -2 - count : -1]
            heights = np.concatenate([before, heights, after])
        residual = heights if axis == 0 else heights.T
    return residual


def _small_groups(candidates: np.ndarray) -> np.ndarray:
    """Return the numbered groups of candidates that are no larger than a spike; 0 elsewhere."""
    from scipy import ndimage

    groups, count = ndimage.label(candidates, structure=np.ones((3, 3)))
    sizes = np.zeros(count + 1, int)
    for rows in np.array_split(groups, -(-groups.size // _COUNTED), axis=0):
        found = np.bincount(rows.ravel())
        sizes[: found.size] += found
    small = sizes <= _SPIKE_SIZE
    small[0] = False
    groups[~small[groups]] = 0
    return groups


def _without_bumps(
    groups: np.ndarray, signed: np.ndarray, padded: np.ndarray, missing: np.ndarray, far: list[int]
) -> np.ndarray:
    """Return the groups that do not have the shape of a bump.

    Heights around the highest point, f = 1 there and 0 on the median of the ring at a distance of three and
    four points, make a bump where 4 f (1 - f) is `_BELL` or more in the mean over the points with f >= 1/2
    that are connected with the highest and their neighbours: 1 half-way up, 0 at either end. A spike, and a
    small block, has a value of 0; a bell whose standard deviation is a point or two lies well above.
    """
    from scipy import ndimage

    where = np.argwhere(groups)
    if not where.size:
        return groups
    of_point = groups[tuple(where.T)]
    numbers, counts = np.unique(of_point, return_counts=True)
    # each group from its lowest to its highest point, of equals the last one
    order = np.lexsort((signed[tuple(where.T)], of_point))
    peaks = where[order[np.cumsum(counts) - 1]]
    reach = [min(2 * _NEAR, f) for f in far]
    steps = np.stack(np.meshgrid(*(np.arange(-r, r + 1) for r in reach), indexing="ij"))
    ring = np.abs(steps).max(axis=0) > _NEAR
    unmeasured = np.pad(missing, [(f, f) for f in far])
    cross = np.zeros((3, 3, 3), dtype=bool)
    cross[1] = ndimage.generate_binary_structure(2, 1)  # windows are not connected with one another
    is_bump = np.zeros(numbers.size, dtype=bool)
    for start in range(0, numbers.size, _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        index = peaks[part, :, None, None] + steps + np.reshape(far, (1, 2, 1, 1))
        window = padded[index[:, 0], index[:, 1]]
        base = np.median(window[:, ring], axis=1)[:, None, None]
        height = window[:, reach[0], reach[1]][:, None, None] - base
        share = (window - base) / np.where(height > 0, height, np.inf)
        tops, _ = ndimage.label(share >= 0.5, structure=cross)
        top = (tops == tops[:, reach[0], reach[1]][:, None, None]) & (tops > 0)
        around = ndimage.binary_dilation(top, structure=cross) & ~unmeasured[index[:, 0], index[:, 1]]
        share = np.maximum(share, 0)  # a moat around it is no fault of a bump
        between = np.sum(4 * share * (1 - share) * around, axis=(1, 2))
        is_bump[part] = between >= _BELL * np.maximum(around.sum(axis=(1, 2)), 1)
    groups[tuple(where[np.isin(of_point, numbers[is_bump])].T)] = 0
    return groups


def _ring(
    padded: np.ndarray, surrounded: np.ndarray, where: np.ndarray, near: list[int], far: list[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the standard deviation of the heights in the ring around each point, and its measured share."""
    steps = (np.arange(-f, f + 1) for f in far)
    offsets = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 2)
    offsets = offsets[(np.abs(offsets) > near).any(axis=1)]
    spread, measured = np.empty(len(where)), np.empty(len(where))
    for start in range(0, len(where), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        index = where[part, None, :] + offsets[None, :, :] + np.asarray(far)
        ring = padded[index[..., 0], index[..., 1]]
        off = np.abs(ring - np.median(ring, axis=1, keepdims=True))
        spread[part] = np.quantile(off, 0.9, axis=1) / 1.645
        measured[part] = surrounded[index[..., 0], index[..., 1]].mean(axis=1)
    return spread, measured


def _without_tilt(values: np.ndarray) -> np.ndarray:
    """Return the heights less the tilt of the map, found on some of its points."""
    every = max(1, int(np.sqrt(values.size / _PLANE_POINTS)))
    coordinates = [np.arange(n, dtype=float) for n in values.shape]
    thin = values[::every, ::every]
    if np.isnan(thin).all():
        return values
    _, tilt = fit_polynomial(thin, [c[::every] for c in coordinates], order=1, robust=True)
    y, x = coordinates
    tilted = tilt["slope_y"]["value"] * y[:, None] + tilt["slope_x"]["value"] * x[None, :]
    return np.subtract(values, tilted, out=tilted)
