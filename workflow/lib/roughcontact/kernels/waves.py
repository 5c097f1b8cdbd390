"""Power of each wave of a map, and iteration over all waves in blocks, to save memory."""

from collections.abc import Iterator, Sequence

import numpy as np

from roughcontact import fourier
from roughcontact.kernels.arrays import DOUBLE
from roughcontact.kernels.fft import make_plan

_BLOCK = 2**17  # waves per block: few enough to stay in the cache


def wave_power(field: np.ndarray) -> np.ndarray:
    """Return |c(q)|^2 of each wave of a periodic field f(r) = sum c(q) exp(i q.r), without the mean.

    The result, shape (ny, nx // 2 + 1), is the square of the unit of the field, in the layout of
    `numpy.fft.rfft2`, for the waves of the half-plane only; zero at the zero frequency, and exactly zero
    everywhere for a constant field.

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


def over_waves(
    power: np.ndarray, shape: Sequence[int], spacing: Sequence[float]
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield the squared wavenumber and the power of all waves, a few rows at a time.

    Parameters
    ----------
    power : array (ny, nx // 2 + 1)
        from `wave_power`.
    shape : (ny, nx)
        of the field.
    spacing : (dy, dx), any unit of length

    Yields
    ------
    squared : array (rows, nx // 2 + 1), rad^2 per unit length^2
        the caller may change it.
    both : array (rows, nx // 2 + 1)
        the power, that of the other half-plane added; the caller may change it.

    Examples
    --------
    The mean square of a wave of amplitude 2, and of its slope:

    >>> import numpy as np
    >>> wave = 2 * np.cos(2 * np.pi * np.arange(8) / 8)[None, :]
    >>> power = wave_power(wave)
    >>> sums = [(both.sum(), (squared * both).sum()) for squared, both in over_waves(power, (1, 8), (1, 1))]
    >>> print(np.round(sums[0] / np.array([1, (np.pi / 4) ** 2]), 6))
    [2. 2.]
    """
    for qy, qx, wave_power in over_wavevectors(power, shape, spacing):
        yield qy**2 + qx**2, wave_power


def over_wavevectors(
    power: np.ndarray, shape: Sequence[int], spacing: Sequence[float]
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield the wavevectors and the power of all waves, a few rows at a time.

    Arguments are those of `over_waves`. The wavevectors, shapes (rows, 1) and (1, nx // 2 + 1), are in rad
    per unit length; the power includes the other half-plane and may be changed by the caller.

    Examples
    --------
    >>> import numpy as np
    >>> wave = 2 * np.cos(2 * np.pi * np.arange(8) / 8)[None, :]
    >>> [(qy, qx, both)] = over_wavevectors(wave_power(wave), (1, 8), (1, 1))
    >>> print(qy.shape, qx.shape, both.round(6))
    (1, 1) (1, 5) [[0. 2. 0. 0. 0.]]
    """
    qy, qx = fourier.wavevectors(shape, spacing)
    weights = fourier.halfplane_weights(shape)
    for rows in _blocks(power.shape):
        yield qy[rows], qx, power[rows] * weights


def _blocks(shape: tuple[int, ...]) -> Iterator[slice]:
    """Yield slices of a few rows each."""
    step = max(1, _BLOCK // shape[1])
    for start in range(0, shape[0], step):
        yield slice(start, start + step)
