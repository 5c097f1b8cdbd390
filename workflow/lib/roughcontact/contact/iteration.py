"""The iteration on one grid: a preconditioned step, projected onto the feasible pressures, again and again.

    p <- [ p - t (M r - mean) ]+ ,    M = P^T G^-1 P

M is mostly at most an eighth more than the inverse of the operator on the active set C, the points that carry
pressure and those that overlap (`roughcontact.contact.interpolation`): a primal-dual active-set method
(Hintermueller, Ito and Kunisch 2002, SIAM J. Optim. 13, 865). The load of points held at 0 is passed to the
contact around them by P^T, as to grounded conductors; two transform pairs reduce the error twentyfold. The
first step on a grid excludes the points that are predicted to lose contact, with a hardness on the finest
grid alone.

No convergence is proved, so every step must lower the elastic energy, quadratic along the last one: a step
that does not is shortened or undone, and projected gradient steps follow, twice as many with every eighth
failure. A correction that solves for C accurately gained nothing: on stiff films with a hardness loads took
up to ten times as many transforms. The first steps are in single precision; then only the correction is
(iterative refinement).
"""

from dataclasses import dataclass

import numpy as np

from roughcontact.contact.certificate import error_bound, relative_bound, rounding_floor
from roughcontact.contact.grid import Grid, Residual
from roughcontact.contact.line_search import LineSearch, minimize_between
from roughcontact.contact.projected_gradient import projected_gradient_step
from roughcontact.contact.state import State, scale_to_load
from roughcontact.kernels.arrays import DOUBLE, SINGLE, Array, empty, get_precision

MAX_SINGLE_FLOOR = 1e-3  # relative rounding floor of single precision above which all steps are in double
PATIENCE = 20  # steps that do not improve the bound before the iteration is called stalled
GUESS_STEPS = 10  # for a first guess; after them the safeguarded iteration takes over
MAX_FLOOR_RATIO = 1.5  # largest ratio of the floor of a first guess to that of the solution
FIRST_LENGTH, SHORTEST, LONGEST = 0.985, 0.1, 0.99  # of a step; M is nowhere less than the inverse
TYPICAL = 0.05  # ratio of the bounds after and before a good step
# A step is taken in double if this share of the predicted bound meets the tolerance: a step that meets it in
# single precision is followed by another, which costs three pairs; one that misses it in double costs a pair.
PREDICTION_MARGIN = 0.5


@dataclass(frozen=True)
class Solution:
    """One load in dimensionless form: the final state on a grid and how it was reached."""

    state: State
    error_bound: float  # of the relative error
    steps: int  # on all grids
    applications: float = 0.0  # transform pairs on all grids, weighted by size
    floor: float = 0.0  # relative error below which rounding hides all changes


def solve_on_grid(
    grid: Grid,
    start: Array,
    mean_pressure: float,
    *,
    tolerance: float,
    finish: str = DOUBLE,
    max_steps: int = 200,
    give_up: bool = False,
) -> Solution:
    """Improve a pressure (ny, nx) until the bound of its relative error is at most `tolerance`.

    Ends early after `max_steps` steps, at the rounding floor, or after `PATIENCE` steps in vain, with
    `give_up` before any step that rounding defeats: the caller compares `error_bound`. `start`, nowhere
    negative, is scaled to the load in place; `finish` is the precision of the last application. Heights are
    in units of g L, pressures of E* g.
    """
    iterate = Iterate(grid, start, mean_pressure, tolerance=tolerance, finish=finish)
    del start  # the iterate holds it, or a copy in another precision
    for step in range(max_steps + 1):
        iterate.measure(step)
        cannot_improve = (
            step == max_steps or iterate.has_stalled(step) or (give_up and iterate.is_limited_by_rounding())
        )
        if cannot_improve or iterate.may_be_done():
            iterate.certify()
            if cannot_improve or iterate.bound <= tolerance:
                break
            iterate.measure_residual()  # the certificate has overwritten it
        iterate.choose_precision()
        iterate.advance()
    return Solution(iterate.state, iterate.bound, step)


