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

from roughcontact.choices import Influence

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

FADE = 1.15  # distance where the kernel vanishes over the distance up to which it is exact
_STEP = 0.05  # of |q| reach in the table of the symbol, whose shortest wave is 2 pi / FADE


@dataclass(frozen=True)
class TruncatedKernel:
    """An influence function (`roughcontact.elasticity.influence`), exact up to the distance `reach`."""

    influence: Influence
    reach: float

    def __call__(self, qy: np.ndarray, qx: np.ndarray, spacing: tuple[float, float]) -> np.ndarray:
        """Return the symbol; infinite at q = 0, whose displacement `mean_displacement` is."""
        if self.influence == "elements":
            width = qx.size > 1 and round(2 * np.pi / (float(qx[0, 1]) * spacing[1]))
            symbol = _transform_of_elements((qy.size, int(width)), spacing, self.reach).copy()
        else:
            q: np.ndarray = np.hypot(qy.astype(float), qx.astype(float))
            q[0, 0] = 1.0
            last = 2.0 ** np.ceil(np.log2(q.max() * self.reach))
            symbol = 2 / q * _cut_off(float(last))(q * self.reach)
        symbol[0, 0] = np.inf
        return symbol.astype(np.result_type(qy, qx))

    def mean_displacement(self, shape: tuple[int, int], spacing: tuple[float, float]) -> float:
        """Return E* times the mean displacement per mean pressure: the symbol at q = 0."""
        if self.influence == "elements":
            return float(_transform_of_elements(shape, spacing, self.reach)[0, 0])
        return (1 + FADE) * self.reach


@lru_cache(maxsize=1)
def _transform_of_elements(shape: tuple[int, int], spacing: tuple[float, float], reach: float) -> np.ndarray:
    """Return the symbol (ny, nx // 2 + 1) of Love's kernel, faded beyond the reach, kept for one grid."""
    quarter = shape[0] // 2 + 1, shape[1] // 2 + 1
    distance = np.hypot(
        *(i * d / reach for i, d in zip(np.ogrid[: quarter[0], : quarter[1]], spacing, strict=True))
    )
    fade = np.clip((FADE - distance) / (FADE - 1), 0, 1)
    return even_transform(love(quarter, spacing) * fade, shape)


def even_transform(quarter: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return the transform (ny, nx // 2 + 1) of a field even along both axes, given by a quarter."""
    from scipy import fft

    rows, columns = (np.minimum(i, n - i) for n in shape for i in [np.arange(n)])
    if shape[0] % 2 or shape[1] % 2:  # the cosine transform is of even sides
        return np.asarray(fft.rfft2(quarter[np.ix_(rows, columns)]).real)
    return np.asarray(fft.dctn(quarter, type=1)[rows])


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

    def integral(upper: np.ndarray) -> np.ndarray:
        """Return the integral of F from 0."""
        return np.asarray(upper * itj0y0(upper)[0] - upper * j1(upper))

    factor = (integral(FADE * z) - integral(z)) / ((FADE - 1) * z)
    return CubicSpline(np.concatenate([[0.0], z]), np.concatenate([[0.0], factor]))
