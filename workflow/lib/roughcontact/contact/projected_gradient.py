"""The safe step: projected gradient, slow but always downhill.

The projection onto {0 <= p <= cap, mean(p) = given} is that of the Euclidean norm, whose projected steps
lower the energy for every small enough step length [1]_.

References
----------
.. [1] Bertsekas (1976), On the Goldstein-Levitin-Polyak gradient projection method, IEEE Trans. Autom.
   Control 21, 174.
"""

import numpy as np

from roughcontact.contact.grid import Grid
from roughcontact.contact.line_search import minimize_between
from roughcontact.contact.state import State, mean_product
from roughcontact.kernels.array_api import active_set, mean
from roughcontact.kernels.arrays import Array


def project_to_load(pressure: Array, mean_pressure: float, *, cap: float = np.inf) -> Array:
    """Return the nearest field to `pressure` between 0 and `cap` that has the prescribed mean.

    It is max(min(p - shift, cap), 0); the mean falls with the shift, which bisection finds to the last digit.

    Parameters
    ----------
    pressure : array (ny, nx)
        dimensionless.
    mean_pressure : float
        to be reached.
    cap : float
        largest pressure allowed.

    Returns
    -------
    array (ny, nx)
    """
    xp = pressure.__array_namespace__()
    top = None if cap == np.inf else cap
    low, high = float(xp.min(pressure)) - mean_pressure, float(xp.max(pressure))
    if top is not None:
        low -= cap
    while True:
        shift = 0.5 * (low + high)
        projected = xp.clip(pressure - shift, 0, top)
        if not low < shift < high:
            break
        if mean(projected) > mean_pressure:
            low = shift
        else:
            high = shift
    return projected


def projected_gradient_step(grid: Grid, state: State, mean_pressure: float) -> State | None:
    """Return a state of lower energy, one projected gradient step away; None where rounding leaves none.

    The first step length is that of steepest descent on the active set, <r, r> / <r, G r>; it is halved until
    the energy falls along the line to the projection.

    Parameters
    ----------
    grid : Grid
        operator and preconditioner.
    state : State
        a feasible pressure and its separation.
    mean_pressure : float
        prescribed, dimensionless.

    Returns
    -------
    State or None
    """
    xp = state.pressure.__array_namespace__()
    gap, pressure = state.gap, state.pressure
    slope = xp.where(active_set(pressure, gap, grid.cap), gap, xp.zeros_like(gap))
    curvature = mean_product(slope, grid.halfspace.displacement(slope))
    if curvature <= 0:
        return None
    length = mean_product(slope, slope) / curvature
    for _ in range(40):
        moved = project_to_load(pressure - length * gap, mean_pressure, cap=grid.cap)
        trial, line = grid.evaluate(moved, before=state)
        lower = trial if line.descends else minimize_between(state, trial, line, cap=grid.cap)
        if lower is not None:
            return lower
        length *= 0.5
    return None
