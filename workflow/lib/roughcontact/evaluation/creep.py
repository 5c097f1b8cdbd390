"""Contact after years under a constant load, of bodies that creep.

While no point leaves the contact, the strains of a linear viscoelastic body at a time t follow from those
of an elastic one by the creep compliance J(t): under a constant load area and gap are the elastic ones with
the creep modulus 1/J(t) (Lee and Radok 1960, J. Appl. Mech. 27, 438). The pressures are not: they depend on
how the contact grew. Poisson's ratio is taken to be constant.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, CREEPING, ENDS
from roughcontact.arguments.materials import contact_modulus
from roughcontact.arguments.relaxation import relaxation_of


def with_creep(
    statistics: xr.Dataset, contact: Mapping[str, Any], evaluate: Callable[[float], xr.Dataset]
) -> xr.Dataset:
    """Return statistics with what the contact has become after the times that its bodies state.

    Parameters
    ----------
    statistics : Dataset
        of the loads.
    contact : mapping
        the section `contact` of the settings (SI).
    evaluate : callable
        contact modulus (Pa) -> statistics of the same loads.

    Returns
    -------
    Dataset
        with the coordinate `time` (s) and `{name}_after` (load, time) of `CREEPING`, with its ends: NaN at
        loads at which points flow. Without times that are stated it is `statistics`.

    Examples
    --------
    A modulus that has halved doubles a small area:

    >>> before = xr.Dataset({"relative_contact_area": ("load", [0.01])})
    >>> polymer = {"youngs_modulus": 2e9, "poissons_ratio": 0.0, "creep_modulus": {"3600.0": 1e9}}
    >>> after = with_creep(before, {"bodies": [polymer]}, lambda modulus: before * (2e9 / modulus))
    >>> after["relative_contact_area_after"].values, after["time"].values
    (array([[0.02]]), array([3600.]))
    """
    moduli = moduli_after(contact)
    if not moduli:
        return statistics
    flows = statistics.get("load_share_above_hardness", xr.zeros_like(statistics[AREA])).values > 0
    later = [evaluate(modulus) for modulus in moduli.values()]
    columns = {
        f"{name}_after{suffix}": (
            ("load", "time"),
            np.where(flows[:, None], np.nan, np.transpose([numbers[f"{name}{suffix}"] for numbers in later])),
        )
        for name in CREEPING
        for suffix in ENDS
        if f"{name}{suffix}" in later[0]
    }
    return statistics.assign(columns).assign_coords(time=[*moduli])


def moduli_after(contact: Mapping[str, Any]) -> dict[float, float]:
    """Return the contact modulus (Pa) by the times (s) after which a body has crept; none without such.

    A creep modulus counts at its own times, a relaxation at those of `time`.

    Examples
    --------
    >>> rubber = {"relaxation": {"long_time_modulus": 1e6, "moduli": [9e6], "times": [1.0]}}
    >>> stated = {"bodies": [rubber | {"youngs_modulus": 1e7, "poissons_ratio": 0.5}], "time": [0.5, 1e9]}
    >>> [round(modulus / 1e6, 3) for modulus in moduli_after(stated).values()]
    [9.266, 1.333]
    """
    bodies = contact.get("bodies") or []
    creep_moduli = [
        {float(time): modulus for time, modulus in (body.get("creep_modulus") or {}).items()}
        for body in bodies
    ]
    times = sorted({*(contact.get("time") or ())}.union(*creep_moduli))
    relaxing = [body.get("relaxation") and relaxation_of(body["relaxation"]) for body in bodies]

    def crept(index: int, time: float) -> float:
        """Return Young's modulus of a body after a time."""
        if creep_moduli[index]:
            return creep_moduli[index][time]
        series = relaxing[index]
        return series.creep_modulus(time) if series else bodies[index]["youngs_modulus"]

    return {
        time: contact_modulus(
            [body | {"youngs_modulus": crept(index, time)} for index, body in enumerate(bodies)]
        )
        for time in times
    }
