"""The chain from a height map to numbers: level, cut out a periodic window, solve and count, bound the error.

The scripts of the workflow, `roughcontact solve` and `evaluate` all go this way, so that they give the same
numbers. Reading, levelling and windowing are one verb each; what follows has several parts, which stand here.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import xarray as xr

from roughcontact.configuration.resolve import resolve
from roughcontact.contact.dataset import joined
from roughcontact.contact.solve import SOLVER_SETTINGS, solve_contact
from roughcontact.errors import HeightMapError
from roughcontact.io.read import read_height_map
from roughcontact.levelling.level import level as level_map
from roughcontact.results.storage import provenance
from roughcontact.statistics.checks import with_verdicts
from roughcontact.statistics.contact_statistics import SOLUTION_COLUMNS, statistics_of, with_uncertainty
from roughcontact.statistics.first_yield import with_first_yield
from roughcontact.statistics.subsurface import with_subsurface_yield
from roughcontact.statistics.targets import wanted_loads
from roughcontact.uncertainty.budget import error_budget
from roughcontact.variables import describe
from roughcontact.window.periodic_window import periodic_window

Settings = Mapping[str, Mapping[str, Any]]
Progress = Callable[[int, int, str], None]
Count = Callable[[xr.Dataset], xr.Dataset]


class Chain(NamedTuple):
    """What the chain leaves of one map.

    Attributes
    ----------
    levelled, window : DataArray (y, x), m
        the map without form and outliers, and the periodic part of it that was solved.
    statistics : Dataset
        the content of statistics.nc.
    """

    levelled: xr.DataArray
    window: xr.DataArray
    statistics: xr.Dataset


def evaluate(
    source: str | Path | xr.DataArray,
    *,
    level: Mapping[str, Any] | None = None,
    window: Mapping[str, Any] | None = None,
    contact: Mapping[str, Any] | None = None,
    statistics: Mapping[str, Any] | None = None,
    uncertainty: Mapping[str, Any] | None = None,
    threads: int = 1,
) -> xr.Dataset:
    """Read, level, window, solve and count one map, and return its statistics with their intervals.

    Parameters
    ----------
    source : str, Path or DataArray (y, x), m
        a measured file, or a height map as `read_height_map` returns it.
    level, window, contact, statistics, uncertainty : mapping, optional
        what the sections of the configuration hold, numbers possibly as text with a unit ("115 GPa"); what is
        left out has its default. `contact` states the elasticity, as `contact_modulus` or `bodies`.
    threads : int
        threads of the solver.

    Returns
    -------
    Dataset
        dims (load, ...), the content of statistics.nc: `{quantity}` for each load, `{quantity}_uncertainty`
        (load, source), `{quantity}_lower` and `{quantity}_upper` (load), numbers of the map, SI units. Its
        attributes hold settings, versions and, for a file, its checksum.

    Raises
    ------
    SettingsError
        for settings that the configuration would not take.
    InputFileError
        for a file that cannot be read.
    HeightMapError
        for a map that cannot be levelled, windowed or solved.
    ConvergenceError
        where a load misses the tolerance and `contact` says ``on_failure: raise``.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> found = evaluate(
    ...     rough_reference_surface(64),
    ...     contact={"contact_modulus": "1 GPa", "relative_pressure": 0.1},
    ...     uncertainty={"sources": ["solver"]},
    ... )
    >>> f"{found['relative_contact_area'].item():.2f}"
    '0.21'
    >>> bool(found["mean_gap_lower"] <= found["mean_gap"])
    True
    """
    given = {
        "level": level,
        "window": window,
        "contact": contact,
        "statistics": statistics,
        "uncertainty": uncertainty,
    }
    full = resolve({section: dict(values) for section, values in given.items() if values is not None})[""]
    settings = {section: full[section] for section in given}
    height = source if isinstance(source, xr.DataArray) else read_height_map(source)
    found = run_chain(height, settings, threads=threads)
    origin = provenance(
        settings,
        source_sha256=str(height.attrs.get("source_sha256", "")),
        stage="statistics",
        history=str(found.window.attrs.get("history", "")),
    )
    return found.statistics.assign_attrs(origin)


def run_chain(
    height: xr.DataArray,
    settings: Settings,
    *,
    threads: int = 1,
    progress: Callable[[int, int | None, str], None] = lambda done, total, text: None,
) -> Chain:
    """Run the chain on a map in memory.

    Parameters
    ----------
    height : DataArray (y, x), m
        as `read_height_map` returns it.
    settings : mapping
        the sections `level`, `window`, `contact`, `statistics`, `uncertainty`, complete, as `resolve` returns
        them.
    threads : int
        threads of the solver.
    progress : callable, optional
        called as ``progress(done, total, text)`` before each part, and after each load.

    Returns
    -------
    Chain

    Raises
    ------
    RoughContactError
        as its parts raise it: `level`, `periodic_window`, `solve_contact`.
    """
    progress(0, None, "levelling")
    levelled = level_map(height, **settings["level"])
    progress(0, None, "periodic window")
    window = periodic_window(levelled, **settings["window"])
    solver = solver_arguments(window, settings["contact"], threads=threads)
    loads = len(solver["mean_pressure"])
    progress(0, loads, "solving")
    _, counted = solve_and_count(window, settings, solver | {"progress": progress})
    progress(loads, loads, "error budget")
    budget = bound_error(levelled, window, settings, solver)
    return Chain(levelled, window, complete_statistics(counted, window, budget, settings, threads=threads))


def solver_arguments(window: xr.DataArray, contact: Mapping[str, Any], *, threads: int = 1) -> dict[str, Any]:
    """Return the keyword arguments of `solve_contact` that the settings stand for.

    Parameters
    ----------
    window : DataArray (y, x), m
        the map to be solved, for loads relative to its rms gradient, and targets.
    contact : mapping
        the section `contact` of the settings.
    threads : int

    Returns
    -------
    dict
        elasticity, loads (Pa), accuracy, threads.

    Raises
    ------
    HeightMapError
        for relative loads and targets on a flat map; it names the measured file.

    Examples
    --------
    >>> from roughcontact.configuration.resolve import resolve
    >>> from roughcontact.references.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 64), 1e-6, amplitude=1e-7, wavelength=64e-6)
    >>> contact = resolve({"contact": {"contact_modulus": 1e9, "mean_pressure": 1e5}})[""]["contact"]
    >>> found = solver_arguments(wave, contact)
    >>> found["mean_pressure"], found["tolerance"]
    ([100000.0], 0.0001)
    """
    try:
        loads = wanted_loads(window, contact, threads=threads)
    except HeightMapError as error:
        file = window.attrs.get("source_file")
        raise HeightMapError(f"{f'{file}: ' if file else ''}{error} (section contact)") from error
    chosen = {key: contact[key] for key in ("contact_modulus", *SOLVER_SETTINGS)}
    return chosen | {"mean_pressure": loads, "threads": threads}


def bound_error(
    levelled: xr.DataArray, window: xr.DataArray, settings: Settings, solver: Mapping[str, Any]
) -> xr.Dataset:
    """Return the error budget of a solution that has yet to be made.

    Parameters
    ----------
    levelled, window : DataArray (y, x), m
        the map levelled, and the part that is solved.
    settings : mapping
        the sections `level`, `window`, `uncertainty`.
    solver : mapping
        from `solver_arguments`.

    Returns
    -------
    Dataset
        as of `error_budget`.
    """
    verbs = {"level": settings["level"], "window": settings["window"], "contact": solver}
    return error_budget(levelled, window, verbs, **settings["uncertainty"])


def solve_and_count(
    window: xr.DataArray, settings: Settings, solver: Mapping[str, Any], *, keep: Count | None = None
) -> tuple[xr.Dataset, xr.Dataset]:
    """Solve the contact load by load, and count in each solution before the next one is made.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic.
    settings : mapping
        the sections `contact` (of which `bodies` count here) and `statistics`.
    solver : mapping
        from `solver_arguments`; `progress` may be added.
    keep : callable, optional
        gets the solution of each load, with its fields: `LoadByLoad.keep`.

    Returns
    -------
    solution : Dataset
        what the solver says of each load, without fields.
    statistics : Dataset
        as of `contact_statistics`.
    """
    count = counter(window, settings)
    counted: dict[float, xr.Dataset] = {}

    def take(piece: xr.Dataset) -> xr.Dataset:
        """Keep and count one load; nothing of it stays in the solution."""
        if keep is not None:
            keep(piece)
        counted[float(piece["mean_pressure"][0])] = count(piece)
        return xr.Dataset()

    solution = solve_contact(window, **solver, reduce=take)
    statistics = joined([counted[load] for load in map(float, solution["mean_pressure"])])
    return solution[[*SOLUTION_COLUMNS, *({"hardness"} & {*solution})]], describe(statistics)


def counter(window: xr.DataArray, settings: Settings) -> Count:
    """Return the function that counts in solutions of one map, whose own numbers are computed once.

    Parameters
    ----------
    window : DataArray (y, x), m
        that is solved.
    settings : mapping
        the sections `contact` and `statistics`.

    Returns
    -------
    callable
        Dataset of a solution with its fields -> Dataset, as of `contact_statistics`.
    """
    contact = settings["contact"]
    return statistics_of(
        window,
        contact_modulus=contact["contact_modulus"],
        bodies=contact["bodies"],
        **settings["statistics"],
    )


def complete_statistics(
    counted: xr.Dataset, window: xr.DataArray, budget: xr.Dataset, settings: Settings, *, threads: int = 1
) -> xr.Dataset:
    """Return the statistics with all that belongs beside them.

    Parameters
    ----------
    counted : Dataset
        of `solve_and_count`.
    window : DataArray (y, x), m
        that was solved, with the attributes that reading, levelling and windowing left.
    budget : Dataset
        of `bound_error`, for the same loads.
    settings : mapping
        the section `contact`.
    threads : int
        of the solutions on the way to first yield.

    Returns
    -------
    Dataset
        with the load of first yield, the intervals, the stresses below the surface, and the verdict on each
        load in the attribute `verdicts`.
    """
    yielding = with_first_yield(counted, window, settings["contact"], threads=threads)
    complete = with_subsurface_yield(with_uncertainty(yielding, budget), settings["contact"]["bodies"])
    return with_verdicts(complete, window)
