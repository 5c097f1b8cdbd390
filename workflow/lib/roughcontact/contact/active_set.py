"""The iteration on one grid: a primal-dual active set around preconditioned conjugate gradients.

One outer step takes a feasible pressure, applies the operator afresh, measures the error bound, and corrects
the pressure on a working set C by a few steps of conjugate gradients for "constant gap on C, given load".
Points whose uncorrected pressure turns negative leave C, points whose gap turns negative join it
(Hintermueller, Ito and Kunisch 2002, SIAM J. Optim. 13, 865: primal-dual active set). The preconditioner is
the inverse operator restricted to C, centred on input and output.

Nothing is proved for active sets with inexact inner solves. So every outer step must lower the elastic
energy; one that does not is undone and replaced by projected gradient steps
(`roughcontact.contact.projected`), twice as many each time, which alone would converge.

The pressure and the gap are in double precision, the correction in single: it is small, and the next fresh
application measures what rounding did to it (iterative refinement).
"""

from dataclasses import dataclass

import numpy as np

from roughcontact.contact.certificate import error_bound, relative_bound, rounding_floor
from roughcontact.contact.contact_set import ContactSet, centred
from roughcontact.contact.projected import projected_step
from roughcontact.contact.state import State, energy_change, evaluate, scale_to_load, total_product
from roughcontact.halfspace import HalfSpace

REDUCTION = 0.25  # of the residual by one inner iteration, where its length is not fixed
MOST_STEPS = 40  # of one inner iteration
PATIENCE = 20  # outer steps that do not improve the bound before the iteration is called stalled
SET_IN_MOTION = 0.05  # relative error above which the contact set moves too much for long inner iterations


@dataclass(frozen=True)
class GridSolution:
    """The state that was reached on one grid, the bound of its relative error, and the outer steps taken."""

    state: State
    error_bound: float
    steps: int


def solve_on_grid(
    halfspace: HalfSpace,
    heights: np.ndarray,
    start: np.ndarray,
    mean_pressure: float,
    *,
    tolerance: float,
    max_steps: int = 200,
) -> GridSolution:
    """Improve the pressure `start` (ny, nx) until the bound of its relative error is at most `tolerance`.

    All in dimensionless form: heights in units of g L, pressures in units of E* g; the start, nowhere
    negative, is scaled to the prescribed load first. Ends early after `max_steps` outer steps, at the
    rounding floor, or after `PATIENCE` steps in vain: the caller compares `error_bound` with its tolerance.
    """
    state = evaluate(halfspace, heights, scale_to_load(start, mean_pressure))
    active = _wanted(state)
    lowest, lowest_step, fallbacks = np.inf, 0, 0
    for step in range(max_steps + 1):
        contact_set = ContactSet(halfspace, active)
        remainder = centred(contact_set.take(state.gap)).astype(np.float32)
        product = contact_set.precondition(remainder)
        residual_norm = np.sqrt(max(total_product(remainder, product), 0.0) / active.size)
        bound = relative_bound(halfspace, state, residual_norm)
        if bound < 0.99 * lowest:
            lowest, lowest_step = bound, step
        exact = contact_set.certifying and np.array_equal(active, _wanted(state))
        hopeless = (
            step == max_steps
            or step - lowest_step > PATIENCE
            or bound <= 2 * rounding_floor(halfspace, state)
        )
        if (bound <= tolerance or hopeless) and not exact:
            bound = error_bound(halfspace, state)
        if bound <= tolerance or hopeless:
            break

        least = 1 if bound > SET_IN_MOTION else 3
        corrected, set_after = _correct(contact_set, state, remainder, product, least=least)
        trial = evaluate(halfspace, heights, contact_set.clip(corrected, mean_pressure))
        if energy_change(state, trial) < 0:
            state, active = trial, set_after
            continue
        fallbacks += 1
        for _ in range(2 ** min(fallbacks, 6)):
            state = projected_step(halfspace, heights, state, mean_pressure) or state
        active = _wanted(state)
    return GridSolution(state, bound, step)


def _wanted(state: State) -> np.ndarray:
    """Return the points that carry pressure or overlap: where the residual of the certificate lives."""
    return (state.pressure > 0) | (state.gap < 0)


def _correct(contact_set, state, remainder, product, *, least):
    """Return the pressure after some conjugate gradient steps on the set, not clipped, and the set after it.

    Preconditioned conjugate gradients for P_C G P_C d = -r with mean(d) = 0 (Hestenes and Stiefel 1952), the
    gap followed on the whole grid, so that points which came to overlap are seen without another application.
    """
    correction = np.zeros_like(remainder)
    gap = state.gap.astype(np.float32)
    direction = -product
    rz = total_product(remainder, product)
    enough = REDUCTION**2 * rz
    for count in range(1, MOST_STEPS + 1):
        displaced = contact_set.displacement(direction)
        curvature = total_product(direction, contact_set.take(displaced))
        if not (curvature > 0 and rz > 0):
            break
        length = np.float32(rz / curvature)
        correction += length * direction
        displaced *= length
        gap += displaced
        if count == least and contact_set.certifying:
            break
        remainder = centred(contact_set.take(gap))
        product = contact_set.precondition(remainder)
        rz_before, rz = rz, total_product(remainder, product)
        if count >= least and rz <= enough:
            break
        direction *= np.float32(rz / rz_before)
        direction -= product

    gap -= contact_set.take(gap).mean(dtype=float)
    corrected = contact_set.spread(contact_set.take(state.pressure) + correction)
    overlapping = gap < 0
    overlapping.ravel()[contact_set.points] = contact_set.take(corrected) > 0
    return corrected, overlapping
