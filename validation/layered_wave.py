"""Stresses in a stack of layers below a pressure wave, by one system of equations of all layers."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Constants = tuple[float, float]


def layered_wave_stresses(
    depths: npt.ArrayLike, layers: Sequence[tuple[float, float, float]], base: Constants | None
) -> np.ndarray:
    """Return the stresses below a pressure wave cos(x) on bonded layers, by Airy's stress function [1]_.

    In every layer that is F cos x, F = (a + b z) exp(-z) + (c + d (t - z)) exp(z - t), in the base (a + b z)
    exp(-z) [2]_. The coefficients of all layers follow at once from the tractions at the surface, and those
    and the displacements on both sides of each interface. Digits are lost where t is far from 1.

    Parameters
    ----------
    depths : array, of unit 1/q
        within the layers or the base; at an interface those of the layer above.
    layers : sequence of (float, float, float)
        thickness times q, Young's modulus and Poisson's ratio, from the surface inwards.
    base : (float, float), optional
        Young's modulus and Poisson's ratio; None: rigid.

    Returns
    -------
    array (3, depths)
        normal stress across the surface over cos x, shear over sin x, normal stress along the wave over cos
        x, per amplitude of the pressure; tension is positive.

    References
    ----------
    .. [1] Johnson (1985), Contact Mechanics, sections 2.2 and 13.2.
    .. [2] O'Sullivan and King (1988), Sliding contact stress field due to a spherical indenter on a layered
       elastic half-space, ASME J. Tribol. 110, 235.

    Examples
    --------
    A layer like its base is a half-space, with the shear z exp(-z):

    >>> found = layered_wave_stresses([0.5, 2.0], [(1.0, 3.0, 0.3)], (3.0, 0.3))
    >>> print((found[1] / np.exp([-0.5, -2.0])).round(12))
    [-0.5 -2. ]
    """
    stack = [*layers, *([] if base is None else [(np.inf, *base)])]
    size = 4 * len(layers) + (0 if base is None else 2)
    rows, right = [], np.zeros(size)
    first = np.zeros((5, size))
    first[:, :4] = _state(0.0, *stack[0])
    rows += [first[0], first[1]]
    right[0] = -1
    for number, (thickness, *constants) in enumerate(layers):
        jump = np.zeros((5, size))
        jump[:, 4 * number : 4 * number + 4] = _state(thickness, thickness, *constants)
        if number + 1 < len(stack):
            below = _state(0.0, *stack[number + 1])
            jump[:, 4 * number + 4 : 4 * number + 4 + below.shape[1]] -= below
            rows += [jump[0], jump[1]]
        rows += [jump[3], jump[4]]
    computed = np.linalg.solve(np.array(rows), right)
    faces = np.cumsum([thickness for thickness, _, _ in layers])
    stresses = []
    for depth in np.ravel(depths):
        number = int(np.searchsorted(faces, depth))
        state = _state(depth - (faces[number - 1] if number else 0.0), *stack[number])
        stresses.append((state @ computed[4 * number : 4 * number + state.shape[1]])[:3])
    return np.array(stresses).T


def _state(z: float, thickness: float, youngs_modulus: float, poissons_ratio: float) -> np.ndarray:
    """Return normal stress, shear, stress along, and the two displacements at a depth, by coefficient."""
    nu, two_mu = poissons_ratio, youngs_modulus / (1 + poissons_ratio)
    order = np.arange(4)
    terms = np.array([(-1.0) ** order, (-1.0) ** order * (z - order)]) * np.exp(-z)
    if np.isfinite(thickness):
        up = thickness - z
        terms = np.concatenate([terms, np.array([np.ones(4), up - order]) * np.exp(-up)])
    f, f1, f2, f3 = terms.T  # of every coefficient the function and its derivatives
    return np.array([-f, f1, f2, ((1 - nu) * f2 + nu * f) / two_mu, ((1 - nu) * f3 - (2 - nu) * f1) / two_mu])
