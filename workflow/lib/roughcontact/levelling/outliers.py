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
_PLANE_POINTS = 250_000  # enough to find the tilt of a map


def find_outliers(values: np.ndarray, *, threshold: float) -> tuple[np.ndarray, dict[str, int]]:
    """Find points that are no surface.

    * `spike`: a point off the median of its 5 x 5 neighbourhood by more than `threshold` standard
      deviations, both of this difference over the whole map and of the heights in the 11 x 11 ring around,
      in a group of no more than 12 such points, all too high or all too low; or by ten times as much,
      in a group of no more than 12 points that are so far off. In a profile the neighbourhood has 5 points,
      the ring 56. The first standard deviation is 1.4826 times the median absolute deviation, the second is
      the distance from their median that 90 % of the ring keep, over 1.645: the same for normal heights,
      larger beside steps and ridges.
    * `sentinel`: the lowest or the highest value, in at most a third of the points, farther from all others
      than these are from each other. It stands for 'not measured' (a -1 among 440 ... 520).
    * `dead_line`: whole rows or columns of one single value among others that vary, standing off their
      neighbours by more than lines usually do.

    Parameters
    ----------
    values : array (ny, nx), m
        NaN where missing.
    threshold : float
        standard deviations.

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
    found = {}
    outliers = np.zeros(values.shape, dtype=bool)
    for kind, finder in (
        ("spike", lambda v: _spikes(v, threshold)),
        ("sentinel", _sentinels),
        ("dead_line", _dead_lines),
    ):
        new = finder(np.where(outliers, np.nan, values))
        if new.any():
            found[kind] = int(new.sum())
            outliers |= new
    return outliers, found


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


def _spikes(values: np.ndarray, threshold: float) -> np.ndarray:
    """Return the points that stand off their surroundings, alone or in small groups."""
    from scipy import ndimage

    result = np.zeros(values.shape, dtype=bool)
    profile = min(values.shape) == 1
    if max(values.shape) <= 2 * _NEAR or np.isnan(values).all():
        return result
    near = [min(_NEAR, n - 1) for n in values.shape]
    far = [min(_FAR_PROFILE if profile else _FAR, n - 1) for n in values.shape]
    residual = _without_tilt(values)
    missing = np.isnan(residual)
    if missing.any():
        # the nearest measured height stands in, for the medians only
        nearest = ndimage.distance_transform_edt(missing, return_distances=False, return_indices=True)
        residual = residual[tuple(nearest)]
    # reflected with the opposite sign, so that a slope goes on beyond the border
    padded = np.pad(residual, [(f, f) for f in far], mode="reflect", reflect_type="odd")
    size = [2 * n + 1 for n in near]
    inner = tuple(slice(f, f + n) for f, n in zip(far, values.shape, strict=True))
    signed = (padded - ndimage.median_filter(padded, size=size))[inner]
    off = np.abs(signed)
    off[missing] = 0
    scale = robust_scale(off[~missing])
    floor = 1e-12 * np.ptp(residual)
    # far spikes stand out of patches that are disturbed as a whole, and too large for a group
    for limit in (threshold, _FAR_SPIKE * threshold):
        candidates = off > max(limit * scale, floor)
        where = np.argwhere(
            _in_small_groups(candidates & (signed > 0)) | _in_small_groups(candidates & (signed < 0))
        )
        if where.size:
            spread = _ring_spread(padded, where, near, far)
            worst = off[tuple(where.T)] > limit * spread
            result[tuple(where[worst & (spread > floor)].T)] = True
    return result


def _in_small_groups(candidates: np.ndarray) -> np.ndarray:
    """Return which candidates have few neighbours that are candidates as well."""
    from scipy import ndimage

    groups, count = ndimage.label(candidates, structure=np.ones((3, 3)))
    small = np.bincount(groups.ravel(), minlength=count + 1) <= _SPIKE_SIZE
    small[0] = False
    return small[groups]


def _ring_spread(padded: np.ndarray, where: np.ndarray, near: list[int], far: list[int]) -> np.ndarray:
    """Return the standard deviation of the heights in the ring around each point, from their medians."""
    steps = (np.arange(-f, f + 1) for f in far)
    offsets = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 2)
    offsets = offsets[(np.abs(offsets) > near).any(axis=1)]
    spread = np.empty(len(where))
    for start in range(0, len(where), 20_000):
        part = slice(start, start + 20_000)
        index = where[part, None, :] + offsets[None, :, :] + np.asarray(far)
        ring = padded[index[..., 0], index[..., 1]]
        off = np.abs(ring - np.median(ring, axis=1, keepdims=True))
        spread[part] = np.quantile(off, 0.9, axis=1) / 1.645
    return spread


def _without_tilt(values: np.ndarray) -> np.ndarray:
    """Return the heights less the tilt of the map, found on some of its points."""
    every = max(1, int(np.sqrt(values.size / _PLANE_POINTS)))
    coordinates = [np.arange(n, dtype=float) for n in values.shape]
    thin = values[::every, ::every]
    if np.isnan(thin).all():
        return values
    _, tilt = fit_polynomial(thin, [c[::every] for c in coordinates], order=1, robust=True)
    y, x = coordinates
    return values - (tilt["slope_y"]["value"] * y[:, None] + tilt["slope_x"]["value"] * x[None, :])
