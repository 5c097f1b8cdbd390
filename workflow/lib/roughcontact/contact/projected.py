"""The safe step: projected gradient, slow but always downhill.

The projection onto {p >= 0, mean(p) = given} is that of the Euclidean norm, whose projected steps lower the
energy for every small enough step length (Bertsekas 1976, IEEE Trans. Autom. Control 21, 174).
"""

import numpy as np

from roughcontact.contact.state import State, descend, evaluate, mean_product


def project_to_load(pressure: np.ndarray, mean_pressure: float) -> np.ndarray:
    """Return the nearest field to `pressure` that is nowhere negative and has the prescribed mean.

    It is max(p - shift, 0); the shift comes from Newton's method on the mean, which is convex and piecewise
    linear in the shift, so that it ends after finitely many steps (Michelot 1986, J. Optim. Theory Appl. 50,
    195).
    """
    total = mean_pressure * pressure.size
    kept = pressure.ravel()
    while True:
        shift = (kept.sum() - total) / kept.size
        above = kept > shift
        if above.all():
            break
        kept = kept[above]
    projected = np.maximum(pressure - shift, 0)
    projected *= mean_pressure / projected.mean()  # rounding of the shift only
    return projected


def projected_step(halfspace, heights: np.ndarray, state: State, mean_pressure: float) -> State | None:
    """Return a state of lower energy, one projected gradient step away; None where rounding leaves none.

    The first step length is that of steepest descent on the contact, <r, r> / <r, G r>; it is halved until
    the energy falls along the way to the projection.
    """
    active = (state.pressure > 0) | (state.gap < 0)
    slope = np.where(active, state.gap, 0)
    slope[active] -= slope[active].mean()
    curvature = mean_product(slope, halfspace.displacement(slope))
    if curvature <= 0:
        return None
    length = mean_product(slope, slope) / curvature
    for _ in range(40):
        trial = evaluate(
            halfspace,
            heights,
            project_to_load(state.pressure - length * state.gap, mean_pressure),
            dtype=state.gap.dtype,
        )
        lower = descend(state, trial)
        if lower is not None:
            return lower
        length *= 0.5
    return None
