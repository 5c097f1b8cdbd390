"""Solve a periodic contact problem with Tamaas or ContactMechanics: a program of its own, for their Python.

python outside.py CODE PROBLEM SOLUTION

PROBLEM holds `heights` (ny, nx), `lengths` (Ly, Lx) and `loads`, dimensionless, E* = 1, and for a layer on a
rigid base, which ContactMechanics knows, `thickness` and `poissons_ratio`. SOLUTION will hold
`pressures` (load, ny, nx) and `version`. It imports nothing of roughcontact, and roughcontact never imports
it: the codes are used as outside programs.
"""

import sys
from collections.abc import Iterator

import numpy as np


def tamaas(heights: np.ndarray, lengths: np.ndarray, loads: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the pressure (ny, nx) at each load by Tamaas, to 1e-10 of its own error.

    The solver is that of Polonsky and Keer (1999), Wear 231, 206: conjugate gradients on the contact set.
    `heights` are one period of the `lengths` (Ly, Lx), the loads mean pressures, E* = 1. Of an odd number of
    rows two periods are solved: Tamaas 2.9.0 has wrong wave numbers there (tests/faults/upstream.md).

    Raises
    ------
    SystemExit
        where a load does not converge, with the error message.
    """
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    rows = len(heights)
    periods = 1 + rows % 2
    heights, lengths = np.tile(heights, (periods, 1)), lengths * [periods, 1]
    for load in loads:
        model = tm.ModelFactory.createModel(tm.model_type.basic_2d, list(lengths), list(heights.shape))
        model.E, model.nu = 1.0, 0.0
        solver = tm.PolonskyKeerRey(model, heights, 1e-10)
        solver.max_iter = 100_000
        if not solver.solve(load) <= 1e-10:
            raise SystemExit(f"Tamaas did not converge at the load {load:g}")
        yield model.traction[:rows].copy()


def contactmechanics(
    heights: np.ndarray,
    lengths: np.ndarray,
    loads: np.ndarray,
    thickness: float | None = None,
    poissons_ratio: float = 0.0,
) -> Iterator[np.ndarray]:
    """Yield the pressure (ny, nx) at each load by ContactMechanics, to overlaps and tensions of 1e-9.

    A `thickness` stands for a layer on a rigid base.

    Solver, arguments and errors are those of `tamaas`.
    """
    from ContactMechanics import PeriodicFFTElasticHalfSpace
    from ContactMechanics.Systems import NonSmoothContactSystem
    from SurfaceTopography import Topography

    ny, nx = heights.shape
    size = (float(lengths[1]), float(lengths[0]))
    area = size[0] * size[1]
    layer = {} if thickness is None else {"thickness": float(thickness), "poisson": float(poissons_ratio)}
    young = 1.0 if thickness is None else 1 - float(poissons_ratio) ** 2
    substrate = PeriodicFFTElasticHalfSpace((nx, ny), young, size, **layer)
    for load in loads:
        surface = Topography(np.ascontiguousarray(heights.T), size, periodic=True)
        system = NonSmoothContactSystem(substrate, surface)
        accuracy = {"pentol": 1e-9, "forcetol": 1e-9 * area / heights.size, "maxiter": 100_000}
        result = system.minimize_proxy(external_force=load * area, **accuracy)
        if not result.success:
            raise SystemExit(f"ContactMechanics did not converge at the load {load:g}: {result.message}")
        yield np.asarray(system.force).T * heights.size / area


def main() -> None:
    """Solve the problem in one file by the code of the command line, and write the solution to another."""
    code, path, solution = sys.argv[1:]
    from importlib.metadata import version

    names = {"tamaas": ("tamaas", tamaas), "contactmechanics": ("ContactMechanics", contactmechanics)}
    distribution, solve = names[code]
    with np.load(path) as given:
        problem = dict(given)
    pressures = np.array(list(solve(**problem)))
    np.savez(solution, pressures=pressures, version=version(distribution))


if __name__ == "__main__":
    main()
