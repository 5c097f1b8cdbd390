"""Power of the waves of a map, their rms gradient, and iteration over all waves in blocks, to save memory."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from roughcontact.kernels import fourier
from roughcontact.kernels.arrays import DOUBLE, Array, like_array, n_elements
from roughcontact.kernels.choose import kernels_for
from roughcontact.kernels.fft import make_plan

_BLOCK = 2**17  # waves per block: few enough to stay in the cache


def wave_power(field: np.ndarray) -> np.ndarray:
    """Return |c(q)|^2 (ny, nx // 2 + 1) of the waves of a periodic field f = sum c(q) exp(i q.r), 0 at q = 0.

    It has the square of the unit of the field and the layout of `numpy.fft.rfft2`, exactly zero for a
    constant field.

    Examples
    --------
    A wave of amplitude 2 has the coefficient 1, here and in the other half-plane:

    >>> import numpy as np
    >>> power = wave_power(5 + 2 * np.cos(2 * np.pi * np.arange(8) / 8)[None, :])
    >>> print(power.round(6))
    [[0. 1. 0. 0. 0.]]
    """
    values = np.subtract(field, field.flat[0], dtype=float)
    values -= values.mean()
    spectrum = make_plan(values, DOUBLE).forward(values)
    del values
    power = np.empty(spectrum.shape)
    for rows in _blocks(power.shape):
        block = spectrum[rows]
        power[rows] = block.real**2 + block.imag**2
    power /= float(field.size) ** 2
    power[0, 0] = 0.0
    return power


def spectral_gradient(heights: Array, steps: tuple[float, float], *, threads: int = 1) -> float:
    """Return the rms gradient of heights (ny, nx) in float64, of any library, `steps` (dy, dx) apart."""
    # the first height is taken off, which makes a flat map exactly zero
    spectrum = make_plan(heights, DOUBLE, threads=threads).forward(heights, offset=float(heights[0, 0]))
    qy, qx = fourier.wavevectors(heights.shape, steps)
    factors = fourier.halfplane_weights(heights.shape)[0], qy[:, 0] ** 2, qx[0] ** 2
    power = kernels_for(heights, threads=threads).slope_power(
        spectrum, *(like_array(values, heights) for values in factors)
    )
    return math.sqrt(power) / n_elements(heights)


def each_wave(
    power: np.ndarray, shape: Sequence[int], spacing: Sequence[float]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield |q|^2 (rad^2 per unit length^2) and power of all waves (rows, nx // 2 + 1), a few rows at a time.

    `power` is that of `wave_power`, here with the other half-plane; the caller may change both arrays.

    Examples
    --------
    The mean square of a wave of amplitude 2, and of its slope:

    >>> import numpy as np
    >>> wave = 2 * np.cos(2 * np.pi * np.arange(8) / 8)[None, :]
    >>> power = wave_power(wave)
    >>> sums = [(both.sum(), (squared * both).sum()) for squared, both in each_wave(power, (1, 8), (1, 1))]
    >>> print(np.round(sums[0] / np.array([1, (np.pi / 4) ** 2]), 6))
    [2. 2.]
    """
    for qy, qx, wave_power in each_wavevector(power, shape, spacing):
        yield qy**2 + qx**2, wave_power


def each_wavevector(
    power: np.ndarray, shape: Sequence[int], spacing: Sequence[float]
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield qy (rows, 1), qx (1, nx // 2 + 1) in rad/length and the power of all waves, as `each_wave`."""
    qy, qx = fourier.wavevectors(shape, spacing)
    weights = fourier.halfplane_weights(shape)
    for rows in _blocks(power.shape):
        yield qy[rows], qx, power[rows] * weights


def _blocks(shape: tuple[int, ...]) -> Iterator[slice]:
    """Yield slices of a few rows each."""
    step = max(1, _BLOCK // shape[1])
    for start in range(0, shape[0], step):
        yield slice(start, start + step)
