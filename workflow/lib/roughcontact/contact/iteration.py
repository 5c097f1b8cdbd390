"""The iteration on one grid: a preconditioned step, projected onto the feasible pressures, again and again.

One step takes a feasible pressure, applies the operator afresh, interpolates the residual of the active set C
(the points that carry pressure, and those that overlap) over the rest of the surface, applies the inverse
operator to that, and subtracts the result from the pressure, which is then projected onto p >= 0:

    p <- [ p - t (M r - mean) ]+ .

M = P^T G^-1 P is nowhere less than the inverse of the operator on the active set and mostly at most an eighth
more (`roughcontact.contact.interpolation`), so that what stands in the brackets is nearly the pressure of
least energy that those points could carry with either sign. The one of least energy without tension is its
projection onto p >= 0 in the norm of the energy. That projection is imitated: the points held at 0 hand the
load that they lose to the contact around them, as charges at grounded conductors do, by P^T for the points
that stay. The active set so moves with every step, and two transform pairs cut the error by twenty. It is a
primal-dual active-set method [1]_ whose linear systems are solved by one application of a nearly exact
inverse. The contact of a first guess is mostly too large: in the first step on a grid those points are left
out of the active set that are foreseen to lose their contact (`Grid.residual`), and give their load away at
once. With a hardness that is done on the finest grid alone: on coarser ones nothing was gained by it.

The step length t follows from the energy along the last step, which is quadratic and known. Nothing is proved
for steps of this kind: so every one must lower the elastic energy. One that does not is cut short where the
energy is least, or undone, and projected gradient steps follow (`roughcontact.contact.projected_gradient`),
twice as many with every second failure, which alone would converge. Where a step gains little, the next
correction is an accurate one (`roughcontact.contact.conjugate_gradients`).

The first steps are taken in single precision. Then pressure and separation are in double precision and the
correction stays in single: it is small, and the next fresh application measures what rounding did to it
(iterative refinement).

References
----------
.. [1] Hintermueller, Ito and Kunisch (2002), The primal-dual active set strategy as a semismooth Newton
   method, SIAM J. Optim. 13, 865.
"""

from dataclasses import dataclass

import numpy as np

from roughcontact.contact.certificate import error_bound, relative_bound, rounding_floor
from roughcontact.contact.conjugate_gradients import corrected_accurately, gains_little
from roughcontact.contact.grid import Grid, Residual
from roughcontact.contact.line_search import LineSearch, minimize_between
from roughcontact.contact.projected_gradient import projected_gradient_step
from roughcontact.contact.state import State, scale_to_load
from roughcontact.kernels.arrays import DOUBLE, SINGLE, Array, empty, precision_of

TOO_STIFF = 1e-3  # relative rounding floor of single precision from which all is done in double
PATIENCE = 20  # steps that do not improve the bound before the iteration is called stalled
FEW_STEPS = 10  # are enough for a first guess, else it is left to the safeguarded iteration
NEARLY = 1.5  # how far the floor of a first guess may be from that of the solution
FIRST_LENGTH, SHORTEST, LONGEST = 0.985, 0.4, 0.99  # of a step; M is nowhere less than the inverse
TYPICAL = 0.05  # of the bound is what a good step leaves
# A step that may leave this share of what is foreseen is taken in double: one that meets the tolerance in
# single precision is followed by another, which costs three pairs; one that misses it in double costs a pair.
HOPE = 0.5


@dataclass(frozen=True)
class GridSolution:
    """The state that was reached on one grid, the bound of its relative error, and the steps taken."""

    state: State
    error_bound: float
    steps: int


def solve_on_grid(
    grid: Grid,
    start: Array,
    mean_pressure: float,
    *,
    tolerance: float,
    finish: str = DOUBLE,
    max_steps: int = 200,
    give_up: bool = False,
) -> GridSolution:
    """Improve a pressure until the bound of its relative error is at most `tolerance`.

    All in dimensionless form: heights in units of g L, pressures in units of E* g. Ends early after
    `max_steps` steps, at the rounding floor, or after `PATIENCE` steps in vain: the caller compares
    `error_bound` with its tolerance.

    Parameters
    ----------
    grid : Grid
        heights and operators.
    start : array (ny, nx)
        pressure, nowhere negative; it is scaled to the load first.
    mean_pressure : float
        the load.
    tolerance : float
        of `error_bound`.
    finish : str
        precision of the last application; the first ones are in single, while the error is far above what
        single precision can tell.
    max_steps : int
        number of steps.
    give_up : bool
        take no step where the rounding of the result is above the tolerance.

    Returns
    -------
    GridSolution
        the state, its bound and the number of steps.
    """
    iterate = Iterate(grid, start, mean_pressure, tolerance=tolerance, finish=finish)
    del start
    for step in range(max_steps + 1):
        iterate.measure(step)
        stalled = step == max_steps or iterate.has_stalled(step) or (give_up and iterate.is_hopeless())
        if stalled or iterate.may_be_done():
            iterate.certify()
            if stalled or iterate.bound <= tolerance:
                break
            iterate.measure_residual()
        iterate.choose_precision()
        iterate.advance()
    return GridSolution(iterate.state, iterate.bound, step)


