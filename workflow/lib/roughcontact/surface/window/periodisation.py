"""Periodisation methods, and a test for maps that are already periodic. Plain arrays (ny, nx)."""

from collections.abc import Sequence

import numpy as np

_SMOOTHING_WIDTH = 1 / 2  # standard deviation of the Gaussian low-pass filter, in band widths
_CLOSED_SHARE = 0.55  # share of the smooth component of the long waves that is removed
_ROWS_PER_BLOCK = 128


def is_periodic(values: np.ndarray) -> bool:
    """Return whether heights and slopes of the map are continuous across its periodic seams.

    The rms step and change of slope at a seam must not exceed the 95 % quantile of interior pairs of lines by
    more than 20 % + 1.5 / sqrt(points of the seam). False with missing points, and where continuity cannot be
    judged: uncorrelated neighbours (rms step above 1.2 times the rms height) or fewer than 64 points.
    """
    if values.size < 64 or np.isnan(values).any():
        return False
    return _is_seamless(values) and _is_seamless(values.T)


def periodic_heights(values: np.ndarray, form: np.ndarray) -> tuple[np.ndarray, bool] | None:
    """Return periodic heights (m) and whether the form, less its mean, was restored; None if neither is.

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
    for start in range(0, len(values), _ROWS_PER_BLOCK):  # to save memory
        rows = values[start : start + _ROWS_PER_BLOCK]
        # two columns more: one for the seam, one for the change of slope behind it
        steps = np.diff(np.concatenate([rows, rows[:, :2]], axis=1), axis=1)
        step += np.sum(steps[:, :columns] ** 2, axis=0)
        bend += np.sum(np.diff(steps, axis=1) ** 2, axis=0)
    step, bend = (np.sqrt(squares / len(values)) for squares in (step, bend))
    # interior pairs first; the seam is the last step, and the last two changes of slope
    rms_step = np.sqrt(np.mean(step[:-1] ** 2))
    if rms_step > 1.2 * np.std(values):  # white from point to point: any seam is as good as the steps inside
        return False
    # a line of few points has a wide scatter of its steps
    allowance = 1.2 + 1.5 / np.sqrt(values.shape[0])
    rounding = 1e-12 * np.ptp(values)
    return all(
        seam.max() <= allowance * np.quantile(interior, 0.95) + rounding
        for seam, interior in ((step[-1:], step[:-1]), (bend[-2:], bend[:-2]))
    )


def periodic_plus_smooth(values: np.ndarray, spacing: Sequence[float]) -> np.ndarray:
    """Return a map (m) less the smoothest surface that closes its seams, by the method of Moisan (2011).

    J. Math. Imaging Vis. 39, 161. It minimises the sum of |grad s|^2 inside plus (step of h - s)^2 over the
    seams: with their step b, s(q) = b(q) / [w_y (2 cos(q_y dy) - 2) + w_x (2 cos(q_x dx) - 2)], weights w = 1
    / pitch^2. The mean is unchanged.
    """
    ny, nx = values.shape
    # in pixels of the finer pitch: Moisan's equation for oblong pixels
    wy, wx = (min(spacing) / np.asarray(spacing)) ** 2
    source = np.zeros(values.shape)
    for edges, lines, weight in ((source, values, wy), (source.T, values.T, wx)):
        step = weight * (lines[-1] - lines[0])
        edges[0] += step
        edges[-1] -= step
    qy = 2 * np.pi * np.fft.fftfreq(ny)[:, None]
    qx = 2 * np.pi * np.fft.rfftfreq(nx)[None, :]
    laplacian = -4 * (wy * np.sin(qy / 2) ** 2 + wx * np.sin(qx / 2) ** 2)
    laplacian[0, 0] = 1.0  # any value: the smooth component has no mean
    spectrum = np.fft.rfft2(source)
    del source, edges  # memory may not hold more than is needed of a large map
    spectrum /= laplacian
    spectrum[0, 0] = 0.0
    smooth = np.fft.irfft2(spectrum, s=values.shape)
    return np.subtract(values, smooth, out=smooth)


def mirror(values: np.ndarray) -> np.ndarray:
    """Return the map and its mirror images side by side, (2 ny, 2 nx); an axis of one point stays."""
    return np.pad(values, [(0, points if points > 1 else 0) for points in values.shape], mode="symmetric")


def cross_fade(values: np.ndarray, band: Sequence[int], *, keep_variance: bool = False) -> np.ndarray:
    """Return the map shortened by a band (by, bx; points) over which its end is blended into its beginning.

    On an axis with n + b points h'(i) = w h(i) + (1 - w) h(i + n) for i < b, w = sin^2 from 0 to 1; the
    result starts at i = b // 2, so that the seam lies in the middle of the band. `keep_variance` divides the
    blended heights by sqrt(w^2 + (1 - w)^2 + 2 r w (1 - w)), with the correlation r of the two ends.
    """
    mean = values.mean()
    values = values - mean
    # before any blending: a transposed map then has the same result
    correlations = [
        _correlation(v[..., :n], v[..., v.shape[-1] - n :]) if keep_variance and n else 1.0
        for v, n in zip((values.T, values), band, strict=True)
    ]
    for axis, points in enumerate(band):
        if points:
            values = values.swapaxes(axis, -1)
            length, half = values.shape[-1] - points, points // 2
            weight = np.sin(np.pi / 2 * (np.arange(points) + 0.5) / points) ** 2
            blend = weight * values[..., :points] + (1 - weight) * values[..., length:]
            if keep_variance:
                product = weight * (1 - weight)
                # weights w and 1 - w of parts of correlation c leave the variance 1 - 2 w (1 - w) (1 - c)
                blend /= np.sqrt(1 - 2 * product * (1 - correlations[axis]))
            # half of the band at each end, so that the window lies in the middle of its part
            pieces = [blend[..., half:], values[..., points:length], blend[..., :half]]
            values = np.concatenate(pieces, axis=-1).swapaxes(axis, -1)
            del blend, pieces
    values += mean
    return values


def _correlation(start: np.ndarray, last: np.ndarray) -> float:
    """Return the correlation of two arrays of zero mean, 0 to 1; 1 where one of them is flat."""
    scale = np.sqrt(np.mean(start**2) * np.mean(last**2))
    return float(np.clip(np.mean(start * last) / scale, 0, 1)) if scale > 0 else 1.0


def smooth_cross_fade(values: np.ndarray, band: Sequence[int], spacing: Sequence[float]) -> np.ndarray:
    """Return the map shortened by a band, long waves closed in part, short waves faded at constant variance.

    A cross-fade alone makes long waves steep, a smooth correction alone flattens the rim: a share of the
    smooth component of the long waves (Gaussian filter of half the band) is removed before. Only short waves
    keep their variance, which determines slopes and peaks; that of long waves is largest at the edges of a
    levelled map. Both constants were calibrated on cut-outs of periodic surfaces
    (docs/explanation/surface.md).
    """
    long_waves = _gaussian_mean(values, [_SMOOTHING_WIDTH * b for b in band])
    # the smooth component of the middle, the same of a mirrored map, continued into half a band on each side
    inner = tuple(slice(b // 2, n - b // 2) for b, n in zip(band, values.shape, strict=True))
    smooth = long_waves[inner] - periodic_plus_smooth(long_waves[inner], spacing)
    smooth = np.pad(smooth, [(b // 2, b // 2) for b in band], mode="edge")
    smooth *= _CLOSED_SHARE
    result = cross_fade(np.subtract(long_waves, smooth, out=smooth), band)
    del smooth
    short_waves = np.subtract(values, long_waves, out=long_waves)
    result += cross_fade(short_waves, band, keep_variance=True)
    return result


def _gaussian_mean(values: np.ndarray, deviations: Sequence[float]) -> np.ndarray:
    """Return the Gaussian-filtered map, which is continued by its mirror image beyond its edges.

    The coefficients c_k of the cosine series are multiplied by exp(-(pi k s / n)^2 / 2) along each axis, with
    s the standard deviation in points: two transforms, whatever the width of the filter.
    """
    from scipy.fft import dctn, idctn

    series = dctn(values)  # a cosine series is that of the map continued by its mirror image
    for axis, (points, deviation) in enumerate(zip(values.shape, deviations, strict=True)):
        transmission = np.exp(-((np.pi * np.arange(points) * deviation / points) ** 2) / 2)
        series *= np.expand_dims(transmission, 1 - axis)
    return idctn(series, overwrite_x=True)


def taper(values: np.ndarray, width: float) -> np.ndarray:
    """Return the map faded to its mean over a share `width` of each axis by a Tukey window (Harris 1978).

    Proc. IEEE 66, 51; the share is that of both ends together.

    Examples
    --------
    >>> import numpy as np
    >>> print(np.round(taper(np.array([[1.0, -1.0] * 4]), 0.5), 3))
    [[ 0.146 -0.854  1.    -1.     1.    -1.     0.854 -0.146]]
    """
    mean = values.mean()
    result = values - mean
    for axis, points in enumerate(values.shape):
        if points > 1 and width:
            from_edge = np.minimum(np.arange(points) + 0.5, points - 0.5 - np.arange(points))
            fade = width * points / 2
            window = np.sin(np.pi / 2 * (np.minimum(from_edge, fade) / fade)) ** 2
            result = result * np.expand_dims(window, 1 - axis)
    return result + mean
