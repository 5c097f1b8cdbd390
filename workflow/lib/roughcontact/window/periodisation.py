"""Periodisation methods, and a test for maps that are already periodic. Plain arrays (ny, nx)."""

from collections.abc import Sequence

import numpy as np

_SMOOTHING_WIDTH = 1 / 2  # standard deviation of the Gaussian low-pass filter, in band widths
_CLOSED_SHARE = 0.55  # share of the smooth component of the long waves that is removed
_ROWS_PER_BLOCK = 128


def is_periodic(values: np.ndarray) -> bool:
    """Return whether heights and slopes of the map are continuous across its periodic seams.

    The rms height step across the seam of each axis, and the rms change of slope on both sides of it, must
    not exceed the 95 % quantile of interior pairs of lines by more than 20 % + 1.5 / sqrt(points of the
    seam), an allowance for chance. A map with missing points is not periodic. Continuity cannot be judged
    where neighbouring points are nearly uncorrelated (rms step above 1.2 times the rms height) or where
    there are fewer than 64 points: such a map does not count as periodic.

    Examples
    --------
    >>> import numpy as np
    >>> wave = np.cos(2 * np.pi * np.arange(128) / 64)[None, :]
    >>> is_periodic(wave), is_periodic(wave[:, :100])
    (True, False)
    """
    if values.size < 64 or np.isnan(values).any():
        return False
    return _is_seamless(values) and _is_seamless(values.T)


def periodic_heights(values: np.ndarray, form: np.ndarray) -> tuple[np.ndarray, bool] | None:
    """Return the heights (m) of a map that is periodic, with or without the form that levelling removed.

    They come with a flag: whether the form, except for its mean, was restored to make them periodic. None
    where the map is not periodic either way.

    Examples
    --------
    >>> import numpy as np
    >>> wave = np.sin(2 * np.pi * np.arange(128) / 64)[None, :]
    >>> tilt = 0.1 * np.arange(128)[None, :]
    >>> heights, form_restored = periodic_heights(wave - tilt, tilt)
    >>> form_restored, bool(np.allclose(heights, wave))
    (True, True)
    """
    if is_periodic(values):
        return values, False
    if not np.ptp(form) or not is_periodic(values + form):
        return None
    heights = values + form
    return heights - heights.mean(), True


def _is_seamless(values: np.ndarray) -> bool:
    """Return whether the map is continuous from its last column to its first."""
    columns = values.shape[1]
    if columns < 3:
        return True
    step, bend = np.zeros((2, columns))
    for first in range(0, len(values), _ROWS_PER_BLOCK):  # to save memory
        rows = values[first : first + _ROWS_PER_BLOCK]
        steps = np.diff(np.concatenate([rows, rows[:, :2]], axis=1), axis=1)
        step += np.sum(steps[:, :columns] ** 2, axis=0)
        bend += np.sum(np.diff(steps, axis=1) ** 2, axis=0)
    step, bend = (np.sqrt(squares / len(values)) for squares in (step, bend))
    # interior pairs first; the seam is the last step, and the last two changes of slope
    rms_step = np.sqrt(np.mean(step[:-1] ** 2))
    if rms_step > 1.2 * np.std(values):
        return False
    allowance = 1.2 + 1.5 / np.sqrt(values.shape[0])
    rounding = 1e-12 * np.ptp(values)
    return all(
        seam.max() <= allowance * np.quantile(interior, 0.95) + rounding
        for seam, interior in ((step[-1:], step[:-1]), (bend[-2:], bend[:-2]))
    )


