"""Fourier conventions, in one place.

Transforms are real-to-complex over the last axis (`rfft2` layout), FFT order, never shifted; angular
wavevectors in rad per unit length. Fields have shape (ny, nx); a profile is a field with one row.
"""

from collections.abc import Sequence

import numpy as np


def wavevectors(shape: Sequence[int], spacing: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the angular wavevectors of a field's `rfft2`, in rad per unit of the spacing (dy, dx).

    Returns
    -------
    qy : array (ny, 1)
        the highest frequency of an even side is negative, as in `numpy.fft.fftfreq`.
    qx : array (1, nx // 2 + 1)
        none is negative.

    Examples
    --------
    >>> import numpy as np
    >>> qy, qx = wavevectors((4, 6), (0.25, 0.5))  # sides of 1 and 3
    >>> print(np.round(qy.ravel() / (2 * np.pi), 3), np.round(qx.ravel() * 3 / (2 * np.pi), 3))
    [ 0.  1. -2. -1.] [0. 1. 2. 3.]
    """
    (ny, nx), (dy, dx) = shape, spacing
    qy = 2 * np.pi * np.fft.fftfreq(ny, dy)[:, None]
    qx = 2 * np.pi * np.fft.rfftfreq(nx, dx)[None, :]
    return qy, qx


def wavenumbers(shape: Sequence[int], spacing: Sequence[float]) -> np.ndarray:
    """Return the length |q| of the `wavevectors`, (ny, nx // 2 + 1), in rad per unit of the spacing (dy, dx).

    Examples
    --------
    >>> import numpy as np
    >>> print(np.round(wavenumbers((2, 2), (1.0, 1.0)) / np.pi, 3))
    [[0.    1.   ]
     [1.    1.414]]
    """
    qy, qx = wavevectors(shape, spacing)
    return np.hypot(qy, qx)


def halfplane_weights(shape: Sequence[int]) -> np.ndarray:
    """Return how often each column of an `rfft2`, (1, nx // 2 + 1), stands in the full transform.

    2, but 1 at the zero frequency and at the Nyquist limit of an even side.

    Examples
    --------
    >>> print(halfplane_weights((5, 6)), halfplane_weights((5, 5)))
    [[1. 2. 2. 1.]] [[1. 2. 2.]]
    """
    nx = shape[1]
    weights = np.full((1, nx // 2 + 1), 2.0)
    weights[:, 0] = 1.0
    if nx % 2 == 0:
        weights[:, -1] = 1.0
    return weights
