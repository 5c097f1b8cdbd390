"""The half-space under a body of finite size: the kernel 1/(pi E* r), cut off beyond its contact.

No image acts on a contact in a cell of at least its width plus the distance where the kernel vanishes (Vico,
Greengard and Ferrando 2016, J. Comput. Phys. 323, 191). The symbol of a cut-off at R, (2/|q|) F(|q| R) with
F(z) the integral of J0 from 0 to z, is positive, and a linear fade is a mean of cut-offs: the certificate of
the periodic solver holds.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from roughcontact.elasticity.influence import HALF_SPACE, Elasticity
from roughcontact.elasticity.layers import LayeredPair
from roughcontact.errors import SettingsError

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

FADE = 1.15  # distance where the kernel vanishes over the distance up to which it is exact
_STEP = 0.05  # of |q| reach in the table of the symbol, whose shortest wave is 2 pi / FADE
_LONG = 300.0  # |q| reach above which a smooth fade changes the symbol of layers by less than 1e-4
_NODES = 16  # of Gauss and Legendre, on panels of at most so many radians
_RADIANS = 8.0
_DISTANCES = 400  # at which the displacement by layers is computed; a spline is between them
_DECAYED = 20.0  # |q| times the thinnest layer, where layers have no effect
_SOFTEST = 1e-5  # |q| times the thickest layer, where it follows any base


@dataclass(frozen=True)
class TruncatedKernel:
    """An influence function (`roughcontact.elasticity.influence`), exact up to the distance `reach`."""

    reach: float
    elasticity: Elasticity = HALF_SPACE  # thicknesses in the unit of the reach

    def __call__(self, qy: np.ndarray, qx: np.ndarray, spacing: tuple[float, float]) -> np.ndarray:
        """Return the symbol; infinite at q = 0, whose displacement `mean_displacement` is."""
        q: np.ndarray = np.hypot(qy.astype(float), qx.astype(float))
        q[0, 0] = highest = q.max()
        if self.elasticity.layers is not None:
            symbol = self._of_layers(q, self.elasticity.layers)
        elif self.elasticity.influence == "elements":
            symbol = transform_of_pixels((qy.size, 2 * (qx.size - 1)), spacing, self.reach).copy()
        else:
            last = 2.0 ** np.ceil(np.log2(highest * self.reach))
            symbol = 2 / q * _cut_off(float(last))(q * self.reach)
        symbol[0, 0] = np.inf
        return symbol.astype(np.result_type(qy, qx))

    def mean_displacement(self, shape: tuple[int, int], spacing: tuple[float, float]) -> float:
        """Return E* times the mean displacement per mean pressure: the symbol at q = 0."""
        if self.elasticity.layers is not None:
            symbol, farthest = _faded_layers(self.elasticity.layers, self.reach)
            return float(symbol(0.0) + farthest * np.prod(shape) * np.prod(spacing))
        if self.elasticity.influence == "elements":
            return float(transform_of_pixels(shape, spacing, self.reach)[0, 0])
        return (1 + FADE) * self.reach

    def _of_layers(self, q: np.ndarray, layers: LayeredPair) -> np.ndarray:
        """Return the symbol of bodies with layers, which has to be positive."""
        symbol = 2 / q * layers.factor(q)
        long = q * self.reach < _LONG
        symbol[long] = _faded_layers(layers, self.reach)[0](q[long] * self.reach)
        if symbol.min() <= 0:
            raise SettingsError(
                "these layers on a body of finite size have no proven solution: their compliance within the "
                "contact is not positive for every wave; solve them with boundary: periodic",
                keys=("bodies",),
            )
        return symbol


@lru_cache(maxsize=8)
def _faded_layers(layers: LayeredPair, reach: float) -> tuple["CubicSpline", float]:
    """Return the symbol over |q| reach < `_LONG` of a smoothly faded response, and its constant term.

    The response at the end of the fade is taken off: it acts on all of the contact alike, as all load is in
    it, and below stiff layers that are thick against the contact it would be most of the response.
    """
    from scipy.interpolate import CubicSpline
    from scipy.special import j0

    z: np.ndarray = np.arange(0.0, _LONG + 1, 0.1)
    end = FADE * reach
    r, weights = graded_panels(end, _RADIANS * reach / _LONG, layers.thinnest / 4)
    weights *= smooth_fade(r / reach, FADE)
    change = change_by_layers(layers, np.append(r, end))
    farthest = 1 / (np.pi * end) + float(change[-1])
    response = 2 * (1 + np.pi * r * (change[:-1] - farthest)) * weights
    return CubicSpline(z, j0(z[:, None] * (r / reach)) @ response), farthest


def change_by_layers(layers: LayeredPair, distance: np.ndarray) -> np.ndarray:
    """Return what layers add to E* times the displacement by a unit force, 1/(pi r), at distances."""
    from scipy.interpolate import CubicSpline
    from scipy.special import j0

    thinnest, farthest = layers.thinnest, float(distance.max())
    logarithm = np.linspace(0, np.arcsinh(farthest / thinnest), _DISTANCES)
    last = _DECAYED / thinnest
    widest = min(_RADIANS / farthest, 0.5 / layers.thickest)
    q, weights = graded_panels(last, widest, _SOFTEST / layers.thickest)
    weights *= (layers.factor(q) - 1) / np.pi
    values = [weights @ j0(q * r) for r in thinnest * np.sinh(logarithm)]
    return np.asarray(CubicSpline(logarithm, values)(np.arcsinh(distance / thinnest)))


def smooth_fade(distance: np.ndarray, end: float) -> np.ndarray:
    """Return the polynomial that is 1 up to the distance 1 and 0 beyond the end, smooth between them."""
    beyond = np.clip((distance - 1) / (end - 1), 0, 1)
    return np.asarray(1 - beyond**3 * (10 - 15 * beyond + 6 * beyond**2))


def graded_panels(end: float, widest: float, finest: float) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of a quadrature (Gauss and Legendre) on panels that are halved towards 0."""
    points, weights = np.polynomial.legendre.leggauss(_NODES)
    halved = end * 0.5 ** np.arange(max(1.0, np.ceil(np.log2(end / finest))))
    edges = np.union1d(np.linspace(0, end, int(np.ceil(end / widest)) + 1), halved)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + points)).ravel(), (half * weights).ravel()


