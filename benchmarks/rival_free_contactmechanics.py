"""Worker for ContactMechanics on a finite body: free boundaries, E* and side 1; the tolerance is its own."""

from importlib.metadata import version

import numpy as np
import worker
from ContactMechanics import make_system
from SurfaceTopography import Topography


def solve(system, load, tolerance):
    result = system.minimize_proxy(external_force=load, pentol=tolerance, maxiter=10_000)
    points = system.surface.nb_grid_pts
    pressure = np.array(system.substrate.force)[: points[0], : points[1]] * points[0] * points[1]
    return pressure, lambda: {"converged": bool(result.success)}


def pose(heights):
    return make_system(substrate="free", surface=Topography(heights, (1.0, 1.0)), young=1.0)


if __name__ == "__main__":
    worker.serve(pose, solve, {"ContactMechanics": version("ContactMechanics")})
