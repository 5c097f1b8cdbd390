"""The elastic energy of the half-space: of a pressure on it, and of a map that is pressed flat."""

import numpy as np

from roughcontact.choices import Influence
from roughcontact.elasticity.influence import symbol
from roughcontact.elasticity.layers import LayeredPair
from roughcontact.kernels.waves import over_waves, over_wavevectors, wave_power


def elastic_energy(
    pressure: np.ndarray,
    steps: tuple[float, float],
    *,
    contact_modulus: float,
    influence: Influence = "sampled",
    layers: LayeredPair | None = None,
) -> float:
    """Return the elastic energy per area, U = 1/2 sum_{q != 0} S(q)/E* |p(q)|^2, J/m^2.

    It is half the mean of pressure times displacement [1]_, zero for a uniform pressure.

    `pressure` (ny, nx) in Pa: periodic; `steps` (dy, dx) in m: of the points; `contact_modulus` in Pa: E*;
    `influence`: symbol S of the operator that the contact was solved with
    (`roughcontact.elasticity.influence`), 2/|q| for ``sampled``; `layers`: of the bodies
    (`roughcontact.elasticity.layers`); E* is then that of their surfaces.

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
    total = 0.0
    for qy, qx, power in over_wavevectors(wave_power(pressure), pressure.shape, steps):
        compliance = symbol(influence, qy, qx, steps, layers)
        compliance[np.isinf(compliance)] = 0.0  # of the mean, which has no power
        total += float((power * compliance).sum())
    return total / (2 * contact_modulus)


def conforming_energy(
    height: np.ndarray,
    steps: tuple[float, float],
    *,
    contact_modulus: float,
    power: np.ndarray | None = None,
    layers: LayeredPair | None = None,
) -> float:
    """Return the elastic energy per area of a map that is pressed flat, U = E*/4 sum |q| |h(q)|^2, J/m^2.

    `height` (ny, nx) in m: periodic; `steps` (dy, dx) in m: of the points; `contact_modulus` in Pa: E*;
    `power` (ny, nx // 2 + 1) in m^2: of its waves (`roughcontact.kernels.waves.wave_power`), if already
    known; `layers`: of the bodies: each wave is divided by their factor.

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
    power = wave_power(height) if power is None else power
    total = 0.0
    for q2, weight in over_waves(power, height.shape, steps):
        q = np.sqrt(q2)
        if layers is not None:
            q /= layers.factor(np.where(q > 0, q, 1.0))
        total += float((q * weight).sum())
    return total * contact_modulus / 4
