"""A dimensionless solution as a labelled dataset in SI units."""

import json
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.checking import check_choice
from roughcontact.choices import Influence
from roughcontact.contact.iteration import Solution
from roughcontact.contact.problem import Problem
from roughcontact.elasticity.influence import Elasticity
from roughcontact.elasticity.layers import LayeredPair, layered_pair
from roughcontact.kernels.arrays import empty, to_numpy
from roughcontact.kernels.choose import kernels_for


def of_one_load(
    fields: "FieldsInUnits",
    solution: Any,
    approach: float,
    *,
    problem: Problem,
    window: xr.DataArray,
    loaded: Mapping[str, float],
    elasticity: Elasticity,
    attrs: Mapping[str, Any],
) -> xr.Dataset:
    """Return the solution of one load as a dataset in SI units, with a dimension `load` of size 1.

    Its variables are those of contact.nc, over (load, y, x) or (load); `approach` is in m, `loaded` are its
    coordinates.
    """
    maps = {"pressure": fields.pressure, "gap": fields.gap, "contact": fields.contact}
    mean = loaded["mean_pressure"]
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
    of_load: dict[str, Any] = {name: ("load", [value]) for name, value in loaded.items()}
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
    """Return the fields of a dimensionless solution in SI units; they take its memory.

    Points at the hardness have yielded until the gap was closed: it is zero there.
    """
    state = solution.state
    # in place: the dimensionless fields are not used again
    pressure, gap = (to_numpy(field) for field in (state.pressure, state.separation))
    contact = empty(pressure, "int8")
    pressure_unit, hardness = unit_of_pressure(problem, elasticity.modulus), elasticity.hardness
    at_hardness = None if hardness == np.inf else pressure >= pressure.dtype.type(hardness / pressure_unit)
    least_gap, total = kernels_for(pressure, threads=threads).restore_units(
        pressure, gap, state.offset, pressure_unit, problem.scale, contact
    )
    yielded = 0.0
    if at_hardness is not None:
        pressure[at_hardness], gap[at_hardness] = hardness, 0.0
        yielded, least_gap = float(at_hardness.mean()), float(gap.min())
    return FieldsInUnits(pressure, gap, contact, least_gap, total, yielded)


def joined(load_datasets: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return the datasets of the loads, from `of_one_load`, as one."""
    if len(load_datasets) == 1:
        return load_datasets[0]
    return xr.concat(
        load_datasets,
        dim="load",
        data_vars="minimal",
        coords="minimal",
        compat="override",
        join="override",
        combine_attrs="override",
    )


def elasticity_of(contact: xr.Dataset) -> Elasticity:
    """Return the elasticity of a contact without its hardness, "sampled" where nothing else is recorded.

    Examples
    --------
    >>> elasticity_of(xr.Dataset({"contact_modulus": 1e9}, attrs={"influence": "elements"})).influence
    'elements'
    """
    influence: Influence = contact.attrs.get("influence", "sampled")
    check_choice("influence", influence, Influence)
    return Elasticity(float(contact["contact_modulus"]), influence, layers_of(contact))


def layers_of(contact: xr.Dataset) -> LayeredPair | None:
    """Return the layers that `solve_contact` recorded in a contact's attributes, None for half-spaces."""
    bodies = contact.attrs.get("bodies")
    return None if bodies is None else layered_pair(json.loads(bodies))


def problem_of(contact: xr.Dataset) -> dict[str, Any]:
    """Return elasticity and operator of a solved contact as keyword arguments of `solve_contact`.

    Examples
    --------
    >>> problem_of(xr.Dataset({"contact_modulus": 1e9}))["contact_modulus"]
    1000000000.0
    """
    bodies = contact.attrs.get("bodies")
    return {
        "contact_modulus": None if bodies else float(contact["contact_modulus"]),
        "bodies": json.loads(bodies) if bodies else None,
        "influence": elasticity_of(contact).influence,
        "zero_frequency": contact.attrs.get("zero_frequency", "zero"),
    }
