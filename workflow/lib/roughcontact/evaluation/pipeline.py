"""The chain from a height map to numbers: level, cut out a periodic window, solve and count, bound the error.

Workflow, `roughcontact solve` and `roughcontact.evaluate` all use it, so that they give the same numbers.
"""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import xarray as xr

from roughcontact.arguments.measurement import Instrument, json_attributes
from roughcontact.arguments.named_materials import temperature_limits
from roughcontact.arguments.positions import separate_positions
from roughcontact.arguments.settings.stages import stage_settings
from roughcontact.contact.dataset import joined
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import SettingsError
from roughcontact.evaluation.creep import with_creep
from roughcontact.evaluation.kinds import kind_of
from roughcontact.evaluation.kinds.periodic_map import STATED_LOADS, SolvedMap
from roughcontact.evaluation.requirement import with_largest_roughness
from roughcontact.results.storage import provenance, written_load_by_load
from roughcontact.statistics.allowed import with_allowed
from roughcontact.statistics.checks import add_verdicts
from roughcontact.statistics.contact_statistics import SOLUTION_COLUMNS, statistics_function, with_uncertainty
from roughcontact.statistics.instrument_checks import instrument_kind
from roughcontact.statistics.precision import add_precision
from roughcontact.statistics.subsurface import add_subsurface_yield
from roughcontact.statistics.targets import add_first_yield
from roughcontact.surface.preparation.periodic_map import Settings
from roughcontact.surface.preparation.region import read_overview
from roughcontact.surface.window.band import lateral_period_limit
from roughcontact.surface.window.instrument import stated_instrument
from roughcontact.uncertainty.budget_inputs import budget_inputs, constrictions_in_grooves
from roughcontact.uncertainty.improvement import add_overview_line

_OF_WINDOW = (  # what a group of maps has in common, how rows were aligned, where a summit stands out
    *("band_shortest", "band_longest", "band_reason", "corrected_for", "lay", "ensemble"),
    *("line_alignment", "summit_x", "summit_y"),
)

_TOLERANCE_OF_ROUGHNESS = 1e-3  # in single precision

Progress = Callable[[int, int | None, str], None]
StatisticsFunction = Callable[[xr.Dataset], xr.Dataset]


def silent(done: int, total: int | None, text: str) -> None:
    """Say nothing of the progress."""


class Chain(NamedTuple):
    """The results of the chain for one map."""

    levelled: xr.DataArray  # (y, x), m
    window: xr.DataArray  # (y, x), m, the periodic part that was solved
    statistics: xr.Dataset  # the content of statistics.nc
    overviews: Sequence[xr.DataArray] = ()  # (y, x), m, with the place of the map


def run_chain(
    height: xr.DataArray,
    settings: Settings,
    *,
    threads: int = 1,
    progress: Progress = silent,
    fields: Path | None = None,
    overviews: Sequence[tuple[xr.DataArray, str]] = (),
) -> Chain:
    """Run the chain on a map (y, x; m) with the complete sections of the settings (`resolve`).

    `progress(done, total, text)` is called before each part and after each load; `fields` is the file for the
    solution with its maps, contact.nc; `overviews` are coarser maps (y, x; m) of a field around
    this one, each with the position that is stated (`arguments.positions`).
    """
    progress(0, None, "levelling")
    kind = kind_of(height, settings)
    level_result = kind.level(height, settings["level"])
    # levelled as the map is, so that forms count as little in both
    located = [kind.overview(level_result, field, settings["level"], place) for field, place in overviews]
    progress(0, None, "periodic window")
    window = kind.window(level_result, settings)
    solver = kind.solver_arguments(window, settings, threads=threads)
    loads = solver[kind.facts.load]  # planned ones too, which only the solved map tells
    progress(0, len(loads), "solving")
    origin: dict[str, Any] = {
        "settings": {key: settings[key] for key in stage_settings(settings, "statistics")},
        "source_sha256": str(height.attrs.get("source_sha256", "")),
        "history": str(window.attrs.get("history", "")),
    }
    with_progress = solver | {"progress": progress}
    if fields is None:
        result = solve_and_evaluate(window, settings, with_progress)
    else:
        # maps of many loads do not fit into memory together: each is written when it is solved
        with written_load_by_load(fields, loads, window) as file:
            result = solve_and_evaluate(window, settings, with_progress, store=file.write_maps)
            solution = result.solution.assign(height=window)
            file.complete(solution.assign_attrs(provenance(**origin, stage="contact")))
    progress(len(loads), len(loads), "error budget")
    solved = SolvedMap(level_result, window, settings, solver, result.for_budget, located)
    statistics = complete_statistics(result.statistics, window, kind.budget(solved), settings, solver)
    statistics = after_creep(statistics, solved)
    statistics = statistics.assign_attrs(provenance(**origin, stage="statistics"))
    return Chain(level_result, window, statistics, located)


def with_positions(
    overviews: Sequence[str | Path | xr.DataArray], text: str
) -> list[tuple[xr.DataArray, str]]:
    """Return overviews, read where they are files, each with the position that is stated for it."""
    for field in overviews:
        if not isinstance(field, str | PathLike | xr.DataArray):
            text = f"overview = {field!r}: give the path of a coarser map, a map, or a list of them"
            raise SettingsError(text, keys=["overview"])
    positions = separate_positions(text, len(overviews))
    maps = [field if isinstance(field, xr.DataArray) else read_overview(field) for field in overviews]
    return [*zip(maps, positions, strict=True)]


class Solved(NamedTuple):
    """What is kept of a solution, without fields."""

    solution: xr.Dataset  # the numbers of the solver
    statistics: xr.Dataset  # of `contact_statistics`
    for_budget: xr.Dataset  # of `budget_inputs`; without sources of uncertainty the solution


