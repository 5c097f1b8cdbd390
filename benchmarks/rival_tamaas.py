"""Worker for Tamaas: Polonsky and Keer's conjugate gradients, as its documentation recommends them.

Its PyPI wheel runs on one thread, whatever it is told. Model and FFTW plans are made anew for each solve;
that takes 1 % of the time of a solve. E = 1 and nu = 0 make E* = 1; the tolerance is that of Tamaas, which
gives up after 10 000 iterations.
"""

import tamaas as tm
import worker


def solve(heights, load, tolerance, *, hardness=None):
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [1.0, 1.0], list(heights.shape))
    model.E, model.nu = 1.0, 0.0
    if hardness is None:
        solver = tm.PolonskyKeerRey(model, heights, tolerance)
    else:
        solver = tm.KatoSaturated(model, heights, tolerance, hardness)
    solver.max_iter = 10_000
    reached = solver.solve(load)
    return model.traction.copy(), lambda: {"converged": reached <= tolerance}


if __name__ == "__main__":
    tm.set_log_level(tm.LogLevel.error)
    worker.serve(lambda heights: heights, solve, {"Tamaas": tm.__version__})
