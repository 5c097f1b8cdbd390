"""Influence functions: how a pressure of wave vector q displaces the surface, u = S(q) p / E*.

To add one, for instance that of a coated half-space, write a function (qy, qx, spacing) -> S here and add its
name to `INFLUENCE` and `roughcontact.choices`; S must be positive and have the dimension of a length.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from roughcontact.choices import Influence

if TYPE_CHECKING:
    from scipy.interpolate import RectBivariateSpline

_NODES = 129  # along each axis of the first quarter of the Brillouin zone
_IMAGES = 40  # aliases that are summed on each side


def sampled(qy: np.ndarray, qx: np.ndarray, spacing: tuple[float, float]) -> np.ndarray:
    """Return 2/|q|: the half-space at the waves that the grid can hold [1]_.

    The wave vectors have the shapes (ny, 1) and (1, nx//2 + 1) and the unit rad per unit length. The result
    is infinite at q = 0 and does not depend on the `spacing`.

    References
    ----------
    .. [1] Johnson (1985), Contact Mechanics, chapter 13.

    Examples
    --------
    >>> import numpy as np
    >>> sampled(np.array([[0.0], [3.0]]), np.array([[4.0]]), (1.0, 1.0)).ravel().tolist()
    [0.5, 0.4]
    """
    symbol = qy * qy + qx * qx
    np.sqrt(symbol, out=symbol)
    with np.errstate(divide="ignore"):
        return np.divide(2, symbol, out=symbol)


def elements(qy: np.ndarray, qx: np.ndarray, spacing: tuple[float, float]) -> np.ndarray:
    """Return the symbol of pressures constant on every pixel, displacements taken at their centres.

    It is the sum over the aliases Q = q + 2 pi (m/dy, n/dx) of 2/|Q| sinc(Q_y dy/2) sinc(Q_x dx/2): Love's
    rectangle [1]_, repeated with the period of the grid. Its ratio to 2/|q| depends on q_y dy and q_x dx
    alone and is smooth: it is summed at a few nodes and interpolated. Shapes and units are those of
    `sampled`.

    References
    ----------
    .. [1] Love (1929), The stress produced in a semi-infinite solid by pressure on part of the boundary,
       Phil. Trans. R. Soc. A 228, 377.
    """
    # rounded, because the same pixels on another grid differ in the last digit
    ratio = _elements_over_sampled(float(f"{spacing[0] / spacing[1]:.12g}"))
    phase_y, phase_x = (
        np.clip(np.abs(q).ravel() * d, 0, np.pi) for q, d in zip((qy, qx), spacing, strict=True)
    )
    row, back_y = np.unique(phase_y, return_inverse=True)
    column, back_x = np.unique(phase_x, return_inverse=True)
    symbol = sampled(qy, qx, spacing)
    symbol *= ratio(row, column)[np.ix_(back_y, back_x)].astype(symbol.dtype)
    return symbol


@lru_cache(maxsize=16)
def _elements_over_sampled(aspect: float) -> "RectBivariateSpline":
    """Return the ratio of the symbols as a function of q_y dy and q_x dx, 0 to pi, for `aspect` = dy/dx.

    It is cached, because all square grids share it and the sum takes most of a second.
    """
    from scipy.interpolate import RectBivariateSpline  # the import takes half a second

    angles = np.linspace(0, np.pi, _NODES)
    dy, dx = aspect, 1.0
    half_y, half_x = 0.5 * angles[:, None], 0.5 * angles[None, :]
    total = np.zeros((angles.size, angles.size))
    orders = np.arange(-_IMAGES, _IMAGES + 1)
    # the signs of the terms alternate: half of the outermost terms gives the mean of two partial sums
    weights = np.where(np.abs(orders) == _IMAGES, 0.5, 1.0)
    own = np.hypot(2 * half_y / dy, 2 * half_x / dx)
    for m, weight_y in zip(orders, weights, strict=True):
        y = half_y + np.pi * m
        for n, weight_x in zip(orders, weights, strict=True):
            x = half_x + np.pi * n
            alias = np.hypot(2 * y / dy, 2 * x / dx)
            share = np.divide(own, alias, out=np.ones_like(own), where=alias > 0)
            total += weight_y * weight_x * share * np.sinc(y / np.pi) * np.sinc(x / np.pi)
    return RectBivariateSpline(angles, angles, total)


INFLUENCE: dict[Influence, Callable] = {"sampled": sampled, "elements": elements}
