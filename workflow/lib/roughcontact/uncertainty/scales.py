"""The scale of each quantity: the one on which it scatters alike at all loads and on all surfaces.

The area is taken as ln erfinv(A), by Persson's law A = erf(sqrt(2) p/(E* g)) the logarithm of load over
gradient; it is the logarithm of the area where that is small, and never leads beyond full contact. The
narrowest places of the gap may be closed: they are taken as they are. All others are logarithms.

References
----------
Persson (2001), J. Chem. Phys. 115, 3840.
"""

import numpy as np
import scipy

AREA, GAP, PEAK, PRESSURE = QUANTITIES = (
    "relative_contact_area",
    "mean_gap",
    "max_pressure",
    "mean_contact_pressure",
)
CONSTRICTIONS = ("critical_constriction_x", "critical_constriction_y")
CONDUCTANCE = "conductance_per_conductivity"
ANSWERS = (CONDUCTANCE, *CONSTRICTIONS)

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
    """Return a quantity on its scale; NaN where it is not positive and has a logarithm.

    Examples
    --------
    >>> to_scale("mean_gap", np.array([1.0, 0.0])), to_scale("critical_constriction_x", np.array([0.0]))
    (array([ 0., nan]), array([0.]))
    """
    if name in CONSTRICTIONS:
        return np.asarray(values, float)
    positive = inverse_erf_area(values) if name == AREA else np.asarray(values, float)
    return np.log(np.where(positive > 0, positive, np.nan))


def from_scale(name: str, values: np.ndarray) -> np.ndarray:
    """Return a quantity from its scale; a narrowest place is closed below zero.

    Examples
    --------
    >>> from_scale("relative_contact_area", to_scale("relative_contact_area", np.array([0.2]))).round(6)
    array([0.2])
    """
    if name in CONSTRICTIONS:
        return np.maximum(values, 0.0)
    with np.errstate(over="ignore"):
        result = np.exp(values)
    if name != AREA:
        return result
    full = scipy.special.erfinv(1 - SMALLEST) * (1 - 1e-12)  # up to rounding
    return np.where(result >= full, 1.0, scipy.special.erf(result))


def at_all_loads(values: np.ndarray, solved: np.ndarray, load: np.ndarray) -> np.ndarray:
    """Return numbers at all loads from those at the indices `solved`, linear in ln p; NaN beside a NaN.

    Examples
    --------
    >>> at_all_loads(np.array([0.1, 0.3]), np.array([0, 2]), np.array([1.0, 2.0, 4.0]))
    array([0.1, 0.2, 0.3])
    """
    rank = np.argsort(load[solved])
    return np.interp(np.log(load), np.log(load[solved][rank]), np.asarray(values, float)[rank])