@lru_cache(maxsize=2)
def transform_of_pixels(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    reach: float = np.inf,
    layers: LayeredPair | None = None,
) -> np.ndarray:
    """Return the symbol (ny, nx // 2 + 1), of even sides, of Love's kernel, faded beyond the reach."""
    from scipy import fft

    y, x = (np.arange(n // 2 + 1) * d for n, d in zip(shape, spacing, strict=True))
    distance = np.hypot(y[:, None], x)
    response = love(distance.shape, spacing) * np.clip((FADE - distance / reach) / (FADE - 1), 0, 1)
    if layers is not None:
        response += change_by_layers(layers, distance) * spacing[0] * spacing[1]
    rows = np.arange(shape[0])
    return np.asarray(fft.dctn(response, type=1)[np.minimum(rows, shape[0] - rows)])


def love(shape: tuple[int, ...], spacing: tuple[float, float]) -> np.ndarray:
    """Return E* u (ny, nx) at the distances (i dy, j dx) from a pixel under unit pressure (Love 1929)."""
    y, x = (np.abs(np.arange(n + 1) - 0.5)[:, None] * d for n, d in zip(shape, spacing, strict=True))
    x = x.T
    # the potential of a rectangle seen from its corner, which is odd in both sides
    corner = (x * np.arcsinh(y / x) + y * np.arcsinh(x / y)) / np.pi
    corner[0] *= -1
    corner[:, 0] *= -1
    return np.diff(np.diff(corner, axis=0), axis=1)


@lru_cache(maxsize=8)
def _cut_off(last: float) -> "CubicSpline":
    """Return the factor of 2/|q| as a function of |q| reach up to `last`."""
    from scipy.interpolate import CubicSpline
    from scipy.special import itj0y0, j1

    z: np.ndarray = np.arange(_STEP, last + 2 * _STEP, _STEP)
    ends = np.outer([1.0, FADE], z)
    start, end = ends * itj0y0(ends)[0] - ends * j1(ends)  # the integral of F from 0
    return CubicSpline(np.append(0.0, z), np.append(0.0, (end - start) / ((FADE - 1) * z)))
