"""Fourier conventions, in one place: real-to-complex over the last axis (`rfft2` layout), never shifted.

Wavevectors are angular, in rad per unit length; a profile is a field (ny, nx) with one row.
"""

from collections.abc import Sequence

import numpy as np


def wavevectors(shape: Sequence[int], spacing: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return qy (ny, 1), signed as by `fftfreq`, and qx (1, nx // 2 + 1), in rad per unit of (dy, dx)."""
    (ny, nx), (dy, dx) = shape, spacing
    qy = 2 * np.pi * np.fft.fftfreq(ny, dy)[:, None]  # rad, not cycles: derivatives are products with q
    qx = 2 * np.pi * np.fft.rfftfreq(nx, dx)[None, :]
    return qy, qx


def wavenumbers(shape: Sequence[int], spacing: Sequence[float]) -> np.ndarray:
    """Return the length |q| of the `wavevectors`, (ny, nx // 2 + 1), in rad per unit of (dy, dx)."""
    qy, qx = wavevectors(shape, spacing)
    return np.hypot(qy, qx)


def halfplane_weights(shape: Sequence[int]) -> np.ndarray:
    """Return how often each column of an `rfft2`, (1, nx // 2 + 1), stands in the full transform.

    2, but 1 at the zero frequency and at the Nyquist limit of an even side.
    """
    nx = shape[1]
    # a wave and its opposite have the same power, but the mean and the highest of an even number stand alone
    weights = np.full((1, nx // 2 + 1), 2.0)
    weights[:, 0] = 1.0
    if nx % 2 == 0:
        weights[:, -1] = 1.0
    return weights


def sums_of_products(lines: np.ndarray) -> np.ndarray:
    """Return sum z(x) z(x + t) of lines (number, points) at shifts t (points,), their mean: no period.

    Examples
    --------
    >>> sums_of_products(np.array([[1.0, 2.0, 3.0]])).round(9)
    array([14.,  8.,  3.])
    """
    points = lines.shape[1]
    return np.fft.irfft(np.mean(np.abs(np.fft.rfft(lines, 2 * points)) ** 2, axis=0))[:points]


def has_few_factors(n: int) -> bool:
    """Return whether a number of points has no prime factors other than 2, 3 and 5: its transform is fast."""
    return pow(30, n.bit_length(), n) == 0  # it divides a power of 30