def solve_and_evaluate(
    window: xr.DataArray,
    settings: Settings,
    solver: Mapping[str, Any],
    *,
    store: StatisticsFunction | None = None,
) -> Solved:
    """Solve a periodic window (y, x; m) load by load, and count each solution before the next one.

    `solver` is from `solver_arguments` of its kind; `store` each solution with its fields
    (`LoadByLoad.write_maps`).
    """
    count, has_budget = statistics_of_settings(window, settings), bool(settings["uncertainty"]["sources"])
    grooves = constrictions_in_grooves(window) if has_budget else []
    statistics: dict[float, xr.Dataset] = {}
    inputs: dict[float, xr.Dataset] = {}

    def take(load_dataset: xr.Dataset) -> xr.Dataset:
        """Keep and count one load, and remove it from the solution."""
        if store is not None:  # the maps first: counting may use their memory
            store(load_dataset)
        load = float(load_dataset["mean_pressure"][0])
        statistics[load] = count(load_dataset)
        if has_budget:
            inputs[load] = budget_inputs(load_dataset, statistics[load], grooves)
        return xr.Dataset()  # nothing of the solution is kept but its numbers

    solution = solve_contact(window, **solver, reduce=take)
    loads = list(map(float, solution["mean_pressure"]))
    return Solved(
        solution[[*SOLUTION_COLUMNS, *({"hardness"} & {*solution})]],
        joined([statistics[load] for load in loads]),
        joined([inputs[load] for load in loads]) if has_budget else solution,
    )


def statistics_of_settings(window: xr.DataArray, settings: Settings) -> StatisticsFunction:
    """Return the function from a solution to `contact_statistics`, by the sections of the settings."""
    contact = settings["contact"]
    return statistics_function(
        window, contact_modulus=contact["contact_modulus"], bodies=contact["bodies"], **settings["statistics"]
    )


def complete_statistics(
    statistics: xr.Dataset,
    window: xr.DataArray,
    budget: xr.Dataset,
    settings: Settings,
    solver: Mapping[str, Any],
) -> xr.Dataset:
    """Return the statistics with first yield, intervals, subsurface stresses, answers, verdicts and reasons.

    `window` (y, x; m) has the attributes of reading, levelling and windowing, `budget` the same loads;
    `solver` is from `solver_arguments` of its kind.
    """
    kind, options = kind_of(window, settings), settings["statistics"]
    # what a requirement is of, without what takes longer than the contact
    of_requirement = {**options, "stress": "never", "friction": None, "work_of_adhesion": None}
    # flow takes longer than the contact: only a leak needs it
    if not (options["requirement"] or {}).get("leak"):
        of_requirement |= {"flow": "never", "seal": None}

    def at_roughness(factor: float, load: float) -> xr.Dataset:
        """Return the statistics of the window with heights that are larger by a factor."""
        # no ± of its own: a search calls this many times
        plain = {**settings, "statistics": of_requirement, "uncertainty": {"sources": []}}
        options = {**solver, kind.facts.load: [load]}
        if solver.get("precision") == "single":  # whose rounding grows with the roughness
            options["tolerance"] = max(solver["tolerance"], _TOLERANCE_OF_ROUGHNESS)
        return solve_and_evaluate(window.copy(data=window.values * factor), plain, options).statistics

    yielding = add_first_yield(statistics, window, settings["contact"], threads=solver["threads"])
    complete = add_subsurface_yield(with_uncertainty(yielding, budget), settings["contact"]["bodies"])
    area = settings["contact"].get("area")
    complete = with_allowed(add_overview_line(complete), options, area=area)
    linear = settings["contact"]["hardness"] is None
    complete = with_largest_roughness(complete, options, at_roughness, area=area, linear=linear)
    result = add_verdicts(add_precision(complete).assign_attrs(_properties(window, settings)), window)
    return kind.add_improvement(result)


def after_creep(statistics: xr.Dataset, solution: SolvedMap) -> xr.Dataset:
    """Return the statistics with what the contact has become after the times that its bodies state."""
    settings, kind = solution.settings, kind_of(solution.window, solution.settings)

    def crept(modulus: float) -> xr.Dataset:
        """Return the statistics with another contact modulus, and their intervals."""
        softer = {**settings, "contact": {**settings["contact"], "contact_modulus": modulus}}
        solver = {**solution.solver, "contact_modulus": modulus}
        solver |= kind.loads_after_creep(solution.window, softer, solver)
        result = solve_and_evaluate(solution.window, softer, solver)
        softer_result = solution._replace(settings=softer, solver=solver, inputs=result.for_budget)
        return with_uncertainty(result.statistics, kind.budget(softer_result))

    return with_creep(statistics, settings["contact"], crept)


def _properties(window: xr.DataArray, settings: Settings) -> dict[str, Any]:
    """Return what checks, reports and groups have to know of a solved map: its instrument, band and loads."""
    instrument = stated_instrument(window, settings.get("instrument"))
    numbers = {key: value for key, value in instrument.items() if isinstance(value, float)}
    if aperture := instrument.get("numerical_aperture"):
        numbers["lateral_period_limit"] = lateral_period_limit(aperture, instrument.get("wavelength"))
    properties: dict[str, Any] = {**Instrument(**numbers).attributes()}
    # no reader knows loads that nobody stated
    if not any(settings["contact"].get(key) for key in STATED_LOADS):
        properties["loads"] = "planned"  # or those of a target
    properties["periodisation"] = window.attrs.get("periodisation", "none")
    properties["measured_by"] = instrument_kind(window.attrs).name
    if limits := temperature_limits(settings["contact"].get("bodies")):
        properties |= json_attributes({"temperatures": limits})
    return properties | {key: window.attrs[key] for key in _OF_WINDOW if key in window.attrs}
