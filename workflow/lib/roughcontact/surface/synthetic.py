"""Surfaces made by formula: for tests, for teaching, and for the sample files.

Every function returns a height map like the one that `read_height_map` returns: a DataArray (y, x) in m,
with cell centres as coordinates. The same arguments give the same heights, everywhere. A profile is a map
with one row.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_positive
from roughcontact.arguments.maps import dimensions, height_map, pitches
from roughcontact.arguments.si import as_declared
from roughcontact.errors import SettingsError
from roughcontact.kernels.fourier import halfplane_weights, wavenumbers, wavevectors


@as_declared
def self_affine_surface(
    shape: Sequence[int],
    spacing: float | Sequence[float],
    *,
    hurst: float,
    shortest: float,
    longest: float,
    rms_height: float | None = None,
    rms_gradient: float | None = None,
    stretch: float = 1.0,
    seed: int = 0,
) -> xr.DataArray:
    """Return a periodic self-affine surface with random phases [1]_.

    The amplitudes follow |h(q)| ~ |q|^-(1+H) for 2 pi/longest <= |q| <= 2 pi/shortest and vanish elsewhere
    (|q|^-(1/2+H) for a profile); only the phases are random, so that the rms values come out as asked.

    Parameters
    ----------
    shape : (ny, nx)
    spacing : float or (dy, dx), m
    hurst : float, 0 to 1
        Hurst exponent H.
    shortest, longest : float, m
        the band of wavelengths; at least two pixels and at most the length of the map have an effect.
    rms_height : float or None, m
    rms_gradient : float or None, dimensionless
        one of the two sets the heights.
    stretch : float
        how much longer the waves are along y than along x (1: isotropic); the band is that along x.
    seed : int
        of `numpy.random.default_rng`.

    Returns
    -------
    DataArray (y, x), m

    Raises
    ------
    SettingsError
        where the band is empty on this grid, or not exactly one rms value is given.

    References
    ----------
    .. [1] Persson, B. N. J., Albohr, O., Tartaglino, U., Volokitin, A. I., Tosatti, E. (2005), J. Phys.:
       Condens. Matter 17, R1.

    Examples
    --------
    >>> height = self_affine_surface((64, 64), 1e-6, hurst=0.8, shortest=8e-6, longest=64e-6, rms_height=1e-7)
    >>> height.shape, f"{float(height.std()):.3g} m"
    ((64, 64), '1e-07 m')
    """
    shape, spacing = tuple(shape), pitches(spacing)
    if (rms_height is None) == (rms_gradient is None):
        raise SettingsError(
            f"rms_height = {rms_height}, rms_gradient = {rms_gradient}: give exactly one of them"
        )
    if not 0 <= hurst <= 1:
        raise SettingsError(f"hurst = {hurst!r}: give a Hurst exponent from 0 to 1", keys=["hurst"])
    lengths = {"shortest": shortest, "longest": longest, "spacing": min(spacing), "rms_height": rms_height}
    for name, length in lengths.items():
        if length is not None:
            check_positive(name, length, unit="m")
    check_positive("stretch", stretch, unit="relative terms")
    qy, qx = wavevectors(shape, spacing)
    q = np.hypot(stretch * qy, qx)
    inside = (q >= 2 * np.pi / longest * (1 - 1e-9)) & (q <= 2 * np.pi / shortest * (1 + 1e-9)) & (q > 0)
    if not inside.any():
        raise SettingsError(
            f"no wave of {shape[1]} x {shape[0]} points at {spacing[1]:g} m x {spacing[0]:g} m lies between "
            f"shortest = {shortest:g} m and longest = {longest:g} m: widen the band or the map"
        )
    noise = np.fft.rfft2(np.random.default_rng(seed).standard_normal(shape))
    spectrum = np.zeros(q.shape, dtype=complex)
    # random phases, exact amplitudes: the spectrum has no scatter
    spectrum[inside] = noise[inside] / np.abs(noise[inside]) * q[inside] ** -(hurst + dimensions(shape) / 2)
    power = halfplane_weights(shape) * np.abs(spectrum) ** 2
    if rms_gradient is None:
        spectrum *= rms_height / np.sqrt(power.sum())
    else:
        spectrum *= rms_gradient / np.sqrt((wavenumbers(shape, spacing) ** 2 * power).sum())
    heights = np.fft.irfft2(spectrum * np.prod(shape), s=shape)
    return height_map(
        heights, spacing, unit="m", instrument={"generator": "self-affine", "hurst": hurst, "seed": int(seed)}
    )


def with_deep_valleys(heights: np.ndarray, *, power: float, rms_height: float) -> np.ndarray:
    """Return heights (m) with flatter summits and deeper valleys, as grinding and honing leave them.

    Parameters
    ----------
    heights : ndarray (ny, nx), m
    power : float
        to which the depths below the highest point are raised.
    rms_height : float, m
        of the result, about its mean.

    Returns
    -------
    ndarray (ny, nx), m

    Examples
    --------
    >>> print(np.round(with_deep_valleys(np.array([[0.0, 1.0, 2.0]]), power=2.0, rms_height=1.0), 2))
    [[-1.37  0.39  0.98]]
    """
    depth = (heights.max() - heights) ** power
    deeper = depth.mean() - depth
    return deeper * (rms_height / deeper.std())


def rough_reference_surface(points: int) -> xr.DataArray:
    """Return the periodic rough surface that the reference solutions are known for, of unit side.

    F = fft2(default_rng(0).standard_normal((64, 64))) K^-1.8 for 2 <= K <= 16 waves per side, 0 elsewhere,
    zero-padded to `points` x `points`; rms height 0.023699516, rms gradient 0.55501825.

    Parameters
    ----------
    points : int
        per side, more than 32.

    Returns
    -------
    DataArray (y, x), m

    Raises
    ------
    SettingsError
        where the surface does not fit on so few points.

    Examples
    --------
    >>> round(float(rough_reference_surface(40).std()), 9), round(float(rough_reference_surface(64).std()), 9)
    (0.023699516, 0.023699516)
    """
    if points <= 32:
        raise SettingsError(f"points = {points}: the surface holds 16 waves per side and needs more than 32")
    waves = np.fft.fftfreq(64, 1 / 64).astype(int)
    k = np.hypot(waves[:, None], waves[None, :])
    inside = (k >= 2) & (k <= 16)
    spectrum = np.zeros((64, 64), dtype=complex)
    noise = np.fft.fft2(np.random.default_rng(0).standard_normal((64, 64)))
    spectrum[inside] = noise[inside] * k[inside] ** -1.8
    full_spectrum = np.zeros((points, points), dtype=complex)
    # negative numbers of waves count from the end, in both spectra
    long_waves = waves[np.abs(waves) <= 16]
    full_spectrum[np.ix_(long_waves, long_waves)] = spectrum[np.ix_(long_waves, long_waves)]
    heights = np.fft.ifft2(full_spectrum).real * (points / 64) ** 2
    return height_map(heights, 1 / points, unit="m", instrument={"generator": "rough reference case"})


def westergaard_surface(
    shape: Sequence[int], spacing: float | Sequence[float], *, amplitude: float, wavelength: float
) -> xr.DataArray:
    """Return the one-dimensional wave h = amplitude cos(2 pi x / wavelength), crest on the first cell.

    Complete contact at p* = pi E* amplitude / wavelength (Westergaard 1939, J. Appl. Mech. 6, A49).

    Parameters
    ----------
    shape : (ny, nx)
    spacing : float or (dy, dx), m
    amplitude, wavelength : float, m

    Returns
    -------
    DataArray (y, x), m

    Examples
    --------
    >>> print(np.abs(np.round(westergaard_surface((1, 4), 1.0, amplitude=1.0, wavelength=4.0).values, 6)))
    [[1. 0. 1. 0.]]
    """
    x = np.arange(shape[1]) * pitches(spacing)[1]
    wave = amplitude * np.cos(2 * np.pi * x / wavelength)
    return height_map(np.broadcast_to(wave, shape), spacing, unit="m")
