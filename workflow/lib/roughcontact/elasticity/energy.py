"""The elastic energy of the half-space: of a pressure on it, and of a map that is pressed flat."""

import numpy as np

from roughcontact.fourier import halfplane_weights, wavenumbers


def elastic_energy(pressure: np.ndarray, steps: tuple[float, float], *, contact_modulus: float) -> float:
    """Return the elastic energy per area, U = 1/2 sum_{q != 0} 2/(E*|q|) |p(q)|^2.

    Parameters
    ----------
    pressure : array (ny, nx), Pa
        periodic.
    steps : (dy, dx), m
        of the points.
    contact_modulus : float, Pa
        E*.

    Returns
    -------
    float, J/m^2
        zero for a uniform pressure.

    References
    ----------
    .. [1] Johnson (1985), Contact Mechanics, chapter 13.

    Examples
    --------
    A pressure wave of amplitude A stores A^2/(2 E* q):

    >>> import numpy as np
    >>> wave = 2.0 * np.cos(2 * np.pi * np.arange(16) / 16)[None, :]
    >>> print(f"{elastic_energy(wave, (1 / 16, 1 / 16), contact_modulus=1.0) * 2 * np.pi:.6f}")
    2.000000
    """
    spectrum = np.fft.rfft2(pressure - pressure.mean())
    spectrum /= pressure.size
    power = spectrum.real**2 + spectrum.imag**2
    del spectrum
    wavenumber = wavenumbers(pressure.shape, steps)
    wavenumber[0, 0] = np.inf
    return float((halfplane_weights(pressure.shape) * power / wavenumber).sum() / contact_modulus)


def conforming_energy(height: np.ndarray, steps: tuple[float, float], *, contact_modulus: float) -> float:
    """Return the elastic energy per area of a map that is pressed flat, U = E*/4 sum |q| |h(q)|^2.

    Parameters
    ----------
    height : array (ny, nx), m
        periodic.
    steps : (dy, dx), m
        of the points.
    contact_modulus : float, Pa
        E*.

    Returns
    -------
    float, J/m^2

    References
    ----------
    .. [1] Johnson (1985), Contact Mechanics, chapter 13.

    Examples
    --------
    A wave of amplitude D costs E* q D^2/8:

    >>> import numpy as np
    >>> wave = 2.0 * np.cos(2 * np.pi * np.arange(16) / 16)[None, :]
    >>> print(f"{conforming_energy(wave, (1 / 16, 1 / 16), contact_modulus=1.0) / np.pi:.6f}")
    1.000000
    """
    spectrum = np.fft.rfft2(height - height.flat[0]) / height.size
    power = spectrum.real**2 + spectrum.imag**2
    weights = halfplane_weights(height.shape) * wavenumbers(height.shape, steps)
    return float((weights * power).sum() * contact_modulus / 4)
