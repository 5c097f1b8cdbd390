"""Slip of a gas in narrow places, where its molecules meet the walls as often as one another."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

MIN_INVERSE_KNUDSEN = 0.01  # down to which the flow of a gas is known
# D, 1, 1/D, 1/D² in the flow of a gas between plates, below D = 0.15, below 5, and above
_FLOW_FIT = np.array(
    [
        [-2.22919, 2.10673, 0.01653, -0.0000694],
        [0.13852, 1.25087, 0.15653, -0.00969],
        [1 / 6, 1.0162, 1.0653, -2.1354],
    ]
)


def path_at_mean_pressure(attrs: Mapping[str, Any]) -> float:
    """Return the mean free path (m) within a seal by the attributes of its statistics; 0: none is stated."""
    path, difference = (attrs.get(f"seal_{key}", 0.0) for key in ("mean_free_path", "pressure_difference"))
    # the mean pressure lies half-way between outlet and inlet
    return path / (1 + difference / (2 * attrs.get("seal_outlet_pressure", np.inf)))


def slip_factor(narrowest: npt.ArrayLike, mean_free_path: float) -> np.ndarray:
    """Return the flow of a gas through narrow places (m) over that without slip, by its free path (m).

    Fits to the linearised Boltzmann equation between plates, 6 Q/D at D = √π/2 over the Knudsen number, held
    below D = 0.01 (Fukui and Kaneko 1990, ASME J. Tribol. 112, 78); 1 of a closed place.

    Examples
    --------
    >>> slip_factor([0.0, 6e-8, 6e-7, 6e-5], 6e-8).round(2)
    array([ 1.  , 10.41,  1.75,  1.01])
    """
    height = np.asarray(narrowest, float)
    if not mean_free_path:
        return np.ones(height.shape)
    # closed places have no free path: any factor
    inverse = np.sqrt(np.pi) / 2 * np.where(height > 0, height, np.inf) / mean_free_path
    inverse = np.clip(inverse, MIN_INVERSE_KNUDSEN, 1e9)  # beyond it the flow is viscous to all digits
    rows = np.searchsorted([0.15, 5.0], inverse, side="right")
    linear, constant, first, second = np.moveaxis(_FLOW_FIT[rows], -1, 0)
    return 6 * (linear + (constant + (first + second / inverse) / inverse) / inverse)
