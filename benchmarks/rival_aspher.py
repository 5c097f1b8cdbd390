"""Worker for ASPHER: nested grids and its preconditioner, in the configuration that was fastest here.

Single precision down to the tolerance that it can reach (2e-6 by default), single then double below: always
polishing in double, the obvious choice, solves far below a true error of 1e-4 and takes about a fifth
longer. No gap or displacement is asked for. Builds with -march=native or FFTW were no faster than the plain
one. The tolerance is ASPHER's, on the relative Frank-Wolfe gap: about the square of the error.
"""

from importlib.metadata import version

import aspher
import worker

SINGLE_REACHES = 2e-6


def solve(gap, load, tolerance, *, coarsest=32):
    result = aspher.solve_nested(
        grid_size=gap.shape[0],
        gap=gap.ravel(),
        p_nominal=load,
        tol=tolerance,
        backend="periodic",
        precond_engine="fft",
        precision="float" if tolerance >= SINGLE_REACHES else "float_then_double",
        coarsest=coarsest,
        light_result=True,
    )
    return result.pressure, lambda: {"converged": str(result.status) == "converged"}


if __name__ == "__main__":
    worker.serve(lambda heights: -heights, solve, {"ASPHER": version("aspher")})
