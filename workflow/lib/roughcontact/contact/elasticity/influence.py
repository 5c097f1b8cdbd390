"""Influence functions: how a pressure of wave vector q displaces the surface, u = S(q) p / E*.

To add one, write (qy, qx, spacing, medium) -> S, positive, a length, and add its name to `INFLUENCE` and
`arguments.choices`. A medium multiplies 2/|q| by a factor of |q| alone (`contact.elasticity.medium`).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from roughcontact.arguments.choices import Influence
from roughcontact.contact.elasticity.medium import HALF_SPACES, Medium
from roughcontact.kernels.arrays import Array, empty, like_array
from roughcontact.kernels.choose import kernels_for

if TYPE_CHECKING:
    from scipy.interpolate import RectBivariateSpline

InfluenceFunction = Callable[[np.ndarray, np.ndarray, tuple[float, float]], np.ndarray]

_NODES = 129  # along each axis of the first quarter of the Brillouin zone
_IMAGES = 40  # aliases that are summed on each side
_SMALL = 1e-9  # departure of the factor of an alias from 1 below which it is left out


def sampled(
    qy: np.ndarray,
    qx: np.ndarray,
    spacing: tuple[float, float],
    medium: Medium = HALF_SPACES,
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
    medium.weigh(symbol, qy, qx)
    return symbol


def elements(
    qy: np.ndarray, qx: np.ndarray, spacing: tuple[float, float], medium: Medium = HALF_SPACES
) -> np.ndarray:
    """Return the symbol of pressures constant on every pixel, with displacements at their centres.

    It is the sum over the aliases Q = q + 2 pi (m/dy, n/dx) of S(Q) sinc(Q_y dy/2) sinc(Q_x dx/2), S that of
    `sampled`: the rectangle of Love (1929, Phil. Trans. R. Soc. A 228, 377), repeated with the period of the
    grid. The wave itself is exact; the sum over all others is smooth, and interpolated between a few nodes.
    """
    pixel = spacing[1]
    # rounded, because the same pixels on another grid differ in the last digit
    aspect = float(f"{spacing[0] / pixel:.12g}")
    alias_terms = [_half_space_aliases(aspect)]
    alias_terms += [_departing_aliases(aspect, departure) for departure in medium.scaled(pixel).departures]
    phase_y, phase_x = (
        np.clip(np.abs(q).ravel() * d, 0, np.pi) for q, d in zip((qy, qx), spacing, strict=True)
    )
    element_transform = np.sinc(phase_y / (2 * np.pi))[:, None] * np.sinc(phase_x / (2 * np.pi))
    row, back_y = np.unique(phase_y, return_inverse=True)
    column, back_x = np.unique(phase_x, return_inverse=True)
    symbol = sampled(qy, qx, spacing, medium)
    symbol *= element_transform.astype(symbol.dtype)
    for alias_term in alias_terms:
        symbol += (pixel * alias_term(row, column)[np.ix_(back_y, back_x)]).astype(symbol.dtype)
    return symbol


@lru_cache(maxsize=16)
def _half_space_aliases(aspect: float) -> "RectBivariateSpline":
    """Return the sum over all aliases but the wave itself, as a function of q_y dy and q_x dx, 0 to pi.

    Lengths are in pixels along x; `aspect` = dy/dx.
    """
    return _alias_sum(aspect, lambda alias: 2 / alias)


@lru_cache(maxsize=16)
def _departing_aliases(aspect: float, medium: Medium) -> "RectBivariateSpline":
    """Return what a medium adds to `_half_space_aliases`."""
    finer, coarser = min(1.0, 1 / aspect), max(1.0, 1 / aspect)
    # from just below the nearest alias to beyond the farthest
    q: np.ndarray = np.geomspace(0.9 * np.pi * finer, 3 * np.pi * _IMAGES * coarser, 2 * _NODES**2)
    change = medium.factor(q) - 1
    significant = np.flatnonzero(np.abs(change) > _SMALL)
    last = float(q[significant[-1]]) if significant.size else 0.0
    return _alias_sum(aspect, lambda alias: 2 / alias * np.interp(alias, q, change), last)


def _alias_sum(
    aspect: float, symbol: Callable[[np.ndarray], np.ndarray], last: float = math.inf
) -> "RectBivariateSpline":
    """Return the sum of a symbol over the aliases but the wave itself, up to about the wavenumber `last`."""
    from scipy.interpolate import RectBivariateSpline

    angles = np.linspace(0, np.pi, _NODES)
    half_y, half_x = 0.5 * angles[:, None], 0.5 * angles[None, :]
    total = np.zeros((angles.size, angles.size))
    orders = np.arange(-_IMAGES, _IMAGES + 1)
    weights = np.where(np.abs(orders) == _IMAGES, 0.5, 1.0)
    for m, weight_y in zip(orders, weights, strict=True):
        y = half_y + np.pi * m
        for n, weight_x in zip(orders, weights, strict=True):
            nearest = np.pi * math.hypot(max(2 * abs(int(m)) - 1, 0) / aspect, max(2 * abs(int(n)) - 1, 0))
            if m == 0 == n or nearest > last:
                continue
            x = half_x + np.pi * n
            share = symbol(np.hypot(2 * y / aspect, 2 * x))
            total += weight_y * weight_x * share * np.sinc(y / np.pi) * np.sinc(x / np.pi)
    return RectBivariateSpline(angles, angles, total)


INFLUENCE: dict[Influence, Callable] = {"sampled": sampled, "elements": elements}


@dataclass(frozen=True)
class Elasticity:
    """How a pressure displaces the surfaces, up to the hardness, the largest that they carry."""

    modulus: float = 1.0  # E* of the surfaces, Pa
    influence: Influence | InfluenceFunction = "sampled"
    medium: Medium = HALF_SPACES  # its lengths in m
    hardness: float = math.inf  # Pa
    foundation: float = 0.0  # E* times the compliance (m/Pa) of a Winkler foundation in series, m

    def scaled(self, length: float, pressure: float = 1.0) -> "Elasticity":
        """Return it with medium and foundation in a unit of length, and the hardness in one of pressure."""
        medium, foundation = self.medium.scaled(length), self.foundation / length
        return replace(self, medium=medium, hardness=self.hardness / pressure, foundation=foundation)

    def symbol(
        self, qy: np.ndarray, qx: np.ndarray, spacing: tuple[float, float], like: Array | None = None
    ) -> Array:
        """Return S(q) in the library and on the device of the array `like`, by default in NumPy."""
        if self.influence == "sampled":  # made on the device; others are made by NumPy
            symbol = sampled(qy, qx, spacing, self.medium, like)
        else:
            influence = self.influence if callable(self.influence) else INFLUENCE[self.influence]
            medium = () if callable(self.influence) else (self.medium,)
            values = np.asarray(influence(qy, qx, spacing, *medium))
            symbol = values if like is None else like_array(values, like)
        return symbol + self.foundation if self.foundation else symbol


HALF_SPACE = Elasticity()
