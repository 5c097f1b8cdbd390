"""The elastic energy of a pressure on the half-space."""

import numpy as np

from roughcontact.fourier import halfplane_weights, wavenumbers


def elastic_energy(pressure: np.ndarray, steps: tuple[float, float], *, contact_modulus: float) -> float:
    """Return the elastic energy per area, ½ Σ_{q≠0} 2/(E*|q|) |p̂(q)|² (J/m²): zero for uniform pressure.

    Parameters
    ----------
    pressure : array (ny, nx), Pa
    steps : (dy, dx), m
    contact_modulus : float, Pa
    """
    wavenumber = wavenumbers(pressure.shape, steps)
    wavenumber[0, 0] = np.inf
    spectrum = np.fft.rfft2(pressure - pressure.mean()) / pressure.size
    power = spectrum.real**2 + spectrum.imag**2
    return float((halfplane_weights(pressure.shape) * power / wavenumber).sum() / contact_modulus)
