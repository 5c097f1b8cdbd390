"""The iteration on one grid: a preconditioned step, held between the bounds of the pressure, again and again.

One step takes a feasible pressure, applies the operator afresh, extends the residual of the unsettled points
(those that carry pressure, and those that overlap) over the rest of the surface, applies the inverse operator
to that, and subtracts the result from the pressure, which is then held at 0:

    p <- [ p - t (M r - mean) ]+ .

M = W^T G^-1 W is nowhere less than the inverse of the operator on the unsettled points and mostly at most an
eighth more (`roughcontact.contact.interpolation`), so that what stands in the brackets is nearly the pressure
of least energy that those points could carry with either sign. The one of least energy without tension is its
projection onto p >= 0 in the norm of the energy. That projection is imitated: the points held at 0 hand the
load that they lose to the contact around them, as charges at grounded conductors do, by W^T for the points
that stay. The contact set so moves with every step, and two transform pairs cut the error by twenty. It is a
primal-dual active set (Hintermueller, Ito and Kunisch 2002, SIAM J. Optim. 13, 865) whose linear systems are
solved by one application of a nearly exact inverse.

The step length t follows from the energy along the last step, which is quadratic and known. Nothing is proved
for steps of this kind: so every one must lower the elastic energy. One that does not is cut short where the
energy is least, or undone, and projected gradient steps follow (`roughcontact.contact.projected_gradient`),
twice as many with every second failure, which alone would converge. Where a step gains little, the next
correction is an accurate one (`roughcontact.contact.conjugate_gradients`).

The first steps are taken in single precision. Then pressure and separation are in double precision and the
correction stays in single: it is small, and the next fresh application measures what rounding did to it
(iterative refinement).
"""

from dataclasses import dataclass

import numpy as np

from roughcontact.contact.certificate import error_bound, relative_bound, rounding_floor
from roughcontact.contact.conjugate_gradients import accurate, is_slow
from roughcontact.contact.grid import Grid
from roughcontact.contact.projected_gradient import projected_step
from roughcontact.contact.state import State, between, scale_to_load
from roughcontact.kernels.arrays import DOUBLE, SINGLE, empty, in_precision, precision_of

TOO_STIFF = 1e-3  # relative rounding floor of single precision from which all is done in double
PATIENCE = 20  # steps that do not improve the bound before the iteration is called stalled
FEW_STEPS = 10  # are enough for a first guess, else it is left to the safeguarded iteration
FIRST_LENGTH, LONGEST = 0.965, 0.99
TYPICAL = 0.05  # of the bound is what a good step leaves
# A step that may leave this share of what is foreseen is taken in double: one that meets the tolerance in
# single precision is followed by another, which costs three pairs; one that misses it in double costs a pair.
HOPE = 0.5
SHORTEST = 0.4  # step length; none need be longer than 1, because M is nowhere less than the inverse


@dataclass(frozen=True)
class GridSolution:
    """The state that was reached on one grid, the bound of its relative error, and the steps taken."""

    state: State
    error_bound: float
    steps: int


