"""Measurement noise from two measurements of the same place (ISO 25178-700:2022).

From the difference of the maps its plane is subtracted, and what a lateral shift of one against the other
makes of it, shift times slope. It is noise where it is as strong everywhere on the map and in all waves.
"""

import math

import numpy as np
import scipy
import xarray as xr

from roughcontact.errors import HeightMapError
from roughcontact.levelling.level import level
from roughcontact.levelling.polynomial import fit_polynomial
from roughcontact.maps import spacing
from roughcontact.quantities import number, percent, quantity

_LEAST_CORRELATION = 0.5  # of the heights of both maps; another place gives about 0, noise of Sq gives 0.5
# Mean over rms of what is the same all over for white noise: 1 there, sqrt(1 - f) with a share f of the mean
# square in few places or waves. Below this the noise would come out too large by more than a twentieth. Noise
# in proportion to the local slope has 0.97, smoothed by a Gaussian of half a pixel 0.97, of 0.7 pixels 0.8.
_EVEN = 0.95
_TILE = 8  # points along each side of the places whose rms is compared
_RAYLEIGH = math.sqrt(math.pi) / 2  # mean over rms of the moduli of the waves of white noise


def noise_of_repeats(first: xr.DataArray, second: xr.DataArray) -> tuple[float, str]:
    """Return the noise N_M (m, rms) of two maps of the same place, and what else their difference holds.

    Both are levelled by a plane; the difference has twice the variance of the noise of one. Where it does not
    look like noise N_M is NaN.

    Raises
    ------
    HeightMapError
        for maps of another size or pitch, for equal heights, and for places that do not look alike.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> surface, noise = rough_reference_surface(64), np.random.default_rng(0).standard_normal((2, 64, 64))
    >>> one, other = (surface + 1e-3 * each for each in noise)
    >>> round(noise_of_repeats(one, other)[0], 4), noise_of_repeats(one, other.clip(max=0.03))[0]
    (0.001, nan)
    """
    names = [each.attrs.get("source_file") or "a map" for each in (first, second)]
    steps = [spacing(each) for each in (first, second)]
    if first.shape != second.shape or not np.allclose(steps[0], steps[1], rtol=1e-6, atol=0):
        sizes = [f"{each.shape[1]} x {each.shape[0]} points" for each in (first, second)]
        raise HeightMapError(
            f"repeat_of: {names[0]} ({sizes[0]}) and {names[1]} ({sizes[1]}) differ in size "
            "or pitch; a repeat is the same place measured again with the same settings"
        )
    if np.array_equal(first.values, second.values, equal_nan=True):
        raise HeightMapError(
            f"repeat_of: {names[0]} and {names[1]} have equal heights: a copy is no second measurement; name "
            "the file of the second one, or leave repeat_of empty"
        )
    heights = [level(each, fill="none", outlier_threshold=None).values for each in (first, second)]
    known = np.isfinite(heights[0]) & np.isfinite(heights[1])
    one, other = (each[known] - each[known].mean() for each in heights)
    correlation = float(one @ other) / math.sqrt(float(one @ one) * float(other @ other) or 1.0)
    if not correlation >= _LEAST_CORRELATION:
        raise HeightMapError(
            f"repeat_of: {names[0]} and {names[1]} do not show the same place (correlation "
            f"{correlation:.2f}); measure again without moving the part, or leave repeat_of empty"
        )
    rest, shift, before = _without_shift(*heights)
    rms, gathered = float(np.sqrt(np.nanmean(rest**2))), _gathered(rest)
    axes = "yx"[-shift.size :]  # a profile is a row
    pixels = ", ".join(f"{number(by, places=2)} along {axis}" for by, axis in zip(shift, axes, strict=True))
    # where it would have made the noise too large
    shifted = f"as by a shift of {pixels} (pixels)" if rms < _EVEN * before else ""
    if not gathered:
        return rms / math.sqrt(2), f"{shifted}, which their noise leaves out" if shifted else ""
    return math.nan, (
        f"by {quantity(before, 'm')} (rms), {f'{shifted}, ' if shifted else ''}not as by noise: {gathered}; "
        "no noise is taken from them. If something was done to the surface in between, name the earlier one "
        "in the column before, not in repeat_of; else measure again, or state the noise (column noise)"
    )


def _without_shift(one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the difference of two levelled maps less that of a shift, the shift (pixels), the rms before."""
    slopes = [np.gradient((one + other) / 2, axis=axis) for axis, n in enumerate(one.shape) if n > 1]
    rest = np.where(np.isfinite(sum(slopes)), one - other, np.nan)
    rest = rest - fit_polynomial(rest, [np.arange(n, dtype=float) for n in rest.shape], order=1)[0]
    known = np.isfinite(rest)
    slopes, before = [slope[known] for slope in slopes], float(np.sqrt(np.nanmean(rest**2)))
    products = np.array([[slope @ column for column in (*slopes, rest[known])] for slope in slopes])
    shift = np.linalg.lstsq(products[:, :-1], products[:, -1], rcond=None)[0]
    rest[known] -= sum(by * slope for by, slope in zip(shift, slopes, strict=True))
    return rest, shift, before


def _gathered(rest: np.ndarray) -> str:
    """Return where a difference (NaN: unknown) is gathered in few places or waves, in words, if it is."""
    known = np.isfinite(rest)
    rest = np.where(known, rest, 0.0)
    around, count = (scipy.ndimage.uniform_filter(part, _TILE)[known] for part in (rest**2, known * 1.0))
    waves = np.abs(np.fft.fft2(rest)).ravel()[1:]
    even = _EVEN - 1 / math.sqrt(known.sum())  # less by chance
    words = []
    for squares, of_noise, where in (
        (np.maximum(around / count, 0.0), 1.0, "on a tenth of the map"),
        (waves**2, _RAYLEIGH, "in a tenth of the waves (33 % of noise)"),
    ):
        if np.mean(np.sqrt(squares)) < even * of_noise * math.sqrt(np.mean(squares)):
            share = np.sort(squares)[-(squares.size // 10) :].sum() / squares.sum()
            words.append(f"{percent(share)} of its mean square lies {where}")
    return " and ".join(words)
