"""Influence functions: how a pressure of wave vector q displaces the surface, u = S(q) p / E*.

To add one, write (qy, qx, spacing, layers) -> S, positive, a length, and add its name to `INFLUENCE` and
`roughcontact.choices`. Layers multiply 2/|q| by a factor of |q| alone (`roughcontact.elasticity.layers`).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from roughcontact.choices import Influence
from roughcontact.elasticity.layers import LayeredPair
from roughcontact.kernels.arrays import Array, empty, like_array
from roughcontact.kernels.choose import kernels_for

if TYPE_CHECKING:
    from scipy.interpolate import RectBivariateSpline

InfluenceFunction = Callable[[np.ndarray, np.ndarray, tuple[float, float]], np.ndarray]

_NODES = 129  # along each axis of the first quarter of the Brillouin zone
_IMAGES = 40  # aliases that are summed on each side
_SMALL = 1e-9  # change of the factor of an alias by layers below which it is left out


def sampled(
    qy: np.ndarray,
    qx: np.ndarray,
    spacing: tuple[float, float],
    layers: LayeredPair | None = None,
    like: Array | None = None,
) -> Array:
    """Return 2/|q| at wave vectors (ny, 1) and (1, nx//2 + 1), infinite at 0: Johnson (1985), chapter 13.

    Examples
    --------
    >>> import numpy as np
    >>> sampled(np.array([[0.0], [3.0]]), np.array([[4.0]]), (1.0, 1.0)).ravel().tolist()
    [0.5, 0.4]
    """
    like = qx if like is None else like
    precision = np.result_type(qy, qx)
    symbol = empty(like, precision.name, (qy.size, qx.size))
    along_y, along_x = (like_array(q.ravel() ** 2, like) for q in (qy, qx))
    kernels_for(symbol).inverse_root(along_y, along_x, symbol)
    if layers is not None:
        symbol *= like_array(layers.factor(_wavenumbers(qy, qx)).astype(precision), like)
    return symbol


def elements(
    qy: np.ndarray, qx: np.ndarray, spacing: tuple[float, float], layers: LayeredPair | None = None
) -> np.ndarray:
    """Return the symbol of pressures constant on every pixel, with displacements at their centres.

    It is the sum over the aliases Q = q + 2 pi (m/dy, n/dx) of S(Q) sinc(Q_y dy/2) sinc(Q_x dx/2), S that of
    `sampled`: the rectangle of Love (1929, Phil. Trans. R. Soc. A 228, 377), repeated with the period of the
    grid. The wave itself is exact; the sum over all others is smooth, and interpolated between a few nodes.
    """
    pixel = spacing[1]
    # rounded, because the same pixels on another grid differ in the last digit
    aspect = float(f"{spacing[0] / pixel:.12g}")
    alias_terms = [_other_aliases(aspect, None)]
    alias_terms += [] if layers is None else [_other_aliases(aspect, layers.scaled(pixel))]
    phase_y, phase_x = (
        np.clip(np.abs(q).ravel() * d, 0, np.pi) for q, d in zip((qy, qx), spacing, strict=True)
    )
    element_transform = np.sinc(phase_y / (2 * np.pi))[:, None] * np.sinc(phase_x / (2 * np.pi))
    row, back_y = np.unique(phase_y, return_inverse=True)
    column, back_x = np.unique(phase_x, return_inverse=True)
    symbol = sampled(qy, qx, spacing, layers)
    symbol *= element_transform.astype(symbol.dtype)
    for alias_term in alias_terms:
        symbol += (pixel * alias_term(row, column)[np.ix_(back_y, back_x)]).astype(symbol.dtype)
    return symbol


@lru_cache(maxsize=16)
def _other_aliases(aspect: float, layers: LayeredPair | None) -> "RectBivariateSpline":
    """Return the sum over all aliases but the wave itself, as a function of q_y dy and q_x dx, 0 to pi.

    It is that of the half-space, or what `layers` change of it. Lengths are in pixels along x; `aspect` =
    dy/dx.
    """
    from scipy.interpolate import RectBivariateSpline

    angles = np.linspace(0, np.pi, _NODES)
    half_y, half_x = 0.5 * angles[:, None], 0.5 * angles[None, :]
    total = np.zeros((angles.size, angles.size))
    orders = np.arange(-_IMAGES, _IMAGES + 1)
    weights = np.where(np.abs(orders) == _IMAGES, 0.5, 1.0)
    finer, coarser = min(1.0, 1 / aspect), max(1.0, 1 / aspect)
    q: np.ndarray = np.geomspace(0.9 * np.pi * finer, 3 * np.pi * _IMAGES * coarser, 2 * _NODES**2)
    change = np.zeros_like(q) if layers is None else layers.factor(q) - 1
    changed = np.flatnonzero(np.abs(change) > _SMALL)
    last = float(q[changed[-1]]) if changed.size else 0.0
    for m, weight_y in zip(orders, weights, strict=True):
        y = half_y + np.pi * m
        for n, weight_x in zip(orders, weights, strict=True):
            nearest = np.pi * math.hypot(max(2 * abs(int(m)) - 1, 0) / aspect, max(2 * abs(int(n)) - 1, 0))
            if m == 0 == n or (layers is not None and nearest > last):
                continue
            x = half_x + np.pi * n
            alias = np.hypot(2 * y / aspect, 2 * x)
            share = 2 / alias if layers is None else 2 / alias * np.interp(alias, q, change)
            total += weight_y * weight_x * share * np.sinc(y / np.pi) * np.sinc(x / np.pi)
    return RectBivariateSpline(angles, angles, total)


def _wavenumbers(qy: np.ndarray, qx: np.ndarray) -> np.ndarray:
    """Return |q| in double precision; that of the mean, which no operator uses, counts as the largest."""
    q: np.ndarray = np.hypot(qy.astype(float), qx.astype(float))
    q[q == 0] = float(q.max()) or 1.0
    return q


INFLUENCE: dict[Influence, Callable] = {"sampled": sampled, "elements": elements}


@dataclass(frozen=True)
class Elasticity:
    """How a pressure displaces the surfaces, up to the hardness, the largest that they carry."""

    modulus: float = 1.0  # E* of the surfaces, Pa
    influence: Influence | InfluenceFunction = "sampled"
    layers: LayeredPair | None = None  # m
    hardness: float = math.inf  # Pa

    def scaled(self, length: float, pressure: float = 1.0) -> "Elasticity":
        """Return it with the layers in a unit of length, and the hardness in one of pressure."""
        layers = self.layers and self.layers.scaled(length)
        return replace(self, layers=layers, hardness=self.hardness / pressure)

    def symbol(
        self, qy: np.ndarray, qx: np.ndarray, spacing: tuple[float, float], like: Array | None = None
    ) -> Array:
        """Return S(q) in the library and on the device of the array `like`, by default in NumPy."""
        if self.influence == "sampled":  # made on the device; others are made by NumPy
            return sampled(qy, qx, spacing, self.layers, like)
        if callable(self.influence):
            values = np.asarray(self.influence(qy, qx, spacing))
        else:
            values = np.asarray(INFLUENCE[self.influence](qy, qx, spacing, self.layers))
        return values if like is None else like_array(values, like)


HALF_SPACE = Elasticity()
