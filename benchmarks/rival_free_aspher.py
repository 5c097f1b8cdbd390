"""Worker for ASPHER on a finite body: nested grids, free boundaries by its FFT backend, E* and side 1."""

from importlib.metadata import version

import aspher
import worker

SINGLE_REACHES = 2e-6


def solve(gap, load, tolerance, *, precision=""):
    result = aspher.solve_nested(
        grid_size=gap.shape[0],
        gap=gap.ravel(),
        p_nominal=load,
        tol=tolerance,
        backend="fft",
        precond_engine="fft",
        precision=precision or ("float" if tolerance >= SINGLE_REACHES else "float_then_double"),
        coarsest=32,
        light_result=True,
    )
    return result.pressure, lambda: {"converged": str(result.status) == "converged"}


if __name__ == "__main__":
    worker.serve(lambda heights: heights.max() - heights, solve, {"ASPHER": version("aspher")})
