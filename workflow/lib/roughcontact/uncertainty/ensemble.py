"""One member of an ensemble: a quick solve of a window, and the four numbers that the error budget is for."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from roughcontact.contact.solve import solve_contact
from roughcontact.maps import spacing
from roughcontact.uncertainty.headline import QUANTITIES, headline

_OWN = ("tolerance", "fields", "reduce", "progress")  # what a member decides for itself


class Member(NamedTuple):
    """What a quick solve gives: {quantity: array (load)}, and the work in FFT pairs times points."""

    values: dict[str, np.ndarray]
    work: float


def solve_member(window: xr.DataArray, contact: dict, *, tolerance: float) -> Member:
    """Solve one window of an ensemble, without keeping fields.

    Parameters
    ----------
    window : DataArray (y, x), m
    contact : dict
        keyword arguments of `solve_contact`. A load that misses the tolerance raises or, with `on_failure` =
        "flag", is NaN.
    tolerance : float
        of the pressure, unless `contact` has a wider one.

    Raises
    ------
    ConvergenceError
        as `solve_contact`.
    """
    arguments = {key: value for key, value in contact.items() if key not in _OWN}
    tolerance = max(tolerance, contact.get("tolerance", 0.0))
    found = solve_contact(window, **arguments, tolerance=tolerance, reduce=headline)
    converged = found["converged"].values == 1
    return Member(
        {name: np.where(converged, found[name].values, np.nan) for name in QUANTITIES},
        float(found["operator_applications"].sum()) * window.size,
    )


def shown_part(levelled: xr.DataArray, periodic: xr.DataArray) -> dict[str, slice]:
    """Return which rows and columns of a map its periodic window shows, without bands and mirror images."""
    mirrored = periodic.attrs["periodisation"] == "mirror"
    shown = {}
    for d, n, step in zip("yx", periodic.shape, spacing(levelled), strict=True):
        first = round(periodic.attrs[f"window_offset_{d}"] / step)
        shown[d] = slice(first, first + (n // 2 if mirrored and n > 1 else n))
    return shown


def scale_to(result, values, *, base) -> np.ndarray:
    """Return the deviations of members from their base, scaled to the main result and added to it.

    A small window or a coarse grid gives other absolute values; relative deviations carry over. The factor
    stays between a half and two, for gaps close to full contact, which are next to nothing.

    Parameters
    ----------
    result : array (load)
        of the main window.
    values : array (member, load)
    base : array (load)
        what the members deviate from.
    """
    ratio = np.divide(result, base, out=np.ones_like(base), where=base != 0)
    return result + np.clip(ratio, 0.5, 2.0) * (values - base)