class Iterate:
    """The state of the iteration on a grid, and the history that determines the next step.

    `bound` of the relative error is rigorous after `certify`; `precision` is that of the next pressure,
    `residual_precision` of residual and correction, `finish` of the result; `length` is that of the next
    step.
    """

    residual: Residual  # deleted during a step: its spectrum need not lie beside another

    def __init__(self, grid: Grid, start: Array, mean_pressure: float, *, tolerance: float, finish: str):
        self.grid, self.mean_pressure = grid, mean_pressure
        self.tolerance, self.finish = tolerance, finish
        self.precision = self.residual_precision = SINGLE
        self.state = self._rescaled_state(SINGLE, start)
        self.bound = self._bound_before = self._lowest = np.inf
        self._lowest_step = self._failures = 0
        self.length = FIRST_LENGTH
        self._spare: State | None = None  # whose arrays the next state may have

    def measure(self, step: int) -> None:
        """Compute the residual of the state, and the bound that it gives without the certificate."""
        self._single_floor = rounding_floor(self.grid.halfspace, self.state, SINGLE)
        if self._single_floor > MAX_SINGLE_FLOOR:
            self.residual_precision = self.precision = self.finish = DOUBLE
        # the contact of a first guess is too large
        self.measure_residual(predict=step == 0)
        self.bound = _residual_bound(self.grid, self.state, self.residual)
        if self.residual.certifies and self.bound < 0.99 * self._lowest:
            self._lowest, self._lowest_step = self.bound, step

    def measure_residual(self, *, predict: bool = False) -> None:
        """Compute the residual of the state afresh; `predict` as in `Grid.residual`."""
        self.residual = self.grid.residual(self.state, precision=self.residual_precision, predict=predict)

    def is_in_final_precision(self) -> bool:
        """Return whether the state has the precision of the result."""
        return get_precision(self.state.pressure) == self.finish

    def is_limited_by_rounding(self) -> bool:
        """Return whether the rounding of a result in single precision alone is above the tolerance."""
        return self.finish == SINGLE and self._single_floor > MAX_FLOOR_RATIO * self.tolerance

    def has_stalled(self, step: int) -> bool:
        """Return whether no further step would help: at the rounding floor, or after many in vain."""
        if step - self._lowest_step > PATIENCE:
            return True
        if not (self.is_in_final_precision() and self.residual.certifies):
            return False
        # the floor is part of the bound: in single precision the tolerance may lie just above it
        at_floor = 2.0 if self.finish == DOUBLE or self.is_limited_by_rounding() else 1.005
        return self.bound <= at_floor * rounding_floor(self.grid.halfspace, self.state)

    def may_be_done(self) -> bool:
        """Return whether the bound is low enough to compute the certificate."""
        return self.bound <= self.tolerance and self.is_in_final_precision()

    def certify(self) -> None:
        """Make the bound rigorous, for a state in the precision of the result; the residual is lost."""
        if not self.is_in_final_precision():  # the bound has to be that of the pressure that is returned
            self.precision = self.finish
            self.state = self._rescaled_state(self.precision, self.state.pressure)
            self.measure_residual()
        elif not self.residual.certifies:
            self.measure_residual()
        self.bound = error_bound(self.grid, self.state, self.residual)

    def choose_precision(self) -> None:
        """Choose the precision of the next step: that of the result if it is predicted to be the last."""
        # the next step gains as much as the last one, at most the typical factor
        prediction = self.bound * min(1.0, max(TYPICAL, self.bound / self._bound_before))
        if PREDICTION_MARGIN * prediction <= self.tolerance or self.bound <= 30 * self._single_floor:
            self.precision = self.finish

    def advance(self) -> None:
        """Take a step: correct the pressure, apply the operator, and accept the state or recover."""
        grid, precision = self.grid, self.precision
        rises = precision != get_precision(self.state.pressure)
        if rises:
            self._spare = None  # arrays in single precision cannot hold the next state
        out = empty(self.state.pressure, precision) if self._spare is None else self._spare.pressure
        correction = grid.precondition(self.residual)
        # a predicted residual is no measure of progress
        self._bound_before = self.bound if self.residual.certifies else np.inf
        del self.residual
        next_pressure = grid.advance(self.state, correction, self.length, self.mean_pressure, out)
        if rises:
            # The difference of the two energies is below the rounding of the first, which need not be kept.
            del self.state
            self.state, _ = grid.evaluate(next_pressure)
            return
        workspace = None if self._spare is None else self._spare.separation
        trial, line = grid.evaluate(next_pressure, former=self.state, out=workspace)
        if not line.descends:
            self._recover(trial, line)
            return
        # the length that would have been best for this step is tried next
        self.length = min(LONGEST, max(SHORTEST, self.length * line.minimizer))
        self.state, self._spare = trial, self.state

    def _recover(self, trial: State, line: LineSearch) -> None:
        """Continue after a step that did not lower the energy: cut it short, or take safe steps."""
        self._failures += 1
        self._spare = None
        self.length = max(SHORTEST, 0.5 * self.length)
        lower = minimize_between(self.state, trial, line, cap=self.grid.cap)
        if lower is None and self.precision != self.finish:
            self.precision = self.finish
            self.state = self._rescaled_state(self.precision, self.state.pressure)
            return
        self.state = lower or self.state
        if lower is None or self._failures > 1:
            # the more of them the more often a step has failed, at most 64
            for _ in range(2 ** min(1 + self._failures // 8, 6)):
                self.state = projected_gradient_step(self.grid, self.state, self.mean_pressure) or self.state

    def _rescaled_state(self, precision: str, pressure: Array) -> State:
        rescaled_pressure = scale_to_load(
            pressure, self.mean_pressure, cap=self.grid.cap, precision=precision, copy=False
        )
        return self.grid.evaluate(rescaled_pressure)[0]


def first_guess_on_grid(
    grid: Grid, start: Array, mean_pressure: float, *, tolerance: float
) -> tuple[Array, int]:
    """Return a pressure (ny, nx) whose relative error is predicted to be about `tolerance`, and its steps.

    The mean of `start`, which may be overwritten, may differ from `mean_pressure`.
    """
    pressure = scale_to_load(start, mean_pressure, cap=grid.cap, precision=SINGLE, copy=False)
    bound_before = np.inf
    for step in range(GUESS_STEPS):
        state, _ = grid.evaluate(pressure)
        residual = grid.residual(state, precision=SINGLE, predict=step == 0 and grid.cap == np.inf)
        bound = _residual_bound(grid, state, residual)
        if bound <= tolerance:
            return state.pressure, step
        # where steps gain less than half, `solve_on_grid` continues
        if bound > 0.5 * bound_before:
            break
        correction = grid.precondition(residual)
        pressure = grid.advance(state, correction, FIRST_LENGTH, mean_pressure, empty(state.pressure, SINGLE))
        # a last step that is so sure to suffice is not measured any more
        if PREDICTION_MARGIN * TYPICAL * bound <= tolerance:
            return pressure, step + 1
        bound_before = bound if residual.certifies else np.inf
    solution = solve_on_grid(grid, pressure, mean_pressure, tolerance=tolerance, finish=SINGLE)
    return solution.state.pressure, step + solution.steps


def _residual_bound(grid: Grid, state: State, residual: Residual) -> float:
    """Return the bound of the relative error that the residual gives, without the certificate."""
    return relative_bound(grid.halfspace, state, np.sqrt(residual.energy))