def solve_on_grid(
    grid: Grid,
    start,
    mean_pressure: float,
    *,
    tolerance: float,
    finish: str = DOUBLE,
    max_steps: int = 200,
) -> GridSolution:
    """Improve the pressure `start` (ny, nx) until the bound of its relative error is at most `tolerance`.

    All in dimensionless form: heights in units of g L, pressures in units of E* g; the start, nowhere
    negative, is scaled to the prescribed load first. The last application is in the precision `finish`, the
    first ones in single, while the error is far above what single precision can tell. Ends early after
    `max_steps` steps, at the rounding floor, or after `PATIENCE` steps in vain: the caller compares
    `error_bound` with its tolerance.
    """
    cap, halfspace = grid.cap, grid.halfspace
    inner = precision = SINGLE
    state, _ = grid.evaluate(
        scale_to_load(in_precision(start, precision, copy=False), mean_pressure, cap=cap)
    )
    del start
    lowest, lowest_step, failures, bound_before = np.inf, 0, 0, np.inf
    length = FIRST_LENGTH
    trial = spare = None
    for step in range(max_steps + 1):
        single_floor = rounding_floor(halfspace, state, SINGLE)
        if single_floor > TOO_STIFF:
            inner = precision = finish = DOUBLE
        residual = grid.residual(state, precision=inner)
        bound = _bound(grid, state, residual)
        if bound < 0.99 * lowest:
            lowest, lowest_step = bound, step
        reached = precision_of(state.pressure)
        hopeless = (
            step == max_steps
            or step - lowest_step > PATIENCE
            or (reached == DOUBLE and bound <= 2 * rounding_floor(halfspace, state))
        )
        if (bound <= tolerance and reached == finish) or hopeless:
            if reached != finish:
                precision = finish
                state = _in_precision(grid, state, precision, mean_pressure)
                residual = grid.residual(state, precision=inner)
            bound = error_bound(grid, state, residual)
            if bound <= tolerance or hopeless:
                break
            residual = grid.residual(state, precision=inner)
        # the last step, as far as the one before tells, is taken in the precision of the result
        foreseen = bound * min(1.0, max(TYPICAL, bound / bound_before))
        if HOPE * foreseen <= tolerance or bound <= 30 * single_floor:
            precision = finish
        rises = precision != precision_of(state.pressure)
        if rises:
            spare = None
        moved = empty(state.pressure, precision) if spare is None else spare.pressure
        slow = step > 0 and is_slow(bound, bound_before)
        product = grid.precondition(residual)
        del residual  # and with it a spectrum that the next one need not lie beside
        if slow:
            product = accurate(grid, product)
        bound_before = bound
        moved = grid.advance(state, product, 1.0 if slow else length, mean_pressure, moved)
        if rises:
            # What tells the two energies apart is lost in the rounding of the first: it need not be kept.
            state = trial = None
            state, _ = grid.evaluate(moved)
            continue
        trial, way = grid.evaluate(moved, before=state, room=None if spare is None else spare.separation)
        if way.falls:
            if not slow:
                length = min(LONGEST, max(SHORTEST, length * way.least))
            state, spare = trial, state
            continue
        failures += 1
        spare = None
        length = max(SHORTEST, 0.5 * length)
        lower = between(state, trial, way, cap=cap)
        if lower is None and precision != finish:
            precision = finish
            state = _in_precision(grid, state, precision, mean_pressure)
        else:
            state = lower or state
            for _ in range(2 ** min(1 + failures // 2, 6) if lower is None or failures > 1 else 0):
                state = projected_step(grid, state, mean_pressure) or state
    return GridSolution(state, bound, step)


def improve_on_grid(grid: Grid, start, mean_pressure: float, *, tolerance: float) -> tuple:
    """Return a pressure (ny, nx) whose relative error is about `tolerance`, and the number of steps to it.

    For a first guess on a finer grid: what the last step leaves is foreseen, not measured. Steps that gain
    less than half are not for this function: `solve_on_grid` goes on.
    """
    pressure = scale_to_load(in_precision(start, SINGLE, copy=False), mean_pressure, cap=grid.cap)
    bound_before = np.inf
    for step in range(FEW_STEPS):
        state, _ = grid.evaluate(pressure)
        residual = grid.residual(state, precision=SINGLE)
        bound = _bound(grid, state, residual)
        if bound <= tolerance:
            return state.pressure, step
        if is_slow(bound, bound_before):
            break
        product = grid.precondition(residual)
        pressure = grid.advance(state, product, FIRST_LENGTH, mean_pressure, empty(state.pressure, SINGLE))
        if HOPE * TYPICAL * bound <= tolerance:
            return pressure, step + 1
        bound_before = bound
    solution = solve_on_grid(grid, pressure, mean_pressure, tolerance=tolerance, finish=SINGLE)
    return solution.state.pressure, step + solution.steps


def _bound(grid, state, residual):
    """Return the bound of the relative error that the extended residual gives, without the certificate."""
    return relative_bound(grid.halfspace, state, np.sqrt(residual.energy))


def _in_precision(grid, state, precision, mean_pressure):
    pressure = in_precision(state.pressure, precision)
    return grid.evaluate(scale_to_load(pressure, mean_pressure, cap=grid.cap))[0]
