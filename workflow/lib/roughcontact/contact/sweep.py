"""Solve one map for a rising sequence of loads, which share the computations independent of the load."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from roughcontact.contact.certificate import bound_without_transform, rounding_by_unit, rounding_floor
from roughcontact.contact.elasticity.influence import HALF_SPACE, Elasticity
from roughcontact.contact.grid import Grid
from roughcontact.contact.iteration import Solution, solve_on_grid
from roughcontact.contact.nested_iteration import first_guess, nested_heights
from roughcontact.contact.problem import Problem
from roughcontact.contact.state import State, scale_to_load
from roughcontact.kernels.arrays import DOUBLE, SINGLE, Array, as_precision, get_precision, namespace

# Points of a map up to which the workspace is kept for the next load. For larger maps it is half of the
# memory that counting takes, and allocating it again is a small part of the time.
MAX_KEPT_POINTS = 2**22
LARGE_LOAD = 1.0  # load in units of E* g; the full-contact pressure has a standard deviation of half that


def sweep(
    problem: Problem,
    loads: Sequence[float],
    elasticity: Elasticity = HALF_SPACE,
    *,
    tolerance: float,
    precision: str = DOUBLE,
    give_up: bool = False,
    start: Array | None = None,
    threads: int,
) -> Iterator[Solution]:
    """Yield the solution of every load, whose fields the caller may change; flat maps in closed form.

    `loads` rise; they, the hardness and `start` are in units of E* g, layers in that of the lengths. `start`,
    the pressure (ny, nx) of a similar contact, is the first guess instead of that of coarser grids.
    `give_up` takes no step on the finest grid where rounding is above the tolerance.
    """
    if problem.flat:
        for load in loads:
            yield _flat(problem, load, precision)
        return
    make_grid = partial(Grid, lengths=problem.lengths, elasticity=elasticity, threads=threads)
    finest = make_grid(problem.heights, reference=problem.reference, unit=problem.scale)
    # a start makes coarser grids superfluous
    levels = [] if start is not None else nested_heights(finest.rounded_heights(SINGLE), problem.lengths)
    grids = [finest, *(make_grid(heights) for _, heights in levels)]
    factors = [factors for factors, _ in levels]
    del levels
    large = np.prod(finest.shape) > MAX_KEPT_POINTS
    # Full contact: p = mean + G^-1 H, wherever that is nowhere negative (Johnson 1985, section 13.2).
    coarse_fluctuation = grids[-1].halfspace.pressure(grids[-1].rounded_heights(SINGLE))
    fluctuation, full_contact_from = _full_contact(grids, max(loads), coarse_fluctuation)
    for number, load in enumerate(loads, start=1):
        work = 0.5 if number == 1 else 0.0  # the forward transform that gave the gradient
        if fluctuation is not None and load >= full_contact_from:
            pressure = as_precision(load + fluctuation, precision, copy=False)
            state, _ = finest.evaluate(scale_to_load(pressure, load))
            bound, steps = bound_without_transform(finest, state), 0
        else:
            guess, steps = (
                (start, 0) if start is not None else first_guess(grids, factors, load, coarse_fluctuation)
            )
            if large:
                for grid in grids[1:]:
                    grid.release()
            if number == len(loads):  # the coarse grids are no longer needed: release their memory
                work += _applications(grids)
                del grids[1:]
            guesses = [guess]  # popped below, so that the solver holds the only reference
            del guess
            solution = solve_on_grid(
                finest, guesses.pop(), load, tolerance=tolerance, finish=precision, give_up=give_up
            )
            state, bound, steps = solution.state, solution.error_bound, steps + solution.steps
            del solution
        floor = rounding_floor(finest.halfspace, state)
        if get_precision(state.pressure) != precision:  # only the steps needed more
            by_unit = rounding_by_unit(finest.halfspace, state, precision)
            bound, floor = bound + by_unit, floor + by_unit
            fields = (as_precision(field, precision) for field in (state.pressure, state.separation))
            state = replace(state, **dict(zip(("pressure", "separation"), fields, strict=True)))
        if large:
            for grid in grids:
                grid.release()
        solutions = [Solution(state, bound, steps, work + _applications(grids), floor)]
        del state  # so that its memory is left for the use of the solution and for the next load
        yield solutions.pop()


def _full_contact(grids: Sequence[Grid], load: float, coarse: Array) -> tuple[Array | None, float]:
    """Return the fluctuation of the full-contact pressure and the load from which it is nowhere negative.

    None, and no such load, where the largest `load` is far from that or the cap is exceeded: already the
    fluctuation on a coarser grid (`coarse` on the coarsest) shows it, which on finer ones is larger still.
    """
    xp = namespace(coarse)
    for grid in reversed(grids if load < LARGE_LOAD else grids[1:]):
        if grid is not grids[-1]:
            coarse = grid.halfspace.pressure(grid.rounded_heights(SINGLE))
        # block means smooth the lowest pressure: gaps that a coarser map keeps are open in the finer one, too
        if load < -0.99 * float(xp.min(coarse)):
            return None, np.inf
    fluctuation = grids[0].halfspace.pressure(grids[0].rounded_heights(DOUBLE))
    lowest, highest = float(xp.min(fluctuation)), float(xp.max(fluctuation))
    if load + highest > grids[0].cap:  # some points would yield: no closed form
        return None, np.inf
    # A load that closes the last gap exactly is full contact, whatever its rounding.
    return fluctuation, -lowest - 1e-13 * (highest - lowest)


def _applications(grids: Sequence[Grid]) -> float:
    """Return the operator applications since the last call, in applications on the finest grid."""
    total = sum(grid.halfspace.applications * np.prod(grid.shape) for grid in grids) / np.prod(grids[0].shape)
    for grid in grids:
        grid.halfspace.applications = 0.0
    return float(total)


def _flat(problem: Problem, load: float, precision: str) -> Solution:
    """Return the uniform pressure under a flat map, which no application of the operator could improve."""
    xp = namespace(problem.heights)
    separation = as_precision(xp.zeros_like(problem.heights), precision, copy=False)
    state = State(pressure=separation + load, separation=separation, offset=0.0, norm=0.0, size=0.0)
    return Solution(state, error_bound=0.0, steps=0)
