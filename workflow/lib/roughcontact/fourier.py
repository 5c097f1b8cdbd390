"""Fourier conventions, in one place.

Transforms are real-to-complex over the last axis (`rfft2` layout), FFT order, never shifted; angular
wavevectors in rad per unit length. Fields have shape (ny, nx); a profile is a field with one row.
"""

import numpy as np


def wavevectors(shape, spacing) -> tuple[np.ndarray, np.ndarray]:
    """Return (qy, qx), shapes (ny, 1) and (1, nx//2 + 1), rad per unit length, for `rfft2`."""
    (ny, nx), (dy, dx) = shape, spacing
    qy = 2 * np.pi * np.fft.fftfreq(ny, dy)[:, None]
    qx = 2 * np.pi * np.fft.rfftfreq(nx, dx)[None, :]
    return qy, qx


def wavenumbers(shape, spacing) -> np.ndarray:
    """Return |q|, shape (ny, nx//2 + 1), rad per unit length, for `rfft2`."""
    qy, qx = wavevectors(shape, spacing)
    return np.hypot(qy, qx)


def halfplane_weights(shape) -> np.ndarray:
    """Return how often each column of an `rfft2` stands in the full transform, shape (1, nx//2 + 1)."""
    nx = shape[1]
    weights = np.full((1, nx // 2 + 1), 2.0)
    weights[:, 0] = 1.0
    if nx % 2 == 0:
        weights[:, -1] = 1.0
    return weights
