"""Power spectra of a periodic map: radially averaged and angular."""

import math

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import side_lengths, spacing
from roughcontact.arguments.si import as_si
from roughcontact.kernels import fourier
from roughcontact.kernels.waves import each_wave, wave_power


@as_si
def isotropic_spectrum(height: xr.DataArray) -> tuple[np.ndarray, np.ndarray]:
    """Return the radially averaged power spectrum C(q): the mean of C over shells of |q|.

    The width of a shell is the fundamental wavenumber of the longer side; the last shell is the largest one
    within both Nyquist limits. q is the mean of |q| in the shell.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.

    Returns
    -------
    q : array (shells,), rad/m
        in ascending order.
    power : array (shells,), m^4; of a profile m^3

    Examples
    --------
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> q, power = isotropic_spectrum(westergaard_surface((1, 8), 0.5, amplitude=2.0, wavelength=4.0))
    >>> print(np.round(q * 4.0 / (2 * np.pi), 6), np.round(power, 6))
    [1. 2. 3. 4.] [4. 0. 0. 0.]
    """
    power = wave_power(height.values)
    fundamental = 2 * np.pi / max(side_lengths(height))
    # beyond the shorter Nyquist limit shells would be cut off
    last = max(int(np.pi / max(spacing(height)) / fundamental * (1 + 1e-9)), 1)
    sides = fourier.halfplane_weights(height.shape)
    count, total, mean = np.zeros((3, last + 1))
    for squares, ring_power in each_wave(power, height.shape, spacing(height)):
        wavenumber = np.sqrt(squares)
        shell = np.rint(wavenumber / fundamental).astype(int)
        count += _sum_shells(shell, np.broadcast_to(sides, shell.shape), last)
        total += _sum_shells(shell, ring_power, last)
        mean += _sum_shells(shell, sides * wavenumber, last)
    is_occupied = count > 0
    is_occupied[0] = False
    # at the mean wavenumber of the waves in the shell, which few waves may have beside its middle
    return mean[is_occupied] / count[is_occupied], _area(height) * total[is_occupied] / count[is_occupied]


def _sum_shells(shell: np.ndarray, values: np.ndarray, last: int) -> np.ndarray:
    """Return the sum of the values in each shell up to the last one."""
    return np.bincount(shell.ravel(), weights=values.ravel(), minlength=last + 1)[: last + 1]


@as_si
def angular_spectrum(
    height: xr.DataArray, power: np.ndarray | None = None, *, step: float = 0.5
) -> tuple[np.ndarray, np.ndarray]:
    """Return the angular power spectrum of a periodic map.

    f(theta) = integral of C(q) q dq along the ray in the direction theta, from the first wave of the shorter
    side to the smaller Nyquist limit, with C interpolated between the waves of the map. Waves longer than the
    shorter side all run along the longer side: the map resolves their direction only to the angle atan(q1/q)
    between neighbouring waves, with q1 the first wave of the shorter side. Their power is distributed over
    that angle to either side, with linearly decreasing weight.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic; not a profile.
    power : array (ny, nx // 2 + 1), m^2, optional
        from `roughcontact.kernels.waves.wave_power`; computed where it is not given.
    step : float, degree
        between the directions.

    Returns
    -------
    theta : array, degree
        from x towards y, 0 to 180.
    power : array, m^2 per radian
        waves q and -q together.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> wave = westergaard_surface((64, 64), 1.0, amplitude=1.0, wavelength=8.0)
    >>> theta, power = angular_spectrum(wave)
    >>> float(theta[np.argmax(power)])  # the wave runs along x
    0.0
    """
    from scipy.ndimage import map_coordinates

    power = wave_power(height.values) if power is None else power
    ny, nx = height.shape
    dqy, dqx = (2 * np.pi / (n * d) for n, d in zip(height.shape, spacing(height), strict=True))
    finer_step, coarser_step = sorted((dqy, dqx))
    theta = np.arange(0, 180, step)
    # circles within the plane of waves, in steps of the finer axis
    radius = np.arange(1, np.pi / max(spacing(height)) / finer_step) * finer_step
    radius = radius[radius >= coarser_step * (1 - 1e-9)]
    across = np.deg2rad(theta)[:, None]
    rows = np.minimum(radius * np.sin(across) / dqy, (ny - 1) // 2)
    columns = np.minimum(radius * np.cos(across) / dqx, (nx - 1) // 2)
    # C(-q) = C(q): values outside the half-plane
    rows = np.where(columns < 0, -rows, rows) + ny // 2
    spectrum = np.fft.fftshift(power, axes=0)
    longer = _removed_waves(
        spectrum, height.shape, math.ceil(coarser_step / finer_step * (1 - 1e-9)) - 1, along_x=dqx < dqy
    )
    # linear between the waves, which are spectra of chance: a spline would swing below zero
    rays = map_coordinates(spectrum, [rows, np.abs(columns)], order=1, mode="nearest")
    variance = 2 * _area(height) * (rays * radius).sum(axis=1) * finer_step / (2 * np.pi) ** 2
    deviation = np.deg2rad(theta if dqx < dqy else theta - 90)
    deviation = np.arcsin(np.abs(np.sin(deviation)))  # angle to the direction of the longer waves
    for order, mean_square in enumerate(longer, start=1):
        width = math.atan(coarser_step / finer_step / order)
        variance += mean_square / width * np.maximum(1 - deviation / width, 0)
    return theta, variance


def _removed_waves(spectrum: np.ndarray, shape: tuple[int, ...], number: int, *, along_x: bool) -> np.ndarray:
    """Set the first waves along x or y to zero in a spectrum and return their mean squares.

    At most `number` waves are removed. The `spectrum` is the half-plane of a map of size `shape`, with
    frequency zero in the middle row.
    """
    middle = shape[0] // 2
    # the sign that includes the highest frequency of an even side
    line = spectrum[middle] if along_x else spectrum[middle::-1, 0]
    weights = fourier.halfplane_weights(shape if along_x else shape[::-1])[0]
    powers = (weights * line)[1 : number + 1]
    if along_x:
        line[1 : number + 1] = 0
    else:
        spectrum[max(middle - number, 0) : middle + number + 1, 0] = 0
    return powers


def _area(height: xr.DataArray) -> float:
    """Return the area of a map, or the length of a profile."""
    return math.prod(n * d for n, d in zip(height.shape, spacing(height), strict=True) if n > 1)
