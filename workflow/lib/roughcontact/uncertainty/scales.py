"""The scale of each quantity: the one on which it scatters alike at all loads and on all surfaces.

That of the area is ln erfinv(A), by Persson's law A = erf(sqrt(2) p/(E* g)) (2001, J. Chem. Phys. 115, 3840)
the logarithm of the load, which never leads beyond full contact; narrowest places may be closed and are taken
as they are, all others as logarithms.
"""

from collections.abc import Container
from typing import Any

import numpy as np
import scipy

from roughcontact.arguments import answers
from roughcontact.arguments.answers import APPROACH, AREA, CONDUCTANCE, GAP, PEAK, PRESSURE

QUANTITIES = (AREA, GAP, PEAK, PRESSURE)
CONSTRICTIONS = tuple(name for name, quantity in answers.QUANTITIES.items() if quantity.scale == "length")
ANSWERS = (CONDUCTANCE, *CONSTRICTIONS)
ALL = (*QUANTITIES, *ANSWERS, APPROACH)  # that of a body of finite size

SMALLEST = 1e-6  # share of a result, and of the area that is open, below which its logarithm is meaningless


def inverse_erf_area(area: np.ndarray) -> np.ndarray:
    """Return x = erfinv(A) of a contact area, by Persson's law the load over E* g up to a factor.

    Examples
    --------
    >>> inverse_erf_area(np.array([0.0, 0.5])).round(3)
    array([0.   , 0.477])
    """
    return scipy.special.erfinv(np.clip(area, 0.0, 1 - SMALLEST))


def to_scale(name: str, values: np.ndarray) -> np.ndarray:
    """Return a quantity on its scale; NaN where it is not positive and has a logarithm."""
    if name in CONSTRICTIONS:
        return np.asarray(values, float)
    positive = inverse_erf_area(values) if name == AREA else np.asarray(values, float)
    return np.log(np.where(positive > 0, positive, np.nan))


def from_scale(name: str, values: np.ndarray) -> np.ndarray:
    """Return a quantity from its scale; a narrowest place is closed below zero."""
    if name in CONSTRICTIONS:
        return np.maximum(values, 0.0)
    with np.errstate(over="ignore"):
        result = np.exp(values)
    if name != AREA:
        return result
    full = scipy.special.erfinv(1 - SMALLEST) * (1 - 1e-12)  # up to rounding
    return np.where(result >= full, 1.0, scipy.special.erf(result))


def headline_names(dataset: Container[Any]) -> tuple[str, ...]:
    """Return the names of the headline quantities and the answers that a dataset contains."""
    return tuple(name for name in ALL if name in dataset)
