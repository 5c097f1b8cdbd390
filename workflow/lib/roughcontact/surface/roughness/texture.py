"""Texture of a periodic map: autocorrelation, its decay length, aspect ratio and direction."""

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import dimensions, spacing
from roughcontact.arguments.si import as_si
from roughcontact.kernels.arrays import DOUBLE
from roughcontact.kernels.fft import make_plan
from roughcontact.kernels.waves import wave_power
from roughcontact.surface.roughness.spectrum import angular_spectrum

DECAY = 0.2  # level of the autocorrelation that defines Sal and Str (ISO 25178-3)
LAY = 0.5  # texture aspect ratio below which a surface has a lay
_RAYS = 360  # directions over half a turn
_POINTS_PER_PIXEL = 4  # along a ray


@as_si
def autocorrelation(height: xr.DataArray, power: np.ndarray | None = None) -> np.ndarray:
    """Return the autocorrelation of a periodic map.

    R(t) = mean z(r) z(r + t) / mean z^2, with z the height above the mean and periodic boundaries.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.
    power : array (ny, nx // 2 + 1), m^2, optional
        from `roughcontact.kernels.waves.wave_power`; computed where it is not given.

    Returns
    -------
    array (ny, nx), -1 to 1
        with zero shift, where it is 1, at [ny // 2, nx // 2]. NaN for a flat map.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 8), 1.0, amplitude=5.0, wavelength=4.0)
    >>> print(np.abs(np.round(autocorrelation(wave), 6)))  # period of four points
    [[1. 0. 1. 0. 1. 0. 1. 0.]]
    """
    power = wave_power(height.values) if power is None else power
    if not power.any():
        return np.full(height.shape, math.nan)
    correlation = np.empty(height.shape)
    # Wiener and Khinchin: the transform of the power spectrum
    make_plan(correlation, DOUBLE).inverse(power.astype(complex), correlation)
    correlation /= float(correlation[0, 0])
    return np.fft.fftshift(correlation)


@as_si
def texture_parameters(height: xr.DataArray, power: np.ndarray | None = None) -> dict[str, float]:
    """Return the spatial parameters of ISO 25178-2 [1]_ of a periodic map.

    * `Sal`, m: the shortest distance over which the autocorrelation falls to 0.2, among the directions in
      which it does so within half the map.
    * `Str`, 0 to 1: Sal over the longest such distance; near 0 with a lay, near 1 without. If the
      autocorrelation stays above 0.2 up to half the map in some direction, half the map is used and Str is
      an upper bound; a bound above 0.5 is meaningless and given as NaN.
    * `Std`, degree from x towards y, 0 to 180: the direction of the strongest waves (maximum of the angular
      power spectrum). Grooves are perpendicular to it: the lay is at Std + 90 degree.
    * `Ssw`, m: the dominant wavelength, that of the wave with the largest amplitude.

    The statistical error of all depends on the number of areas of the size of Sal in the map: maps of
    few correlation lengths scatter.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.
    power : array (ny, nx // 2 + 1), m^2, optional
        from `roughcontact.kernels.waves.wave_power`; computed where it is not given.

    Returns
    -------
    dict of float
        `Sal`, `Str`, `Std`, `Ssw`. NaN: `Str` and `Std` of a profile, all for a flat map, and `Str` of a map
        too narrow for the waves along its longer side.

    References
    ----------
    .. [1] ISO 25178-2:2021, 4.3.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> wave = westergaard_surface((64, 64), 1.0, amplitude=1.0, wavelength=16.0)
    >>> {name: round(value, 2) for name, value in texture_parameters(wave).items()}
    {'Sal': 3.49, 'Str': 0.11, 'Std': 0.0, 'Ssw': 16.0}
    """
    result = dict.fromkeys(("Sal", "Str", "Std", "Ssw"), math.nan)
    power = wave_power(height.values) if power is None else power
    correlation = autocorrelation(height, power)
    if np.isnan(correlation).any():
        return result
    shortest, longest, decays = decay_lengths(correlation, spacing(height))
    del correlation
    result |= {"Sal": shortest, "Ssw": _dominant_wavelength(power, height.shape, spacing(height))}
    if dimensions(height.shape) > 1:
        aspect = shortest / longest
        theta, power = angular_spectrum(height, power)
        result |= {
            # where it falls nowhere in some direction the ratio is an upper limit, which tells a lay but no
            # isotropy
            "Str": aspect if decays or aspect <= LAY else math.nan,
            "Std": float(theta[np.argmax(power)]),
        }
    return result


