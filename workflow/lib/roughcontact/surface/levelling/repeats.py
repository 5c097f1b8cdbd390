"""Measurement noise from two measurements of one area (ISO 25178-700:2022).

The difference of the maps, less its plane and a lateral shift times the slope, is noise where it is as strong
everywhere on the map and in all waves.
"""

import math

import numpy as np
import scipy
import xarray as xr

from roughcontact.arguments.maps import spacing
from roughcontact.arguments.quantities import number, percent, quantity
from roughcontact.errors import HeightMapError
from roughcontact.surface.levelling.level import level
from roughcontact.surface.levelling.polynomial import fit_polynomial

_MIN_CORRELATION = 0.5  # of the heights of both maps; another place gives about 0, noise of Sq gives 0.5
# Mean over rms of what is the same all over for white noise: 1 there, sqrt(1 - f) with a share f of the mean
# square in few places or waves. Below this the noise would come out too large by more than a twentieth. Noise
# in proportion to the local slope has 0.97, smoothed by a Gaussian of half a pixel 0.97, of 0.7 pixels 0.8.
_EVEN = 0.95
_TILE = 8  # points along each side of the places whose rms is compared
_RAYLEIGH = math.sqrt(math.pi) / 2  # mean over rms of the moduli of the waves of white noise


def check_repeat(height: xr.DataArray, repeat: xr.DataArray) -> None:
    """Raise a HeightMapError for two maps (y, x; m) whose points are not those of one area."""
    names = [height.attrs.get("source_file") or "a map" for height in (height, repeat)]
    if height.shape != repeat.shape or not np.allclose(spacing(height), spacing(repeat), rtol=1e-6, atol=0):
        sizes = [f"{height.shape[1]} x {height.shape[0]} points" for height in (height, repeat)]
        raise HeightMapError(
            f"repeat_of: {names[0]} ({sizes[0]}) and {names[1]} ({sizes[1]}) differ in size "
            "or pitch; a repeat is the same place measured again with the same settings"
        )


def noise_of_repeats(height: xr.DataArray, repeat: xr.DataArray) -> tuple[float, str]:
    """Return the noise N_M (m, rms) of two maps of one area, and what else their difference holds.

    Both are levelled by a plane; the difference has twice the variance of one's noise. NaN if unlike noise.
    """
    check_repeat(height, repeat)
    names = [height.attrs.get("source_file") or "a map" for height in (height, repeat)]
    difference = np.abs(height.values - repeat.values)  # NaN where one of them was not measured
    if np.isfinite(difference).any() and not np.nanmax(difference):
        raise HeightMapError(
            f"repeat_of: {names[0]} and {names[1]} have equal heights: a copy is no second measurement; name "
            "the file of the second one, or leave repeat_of empty"
        )
    # without rejections, which would take the tails of the noise
    heights = [level(height, fill="none", outlier_threshold=None).values for height in (height, repeat)]
    is_measured = np.isfinite(heights[0]) & np.isfinite(heights[1])
    first_heights, second_heights = (height[is_measured] - height[is_measured].mean() for height in heights)
    squares = float(first_heights @ first_heights) * float(second_heights @ second_heights)
    correlation = float(first_heights @ second_heights) / math.sqrt(squares or 1.0)
    if not correlation >= _MIN_CORRELATION:
        raise HeightMapError(
            f"repeat_of: {names[0]} and {names[1]} do not show the same place (correlation "
            f"{correlation:.2f}); measure again without moving the part, or leave repeat_of empty"
        )
    residual, shift, rms_raw = _subtract_shift(*heights)
    rms, clusters = _rms(residual), _gathered(residual)
    axes = "yx"[-shift.size :]  # a profile is a row
    shifts = (f"{number(along, decimals=2)} along {axis}" for along, axis in zip(shift, axes, strict=True))
    # where it would have made the noise too large
    note = f"as by a shift of {', '.join(shifts)} (pixels)" if rms < _EVEN * rms_raw else ""
    if not clusters:
        # each of both maps has half of the variance of their difference
        return rms / math.sqrt(2), f"{note}, which their noise leaves out" if note else ""
    return math.nan, (
        f"by {quantity(rms_raw, 'm')} (rms), {f'{note}, ' if note else ''}not as by noise: {clusters}; "
        "no noise is taken from them. If something was done to the surface in between, name the earlier one "
        "in the column before, not in repeat_of; else measure again, or state the noise (column noise)"
    )


def _subtract_shift(height: np.ndarray, repeat: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the difference of two levelled maps less that of a shift, the shift (pixels), the rms before."""
    # to first order a shift changes the heights by the slope times it
    slopes = [np.gradient((height + repeat) / 2, axis=axis) for axis, n in enumerate(height.shape) if n > 1]
    residual = np.where(np.isfinite(sum(slopes)), height - repeat, np.nan)
    coordinates = [np.arange(n, dtype=float) for n in residual.shape]
    residual -= fit_polynomial(residual, coordinates, order=1)[0]
    is_measured, rms_raw = np.isfinite(residual), _rms(residual)
    columns = np.column_stack([slope[is_measured] for slope in slopes])
    shift = np.linalg.lstsq(columns.T @ columns, columns.T @ residual[is_measured], rcond=None)[0]
    residual[is_measured] -= columns @ shift
    return residual, shift, rms_raw


def _rms(residual: np.ndarray) -> float:
    """Return the root mean square of a difference of two maps (m; NaN: unknown)."""
    return float(np.sqrt(np.nanmean(residual**2)))


def _gathered(residual: np.ndarray) -> str:
    """Return where a difference (NaN: unknown) is gathered in few places or waves, in words, if it is."""
    is_measured = np.isfinite(residual)
    residual = np.where(is_measured, residual, 0.0)
    around, count = (
        scipy.ndimage.uniform_filter(field, _TILE)[is_measured] for field in (residual**2, is_measured * 1.0)
    )
    waves = np.abs(np.fft.fft2(residual)).ravel()[1:]
    even = _EVEN - 1 / math.sqrt(is_measured.sum())  # less by chance
    evidence = []
    for squares, of_noise, where in (
        (np.maximum(around / count, 0.0), 1.0, "on a tenth of the map"),
        (waves**2, _RAYLEIGH, "in a tenth of the waves (33 % of noise)"),
    ):
        if np.mean(np.sqrt(squares)) < even * of_noise * math.sqrt(np.mean(squares)):
            share = np.sort(squares)[-(squares.size // 10) :].sum() / squares.sum()
            evidence.append(f"{percent(share)} of its mean square lies {where}")
    return " and ".join(evidence)
