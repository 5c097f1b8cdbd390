"""Solve a periodic contact problem with Tamaas or ContactMechanics: a program of its own, for their Python.

python solve.py CODE PROBLEM SOLUTION

PROBLEM holds `heights` (ny, nx), `lengths` (Ly, Lx) and `loads`, dimensionless, E* = 1. SOLUTION gets
`pressures` (load, ny, nx) and `version`. It imports nothing of roughcontact, and roughcontact never imports
it: the codes are used as outside programs.
"""

import sys

import numpy as np


def tamaas(heights, lengths, loads):
    """Polonsky and Keer's conjugate gradients, to 1e-10 of Tamaas's own error."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    for load in loads:
        model = tm.ModelFactory.createModel(tm.model_type.basic_2d, list(lengths), list(heights.shape))
        model.E, model.nu = 1.0, 0.0
        solver = tm.PolonskyKeerRey(model, heights, 1e-10)
        solver.max_iter = 100_000
        if not solver.solve(load) <= 1e-10:
            raise SystemExit(f"Tamaas did not converge at the load {load:g}")
        yield model.traction.copy()


def contactmechanics(heights, lengths, loads):
    """Polonsky and Keer's conjugate gradients, to overlaps and tensions of 1e-9."""
    from ContactMechanics import PeriodicFFTElasticHalfSpace
    from ContactMechanics.Systems import NonSmoothContactSystem
    from SurfaceTopography import Topography

    ny, nx = heights.shape
    size = (float(lengths[1]), float(lengths[0]))
    area = size[0] * size[1]
    substrate = PeriodicFFTElasticHalfSpace((nx, ny), 1.0, size)
    for load in loads:
        surface = Topography(np.ascontiguousarray(heights.T), size, periodic=True)
        system = NonSmoothContactSystem(substrate, surface)
        accuracy = {"pentol": 1e-9, "forcetol": 1e-9 * area / heights.size, "maxiter": 100_000}
        result = system.minimize_proxy(external_force=load * area, **accuracy)
        if not result.success:
            raise SystemExit(f"ContactMechanics did not converge at the load {load:g}: {result.message}")
        yield np.asarray(system.force).T * heights.size / area


def main():
    code, problem, solution = sys.argv[1:]
    from importlib.metadata import version

    names = {"tamaas": ("tamaas", tamaas), "contactmechanics": ("ContactMechanics", contactmechanics)}
    distribution, solve = names[code]
    with np.load(problem) as given:
        heights, lengths, loads = (given[name] for name in ("heights", "lengths", "loads"))
    pressures = np.array(list(solve(heights, lengths, loads)))
    np.savez(solution, pressures=pressures, version=version(distribution))


if __name__ == "__main__":
    main()
