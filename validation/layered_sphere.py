"""A sphere pressed on a layer with a rigid base, by an integral equation: no grid, no period, no solver."""

from typing import NamedTuple

import numpy as np

_POINTS, _WAVES = 80, 600  # of Gauss and Legendre, along the contact radius and the wavenumber
_SHORTEST = 40.0  # |q| t from which the layer is a half-space, to 1e-30


class LayeredSphere(NamedTuple):
    """What belongs to a contact radius: the approach (m) and the force over E* (m²)."""

    approach: float
    force: float


def rigid_base_factor(x: np.ndarray, poissons_ratio: float) -> np.ndarray:
    """Return E* |q| S(q)/2 of a layer bonded to a rigid base, a function of x = |q| t [1]_.

    Digits cancel below x = 0.01 where the layer is incompressible.

    References
    ----------
    .. [1] Lebedev and Ufliand (1958), Axisymmetric contact problem for an elastic layer, J. Appl. Math. Mech.
       22, 442.

    Examples
    --------
    A thin layer is a bed of springs, (1 - 2 nu)/(1 - nu)^2 x/2; short waves do not feel the base:

    >>> rigid_base_factor(np.array([0.002, 30.0]), 0.25).round(6).tolist()
    [0.000889, 1.0]
    """
    k, decay = 3 - 4 * poissons_ratio, np.exp(-2 * x)
    above = k * (1 - decay**2) - 4 * x * decay
    below = k * (1 + decay**2) + 2 * decay * (2 * x**2 + 5 - 12 * poissons_ratio + 8 * poissons_ratio**2)
    return above / below


def sphere_on_layer(
    contact_radius: float, radius: float, thickness: float, poissons_ratio: float
) -> LayeredSphere:
    """Return approach and force of a rigid sphere (a paraboloid) on a bonded layer with a rigid base.

    The pressure is that of a function phi(x) along the contact radius a, with phi(a) = 0 [1]_::

        phi(x) - 2/pi int_0^a phi(y) int_0^inf (1 - f(q t)) cos(qx) cos(qy) dq dy = E*/pi (delta - x²/R)

    and F = 2 pi int_0^a phi. f is the `rigid_base_factor`; f = 1 is Hertz.

    Parameters
    ----------
    contact_radius, radius, thickness : float, m
        a, R and t.
    poissons_ratio : float
        of the layer.

    References
    ----------
    .. [1] Lebedev and Ufliand (1958), J. Appl. Math. Mech. 22, 442.

    Examples
    --------
    On a layer far thicker than the contact it is Hertz, delta = a²/R and F = 4 a³/(3 R):

    >>> found = sphere_on_layer(1.0, 3.0, 1e4, 0.3)
    >>> print(f"{3 * found.approach:.3f} {9 / 4 * found.force:.3f}")
    1.000 1.000
    """
    x, weight = _gauss(_POINTS, contact_radius)
    q, share = _gauss(_WAVES, _SHORTEST / thickness)
    share = 2 / np.pi * share * (1 - rigid_base_factor(q * thickness, poissons_ratio))
    waves = np.cos(np.outer(q, x))
    matrix = np.eye(_POINTS) - (waves.T * share) @ waves * weight
    sides = np.stack([np.ones_like(x), x**2 / radius], axis=1) / np.pi
    parts = np.linalg.solve(matrix, sides)
    edge = (share * np.cos(q * contact_radius)) @ waves * weight
    ends = np.array([1, contact_radius**2 / radius]) / np.pi + edge @ parts
    approach = float(ends[1] / ends[0])
    return LayeredSphere(approach, float(2 * np.pi * weight @ (approach * parts[:, 0] - parts[:, 1])))


def _gauss(points: int, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of Gauss and Legendre from 0 to an end."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    return (nodes + 1) * end / 2, weights * end / 2
