"""Solve one map for a rising sequence of loads, each starting from what the last one left."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from roughcontact.contact.active_set import solve_on_grid
from roughcontact.contact.certificate import error_bound, rounding_floor
from roughcontact.contact.levels import hierarchy, prolong
from roughcontact.contact.problem import Problem
from roughcontact.contact.state import State, evaluate, scale_to_load
from roughcontact.halfspace import HalfSpace

COARSE_TOLERANCE = 3e-2  # of all grids but the finest: a tighter one chases points the next grid moves anyway


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


def sweep(problem: Problem, loads: Sequence[float], *, tolerance: float, threads: int) -> Iterator[Solution]:
    """Yield the solution of every load, a rising sequence of mean pressures in units of E* g.

    Flat maps and full contact are known in closed form and take no iteration. Otherwise a load starts from
    coarser grids and from the load before it (`_nested_start`).
    """
    if problem.flat:
        for load in loads:
            yield _flat(problem, load)
        return
    levels = hierarchy(problem.heights, problem.lengths)
    grids = [HalfSpace(heights.shape, problem.lengths, threads=threads) for heights, _ in levels]
    finest = grids[0]
    # Full contact: p = mean + G^-1 H, wherever that is nowhere negative (Johnson 1985, section 13.2).
    fluctuation = finest.pressure(problem.heights).copy()
    # A load that closes the last gap exactly is full contact whatever the last digit says.
    full_contact_from = -float(fluctuation.min()) - 1e-13 * float(np.ptp(fluctuation))
    last = None  # the pressures of the last load, finest grid first
    for load in loads:
        if load >= full_contact_from:
            state = evaluate(finest, problem.heights, scale_to_load(load + fluctuation, load))
            bound, steps = error_bound(finest, state), 0
        else:
            start, coarse, steps = _nested_start(levels, grids, load, last)
            solution = solve_on_grid(finest, problem.heights, start, load, tolerance=tolerance)
            state, bound, steps = solution.state, solution.error_bound, steps + solution.steps
            last = [state.pressure, *coarse]
        yield Solution(
            state=state,
            error_bound=bound,
            steps=steps,
            applications=_applications(grids),
            floor=rounding_floor(finest, state),
        )


def _nested_start(levels, grids, load: float, last) -> tuple[np.ndarray, list[np.ndarray], int]:
    """Return a first guess of the pressure on the finest grid, the coarse pressures, and the steps they took.

    Each grid starts from the pressure of the next coarser one, repeated. After another load, whose pressures
    on all grids are `last`, it starts from that load's pressure plus the repeated difference that the new
    load makes on the coarser grid: the detail that only the finer grid resolves is then there already.
    """
    pressure = np.full(grids[-1].shape, load) if last is None else last[-1]
    coarse, steps = [], 0
    for level in range(len(levels) - 1, 0, -1):
        solution = solve_on_grid(
            grids[level], levels[level][0], pressure, load, tolerance=COARSE_TOLERANCE, finish=np.float32
        )
        steps += solution.steps
        found = solution.state.pressure
        coarse.insert(0, found)
        factors = levels[level - 1][1]
        if last is None:
            pressure = prolong(found, factors)
        else:
            pressure = last[level - 1] + prolong(found - last[level], factors)
            np.maximum(pressure, 0, out=pressure)
    return pressure, coarse, steps


def _applications(grids) -> float:
    """Return the operator applications since the last call, in applications on the finest grid."""
    finest = np.prod(grids[0].shape)
    total = sum(grid.applications * np.prod(grid.shape) for grid in grids) / finest
    for grid in grids:
        grid.applications = 0.0
    return float(total)


def _flat(problem: Problem, load: float) -> Solution:
    """Return the uniform pressure under a flat map, which no application of the operator could improve."""
    pressure = np.full(problem.heights.shape, load)
    state = State(pressure=pressure, gap=np.zeros_like(pressure), level=0.0, norm=0.0, size=0.0)
    return Solution(state=state, error_bound=0.0, steps=0, applications=0.0, floor=0.0)
