"""Layers under a point force, in free space: what they add to its displacement, and that faded out."""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from roughcontact.contact.elasticity.fade import FADE, graded_panels, smooth_fade
from roughcontact.contact.elasticity.medium import Medium
from roughcontact.errors import SettingsError

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

_LONG = 300.0  # |q| reach above which a smooth fade changes the symbol by less than 1e-4
_RADIANS = 8.0  # of a panel
_DISTANCES = 400  # at which the displacement is computed; a spline is between them
_DECAYED = 20.0  # |q| times the thinnest layer, where layers have no effect
_BLOCKS = 20  # of distances that share a quadrature
# radians at which waves fade out, by an error function: smooth compliances need no shorter ones
_FADED, _WIDTH = 60.0, 9.0
_SOFTEST = 1e-5  # |q| times the thickest layer, where it follows any base


@dataclass(frozen=True)
class FadedLayers:
    """The response of layers, exact up to the distance `reach`."""

    layers: Medium
    reach: float

    def symbol(self, q: np.ndarray, spacing: tuple[float, float]) -> np.ndarray:
        """Return the symbol at wavenumbers (ny, nx // 2 + 1), which has to be positive."""
        # short waves do not notice that the response fades out; long ones come from a table
        symbol = 2 / q * self.layers.factor(q)
        long = q * self.reach < _LONG
        symbol[long] = _faded(self.layers, self.reach)[0](q[long] * self.reach)
        # the certificate of the solver needs a positive operator
        if symbol.min() <= 0:
            raise SettingsError(
                "these layers on a body of finite size have no proven solution: their compliance within the "
                "contact is not positive for every wave; solve them with boundary: periodic",
                keys=("bodies",),
            )
        return symbol

    def mean(self, shape: tuple[int, int], spacing: tuple[float, float]) -> float:
        """Return E* times the mean displacement per mean pressure of a cell (ny, nx)."""
        symbol, farthest = _faded(self.layers, self.reach)
        return float(symbol(0.0) + farthest * np.prod(shape) * np.prod(spacing))


@lru_cache(maxsize=8)
def _faded(layers: Medium, reach: float) -> tuple["CubicSpline", float]:
    """Return the symbol over |q| reach < `_LONG` of a smoothly faded response, and its constant term.

    The response at the end of the fade is taken off: it acts on all of the contact alike, as all load is in
    it, and below stiff layers that are thick against the contact it would be most of the response.
    """
    from scipy.interpolate import CubicSpline
    from scipy.special import j0

    z: np.ndarray = np.arange(0.0, _LONG + 1, 0.1)
    outer_radius = FADE * reach  # the fade ends there
    r, weights = graded_panels(outer_radius, _RADIANS * reach / _LONG, layers.thinnest / 4)
    weights *= smooth_fade(r / reach, FADE)
    change = change_by_layers(layers, np.append(r, outer_radius))
    farthest = 1 / (np.pi * outer_radius) + float(change[-1])
    # in polar coordinates, where 1/(pi r) times r is constant at a point force
    response = 2 * (1 + np.pi * r * (change[:-1] - farthest)) * weights
    return CubicSpline(z, j0(z[:, None] * (r / reach)) @ response), farthest


def change_by_layers(layers: Medium, distance: np.ndarray) -> np.ndarray:
    """Return what layers add to E* times the displacement by a unit force, 1/(pi r), at distances."""
    from scipy.interpolate import CubicSpline
    from scipy.special import erfc, j0

    thinnest, values = layers.thinnest, []
    logarithm = np.linspace(0, np.arcsinh(float(distance.max()) / thinnest), _DISTANCES)
    # near the force short waves count, far from it they have decayed: so many ranges of distance
    for r in np.array_split(thinnest * np.sinh(logarithm), _BLOCKS):
        # waves beyond have died out by the layers, or by the error function
        last = min(_DECAYED / thinnest, (_FADED + 6 * _WIDTH) / max(r[0], thinnest))
        q, weights = graded_panels(last, _RADIANS / r[-1], _SOFTEST / layers.thickest)
        phase = np.outer(r, q)
        waves = j0(phase) * erfc((phase - _FADED) / _WIDTH) / 2
        values.append(waves @ (weights * (layers.factor(q) - 1) / np.pi))
    # distances in even steps of arsinh: even in the thinnest layer, in equal ratios beyond it
    return np.asarray(CubicSpline(logarithm, np.concatenate(values))(np.arcsinh(distance / thinnest)))
