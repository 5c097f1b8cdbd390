"""A dimensionless solution as a labelled dataset in SI units."""

from collections.abc import Hashable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.choices import Influence, check_choice
from roughcontact.arguments.measurement import json_attribute
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.elasticity.media import elastic_medium
from roughcontact.contact.elasticity.medium import Medium
from roughcontact.contact.iteration import Solution
from roughcontact.contact.problem import Problem
from roughcontact.kernels.arrays import empty, to_numpy
from roughcontact.kernels.choose import kernels_for


def load_result(
    fields: "FieldsInUnits",
    solution: Any,
    approach: float,
    *,
    problem: Problem,
    window: xr.DataArray,
    loads: Mapping[str, float],
    elasticity: Elasticity,
    attrs: Mapping[str, Any],
) -> xr.Dataset:
    """Return the solution of one load as a dataset in SI units, with a dimension `load` of size 1.

    Its variables are those of contact.nc, over (load, y, x) or (load); `approach` is in m, `loads` are its
    coordinates.
    """
    maps = {"pressure": fields.pressure, "gap": fields.gap, "contact": fields.contact}
    mean = loads["mean_pressure"]
    per_load = {
        "relative_pressure": mean / unit_of_pressure(problem, elasticity.modulus)
        if not problem.flat
        else np.inf,
        "approach": approach,
        "iterations": solution.steps,
        "operator_applications": solution.applications,
        "error_bound": solution.error_bound,
        "rounding_floor": solution.floor,
        "yielded_area": fields.yielded,
        "max_penetration": max(0.0, -fields.least_gap),
        "converged": np.int8(solution.error_bound <= attrs["tolerance"]),
        "load_error": abs(fields.total / fields.pressure.size / mean - 1),
    }
    of_load: dict[str, Any] = {name: ("load", [value]) for name, value in loads.items()}
    return xr.Dataset(
        {name: (("load", "y", "x"), field[None]) for name, field in maps.items()}
        | {name: ("load", [value]) for name, value in per_load.items()}
        | {"height": window.variable, "contact_modulus": elasticity.modulus}
        | ({"hardness": elasticity.hardness} if elasticity.hardness < np.inf else {}),
        # with the indexes that are there
        coords=xr.Coordinates(of_load | {**window.coords.variables}, indexes=window.xindexes),
        attrs=attrs,
    )


def unit_of_pressure(problem: Problem, modulus: float) -> float:
    """Return the unit of the dimensionless pressure, E* g, or E* for a flat map (Pa)."""
    return modulus * problem.gradient if not problem.flat else modulus


class FieldsInUnits(NamedTuple):
    """The fields (ny, nx) of one solution in SI units, and three numbers that are known on the way."""

    pressure: np.ndarray  # Pa
    gap: np.ndarray  # m
    contact: np.ndarray
    least_gap: float  # m
    total: float  # sum of the pressure, Pa
    yielded: float  # share of the points at the hardness


def fields_in_units(
    solution: Solution, problem: Problem, elasticity: Elasticity, *, threads: int
) -> FieldsInUnits:
    """Return the fields of a dimensionless solution in SI units; they take its memory."""
    state = solution.state
    # in place: the dimensionless fields are not used again
    pressure, gap = (to_numpy(field) for field in (state.pressure, state.separation))
    contact = empty(pressure, "int8")
    pressure_unit = unit_of_pressure(problem, elasticity.modulus)
    least_gap, total = kernels_for(pressure, threads=threads).restore_units(
        pressure, gap, state.offset, pressure_unit, problem.scale, contact
    )
    yield_share = 0.0
    if elasticity.hardness < np.inf:
        yield_share = limit_to_hardness(pressure, gap, elasticity.hardness)
        least_gap = float(gap.min())
    return FieldsInUnits(pressure, gap, contact, least_gap, total, yield_share)


def limit_to_hardness(pressure: np.ndarray, gap: np.ndarray, hardness: float) -> float:
    """Set pressures (Pa) that reach the hardness up to rounding to it; return the share of these points.

    They have yielded until the gap was closed: it becomes zero there.
    """
    at_hardness = carrying(pressure, hardness)
    pressure[at_hardness], gap[at_hardness] = hardness, 0.0
    return float(at_hardness.mean())


def carrying(pressure: np.ndarray, limit: float) -> np.ndarray:
    """Return where a pressure (Pa) reaches a limit, as a hardness, up to rounding.

    Examples
    --------
    >>> import numpy as np
    >>> carrying(np.float32([0.1, 0.2]), 0.2).tolist()
    [False, True]
    """
    # three roundings of eps/2: of the limit without its unit, of the unit, of their product; a wider margin
    # would take more from points that are free than the error bound knows of
    return pressure >= limit * (1 - 2 * np.finfo(pressure.dtype).eps)


def joined(load_datasets: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return the datasets of the loads, from `load_result`, as one."""
    first = load_datasets[0]
    if len(load_datasets) == 1:
        return first

    def along_load(name: Hashable, variable: xr.Variable) -> xr.Variable:
        """Return a variable of all loads; `xr.concat` takes twenty times as long."""
        if "load" not in variable.dims:
            return variable
        values = [load_dataset.variables[name].values for load_dataset in load_datasets]
        return xr.Variable(variable.dims, np.concatenate(values, variable.dims.index("load")), variable.attrs)

    variables = {name: along_load(name, variable) for name, variable in first.variables.items()}
    return xr.Dataset(variables, attrs=first.attrs).set_coords(first.coords)


def recorded_elasticity(contact: xr.Dataset) -> Elasticity:
    """Return the elasticity of a contact without its hardness, "sampled" where nothing else is recorded.

    Examples
    --------
    >>> recorded_elasticity(xr.Dataset({"contact_modulus": 1e9}, attrs={"influence": "elements"})).influence
    'elements'
    """
    influence: Influence = contact.attrs.get("influence", "sampled")
    check_choice("influence", influence, Influence)
    return Elasticity(float(contact["contact_modulus"]), influence, recorded_medium(contact.attrs))


def recorded_medium(attrs: Mapping[str, Any]) -> Medium:
    """Return the medium that `solve_contact` recorded in a contact's attributes, half-spaces without."""
    return elastic_medium(json_attribute(attrs, "bodies"))


def recorded_problem(contact: xr.Dataset) -> dict[str, Any]:
    """Return elasticity and operator of a solved contact as keyword arguments of `solve_contact`.

    Examples
    --------
    >>> recorded_problem(xr.Dataset({"contact_modulus": 1e9}))["contact_modulus"]
    1000000000.0
    """
    bodies = json_attribute(contact.attrs, "bodies") or None
    return {
        "contact_modulus": None if bodies else float(contact["contact_modulus"]),
        "bodies": bodies,
        "influence": recorded_elasticity(contact).influence,
        "zero_frequency": contact.attrs.get("zero_frequency", "zero"),
    }
