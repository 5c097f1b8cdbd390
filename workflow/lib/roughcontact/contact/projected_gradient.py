"""The safe step: projected gradient, slow but always downhill for small enough steps.

The projection onto {0 <= p <= cap, mean(p) = given} is that of the Euclidean norm (Bertsekas 1976, IEEE
Trans. Autom. Control 21, 174).
"""

from roughcontact.contact.grid import Grid
from roughcontact.contact.line_search import minimize_between
from roughcontact.contact.state import State, mean_product, project_to_load
from roughcontact.kernels.array_api import active_set
from roughcontact.kernels.arrays import namespace


def projected_gradient_step(grid: Grid, state: State, mean_pressure: float) -> State | None:
    """Return a state of lower energy, one projected gradient step away; None where rounding leaves none.

    The first step length is that of steepest descent on the active set, <r, r> / <r, G r>; it is halved until
    the energy falls along the line to the projection.
    """
    xp = namespace(state.pressure)
    gap, pressure = state.gap, state.pressure
    slope = xp.where(active_set(pressure, gap, grid.cap), gap, xp.zeros_like(gap))
    curvature = mean_product(slope, grid.halfspace.displacement(slope))
    if curvature <= 0:  # no curvature is left but rounding
        return None
    length = mean_product(slope, slope) / curvature  # the minimum along the slope, if no bound interfered
    for _ in range(40):  # down to 1e-12 of it, below which rounding decides
        next_pressure = project_to_load(pressure - length * gap, mean_pressure, cap=grid.cap)
        trial, line = grid.evaluate(next_pressure, former=state)
        lower = trial if line.descends else minimize_between(state, trial, line, cap=grid.cap)
        if lower is not None:
            return lower
        length *= 0.5
    return None
