"""Fields of pressure and gap, load by load, as plain arrays: for ensembles of many small maps.

`solve_contact` labels and checks everything; on maps of a hundred points along a side that takes longer than
the solution itself.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.contact.free_boundary import free_solutions
from roughcontact.contact.problem import nondimensionalise
from roughcontact.contact.solve import MOST_LOAD, elasticity, periodic_solutions
from roughcontact.kernels.arrays import SINGLE
from roughcontact.maps import radii_of


class LoadFields(NamedTuple):
    """The solution of one load: fields (ny, nx) and the bound of the relative error in the energy norm."""

    load_index: int  # in `mean_pressure`
    pressure: np.ndarray  # Pa
    gap: np.ndarray  # m
    error_bound: float


def solved_fields(
    window: xr.DataArray, contact: Mapping[str, Any], *, tolerance: float, precision: str = SINGLE
) -> Iterator[LoadFields]:
    """Yield the fields of every load of a map (y, x; m), from the smallest to the largest.

    Of the arguments `contact` of `solve_contact` the elasticity, loads, `boundary`, `hardness`, `influence`
    and `threads` count; what misses the tolerance says so by its `error_bound`. A periodic map so flat that
    rounding hides its contact is solved as flat, forces on a finite body are pressures times its `area` (m2).
    """
    known = elasticity(**contact)
    loads = np.atleast_1d(np.asarray(contact["mean_pressure"], float))
    order = np.argsort(loads, kind="stable")
    rising, threads = loads[order].tolist(), contact.get("threads", 1)
    options = {"tolerance": tolerance, "threads": threads}
    problem = nondimensionalise(window, threads=threads)
    if contact.get("boundary") == "free":
        forces = [pressure * contact["area"] for pressure in rising]
        solutions = free_solutions(problem, forces, known, radii=radii_of(window), **options)
    else:
        if loads.max() > 0.5 * MOST_LOAD * known.modulus * problem.gradient:  # rounding errors only
            problem = nondimensionalise(xr.zeros_like(window), threads=threads)
        solutions = periodic_solutions(problem, rising, known, precision=precision, **options)
    for index in order:
        fields, solution, _ = next(solutions)
        yield LoadFields(int(index), fields.pressure, fields.gap, solution.error_bound)
