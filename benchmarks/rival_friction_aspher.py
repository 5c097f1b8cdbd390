"""Worker for ASPHER's friction: a body pressed on (heights, Poisson's ratio 0), then pulled along x."""

from importlib.metadata import version

import aspher
import numpy as np
import worker

FRICTION = 0.3


def solve(gap, load, tolerance, *, share):
    solver = aspher.FrictionSolver(gap.shape[0], 1.0, 1.0, 0.0, aspher.CoulombFriction(FRICTION))
    solver.set_gap(gap)
    tight = {"tol_normal": tolerance, "tol_tangential": 100 * tolerance}
    solver.step(p_bar=load, **tight)
    result = solver.step(p_bar=load, q_bar=[share * FRICTION * load, 0.0], **tight)
    return np.asarray(result.qx), lambda: {"converged": bool(result.converged)}


if __name__ == "__main__":
    worker.serve(lambda heights: heights.max() - heights, solve, {"ASPHER": version("aspher")})
