"""The iteration on one grid: a primal-dual active set around preconditioned conjugate gradients.

One outer step takes a feasible pressure, applies the operator afresh, measures the error bound, and corrects
the pressure on a working set C by a few steps of conjugate gradients for "constant gap on C, given load".
C holds the points that carry pressure and those that overlap: points whose pressure turns negative leave it,
points whose gap turns negative join it (Hintermueller, Ito and Kunisch 2002, SIAM J. Optim. 13, 865:
primal-dual active set). The preconditioner is the inverse operator restricted to C, centred on input and
output.

Nothing is proved for active sets with inexact inner solves. So every outer step must lower the elastic
energy; one that does not is cut short where the energy is least, or undone, and projected gradient steps
follow (`roughcontact.contact.projected`), twice as many each time, which alone would converge.

The pressure and the last gap are in double precision, the correction in single: it is small, and the next
fresh application measures what rounding did to it (iterative refinement).
"""

from dataclasses import dataclass

import numpy as np

from roughcontact.contact.certificate import error_bound, relative_bound, rounding_floor
from roughcontact.contact.contact_set import ContactSet, centred
from roughcontact.contact.projected import projected_step
from roughcontact.contact.state import State, descend, evaluate, scale_to_load, total_product
from roughcontact.halfspace import HalfSpace

SINGLE = np.float32
TOO_STIFF = 1e-3  # relative rounding floor of single precision from which all is done in double
PATIENCE = 20  # outer steps that do not improve the bound before the iteration is called stalled
MOST_STEPS = 40  # of one inner iteration
FIRST_RATE = 0.1  # by which the first conjugate gradient step is taken to lower the squared residual


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
    finish=np.float64,
    max_steps: int = 200,
) -> GridSolution:
    """Improve the pressure `start` (ny, nx) until the bound of its relative error is at most `tolerance`.

    All in dimensionless form: heights in units of g L, pressures in units of E* g; the start, nowhere
    negative, is scaled to the prescribed load first. The last application is in the precision `finish`, the
    first ones in single, while the error is far above what single precision can tell. Ends early after
    `max_steps` outer steps, at the rounding floor, or after `PATIENCE` steps in vain: the caller compares
    `error_bound` with its tolerance.
    """
    inner = precision = SINGLE
    state = evaluate(halfspace, heights, scale_to_load(start, mean_pressure), dtype=precision)
    lowest, lowest_step, failures = np.inf, 0, 0
    for step in range(max_steps + 1):
        single_floor = rounding_floor(halfspace, state, SINGLE)
        if single_floor > TOO_STIFF:
            inner = precision = finish = np.float64
        contact_set = ContactSet(halfspace, wanted(state))
        remainder = centred(contact_set.take(state.gap)).astype(inner, copy=False)
        product = contact_set.precondition(remainder)
        residual_norm = np.sqrt(max(total_product(remainder, product), 0.0) / state.gap.size)
        bound = relative_bound(halfspace, state, residual_norm)
        if bound < 0.99 * lowest:
            lowest, lowest_step = bound, step
        hopeless = (
            step == max_steps
            or step - lowest_step > PATIENCE
            or (state.gap.dtype == np.float64 and bound <= 2 * rounding_floor(halfspace, state))
        )
        if bound <= tolerance or hopeless:
            rounded = state.gap.dtype != finish
            if rounded:
                precision = finish
                state = evaluate(halfspace, heights, state.pressure, dtype=precision)
            if rounded or not contact_set.certifying:
                bound = error_bound(halfspace, state)
            if bound <= tolerance or hopeless:
                break
            if rounded:
                continue

        easy = contact_set.certifying and failures == 0
        reduction = _reduction(bound) if easy else 0.1
        correction = _correction(contact_set, remainder, product, reduction=reduction)
        corrected = contact_set.spread(contact_set.take(state.pressure) + correction)
        if bound <= max(20 * tolerance, 30 * single_floor):
            precision = finish
        trial = evaluate(halfspace, heights, contact_set.clip(corrected, mean_pressure), dtype=precision)
        # where the precision rises, what tells the two energies apart is lost in the rounding of the first
        lower = descend(state, trial) if trial.gap.dtype == state.gap.dtype else trial
        if lower is trial:
            state = trial
            continue
        failures += 1
        if lower is None and precision != finish:
            precision = finish
            state = evaluate(halfspace, heights, state.pressure, dtype=precision)
        else:
            state = lower or state
            for _ in range(2 ** min(failures, 6) if lower is None or failures > 1 else 0):
                state = projected_step(halfspace, heights, state, mean_pressure) or state
    return GridSolution(state, bound, step)


def wanted(state: State) -> np.ndarray:
    """Return the points that carry pressure or overlap: where the residual of the certificate lives."""
    return (state.pressure > 0) | (state.gap < 0)


def _reduction(bound: float) -> float:
    """Return the factor by which an inner iteration shall lower the residual.

    While the contact set moves much, a single step is as good as many; the fewer points still change sides,
    the more an accurate correction is worth. Measured over sizes, loads and seeds; the optimum is flat.
    """
    if bound > 0.02:
        return 1.0
    return 0.3 if bound > 0.002 else 0.1


def _correction(contact_set, remainder, product, *, reduction):
    """Return the change of the pressure on the set, not clipped, that takes most of the residual away.

    Preconditioned conjugate gradients for P_C G P_C d = -r with mean(d) = 0 (Hestenes and Stiefel 1952), from
    the residual `remainder` on the set and its preconditioned `product`.
    """
    correction = np.zeros_like(remainder)
    direction = -product
    rz = total_product(remainder, product)
    enough = reduction**2 * rz
    rate = FIRST_RATE
    for count in range(1, MOST_STEPS + 1):
        displaced = contact_set.take(contact_set.displacement(direction))
        curvature = total_product(direction, displaced)
        if not (curvature > 0 and rz > 0):
            break
        length = rz / curvature
        correction += length * direction
        if rz * rate <= enough or count == MOST_STEPS:
            break  # the next residual, foreseen from the last rate, will do: measuring it would cost a step
        displaced *= length
        remainder = centred(remainder + displaced)
        product = contact_set.precondition(remainder)
        rz_before, rz = rz, total_product(remainder, product)
        rate = rz / rz_before
        direction *= rate
        direction -= product
    return correction