def periodic_plus_smooth(values: np.ndarray, spacing: Sequence[float]) -> np.ndarray:
    """Return the periodic component of a map: the map less the smoothest surface that closes its seams.

    The smooth component s minimises the sum of |grad s|^2 inside plus (step of h - s)^2 over the seams. It
    solves a discrete Poisson equation whose source is the step b of the heights across the seams [1]_:
    s(q) = b(q) / [w_x (2 cos(q_x dx) - 2) + w_y (2 cos(q_y dy) - 2)], with relative weights w = 1 / pitch^2
    that account for rectangular pixels (`spacing` is (dy, dx)). The mean is unchanged.

    References
    ----------
    .. [1] Moisan, L. (2011), J. Math. Imaging Vis. 39, 161.

    Examples
    --------
    >>> import numpy as np
    >>> tilt = np.arange(8.0)[None, :]
    >>> closed = periodic_plus_smooth(tilt, (1.0, 1.0))
    >>> float(np.ptp(tilt)), round(float(np.ptp(closed)), 3)  # the step at the seam
    (7.0, 0.875)
    """
    ny, nx = values.shape
    wy, wx = (min(spacing) / np.asarray(spacing)) ** 2
    source = np.zeros(values.shape)
    step_y = wy * (values[-1, :] - values[0, :])
    source[0, :] += step_y
    source[-1, :] -= step_y
    step_x = wx * (values[:, -1] - values[:, 0])
    source[:, 0] += step_x
    source[:, -1] -= step_x
    qy = 2 * np.pi * np.fft.fftfreq(ny)[:, None]
    qx = 2 * np.pi * np.fft.rfftfreq(nx)[None, :]
    laplacian = -4 * (wy * np.sin(qy / 2) ** 2 + wx * np.sin(qx / 2) ** 2)
    laplacian[0, 0] = 1.0
    spectrum = np.fft.rfft2(source)
    del source  # memory may not hold more than is needed of a large map
    spectrum /= laplacian
    spectrum[0, 0] = 0.0
    smooth = np.fft.irfft2(spectrum, s=values.shape)
    return np.subtract(values, smooth, out=smooth)


def mirror(values: np.ndarray) -> np.ndarray:
    """Return the map and its mirror images side by side, (2 ny, 2 nx); an axis of one point is not doubled.

    Heights are continuous at the seams; slopes change sign there.

    Examples
    --------
    >>> import numpy as np
    >>> print(mirror(np.array([[1, 2, 3]])))
    [[1 2 3 3 2 1]]
    """
    for axis, points in enumerate(values.shape):
        if points > 1:
            values = np.concatenate([values, np.flip(values, axis)], axis=axis)
    return values


