"""Solve one map on several grids to several tolerances, with times and errors."""

import time
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact.contact.solve import solve_contact
from roughcontact.errors import HeightMapError
from roughcontact.maps import refined
from roughcontact.uncertainty.headline import headline

QUANTITIES = {
    "relative_contact_area": 1.5,
    "mean_gap": 2.0,
    "max_pressure": 1.0,
}  # order of the error in the number of points, see the validation
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
_REFERENCE_TOLERANCE = 1e-6
_MAX_POINTS = 2048**2  # of the reference
_MAX_REFINEMENT = 4  # per axis: a finer grid adds no information on a measured map
_MIN_POINTS = 32  # per axis
_REPEAT_BELOW = 0.3  # seconds: shorter sweeps are timed three times, the fastest counts


def run_time_against_error(
    window: xr.DataArray,
    *,
    contact_modulus: float,
    mean_pressure: Sequence[float],
    threads: int = 1,
    bodies: Sequence[Mapping[str, Any]] | None = None,
) -> pd.DataFrame:
    """Return time and errors of a sweep of loads on every grid, to every tolerance.

    The map represents the surface given by its Fourier series. A coarser grid takes every second, fourth, ...
    point of it, a finer one is interpolated by the series. The reference is the finest grid (at most 4 times
    as fine as the map, at most 2048² points), solved to 1e-6. Its own error is estimated from the grid half
    as fine, |q(h) - q(2h)|/(2^k - 1) with the order k of the quantity, and added to all errors.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic.
    contact_modulus : float, Pa
    mean_pressure : list of float, Pa
        all loads are solved in one sweep, as a run does.
    threads : int
        of the solver.
    bodies : sequence of two mappings, optional
        of `solve_contact`, where they have layers.

    Returns
    -------
    DataFrame
        a row for each grid, tolerance and load: `points_x`, `points_y`, `tolerance`, `mean_pressure` (Pa),
        `seconds` (of the whole sweep), and for each of `QUANTITIES` its value and its relative error
        `..._error`.

    Raises
    ------
    HeightMapError
        for a flat map, and for one so small that there is no coarser grid.
    """
    if np.ptp(window.values) == 0:
        raise HeightMapError(
            "the window is flat: every grid gives the same pressure, there is nothing to measure"
        )
    finest = _finest(window)
    grids = [finest]
    while (coarser := _every_second(grids[-1])) is not None:
        grids.append(coarser)
    if len(grids) < 2:
        sides = " × ".join(str(n) for n in window.shape[::-1])
        raise HeightMapError(
            f"the window of {sides} points has no coarser grid to compare with: it is too small"
        )
    solve = partial(
        _solve, contact_modulus=contact_modulus, bodies=bodies, mean_pressure=mean_pressure, threads=threads
    )
    solve(grids[-1], tolerance=1e-1)  # loads the libraries
    reference, _ = solve(finest, tolerance=_REFERENCE_TOLERANCE)
    own = {name: np.zeros(len(mean_pressure)) for name in QUANTITIES}
    for step, grid in enumerate(grids[1:], start=1):
        found, _ = solve(grid, tolerance=_REFERENCE_TOLERANCE)
        for name, order in QUANTITIES.items():
            difference = np.abs(found[name] - reference[name])
            own[name] = np.maximum(own[name], difference / (2 ** (step * order) - 1))
    rows = []
    for grid in grids[1:]:
        for tolerance in TOLERANCES:
            found, seconds = solve(grid, tolerance=tolerance)
            errors = {
                f"{name}_error": _relative(np.abs(found[name] - reference[name]) + own[name], reference[name])
                for name in QUANTITIES
            }
            rows.append(
                pd.DataFrame(
                    {
                        "points_x": grid.shape[1],
                        "points_y": grid.shape[0],
                        "tolerance": tolerance,
                        "mean_pressure": mean_pressure,
                        "seconds": seconds,
                    }
                    | found
                    | errors
                )
            )
    return pd.concat(rows, ignore_index=True)


def _finest(window: xr.DataArray) -> xr.DataArray:
    """Return the map on the finest grid: its Fourier series at 4, 2 or 1 times as many points per axis."""
    axes = sum(n > 1 for n in window.shape)
    factor = _MAX_REFINEMENT
    while factor > 1 and window.size * factor**axes > _MAX_POINTS:
        factor //= 2
    return refined(window, factor)


def _every_second(grid: xr.DataArray) -> xr.DataArray | None:
    """Return every second point along each axis; None where that grid is too coarse or not periodic."""
    sides = [n for n in grid.shape if n > 1]
    if any(n % 2 or n // 2 < _MIN_POINTS for n in sides):
        return None
    return grid[tuple(slice(None, None, 2 if n > 1 else 1) for n in grid.shape)]


def _solve(
    grid: xr.DataArray,
    *,
    tolerance: float,
    contact_modulus: float,
    bodies: Sequence[Mapping[str, Any]] | None,
    mean_pressure: Sequence[float],
    threads: int,
) -> tuple[dict[str, np.ndarray], float]:
    """Return (quantities, each an array (load); seconds) of one sweep."""
    best = np.inf
    for _ in range(3):
        start = time.perf_counter()
        result = solve_contact(
            grid,
            contact_modulus=contact_modulus,
            bodies=bodies,
            mean_pressure=mean_pressure,
            tolerance=tolerance,
            reduce=headline,
            threads=threads,
        )
        seconds = time.perf_counter() - start
        best = min(best, seconds)
        if seconds > _REPEAT_BELOW or tolerance == _REFERENCE_TOLERANCE:
            break
    return {name: result[name].values for name in QUANTITIES}, best


def _relative(difference: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Return difference / |reference|, zero where both are zero (the gap in full contact)."""
    return np.divide(difference, np.abs(reference), out=np.zeros_like(difference), where=difference > 0)