class Iterate:
    """Where the iteration on a grid stands, and what its past says of the next step.

    Attributes
    ----------
    state : State
        the pressure that was reached.
    residual : Residual
        of the state; gone while a step is taken, because its spectrum need not lie beside another.
    bound : float
        of the relative error of the state; rigorous after `certify`, an estimate where the residual leaves
        out points of the contact.
    precision : str
        of the next pressure.
    residual_precision : str
        of residual and correction.
    finish : str
        of the result.
    length : float
        of the next step.
    """

    residual: Residual

    def __init__(self, grid: Grid, start: Array, mean_pressure: float, *, tolerance: float, finish: str):
        self.grid, self.mean_pressure = grid, mean_pressure
        self.tolerance, self.finish = tolerance, finish
        self.precision = self.residual_precision = SINGLE
        self.state = self._state_in(SINGLE, start)
        self.bound = self._bound_before = self._lowest = np.inf
        self._lowest_step = self._failures = 0
        self.length = FIRST_LENGTH
        self._spare: State | None = None  # whose arrays the next state may have

    def measure(self, step: int) -> None:
        """Find the residual of the state and the bound that it gives without the certificate.

        Parameters
        ----------
        step : int
            number of the step.
        """
        self._single_floor = rounding_floor(self.grid.halfspace, self.state, SINGLE)
        if self._single_floor > TOO_STIFF:
            self.residual_precision = self.precision = self.finish = DOUBLE
        # the contact of a first guess is too large
        self.measure_residual(predict=step == 0)
        self.bound = _bound_by(self.grid, self.state, self.residual)
        if self.residual.certifies and self.bound < 0.99 * self._lowest:
            self._lowest, self._lowest_step = self.bound, step

    def measure_residual(self, *, predict: bool = False) -> None:
        """Find the residual of the state afresh.

        Parameters
        ----------
        predict : bool
            for a step that leaves out what is foreseen to lose its contact.
        """
        self.residual = self.grid.residual(self.state, precision=self.residual_precision, predict=predict)

    def is_in_final_precision(self) -> bool:
        """Return whether the state has the precision of the result.

        Returns
        -------
        bool
        """
        return precision_of(self.state.pressure) == self.finish

    def is_hopeless(self) -> bool:
        """Return whether the rounding of a result in single precision alone is above the tolerance.

        Returns
        -------
        bool
        """
        return self.finish == SINGLE and self._single_floor > NEARLY * self.tolerance

    def has_stalled(self, step: int) -> bool:
        """Return whether no further step would help: at the rounding floor, or after many in vain.

        Parameters
        ----------
        step : int
            number of the step.

        Returns
        -------
        bool
        """
        if step - self._lowest_step > PATIENCE:
            return True
        if not (self.is_in_final_precision() and self.residual.certifies):
            return False
        # the floor is part of the bound: in single precision the tolerance may lie just above it
        at_floor = 2.0 if self.finish == DOUBLE or self.is_hopeless() else 1.005
        return self.bound <= at_floor * rounding_floor(self.grid.halfspace, self.state)

    def may_be_done(self) -> bool:
        """Return whether the certificate is worth its price.

        Returns
        -------
        bool
        """
        return self.bound <= self.tolerance and self.is_in_final_precision()

    def certify(self) -> None:
        """Make the bound rigorous, for a state in the precision of the result; the residual is lost."""
        if not self.is_in_final_precision():
            self.precision = self.finish
            self.state = self._state_in(self.precision, self.state.pressure)
            self.measure_residual()
        elif not self.residual.certifies:
            self.measure_residual()
        self.bound = error_bound(self.grid, self.state, self.residual)

    def choose_precision(self) -> None:
        """Take the last step, as far as the one before tells, in the precision of the result."""
        foreseen = self.bound * min(1.0, max(TYPICAL, self.bound / self._bound_before))
        if HOPE * foreseen <= self.tolerance or self.bound <= 30 * self._single_floor:
            self.precision = self.finish

    def advance(self) -> None:
        """Take a step: correct the pressure, apply the operator, and accept the state or recover."""
        grid, precision = self.grid, self.precision
        rises = precision != precision_of(self.state.pressure)
        if rises:
            self._spare = None
        out = empty(self.state.pressure, precision) if self._spare is None else self._spare.pressure
        correction = grid.precondition(self.residual)
        accurate = gains_little(self.bound, self._bound_before)
        if accurate:
            correction = corrected_accurately(grid, correction)
        self._bound_before = self.bound if self.residual.certifies else np.inf
        del self.residual
        length = 1.0 if accurate else self.length
        moved = grid.advance(self.state, correction, length, self.mean_pressure, out)
        if rises:
            # What tells the two energies apart is lost in the rounding of the first: it need not be kept.
            del self.state
            self.state, _ = grid.evaluate(moved)
            return
        workspace = None if self._spare is None else self._spare.separation
        trial, line = grid.evaluate(moved, before=self.state, out=workspace)
        if not line.descends:
            self._recover(trial, line)
            return
        if not accurate:
            self.length = min(LONGEST, max(SHORTEST, self.length * line.minimizer))
        self.state, self._spare = trial, self.state

    def _recover(self, trial: State, line: LineSearch) -> None:
        """Go on from a step after which the energy is not lower: cut it short, or take safe steps."""
        self._failures += 1
        self._spare = None
        self.length = max(SHORTEST, 0.5 * self.length)
        lower = minimize_between(self.state, trial, line, cap=self.grid.cap)
        if lower is None and self.precision != self.finish:
            self.precision = self.finish
            self.state = self._state_in(self.precision, self.state.pressure)
            return
        self.state = lower or self.state
        if lower is None or self._failures > 1:
            for _ in range(2 ** min(1 + self._failures // 2, 6)):
                self.state = projected_gradient_step(self.grid, self.state, self.mean_pressure) or self.state

    def _state_in(self, precision: str, pressure: Array) -> State:
        scaled = scale_to_load(pressure, self.mean_pressure, cap=self.grid.cap, precision=precision)
        return self.grid.evaluate(scaled)[0]


def first_guess_on_grid(
    grid: Grid, start: Array, mean_pressure: float, *, tolerance: float
) -> tuple[Array, int]:
    """Return a pressure (ny, nx) whose relative error is about `tolerance`, and the number of steps to it.

    For a first guess on a finer grid: what the last step leaves is foreseen, not measured. Steps that gain
    less than half are not for this function: `solve_on_grid` goes on.

    Parameters
    ----------
    grid : Grid
        operator and preconditioner.
    start : array (ny, nx)
        where to begin; its mean may differ.
    mean_pressure : float
        prescribed, dimensionless.
    tolerance : float
        relative error wanted, in the norm of the elastic energy.

    Returns
    -------
    pressure : array (ny, nx)
    steps : int
    """
    pressure = scale_to_load(start, mean_pressure, cap=grid.cap, precision=SINGLE)
    bound_before = np.inf
    for step in range(FEW_STEPS):
        state, _ = grid.evaluate(pressure)
        residual = grid.residual(state, precision=SINGLE, predict=step == 0 and grid.cap == np.inf)
        bound = _bound_by(grid, state, residual)
        if bound <= tolerance:
            return state.pressure, step
        if gains_little(bound, bound_before):
            break
        correction = grid.precondition(residual)
        pressure = grid.advance(state, correction, FIRST_LENGTH, mean_pressure, empty(state.pressure, SINGLE))
        if HOPE * TYPICAL * bound <= tolerance:
            return pressure, step + 1
        bound_before = bound if residual.certifies else np.inf
    solution = solve_on_grid(grid, pressure, mean_pressure, tolerance=tolerance, finish=SINGLE)
    return solution.state.pressure, step + solution.steps


def _bound_by(grid: Grid, state: State, residual: Residual) -> float:
    """Return the bound of the relative error that the residual gives, without the certificate."""
    return relative_bound(grid.halfspace, state, np.sqrt(residual.energy))
