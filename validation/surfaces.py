"""Surfaces made by formula, for the validation and for tests: ground ones, and waves along both axes."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import height_map, pitches
from roughcontact.surface.synthetic import self_affine_surface, with_deep_valleys


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
        heights = with_deep_valleys(heights, power=skewness_power, rms_height=rms_height)
    return height_map(heights, spacing, unit="m", instrument={"generator": "ground", "seed": int(seed)})


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
