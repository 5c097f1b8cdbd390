"""The half-space under a body of finite size: the kernel 1/(pi E* r), cut off beyond its contact.

No image acts on a contact in a cell of at least its width plus the distance where the kernel vanishes (Vico,
Greengard and Ferrando 2016, J. Comput. Phys. 323, 191). The symbol of a cut-off at R, (2/|q|) F(|q| R) with
F(z) the integral of J0 from 0 to z, is positive, and a linear fade is a mean of cut-offs: the certificate of
the periodic solver holds.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from roughcontact.contact.elasticity.fade import FADE
from roughcontact.contact.elasticity.influence import HALF_SPACE, Elasticity
from roughcontact.contact.elasticity.medium import HALF_SPACES, Medium

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

_STEP = 0.05  # of |q| reach in the table of the symbol, whose shortest wave is 2 pi / FADE


@dataclass(frozen=True)
class TruncatedKernel:
    """An influence function (`contact.elasticity.influence`), exact up to the distance `reach`."""

    reach: float
    elasticity: Elasticity = HALF_SPACE  # its lengths in the unit of the reach

    def __call__(self, qy: np.ndarray, qx: np.ndarray, spacing: tuple[float, float]) -> np.ndarray:
        """Return the symbol; infinite at q = 0, whose displacement `mean_displacement` is."""
        q: np.ndarray = np.hypot(qy.astype(float), qx.astype(float))
        q[0, 0] = q.max()  # any value: that of q = 0 is replaced below
        symbol = self._response.symbol(q, spacing)
        symbol[0, 0] = np.inf
        return symbol.astype(np.result_type(qy, qx))

    def mean_displacement(self, shape: tuple[int, int], spacing: tuple[float, float]) -> float:
        """Return E* times the mean displacement per mean pressure: the symbol at q = 0."""
        return self._response.mean(shape, spacing)

    @property
    def _response(self) -> "_Response":
        """The response of the medium, or of the influence function."""
        of_medium = self.elasticity.medium.free_response(self.reach)
        return of_medium or _RESPONSES[self.elasticity.influence](self.reach)


class _Response(Protocol):
    """A response that is cut off, by its symbol (of wavenumbers q) and its mean."""

    def symbol(self, q: np.ndarray, spacing: tuple[float, float]) -> np.ndarray: ...

    def mean(self, shape: tuple[int, int], spacing: tuple[float, float]) -> float: ...


@dataclass(frozen=True)
class _PointForces:
    """The response of the half-space to point forces."""

    reach: float

    def symbol(self, q: np.ndarray, spacing: tuple[float, float]) -> np.ndarray:
        """Return 2/|q| times a factor of |q| reach."""
        # a power of two, so that many grids share a table
        last = 2.0 ** np.ceil(np.log2(q.max() * self.reach))
        return np.asarray(2 / q * _cut_off(float(last))(q * self.reach))

    def mean(self, shape: tuple[int, int], spacing: tuple[float, float]) -> float:
        """Return the limit of the symbol for q to 0."""
        # twice the integral of the fade, linear from the reach to FADE times it
        return (1 + FADE) * self.reach


@dataclass(frozen=True)
class _Pixels:
    """The response of the half-space to pressures constant on every pixel."""

    reach: float

    def symbol(self, q: np.ndarray, spacing: tuple[float, float]) -> np.ndarray:
        """Return the transform of Love's kernel."""
        return transform_of_pixels((len(q), 2 * (q.shape[1] - 1)), spacing, self.reach).copy()

    def mean(self, shape: tuple[int, int], spacing: tuple[float, float]) -> float:
        """Return the same at q = 0."""
        return float(transform_of_pixels(shape, spacing, self.reach)[0, 0])


_RESPONSES: dict[Any, Callable[[float], _Response]] = {"sampled": _PointForces, "elements": _Pixels}


@lru_cache(maxsize=2)
def transform_of_pixels(
    shape: tuple[int, int], spacing: tuple[float, float], reach: float = np.inf, medium: Medium = HALF_SPACES
) -> np.ndarray:
    """Return the symbol (ny, nx // 2 + 1), of even sides, of Love's kernel, faded beyond the reach."""
    from scipy import fft

    y, x = (np.arange(n // 2 + 1) * d for n, d in zip(shape, spacing, strict=True))
    distance = np.hypot(y[:, None], x)
    response = love(distance.shape, spacing) * np.clip((FADE - distance / reach) / (FADE - 1), 0, 1)
    response += medium.change_of_point_force(distance) * spacing[0] * spacing[1]
    rows = np.arange(shape[0])
    # row n - k is row k of an even function
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
    from scipy.special import j0, j1, struve

    z: np.ndarray = np.arange(_STEP, last + 2 * _STEP, _STEP)
    limits = np.outer([1.0, FADE], z)
    # the integral of J0 by Struve functions (DLMF 10.22.2): `itj0y0` is wrong above 20 before SciPy 1.17
    of_j0 = limits * j0(limits)
    of_j0 += np.pi / 2 * limits * (j1(limits) * struve(0, limits) - j0(limits) * struve(1, limits))
    start, upper_integral = limits * of_j0 - limits * j1(limits)  # the integral of F from 0
    return CubicSpline(np.append(0.0, z), np.append(0.0, (upper_integral - start) / ((FADE - 1) * z)))
