"""Scales on which results change by the same share up and down: ln Q, of the contact area ln erfinv(A).

By Persson's law (Persson 2001, J. Chem. Phys. 115, 3840) erfinv(A) is proportional to the load over modulus
times slope.
"""

import numpy as np
import scipy
import xarray as xr

from roughcontact.uncertainty.answers import ANSWERS
from roughcontact.uncertainty.headline import QUANTITIES

AREA, GAP, PEAK, PRESSURE = QUANTITIES
CONDUCTANCE = ANSWERS[0]
_MAX_AREA = 1 - 1e-6  # keeps erfinv finite: hardly a point is open


def effort(area: np.ndarray) -> np.ndarray:
    """Return x = erfinv(A) of a contact area, by Persson's law the load over E* g up to a factor.

    Parameters
    ----------
    area : array
        relative contact area.

    Returns
    -------
    array
        finite for full contact.

    Examples
    --------
    >>> import numpy as np
    >>> effort(np.array([0.0, 0.5])).round(3)
    array([0.   , 0.477])
    """
    return scipy.special.erfinv(np.clip(area, 0.0, _MAX_AREA))


def half_widths(
    solved: xr.Dataset,
    logarithms: dict[str, tuple[np.ndarray, np.ndarray]],
    *,
    ending: str = "",
) -> xr.Dataset:
    """Return half-widths in the unit of each result from those of its logarithm.

    Parameters
    ----------
    solved : Dataset
        the result: quantities along `load`, with `mean_pressure`.
    logarithms : dict
        quantity -> half-widths (load) below and above, of ln Q; of the area those of ln erfinv(A). The
        pressure in contact is the load over the area.
    ending : str
        inserted into the names: `{name}{ending}_down`.

    Returns
    -------
    Dataset
        along `load`: `{name}{ending}_down` and `{name}{ending}_up`, and `{name}`, the larger one.

    Examples
    --------
    >>> import numpy as np, xarray as xr
    >>> solved = xr.Dataset({"mean_gap": ("load", [2.0]), "mean_pressure": ("load", [1.0])})
    >>> found = half_widths(solved, {"mean_gap": (np.array([0.0]), np.log([1.5]))})
    >>> found["mean_gap_down"].item(), found["mean_gap_up"].item()
    (0.0, 1.0)
    """
    widths: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for name, (down, up) in logarithms.items():
        value = solved[name].values
        if name == AREA:
            x = effort(value)
            low, high = (scipy.special.erf(x * np.exp(change)) for change in (-down, up))
            # where nothing changes, erf and erfinv leave a rounding error of either sign
            widths[name] = (
                np.where(np.equal(down, 0), 0.0, np.maximum(value - low, 0.0)),
                np.where(np.equal(up, 0), 0.0, np.maximum(high - value, 0.0)),
            )
            widths[PRESSURE] = _pressure_half_widths(solved, *widths[name])
        else:
            with np.errstate(over="ignore"):
                factor = np.expm1(up)
            widths[name] = -value * np.expm1(-down), _product(value, factor)
    found: dict[str, tuple[str, np.ndarray]] = {}
    for name, (down, up) in widths.items():
        found |= {f"{name}{ending}_down": ("load", down), f"{name}{ending}_up": ("load", up)}
        found[name] = ("load", np.maximum(down, up))
    return xr.Dataset(found)


def _pressure_half_widths(
    solved: xr.Dataset, down: np.ndarray, up: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the half-widths of the pressure in contact, the load over either end of the area."""
    area, pressure = solved[AREA].values, solved[PRESSURE].values
    area = np.where(area > 0, area, 1.0)
    with np.errstate(divide="ignore"):
        above = np.where(area > down, down / (area - down), np.inf)
    return pressure * up / (area + up), pressure * above


def _product(value: np.ndarray, factor: np.ndarray) -> np.ndarray:
    """Return the product; zero times infinity is zero."""
    with np.errstate(over="ignore"):
        return value * np.where(value == 0, 0.0, factor)
