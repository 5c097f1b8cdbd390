"""Worker for reynoldsflow: the mean flux along y through a periodic square gap of mean 1, without 1/12."""

from importlib.metadata import version

import numpy as np
import worker
from reynoldsflow import transport


def solve(gap, load, tolerance):
    gaps, _, flux = transport.solve_fluid_problem(
        gap, boundary_mode="periodic", pressure_gradient=load, solver="scipy-spsolve"
    )
    along, _ = transport.compute_total_flux(gaps, flux, gap.shape[0], boundary_mode="periodic")
    return np.array([along]), dict


if __name__ == "__main__":
    worker.serve(lambda gap: gap, solve, {"reynoldsflow": version("reynoldsflow")})
