"""Fields of pressure and gap, load by load, as plain arrays: for ensembles of many small maps.

`solve_contact` labels and checks everything; on maps of a hundred points along a side that takes longer than
the solution itself.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.contact.dataset import fields_in_units, unit_of_pressure
from roughcontact.contact.problem import nondimensionalise
from roughcontact.contact.solve import MOST_LOAD, elasticity
from roughcontact.contact.sweep import sweep
from roughcontact.kernels.arrays import SINGLE


class LoadFields(NamedTuple):
    """The solution of one load: fields (ny, nx) and the bound of the relative error in the energy norm."""

    load_index: int  # in `mean_pressure`
    pressure: np.ndarray  # Pa
    gap: np.ndarray  # m
    error_bound: float


def solved_fields(
    window: xr.DataArray, contact: Mapping[str, Any], *, tolerance: float, precision: str = SINGLE
) -> Iterator[LoadFields]:
    """Yield the fields of every load of a periodic map (y, x; m), from the smallest to the largest.

    Of the arguments `contact` of `solve_contact` the elasticity, loads, `hardness`, `influence` and `threads`
    count; what misses the tolerance says so by its `error_bound`. A map so flat that rounding hides its
    contact is solved as flat.
    """
    modulus, layers = elasticity(contact.get("contact_modulus"), contact.get("bodies"))
    loads = np.atleast_1d(np.asarray(contact["mean_pressure"], float))
    hardness, threads = contact.get("hardness"), contact.get("threads", 1)
    problem = nondimensionalise(window, threads=threads)
    if loads.max() > 0.5 * MOST_LOAD * modulus * problem.gradient:  # rounding errors only, after levelling
        problem = nondimensionalise(xr.zeros_like(window), threads=threads)
    unit = unit_of_pressure(problem, modulus)
    order = np.argsort(loads, kind="stable")
    solutions = sweep(
        problem,
        [float(loads[index] / unit) for index in order],
        tolerance=tolerance,
        cap=np.inf if hardness is None else hardness / unit,
        influence=contact.get("influence", "sampled"),
        layers=layers and layers.scaled(problem.unit_length),
        precision=precision,
        threads=threads,
    )
    for index in order:
        solution = next(solutions)
        fields = fields_in_units(solution, problem, modulus=modulus, hardness=hardness, threads=threads)
        yield LoadFields(int(index), fields.pressure, fields.gap, solution.error_bound)