def _dominant_wavelength(power: np.ndarray, shape: tuple[int, ...], spacing: Sequence[float]) -> float:
    """Return the wavelength (m) of the strongest wave of half of the waves of a map."""
    y, x = np.unravel_index(int(power.argmax()), power.shape)
    (ny, nx), (dy, dx) = shape, spacing
    return 1 / math.hypot(float(np.fft.fftfreq(ny, dy)[y]), float(x) / (nx * dx))


def decay_lengths(correlation: np.ndarray, spacing: Sequence[float]) -> tuple[float, float, bool]:
    """Return the shortest and the longest distance over which the autocorrelation falls to 0.2.

    It is evaluated along rays from the middle, with cubic splines between the points. A ray on which the
    autocorrelation stays above 0.2 up to half the map does not count for the shortest distance, and is a
    lower bound of the longest one.

    Parameters
    ----------
    correlation : array (ny, nx)
        from `autocorrelation`.
    spacing : (dy, dx), m

    Returns
    -------
    shortest, longest : float, m
        the shortest is NaN if the autocorrelation does not fall to 0.2 on any ray.
    known : bool
        whether it does so on all rays; otherwise the longest distance is a lower bound.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 640), 0.1, amplitude=1.0, wavelength=16.0)
    >>> shortest, _, _ = decay_lengths(autocorrelation(wave), (0.1, 0.1))
    >>> round(shortest, 3), round(16.0 * math.acos(0.2) / (2 * math.pi), 3)
    (3.487, 3.487)
    """
    from scipy.ndimage import find_objects, label, map_coordinates, spline_filter

    centre = [n // 2 for n in correlation.shape]
    # bounding box of the region connected to the middle, with a margin for the splines
    regions, _ = label(correlation > DECAY)
    box = find_objects(regions)[regions[tuple(centre)] - 1]
    starts = [max(side.start - 4, 0) for side in box]
    peak = correlation[tuple(slice(start, side.stop + 4) for start, side in zip(starts, box, strict=True))]
    for axis, n in enumerate(correlation.shape):
        if peak.shape[axis] == n > 1:  # a whole period: add its other end
            peak = np.concatenate([peak, peak.take([0], axis)], axis)
    splines = spline_filter(peak, order=3)
    middle = [c - start for c, start in zip(centre, starts, strict=True)]
    profile = dimensions(correlation.shape) == 1
    along = 1 if correlation.shape[1] > 1 else 0
    angles = [np.pi / 2 * (1 - along)] if profile else np.pi * np.arange(_RAYS) / _RAYS
    # half a period, beyond which the autocorrelation repeats, and what is left of the box
    halves = [n / 2 * d if n > 1 else math.inf for n, d in zip(correlation.shape, spacing, strict=True)]
    rooms = [max(m, n - 1 - m) * d for n, m, d in zip(peak.shape, middle, spacing, strict=True)]
    fallen, open_ends = [], []
    for angle in angles:
        direction = np.sin(angle), np.cos(angle)
        reach, inside, crossing = (
            min(side / abs(u) for side, u in zip(sides, direction, strict=True) if abs(u) > 1e-12)
            for sides in (halves, rooms, spacing)
        )
        # of oblong pixels the long ones are not sampled at the steps of the short ones
        pitch = spacing[along] if profile else max(min(spacing), crossing / 2)
        distance = np.arange(0, min(reach, inside) + pitch / _POINTS_PER_PIXEL / 2, pitch / _POINTS_PER_PIXEL)
        points = [m + distance * u / d for m, d, u in zip(middle, spacing, direction, strict=True)]
        ray = map_coordinates(splines, points, order=3, prefilter=False, mode="nearest")
        is_below = ray <= DECAY
        if is_below.any():
            index = np.argmax(is_below)
            # linear between the two points, a quarter of a pixel apart
            share = (ray[index - 1] - DECAY) / (ray[index - 1] - ray[index])
            fallen.append(distance[index - 1] + share * (distance[index] - distance[index - 1]))
        else:
            open_ends.append(reach)
    return float(min(fallen, default=math.nan)), float(max(fallen + open_ends)), not open_ends
