"""The elastic energy of the half-space: of a pressure on it, and of a map that is pressed flat."""

import numpy as np

from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.kernels.waves import each_wave, each_wavevector, wave_power


def elastic_energy(pressure: np.ndarray, steps: tuple[float, float], elasticity: Elasticity) -> float:
    """Return the energy U = 1/2 sum_{q != 0} S(q)/E* |p(q)|^2 of a pressure (ny, nx; Pa), in J/m^2.

    It is half the mean of pressure times displacement (Johnson 1985, Contact Mechanics, chapter 13), with the
    symbol S that the contact was solved with, and zero for a uniform pressure; `steps`
    (dy, dx) are in m.
    """
    total = 0.0
    for qy, qx, power in each_wavevector(wave_power(pressure), pressure.shape, steps):
        compliance = elasticity.symbol(qy, qx, steps)
        compliance[np.isinf(compliance)] = 0.0  # of the mean, which has no power
        total += float((power * compliance).sum())
    return total / (2 * elasticity.modulus)


def conforming_energy(
    height: np.ndarray, steps: tuple[float, float], elasticity: Elasticity, *, power: np.ndarray | None = None
) -> float:
    """Return the elastic energy per area of a map that is pressed flat, U = E*/4 sum |q| |h(q)|^2, J/m^2.

    Johnson (1985), Contact Mechanics, chapter 13; `height` (ny, nx) and `steps` (dy, dx) in m, the `power`
    (m^2) of its waves (ny, nx // 2 + 1) where known; each wave is divided by the factor of the medium.
    """
    power = wave_power(height) if power is None else power
    total = 0.0
    for q2, weight in each_wave(power, height.shape, steps):
        q = np.sqrt(q2)
        q /= elasticity.medium.factor(np.where(q > 0, q, 1.0))  # any factor for the mean, whose q is zero
        total += float((q * weight).sum())
    return total * elasticity.modulus / 4
