"""The loads to solve: given in pascal, given relative to E* g, or planned for the map."""

import math
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_positive
from roughcontact.arguments.materials import MAX_HARDNESS, RUBBER
from roughcontact.contact.problem import nondimensionalise
from roughcontact.errors import HeightMapError, SettingsError

# 1-2-5 steps of p / (E* g), from below 1 % to near full contact of a random surface (A = erf(sqrt(2) p'))
DEFAULT_PLAN = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
_USEFUL_POINTS = 200  # in contact at the lowest planned load, twice what statistics need
_MIN_LOADS = 4  # planned ones closer together, below which their steps are finer


def plan_loads(
    window: xr.DataArray,
    *,
    contact_modulus: float,
    mean_pressure: float | list[float] | None = None,
    relative_pressure: float | list[float] | None = None,
    hardness: float | None = None,
) -> list[float]:
    """Return the mean pressures (Pa) to solve for on a map (y, x; m): as stated, relative, or planned.

    Planned loads that are not below the hardness (Pa) are left out, stated ones refused.
    """
    modulus = check_positive("contact_modulus", contact_modulus, unit="Pa")
    if mean_pressure is not None and relative_pressure is not None:
        raise SettingsError("mean_pressure and relative_pressure are both given; give one of them")
    if mean_pressure is not None:
        return check_loads("mean_pressure", mean_pressure, unit="Pa")
    relative = None
    if relative_pressure is not None:
        relative = check_loads("relative_pressure", relative_pressure, unit="units of E* x rms gradient")
    gradient = nondimensionalise(window).gradient
    if gradient == 0:
        raise HeightMapError(
            "the map is flat: loads relative to its rms gradient mean nothing; give mean_pressure in Pa"
        )
    if relative is not None:
        loads = [value * modulus * gradient for value in relative]
        if hardness is not None and max(loads) >= hardness:
            raise SettingsError(
                f"relative_pressure = {max(relative):g} is a mean pressure of {max(loads):.3g} Pa here, "
                f"not below the hardness {hardness:g} Pa: no contact carries it; stay below "
                f"{hardness / (modulus * gradient):.2g}, or leave relative_pressure out: planned loads do",
                keys=["relative_pressure", "hardness"],
            )
        return loads
    # elastomers do not flow plastically, so that their loads have no such end
    limit = MAX_HARDNESS * modulus if hardness is None and modulus >= RUBBER else math.inf
    relative_loads = planned_pressures(window.size, limit / (modulus * gradient))
    loads = [value * modulus * gradient for value in relative_loads]
    if hardness is None:
        return loads
    feasible = [load for load in loads if load < hardness]
    if not feasible:
        raise SettingsError(
            f"hardness = {hardness:g} Pa is below all planned loads ({loads[0]:g} Pa and more, by the "
            f"rms gradient {gradient:.3g} of the map): check the units of the map, or give mean_pressure "
            "in Pa",
            keys=["hardness", "mean_pressure"],
        )
    return feasible


def planned_pressures(points: int, limit: float) -> list[float]:
    """Return relative pressures from the first useful contact of a map to where the elastic model ends.

    The first brings a few hundred of the `points` into contact, the last has a mean pressure in contact below
    `limit`, in units of E* g; both by A = erf(sqrt(2) p') (Persson 2001). Without such loads the plan is
    `DEFAULT_PLAN`.

    Examples
    --------
    >>> planned_pressures(128**2, math.inf)
    [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0]
    >>> planned_pressures(1024**2, 0.8), planned_pressures(64**2, 0.65)
    ([0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5], [0.05, 0.084, 0.14, 0.23])
    """

    def area(pressure: float) -> float:
        return math.erf(math.sqrt(2) * pressure)  # Persson's theory of a random surface

    useful = [pressure for pressure in DEFAULT_PLAN if area(pressure) * points >= _USEFUL_POINTS]
    below_limit = [pressure for pressure in useful if pressure < limit * area(pressure)]
    if not below_limit:
        return list(DEFAULT_PLAN)  # too few points, or too steep a map, for either limit: all of them
    if len(below_limit) == len(useful) or len(below_limit) >= _MIN_LOADS:
        return below_limit
    elastic = [float(p) for p in np.geomspace(below_limit[0], 1.0, 100) if p < limit * area(p)]
    finer = np.geomspace(below_limit[0], elastic[-1], _MIN_LOADS)
    # two digits, as somebody would state them
    return list(dict.fromkeys(float(f"{pressure:.2g}") for pressure in finer))


def check_loads(name: str, loads: Any, *, unit: str) -> list[float]:
    """Return loads, a number or a sequence of numbers in `unit`, as a list of positive floats.

    Examples
    --------
    >>> check_loads("mean_pressure", [1e6, "5e6"], unit="Pa")
    [1000000.0, 5000000.0]
    """
    values = np.atleast_1d(np.asarray(loads, dtype=object)).ravel()
    if values.size == 0:
        raise SettingsError(
            f"{name} is an empty list; give at least one positive number in {unit}, or leave it out"
        )
    return [check_positive(name, value, unit=unit) for value in values]
