"""Fields of pressure and gap, load by load, as plain arrays: for ensembles of many small maps.

`solve_contact` labels and checks everything; on maps of a hundred points along a side that takes longer than
the solution itself.
"""

import contextlib
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.kinds import facts_of
from roughcontact.contact.problem import nondimensionalise
from roughcontact.contact.solve import MAX_LOAD, METHODS, elasticity
from roughcontact.errors import HeightMapError
from roughcontact.kernels.arrays import SINGLE


def solved_fields(
    window: xr.DataArray, contact: Mapping[str, Any], *, tolerance: float, precision: str = SINGLE
) -> Iterator[tuple[int, np.ndarray, np.ndarray, float]]:
    """Yield index, pressure (Pa), gap and approach (m) of every load of a map (y, x; m) from the smallest on.

    Of the arguments `contact` of `solve_contact` the elasticity, loads, `boundary`, `hardness`, `influence`
    and `threads` count. A load that misses the tolerance, or under which the contact leaves the map, is left
    out. A map so flat that rounding hides its contact is solved as flat, forces on a finite body are
    pressures times its `area` (m2).
    """
    material = elasticity(**contact)
    loads = np.atleast_1d(np.asarray(contact["mean_pressure"], float))
    order = np.argsort(loads, kind="stable")
    rising, threads = loads[order].tolist(), contact.get("threads", 1)
    options = {"tolerance": tolerance, "threads": threads}
    problem = nondimensionalise(window, threads=threads)
    if loads.max() > 0.5 * MAX_LOAD * material.modulus * problem.gradient:  # rounding errors only
        problem = nondimensionalise(xr.zeros_like(window), threads=threads)
    kind = facts_of(contact)
    rising = [pressure * kind.load_over_pressure(contact.get("area", 1.0)) for pressure in rising]
    solutions = METHODS[kind.name].solutions(
        problem, rising, material, window=window, precision=precision, **options
    )
    with contextlib.suppress(HeightMapError):  # and larger loads leave it, too
        for index in order:
            fields, solution, approach = next(solutions)
            if solution.error_bound <= tolerance:
                yield int(index), fields.pressure, fields.gap, approach
