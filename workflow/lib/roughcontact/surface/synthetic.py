"""Surfaces made by formula: for tests, for teaching, and for the sample files.

Every function returns a height map like the one that `read_height_map` returns: a DataArray (y, x) in m,
with cell centres as coordinates. The same arguments give the same heights, everywhere. A profile is a map
with one row.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_positive
from roughcontact.arguments.maps import height_map, pitches
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
    dimension = 2 if min(shape) > 1 else 1
    noise = np.fft.rfft2(np.random.default_rng(seed).standard_normal(shape))
    spectrum = np.zeros(q.shape, dtype=complex)
    # random phases, exact amplitudes: the spectrum has no scatter
    spectrum[inside] = noise[inside] / np.abs(noise[inside]) * q[inside] ** -(hurst + dimension / 2)
    power = halfplane_weights(shape) * np.abs(spectrum) ** 2
    if rms_gradient is None:
        spectrum *= rms_height / np.sqrt(power.sum())
    else:
        spectrum *= rms_gradient / np.sqrt((wavenumbers(shape, spacing) ** 2 * power).sum())
    heights = np.fft.irfft2(spectrum * np.prod(shape), s=shape)
    return height_map(
        heights, spacing, unit="m", instrument={"generator": "self-affine", "hurst": hurst, "seed": int(seed)}
    )


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
    spectrum[inside] = (
        np.fft.fft2(np.random.default_rng(0).standard_normal((64, 64)))[inside] * k[inside] ** -1.8
    )
    full_spectrum = np.zeros((points, points), dtype=complex)
    full_spectrum[np.ix_(waves[np.abs(waves) <= 16], waves[np.abs(waves) <= 16])] = spectrum[
        np.ix_(np.abs(waves) <= 16, np.abs(waves) <= 16)
    ]
    heights = np.fft.ifft2(full_spectrum).real * (points / 64) ** 2
    return height_map(heights, 1 / points, unit="m", instrument={"generator": "rough reference case"})


def turned_surface(
    shape: Sequence[int],
    spacing: float | Sequence[float],
    *,
    feed: float,
    nose_radius: float,
    groove_scatter: float = 0.0,
    arc_radius: float = np.inf,
    rms_roughness: float = 0.0,
    hurst: float = 0.8,
    seed: int = 0,
) -> xr.DataArray:
    """Return a face-turned surface: parabolic grooves of the tool nose, one per feed, lay along y.

    h = s^2 / (2 R) + depth of the groove + fine roughness, s = distance from the middle of the groove; the
    ideal profile is that of Shaw (2005), Metal Cutting Principles.

    Parameters
    ----------
    shape : (ny, nx)
    spacing : float or (dy, dx), m
    feed : float, m
        distance between grooves.
    nose_radius : float, m
        radius R of the tool nose; the ridges stand feed^2 / (8 R) above the grooves.
    groove_scatter : float, m
        standard deviation of the depth from groove to groove.
    arc_radius : float, m
        distance of the map from the axis of turning; infinite for straight grooves.
    rms_roughness : float, m
        rms height of the self-affine fine roughness on top, waves from two pixels to one feed.
    hurst : float, 0 to 1
        its Hurst exponent.
    seed : int
        of `numpy.random.default_rng`.

    Returns
    -------
    DataArray (y, x), m

    Examples
    --------
    >>> height = turned_surface((1, 800), 1e-6, feed=100e-6, nose_radius=400e-6)
    >>> f"{np.ptp(height.values):.1e} m"  # feed^2 / (8 R)
    '3.1e-06 m'
    """
    dy, dx = pitches(spacing)
    ny, nx = shape
    y = (np.arange(ny)[:, None] + 0.5 - ny / 2) * dy
    x = (np.arange(nx)[None, :] + 0.5) * dx
    # distance from the axis of turning, less that of the left edge; y^2 / (hypot + R) avoids cancellation
    across = x + (0 if np.isinf(arc_radius) else y**2 / (np.hypot(x + arc_radius, y) + x + arc_radius))
    across = np.broadcast_to(across, (ny, nx))
    groove = np.floor(across / feed).astype(int)
    from_middle = across - (groove + 0.5) * feed
    generator = np.random.default_rng(seed)
    # each pass of the tool is a little deeper or less deep
    depth = groove_scatter * generator.standard_normal(groove.max() + 1)
    # neighbouring passes cut into each other: the lower of the two parabolas is what stays
    heights = from_middle**2 / (2 * nose_radius) + depth[groove]
    for side in (-1, 1):
        neighbour = np.clip(groove + side, 0, depth.size - 1)
        cut = (from_middle - side * feed) ** 2 / (2 * nose_radius) + depth[neighbour]
        heights = np.where(neighbour == groove, heights, np.minimum(heights, cut))
    if rms_roughness:
        heights = heights + self_affine_surface(
            shape,
            (dy, dx),
            hurst=hurst,
            shortest=2 * max(dx, dy if ny > 1 else dx),
            longest=feed,
            rms_height=rms_roughness,
            seed=int(generator.integers(2**32)),
        )
    return height_map(heights, (dy, dx), unit="m", instrument={"generator": "turned", "seed": int(seed)})


def ground_surface(
    shape: Sequence[int],
    spacing: float | Sequence[float],
    *,
    hurst: float,
    shortest: float,
    longest: float,
    rms_height: float,
    stretch: float = 8.0,
    skewness_power: float = 1.0,
    seed: int = 0,
) -> xr.DataArray:
    """Return a ground surface: self-affine across the lay, `stretch` times longer waves along it (y).

    Parameters
    ----------
    shape : (ny, nx)
    spacing : float or (dy, dx), m
    hurst : float, 0 to 1
        Hurst exponent.
    shortest, longest : float, m
        the band of wavelengths across the lay.
    rms_height : float, m
    stretch : float
        how much longer the waves are along the lay.
    skewness_power : float
        above 1 it draws the valleys deeper and the plateaus flatter, as grinding and honing do:
        heights below the highest point are raised to this power.
    seed : int
        of `numpy.random.default_rng`.

    Returns
    -------
    DataArray (y, x), m

    Raises
    ------
    SettingsError
        where the band is empty on this grid.

    Examples
    --------
    >>> height = ground_surface(
    ...     (64, 128), 1e-6, hurst=0.8, shortest=4e-6, longest=64e-6, rms_height=1e-7, skewness_power=1.5
    ... )
    >>> skewness = float((height**3).mean() / (height**2).mean() ** 1.5)
    >>> f"{float(height.std()):.3g} m", skewness < 0
    ('1e-07 m', True)
    """
    heights = self_affine_surface(
        shape,
        spacing,
        hurst=hurst,
        shortest=shortest,
        longest=longest,
        rms_height=rms_height,
        stretch=stretch,
        seed=seed,
    ).values
    if skewness_power != 1.0:
        # a power of the depth: flattened summits, deep scratches
        depth = (heights.max() - heights) ** skewness_power
        heights = depth.mean() - depth
        heights *= rms_height / heights.std()
    return height_map(heights, spacing, unit="m", instrument={"generator": "ground", "seed": int(seed)})


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
    _, x = _cell_distances(shape, spacing)
    return height_map(
        np.broadcast_to(amplitude * np.cos(2 * np.pi * x / wavelength), shape), spacing, unit="m"
    )


def product_wave_surface(
    shape: Sequence[int], spacing: float | Sequence[float], *, amplitude: float, wavelength: float
) -> xr.DataArray:
    """Return the two-dimensional wave h = amplitude cos(2 pi x / wavelength) cos(2 pi y / wavelength).

    The crest is on the first cell; complete contact at p* = sqrt(2) pi E* amplitude / wavelength (Johnson,
    Greenwood and Higginson 1985, Int. J. Mech. Sci. 27, 383).

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
    >>> height = product_wave_surface((4, 4), 1.0, amplitude=2.0, wavelength=4.0)
    >>> print(np.round(height.values[::2, ::2], 6))
    [[ 2. -2.]
     [-2.  2.]]
    """
    y, x = _cell_distances(shape, spacing)
    q = 2 * np.pi / wavelength
    return height_map(amplitude * np.cos(q * x) * np.cos(q * y), spacing, unit="m")


def sum_wave_surface(
    shape: Sequence[int],
    spacing: float | Sequence[float],
    *,
    amplitudes: Sequence[float],
    wavelengths: Sequence[float],
) -> xr.DataArray:
    """Return orthogonal waves h = A_y cos(2 pi y / l_y) + A_x cos(2 pi x / l_x).

    Complete contact at p* = pi E* (A_x / l_x + A_y / l_y); with equal amplitudes and wavelengths it is the
    product wave turned by 45 degrees, with twice the amplitude and sqrt(2) times the wavelength.

    Parameters
    ----------
    shape : (ny, nx)
    spacing : float or (dy, dx), m
    amplitudes, wavelengths : (along y, along x), m

    Returns
    -------
    DataArray (y, x), m

    Examples
    --------
    >>> height = sum_wave_surface((4, 4), 1.0, amplitudes=(1.0, 2.0), wavelengths=(4.0, 4.0))
    >>> print(np.round(height.values[::2, ::2], 6))
    [[ 3. -1.]
     [ 1. -3.]]
    """
    y, x = _cell_distances(shape, spacing)
    (ay, ax), (ly, lx) = amplitudes, wavelengths
    return height_map(ay * np.cos(2 * np.pi * y / ly) + ax * np.cos(2 * np.pi * x / lx), spacing, unit="m")


def _cell_distances(shape: Sequence[int], spacing: float | Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return (y, x), shapes (ny, 1) and (1, nx), distances from the first cell centre in m."""
    dy, dx = pitches(spacing)
    return np.arange(shape[0])[:, None] * dy, np.arange(shape[1])[None, :] * dx