def cross_fade(values: np.ndarray, band: Sequence[int], *, keep_variance: bool = False) -> np.ndarray:
    """Return the map shortened by a band (by, bx; points) over which its end is blended into its beginning.

    On an axis with n + b points: h'(i) = w h(i) + (1 - w) h(i + n) for i < b, h'(i) = h(i) for b <= i < n,
    with w = sin^2 from 0 to 1 over the band, b from 0 to n. The result starts at i = b // 2, so that the seam
    lies in the middle of the blended points.

    Blending reduces the variance of uncorrelated ends by up to one half. With `keep_variance` the blended
    heights, relative to the mean of the map, are divided by sqrt(w^2 + (1 - w)^2 + 2 r w (1 - w)), where r
    is the correlation of the two ends: the variance is then preserved, and equal ends (r = 1) are unchanged.

    Examples
    --------
    >>> import numpy as np
    >>> steps = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 4.0]])
    >>> print(np.round(cross_fade(steps, (0, 2)), 3))  # from the second point on
    [[0.586 0.    0.    0.    0.    3.414]]
    """
    mean = values.mean()
    values = values - mean
    # before any blending: a transposed map then has the same result
    correlations = [
        _correlation(v[..., :n], v[..., v.shape[-1] - n :]) if n else 1.0
        for v, n in zip((values.T, values), band, strict=True)
    ]
    for axis, points in enumerate(band):
        if points:
            values = np.moveaxis(values, axis, -1)
            length = values.shape[-1] - points
            first, last = values[..., :points], values[..., length:]
            weight = np.sin(np.pi / 2 * (np.arange(points) + 0.5) / points) ** 2
            blended = weight * first + (1 - weight) * last
            if keep_variance:
                product = weight * (1 - weight)
                blended /= np.sqrt(1 - 2 * product * (1 - correlations[axis]))
            values = np.concatenate([blended, values[..., points:length]], axis=-1)
            del first, last, blended
            values = np.moveaxis(np.roll(values, -(points // 2), axis=-1), -1, axis)
    values += mean
    return values


def _correlation(first: np.ndarray, last: np.ndarray) -> float:
    """Return the correlation of two arrays of zero mean, 0 to 1; 1 where one of them is flat."""
    scale = np.sqrt(np.mean(first**2) * np.mean(last**2))
    return float(np.clip(np.mean(first * last) / scale, 0, 1)) if scale > 0 else 1.0


def smooth_cross_fade(values: np.ndarray, band: Sequence[int], spacing: Sequence[float]) -> np.ndarray:
    """Return the map shortened by a band, long waves closed in part, short waves faded at constant variance.

    A cross-fade alone bridges the height difference between both ends within the band: long waves make it
    steep. A smooth correction alone draws the heights on both sides of the seam to their mean: the rim is
    flattened and carries too little load. This method first removes a share of the smooth component
    (`periodic_plus_smooth`) of the long waves and cross-fades the remainder. The short waves are cross-faded
    separately with `keep_variance` (see `cross_fade`), because their variance determines slopes and peaks.
    The variance of the long waves is largest at the edges of a levelled map and is not compensated, as that
    would put too much load on the rim. Long waves are those passed by a Gaussian filter with a standard
    deviation of half of the band. Both constants were calibrated on cut-outs of periodic surfaces; see
    docs/explanation/surface.md.

    Examples
    --------
    >>> import numpy as np
    >>> wave = np.cos(2 * np.pi * np.arange(72) / 64)[None, :]
    >>> closed = smooth_cross_fade(wave, (0, 8), (1.0, 1.0))  # one period remains, from the fifth point on
    >>> closed.shape, bool(np.abs(closed - wave[:, 4:68]).max() < 0.1)
    ((1, 64), True)
    """
    long_waves = _gaussian_mean(values, [_SMOOTHING_WIDTH * b for b in band])
    # the smooth component of the middle, the same of a mirrored map, continued into half a band on each side
    inner = tuple(slice(b // 2, n - b // 2) for b, n in zip(band, values.shape, strict=True))
    smooth = long_waves[inner] - periodic_plus_smooth(long_waves[inner], spacing)
    smooth = np.pad(smooth, [(b // 2, b // 2) for b in band], mode="edge")
    smooth *= _CLOSED_SHARE
    closed = cross_fade(np.subtract(long_waves, smooth, out=smooth), band)
    del smooth
    short_waves = np.subtract(values, long_waves, out=long_waves)
    closed += cross_fade(short_waves, band, keep_variance=True)
    return closed


def _gaussian_mean(values: np.ndarray, deviations: Sequence[float]) -> np.ndarray:
    """Return the Gaussian-filtered map, which is continued by its mirror image beyond its edges.

    The coefficients c_k of the cosine series are multiplied by exp(-(pi k s / n)^2 / 2) along each axis, with
    s the standard deviation in points: two transforms, whatever the width of the filter.
    """
    from scipy.fft import dctn, idctn

    series = dctn(values)
    for axis, (points, deviation) in enumerate(zip(values.shape, deviations, strict=True)):
        passed = np.exp(-((np.pi * np.arange(points) * deviation / points) ** 2) / 2)
        series *= np.expand_dims(passed, 1 - axis)
    return idctn(series, overwrite_x=True)


def taper(values: np.ndarray, width: float) -> np.ndarray:
    """Return the map faded to its mean near the edges by a Tukey window [1]_.

    `width` is the share (0 to 1) of each axis, both ends together, over which the window falls to zero as a
    cosine.

    References
    ----------
    .. [1] Harris, F. J. (1978), Proc. IEEE 66, 51.

    Examples
    --------
    >>> import numpy as np
    >>> print(np.round(taper(np.array([[1.0, -1.0] * 4]), 0.5), 3))
    [[ 0.146 -0.854  1.    -1.     1.    -1.     0.854 -0.146]]
    """
    mean = values.mean()
    result = values - mean
    for axis, points in enumerate(values.shape):
        if points > 1:
            from_edge = np.minimum(np.arange(points) + 0.5, points - 0.5 - np.arange(points))
            edge = width * points / 2
            fall = np.minimum(from_edge, edge) / edge if width else np.ones(points)
            window = np.sin(np.pi / 2 * fall) ** 2
            result = result * np.expand_dims(window, 1 - axis)
    return result + mean
