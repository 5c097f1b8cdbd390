"""Run time against error on the windows of a finished run: `python3 run.py cost results/ground ...`.

Each window is solved on several grids to several tolerances. Printed are time and error of each, and
sentences like "For 1 % in contact area, solve at 1024 × 1024 with tolerance 1e-3: 0.40 s."; `cost.csv`
beside the window has all numbers. Nothing else should run meanwhile.
"""

import argparse
import json
import sys
import time
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact.arguments.maps import refined, spacing
from roughcontact.arguments.quantities import number, percent
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import HeightMapError, RoughContactError
from roughcontact.results.storage import read_dataset, write_table
from roughcontact.uncertainty.budget_inputs import headline_values, iterate_fields

WORDS = {
    "relative_contact_area": "contact area",
    "mean_gap": "mean gap",
    "max_pressure": "largest pressure",
}
_TARGETS = (0.05, 0.01, 0.002)
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
    order_errors = {name: np.zeros(len(mean_pressure)) for name in QUANTITIES}
    for step, grid in enumerate(grids[1:], start=1):
        result, _ = solve(grid, tolerance=_REFERENCE_TOLERANCE)
        for name, order in QUANTITIES.items():
            difference = np.abs(result[name] - reference[name])
            order_errors[name] = np.maximum(order_errors[name], difference / (2 ** (step * order) - 1))
    rows = []
    for grid in grids[1:]:
        for tolerance in TOLERANCES:
            result, seconds = solve(grid, tolerance=tolerance)
            errors = {
                f"{name}_error": _relative(
                    np.abs(result[name] - reference[name]) + order_errors[name], reference[name]
                )
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
                    | result
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


def _headline(contact: xr.Dataset) -> xr.Dataset:
    """Return the headline quantities (load) of a solution with its fields."""
    steps = spacing(contact["pressure"])
    rows = [headline_values(*fields, QUANTITIES, steps=steps) for fields in iterate_fields(contact)]
    return xr.Dataset({name: ("load", [row[name] for row in rows]) for name in QUANTITIES})


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
            reduce=_headline,
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


def choices(table: pd.DataFrame) -> pd.DataFrame:
    """Return one row for each grid and tolerance: seconds, and the expected errors.

    The expected error is the largest over the loads, of this choice and of all finer or tighter ones: a
    coarse grid that is right by chance is not reliable.

    Parameters
    ----------
    table : DataFrame
        as `run_time_against_error` returns it.

    Returns
    -------
    DataFrame
        `seconds`, `points_x`, `points_y`, `tolerance`, and for each quantity of `WORDS` its relative
        `..._error`.
    """
    keys = ["points_x", "points_y", "tolerance"]
    errors = [f"{name}_error" for name in WORDS]
    grouped = table.groupby(keys, as_index=False).agg({"seconds": "first"} | dict.fromkeys(errors, "max"))
    rows = []
    for _, row in grouped.iterrows():
        finer = (grouped[keys[:2]] >= row[keys[:2]]).all(axis=1) & (grouped["tolerance"] <= row["tolerance"])
        rows.append(pd.concat([row[["seconds", *keys]], grouped.loc[finer, errors].max()]))
    return pd.DataFrame(rows).astype({"points_x": int, "points_y": int})


def cheapest(table: pd.DataFrame, quantity: str, target: float) -> pd.Series | None:
    """Return the fastest row of `choices` with at most a relative error of `target` in a key of `WORDS`.

    None where no choice reaches it.
    """
    options = choices(table)
    reached = options[options[f"{quantity}_error"] <= target]
    return None if reached.empty else reached.iloc[reached["seconds"].argmin()]


def advice(table: pd.DataFrame) -> list[str]:
    """Return sentences like: for 1 % in contact area, solve at 1024 × 1024 with tolerance 1e-3: 0.4 s.

    There is one for each quantity of `WORDS` and the targets 5 %, 1 % and 0.2 %; targets with the same choice
    share a sentence.

    Examples
    --------
    >>> import pandas as pd
    >>> grid = {"points_x": [64], "points_y": [64], "tolerance": [1e-3], "seconds": [0.02]}
    >>> advice(pd.DataFrame(grid | {f"{name}_error": [0.03] for name in WORDS}))[0]
    'For 5 % in contact area, solve at 64 × 64 with tolerance 1e-3: 0.020 s.'
    """
    sentences = []
    options = choices(table)
    for quantity, words in WORDS.items():
        choice_by_target = {target: cheapest(table, quantity, target) for target in _TARGETS}
        reached = [(target, row) for target, row in choice_by_target.items() if row is not None]
        for _, group in groupby(reached, key=lambda pair: in_words(pair[1])):
            targets, rows = zip(*group, strict=True)
            targets_text = " or ".join(f"{100 * target:g} %" for target in targets)
            seconds = number(rows[-1]["seconds"], digits=2)
            sentences.append(f"For {targets_text} in {words}, solve at {in_words(rows[-1])}: {seconds} s.")
        missed = [target for target, row in choice_by_target.items() if row is None]
        if missed:
            best = options.iloc[options[f"{quantity}_error"].argmin()]
            error_left = percent(best[f"{quantity}_error"])
            sentences.append(
                f"For {100 * missed[0]:g} % in {words}, no grid of this comparison is fine enough; the best, "
                f"{in_words(best)}, has {error_left}."
            )
    return sentences


def in_words(row: pd.Series) -> str:
    """Return the grid, x first, or the points of a profile, and the tolerance of a row of `choices`.

    Examples
    --------
    >>> import pandas as pd
    >>> in_words(pd.Series({"points_x": 1024.0, "points_y": 1.0, "tolerance": 1e-3}))
    '1024 with tolerance 1e-3'
    """
    sides = [f"{int(row[f'points_{axis}'])}" for axis in ("x", "y") if row[f"points_{axis}"] > 1]
    return f"{' × '.join(sides)} with tolerance {short(row['tolerance'])}"


def short(tolerance: float) -> str:
    """Return a tolerance as it is written in the settings, with one digit and a short exponent.

    Examples
    --------
    >>> short(0.001), short(1e-10)
    ('1e-3', '1e-10')
    """
    return f"{tolerance:.0e}".replace("e-0", "e-")


def main(arguments: Sequence[str]) -> int:
    """Measure each folder of results, print choices and advice, and return 1 where one cannot be measured."""
    parser = argparse.ArgumentParser(prog="run.py cost", description=__doc__.splitlines()[0])
    parser.add_argument("results", nargs="+", type=Path, help="folder of a surface: results/ground")
    parser.add_argument("--threads", type=int, default=1, help="of the solver (%(default)s)")
    options = parser.parse_args(arguments)
    try:
        for folder in options.results:
            statistics = read_dataset(folder / "statistics.nc")
            table = run_time_against_error(
                read_dataset(folder / "window.nc")["height"],
                contact_modulus=float(statistics["contact_modulus"]),
                mean_pressure=statistics["mean_pressure"].values,
                bodies=json.loads(statistics.attrs.get("bodies", "null")),
                threads=options.threads,
            )
            write_table(table, folder / "cost.csv")
            print(f"{folder}:")
            print(choices(table).to_string(index=False, float_format="{:.3g}".format))
            print("\n".join(advice(table)))
    except RoughContactError as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
