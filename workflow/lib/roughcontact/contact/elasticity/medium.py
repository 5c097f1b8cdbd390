"""What lies below the surfaces of a contact: homogeneous half-spaces, or a medium that inherits.

Solver and statistics ask the medium of an `Elasticity`, and never which one it is.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from roughcontact.kernels.arrays import Array


@dataclass(frozen=True)
class Medium:
    """Both bodies of a contact, here homogeneous: a pressure wave displaces them by 2/(E* |q|).

    Lengths may have any unit; so has |q| in `factor`.
    """

    properties: ClassVar[tuple[str, ...]] = ()  # what may exclude settings (`KindFacts.excluded`)

    @property
    def is_homogeneous(self) -> bool:
        """Whether waves of all lengths meet the same E*, as theories and conductance assume."""
        return not self.departures

    @property
    def departures(self) -> tuple["Medium", ...]:
        """What differs from half-spaces: the medium, or nothing."""
        return ()

    @property
    def thinnest(self) -> float:
        """The thickness of the thinnest layer."""
        return math.inf

    @property
    def thickest(self) -> float:
        """The thickness of all layers of a body together, of the one with most of them."""
        return 0.0

    @property
    def largest_factor(self) -> float:
        """The largest `factor`, at least 1."""
        return 1.0

    def factor(self, q: np.ndarray) -> np.ndarray:
        """Return E* |q| S(|q|)/2 of both bodies together, of q > 0."""
        return np.ones(np.shape(q))

    def weigh(self, symbol: Array, qy: np.ndarray, qx: np.ndarray) -> None:
        """Multiply the symbol of half-spaces (qy.size, qx.size) by the `factor` of its waves, in place."""

    def scaled(self, unit: float) -> "Medium":
        """Return the medium with its thicknesses in a `unit` of length."""
        return self

    def base_modulus(self, modulus: float) -> float:
        """Return E* of the longest waves (Pa), where that of the surfaces is `modulus`."""
        return modulus

    def mean_compliance(self, *, elastic: bool) -> float:
        """Return the displacement (m/Pa) per mean pressure, q = 0, beside that of elastic bases alone."""
        return 0.0

    def change_of_point_force(self, distance: np.ndarray) -> np.ndarray | float:
        """Return what is added to E* times the displacement by a unit force, 1/(pi r), at distances."""
        return 0.0

    def free_response(self, reach: float) -> Any:
        """Return the response cut off beyond `reach`, None where it is that of the influence function."""
        return None

    def as_settings(self) -> list[dict[str, Any]]:
        """Return the bodies as the settings describe them, where E* does not say all of them."""
        return []


HALF_SPACES = Medium()


def wavenumbers(qy: np.ndarray, qx: np.ndarray) -> np.ndarray:
    """Return |q| in double precision; that of the mean, which no operator uses, counts as the largest."""
    q: np.ndarray = np.hypot(qy.astype(float), qx.astype(float))
    q[q == 0] = float(q.max()) or 1.0
    return q
