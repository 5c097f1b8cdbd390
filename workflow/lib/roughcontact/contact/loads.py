"""Which loads to solve: given in pascal, given relative to E* g, or a plan made for the map."""

import numpy as np
import xarray as xr

from roughcontact.contact.problem import check_positive, pose
from roughcontact.errors import HeightMapError, SettingsError

# 1-2-5 steps of p / (E* g), from below 1 % to near full contact of a random surface (A = erf(sqrt(2) p'))
DEFAULT_PLAN = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)


def plan_loads(
    window: xr.DataArray,
    *,
    contact_modulus: float,
    mean_pressure: float | list[float] | None = None,
    relative_pressure: float | list[float] | None = None,
) -> list[float]:
    """Return the mean pressures (Pa) to solve for.

    Either `mean_pressure` (Pa) or `relative_pressure` p' = p / (E* g), one number or a list; with neither,
    the plan `DEFAULT_PLAN` of relative pressures. g is the rms gradient of `window`.

    Raises
    ------
    SettingsError
        for both at once, an empty list, or a load that is not positive.
    HeightMapError
        where relative pressures are asked for on a flat map, which has no gradient to relate them to.
    """
    modulus = check_positive("contact_modulus", contact_modulus, unit="Pa")
    if mean_pressure is not None and relative_pressure is not None:
        raise SettingsError("mean_pressure and relative_pressure are both given; give one of them")
    if mean_pressure is not None:
        return check_loads("mean_pressure", mean_pressure, unit="Pa")
    relative = DEFAULT_PLAN if relative_pressure is None else relative_pressure
    relative = check_loads("relative_pressure", relative, unit="units of E* x rms gradient")
    gradient = pose(window).gradient
    if gradient == 0:
        raise HeightMapError(
            "the map is flat: loads relative to its rms gradient mean nothing; give mean_pressure in Pa"
        )
    return [value * modulus * gradient for value in relative]


def check_loads(name: str, loads, *, unit: str) -> list[float]:
    """Return `loads`, one number or a sequence, as a list of positive floats."""
    values = np.atleast_1d(np.asarray(loads, dtype=object)).ravel()
    if values.size == 0:
        raise SettingsError(
            f"{name} is an empty list; give at least one positive number in {unit}, or leave it out"
        )
    return [check_positive(name, value, unit=unit) for value in values]
