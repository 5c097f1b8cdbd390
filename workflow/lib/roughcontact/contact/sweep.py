"""Solve one map for a rising sequence of loads, which share all that does not depend on the load."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from roughcontact.contact.certificate import bound_without_transform, rounding_floor
from roughcontact.contact.grid import Grid
from roughcontact.contact.hierarchy import hierarchy
from roughcontact.contact.iteration import improve_on_grid, solve_on_grid
from roughcontact.contact.problem import Problem
from roughcontact.contact.state import State, scale_to_load
from roughcontact.kernels.arrays import DOUBLE, SINGLE, empty, in_precision

COARSE_TOLERANCE = 0.03  # of all grids but the finest: a tighter one chases points the next grid moves anyway
CLOSE = 1.05  # ratio of loads up to which the pressure of the smaller is a better start than a coarse grid's
OFTEN_FULL = 1.0  # load in units of E* g; the full-contact pressure has a standard deviation of half that


@dataclass(frozen=True)
class Solution:
    """One load in dimensionless form: the state on the finest grid and how it was reached.

    `applications` counts operator applications (transform pairs) weighted by grid size; `floor` is the
    relative error below which rounding leaves nothing to measure.
    """

    state: State
    error_bound: float
    steps: int
    applications: float
    floor: float


def sweep(
    problem: Problem,
    loads: Sequence[float],
    *,
    tolerance: float,
    cap: float = np.inf,
    influence: str = "sampled",
    precision: str = DOUBLE,
    threads: int,
) -> Iterator[Solution]:
    """Yield the solution of every load, a rising sequence of mean pressures in units of E* g.

    `cap` is the largest pressure allowed, `influence` the symbol of the operator, `precision` that of the
    result. The fields of a solution are the caller's to change.

    Flat maps and full contact are known in closed form and take no iteration. Otherwise a load starts from
    coarser grids (`_nested_start`), or from the load before it where that is hardly less.
    """
    if problem.flat:
        for load in loads:
            yield _flat(problem, load, precision)
        return
    operator = {"cap": cap, "influence": influence, "threads": threads}
    finest = Grid(
        problem.heights, problem.lengths, reference=problem.reference, unit=problem.scale, **operator
    )
    levels = hierarchy(finest.heights_in(SINGLE), problem.lengths)
    grids = [finest, *(Grid(heights, problem.lengths, **operator) for _, heights in levels)]
    factors = [factors for factors, _ in levels]
    del levels
    # Full contact: p = mean + G^-1 H, wherever that is nowhere negative (Johnson 1985, section 13.2).
    fluctuation, full_contact_from = _full_contact(grids, max(loads))
    last = None  # the pressure of the load before, where it is a start
    for number, load in enumerate(loads, start=1):
        work = 0.0
        if load >= full_contact_from:
            pressure = in_precision(load + fluctuation, precision, copy=False)
            state, _ = finest.evaluate(scale_to_load(pressure, load))
            bound, steps = bound_without_transform(finest, state), 0
        else:
            guess, last = [last], None  # in a list, from which the solver alone takes it over
            steps = 0
            if guess[0] is None:
                guess[0], steps = _nested_start(grids, factors, load)
            if number == len(loads):  # the coarse grids are needed no more: give their memory back
                work = _applications(grids)
                del grids[1:]
            solution = solve_on_grid(finest, guess.pop(), load, tolerance=tolerance, finish=precision)
            state, bound, steps = solution.state, solution.error_bound, steps + solution.steps
            close = number < len(loads) and loads[number] <= CLOSE * load
            if close:
                last = in_precision(state.pressure, SINGLE)
        yield Solution(
            state=state,
            error_bound=bound,
            steps=steps,
            applications=work + _applications(grids),
            floor=rounding_floor(finest.halfspace, state),
        )


def _full_contact(grids, load: float) -> tuple:
    """Return the fluctuation of the full-contact pressure and the load from which it is nowhere negative.

    None, and no such load, where even the largest `load` is far from that: what a coarser grid leaves open,
    the finer ones, whose fluctuation is larger, leave open too. Nor is there one where the cap is in the way.
    """
    xp = grids[0].heights_in(SINGLE).__array_namespace__()
    for grid in reversed(grids) if load < OFTEN_FULL else ():
        if load < -0.99 * float(xp.min(grid.halfspace.pressure(grid.heights_in(SINGLE)))):
            return None, np.inf
    fluctuation = grids[0].halfspace.pressure(grids[0].heights_in(DOUBLE))
    least, most = float(xp.min(fluctuation)), float(xp.max(fluctuation))
    if load + most > grids[0].cap:
        return None, np.inf
    # A load that closes the last gap exactly is full contact whatever the last digit says.
    return fluctuation, -least - 1e-13 * (most - least)


def _nested_start(grids, factors, load: float) -> tuple:
    """Return a first guess of the pressure on the finest grid, and the steps taken on the others.

    Each grid starts from the next coarser one's pressure, refined, and is solved to about `COARSE_TOLERANCE`.
    """
    coarsest = grids[-1].heights_in(SINGLE)
    pressure, steps = coarsest.__array_namespace__().full_like(coarsest, load), 0
    for level in range(len(grids) - 1, 0, -1):
        found, taken = improve_on_grid(grids[level], pressure, load, tolerance=COARSE_TOLERANCE)
        steps += taken
        pressure = empty(found, SINGLE, grids[level - 1].shape)
        grids[level].kernels.refine(found, factors[level - 1], pressure)
    return pressure, steps


def _applications(grids) -> float:
    """Return the operator applications since the last call, in applications on the finest grid."""
    total = sum(grid.halfspace.applications * np.prod(grid.shape) for grid in grids) / np.prod(grids[0].shape)
    for grid in grids:
        grid.halfspace.applications = 0.0
    return float(total)


def _flat(problem: Problem, load: float, precision: str) -> Solution:
    """Return the uniform pressure under a flat map, which no application of the operator could improve."""
    xp = problem.heights.__array_namespace__()
    separation = in_precision(xp.zeros_like(problem.heights), precision, copy=False)
    state = State(pressure=separation + load, separation=separation, level=0.0, norm=0.0, size=0.0)
    return Solution(state=state, error_bound=0.0, steps=0, applications=0.0, floor=0.0)
