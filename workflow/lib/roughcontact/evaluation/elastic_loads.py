"""The planned loads that a measured surface bears elastically, by a coarse solution of the contact."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.materials import MAX_HARDNESS, RUBBER
from roughcontact.contact.problem import nondimensionalise
from roughcontact.uncertainty.discretisation import discretisation_error
from roughcontact.uncertainty.ensemble import Result, solve_member
from roughcontact.uncertainty.scales import AREA, from_scale, to_scale

_STEEP = 0.04  # rms gradient: gentler surfaces have at most 2.5 times as much E* in contact
_MARGIN = 0.98, 0.93  # of the limit, as the solution is coarse: of the loads solved, of those between
_MIN_LOADS = 4


def elastic_loads(window: xr.DataArray, loads: Sequence[float], contact: Mapping[str, Any]) -> list[float]:
    """Return those planned loads (Pa) whose mean pressure in contact is below 0.1 E*.

    Fewer than four are spread over the range below; all come back where none does, with a hardness, or of
    rubber.
    """
    modulus = float(contact["contact_modulus"])
    gradient = nondimensionalise(window).gradient
    if contact.get("hardness") is not None or modulus < RUBBER or gradient < _STEEP:
        return list(loads)
    pressure = np.array(loads, float)
    lenient = {**contact, "mean_pressure": pressure, "on_failure": "flag"}
    values = solve_member(window, lenient, names=[AREA])
    correction, _ = discretisation_error(Result(window, lenient, values), pixel_share=values[AREA])
    area = from_scale(AREA, to_scale(AREA, values[AREA]) + correction[AREA])
    excess = np.log(pressure / area / (MAX_HARDNESS * modulus))
    elastic = np.flatnonzero(excess < math.log(_MARGIN[0]))
    fine = np.linspace(0, np.log(pressure[-1] / pressure[0]), 200)
    below = np.flatnonzero(np.interp(fine, np.log(pressure / pressure[0]), excess) < math.log(_MARGIN[1]))
    if not elastic.size:
        return list(loads)
    if elastic.size >= _MIN_LOADS or not below.size:
        return [float(pressure[index]) for index in elastic]
    indices = below[np.linspace(0, below.size - 1, _MIN_LOADS).round().astype(int)]
    unit = modulus * gradient  # in which loads are round, so that those of two moduli are the same
    spread = pressure[0] / unit * np.exp(fine[indices])
    return [load * unit for load in dict.fromkeys(float(f"{load:.3g}") for load in spread)]
