"""The chain from a height map to numbers: level, cut out a periodic window, solve and count, bound the error.

Workflow, `roughcontact solve` and `roughcontact.evaluate` all use it, so that they give the same numbers.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import xarray as xr

from roughcontact.bodies import have_layers
from roughcontact.configuration.stages import settings_of
from roughcontact.contact.dataset import joined
from roughcontact.contact.solve import SOLVER_SETTINGS, solve_contact
from roughcontact.errors import HeightMapError
from roughcontact.profiles.scatter import isotropic_contact, scatter_of_surfaces
from roughcontact.profiles.surface import is_drawn, levelled_heights, solved_window
from roughcontact.results.storage import provenance, written_load_by_load
from roughcontact.statistics.checks import with_verdicts
from roughcontact.statistics.contact_statistics import SOLUTION_COLUMNS, statistics_function, with_uncertainty
from roughcontact.statistics.first_yield import with_first_yield
from roughcontact.statistics.instrument_checks import instrument_kind
from roughcontact.statistics.precision import with_precision
from roughcontact.statistics.subsurface import with_subsurface_yield
from roughcontact.statistics.targets import TARGETS, wanted_loads
from roughcontact.uncertainty.budget import MATERIAL_UNCERTAINTIES, error_budget
from roughcontact.uncertainty.budget_inputs import budget_inputs
from roughcontact.uncertainty.calibration import MAP_SCATTER
from roughcontact.uncertainty.elastic_loads import elastic_loads
from roughcontact.uncertainty.finite_body import finite_body_budget
from roughcontact.uncertainty.improvement import with_halving
from roughcontact.uncertainty.local_scale import hertz_pressures, whole_contact
from roughcontact.uncertainty.subwindows import Scatter, scatter_of_subwindows
from roughcontact.window.band import lateral_period_limit
from roughcontact.window.instrument import stated_instrument, window_arguments

_OF_WINDOW = (  # what a group of maps has in common, how rows were aligned, where a summit stands out
    *("band_shortest", "band_longest", "band_reason", "corrected_for", "lay", "profiles"),
    *("line_alignment", "summit_x", "summit_y"),
)
_LOADS = ("mean_pressure", "relative_pressure", "force")

Settings = Mapping[str, Mapping[str, Any]]
Progress = Callable[[int, int, str], None]
StatisticsFunction = Callable[[xr.Dataset], xr.Dataset]


class Chain(NamedTuple):
    """The results of the chain for one map."""

    levelled: xr.DataArray  # (y, x), m
    window: xr.DataArray  # (y, x), m, the periodic part that was solved
    statistics: xr.Dataset  # the content of statistics.nc


def run_chain(
    height: xr.DataArray,
    settings: Settings,
    *,
    threads: int = 1,
    progress: Callable[[int, int | None, str], None] = lambda solved, total, text: None,
    fields: Path | None = None,
) -> Chain:
    """Run the chain on a map (y, x; m) with the complete sections of the settings (`resolve`).

    `progress(done, total, text)` is called before each part and after each load; `fields` is the file for the
    solution with its maps, contact.nc.
    """
    progress(0, None, "levelling")
    levelled = levelled_heights(height, settings["level"])
    progress(0, None, "periodic window")
    window = solved_window(levelled, settings)
    solver = solver_arguments(window, settings, threads=threads)
    loads = loads_of(solver)
    progress(0, len(loads), "solving")
    origin: dict[str, Any] = {
        "settings": {key: settings[key] for key in settings_of(settings, "statistics")},
        "source_sha256": str(height.attrs.get("source_sha256", "")),
        "history": str(window.attrs.get("history", "")),
    }
    with_progress = solver | {"progress": progress}
    if fields is None:
        result = solve_and_evaluate(window, settings, with_progress)
    else:
        with written_load_by_load(fields, loads, window) as file:
            result = solve_and_evaluate(window, settings, with_progress, store=file.write_maps)
            solution = result.solution.assign(height=window)
            file.complete(solution.assign_attrs(provenance(**origin, stage="contact")))
    progress(len(loads), len(loads), "error budget")
    budget = bound_error(levelled, window, settings, solver, result.for_budget)
    statistics = complete_statistics(result.statistics, window, budget, settings, threads=threads)
    return Chain(levelled, window, statistics.assign_attrs(provenance(**origin, stage="statistics")))


def _radius_of_form(settings: Settings) -> Sequence[float]:
    """Return one radius or two (m) of a form wider than its map, none of other maps."""
    form = settings.get("form", {})
    return form["radius"] if form.get("local_scale") else ()


def loads_of(solver: Mapping[str, Any]) -> list[float]:
    """Return the loads of `solver_arguments`: mean pressures (Pa), of a body of finite size forces (N)."""
    return list(solver["force"] if "force" in solver else solver["mean_pressure"])


def solver_arguments(window: xr.DataArray, settings: Settings, *, threads: int = 1) -> dict[str, Any]:
    """Return the keyword arguments of `solve_contact` by the sections `contact` and `form`, for a window.

    Examples
    --------
    >>> from roughcontact.configuration.resolve import resolve
    >>> from roughcontact.references.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 64), 1e-6, amplitude=1e-7, wavelength=64e-6)
    >>> settings = resolve({"contact": {"contact_modulus": 1e9, "mean_pressure": 1e5}})[""]
    >>> found = solver_arguments(wave, settings)
    >>> found["mean_pressure"], found["tolerance"]
    ([100000.0], 0.0001)
    """
    contact = settings["contact"]
    chosen = {key: contact[key] for key in ("contact_modulus", *SOLVER_SETTINGS)}
    if have_layers(contact["bodies"]):
        chosen["bodies"] = contact["bodies"]
    if contact.get("boundary") == "free":
        return chosen | {"boundary": "free", "force": contact["force"], "threads": threads}
    if radius := _radius_of_form(settings):
        return chosen | {"mean_pressure": hertz_pressures(contact, radius), "threads": threads}
    try:
        loads = wanted_loads(window, contact, threads=threads)
    except HeightMapError as error:
        file = window.attrs.get("source_file")
        raise HeightMapError(f"{f'{file}: ' if file else ''}{error} (section contact)") from error
    if not any(contact.get(key) for key in (*_LOADS, *TARGETS)):  # the loads are planned
        loads = elastic_loads(window, loads, chosen | {"threads": threads})
    return chosen | {"mean_pressure": loads, "threads": threads}


def bound_error(
    levelled: xr.DataArray,
    window: xr.DataArray,
    settings: Settings,
    solver: Mapping[str, Any],
    solved: xr.Dataset | None = None,
) -> xr.Dataset:
    """Return the `error_budget` of a solution (`Solved.for_budget`), computed again where it is not given."""
    contact = {**solver, **{key: settings["contact"][key] for key in MATERIAL_UNCERTAINTIES}}
    if "force" in solver:
        inputs = solve_contact(window, **solver, reduce=budget_inputs) if solved is None else solved
        options = {key: settings["uncertainty"][key] for key in ("sources", "windows")}
        return finite_body_budget(window, {**settings, "contact": contact}, solved=inputs, **options)
    chain_sections = {key: settings[key] for key in ("level", "instrument")}
    chain_sections |= {"window": window_arguments(levelled, settings), "contact": contact}
    scatter_of: Callable[..., Scatter] = scatter_of_subwindows
    if is_drawn(levelled):
        scatter_of, levelled = partial(scatter_of_surfaces, levelled), window
    options = {**settings["uncertainty"], "scatter_of": scatter_of}
    budget = error_budget(levelled, window, chain_sections, **options, solved=solved)
    if radius := _radius_of_form(settings):
        whole = {"forces": settings["contact"]["force"], "bodies": settings["contact"]["bodies"]}
        options |= {**whole, "radius": radius}
        budget = budget.assign(whole_contact(levelled, window, chain_sections, **options))
    if 1 not in window.shape or "lay" in window.attrs or not settings["uncertainty"]["sources"]:
        return budget
    isotropic = isotropic_contact(levelled, solver)
    return budget.assign({f"{name}_if_isotropic": ("load", value) for name, value in isotropic.items()})


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

    `solver` is from `solver_arguments`; `store` each solution with its fields (`LoadByLoad.write_maps`).
    """
    count, bounded = statistics_of_settings(window, settings), bool(settings["uncertainty"]["sources"])
    statistics: dict[float, xr.Dataset] = {}
    inputs: dict[float, xr.Dataset] = {}

    def take(load_dataset: xr.Dataset) -> xr.Dataset:
        """Keep and count one load, and remove it from the solution."""
        if store is not None:
            store(load_dataset)
        load = float(load_dataset["mean_pressure"][0])
        statistics[load] = count(load_dataset)
        if bounded:
            inputs[load] = budget_inputs(load_dataset, statistics[load])
        return xr.Dataset()

    solution = solve_contact(window, **solver, reduce=take)
    loads = list(map(float, solution["mean_pressure"]))
    return Solved(
        solution[[*SOLUTION_COLUMNS, *({"hardness"} & {*solution})]],
        joined([statistics[load] for load in loads]),
        joined([inputs[load] for load in loads]) if bounded else solution,
    )


def statistics_of_settings(window: xr.DataArray, settings: Settings) -> StatisticsFunction:
    """Return the function from a solution to `contact_statistics`, by the sections of the settings."""
    contact = settings["contact"]
    return statistics_function(
        window,
        contact_modulus=contact["contact_modulus"],
        bodies=contact["bodies"],
        **settings["statistics"],
    )


def complete_statistics(
    statistics: xr.Dataset, window: xr.DataArray, budget: xr.Dataset, settings: Settings, *, threads: int = 1
) -> xr.Dataset:
    """Return the statistics with first yield, intervals, subsurface stresses, verdicts and reasons.

    `window` (y, x; m) has the attributes of reading, levelling and windowing, `budget` the same loads.
    """
    yielding = with_first_yield(statistics, window, settings["contact"], threads=threads)
    complete = with_subsurface_yield(with_uncertainty(yielding, budget), settings["contact"]["bodies"])
    if "contact_area" in complete:  # of the corrected area, too
        ratio = complete["relative_contact_area"] / yielding["relative_contact_area"]
        corrected = {"contact_area": ratio, "contact_radius": ratio**0.5}
        complete = complete.assign({name: complete[name] * factor for name, factor in corrected.items()})
    judged = with_verdicts(with_precision(complete).assign_attrs(_properties(window, settings)), window)
    if "contact_area" in judged:  # a longer map does not bring the positions nearer to one another
        return judged
    return with_halving(judged, budget.attrs.get(MAP_SCATTER))


def _properties(window: xr.DataArray, settings: Settings) -> dict[str, Any]:
    """Return what checks, reports and groups have to know of a solved map: its instrument, band and loads."""
    stated = stated_instrument(window, settings.get("instrument"))
    properties: dict[str, Any] = {
        f"instrument_{key}": value for key, value in stated.items() if isinstance(value, float)
    }
    if aperture := stated.get("numerical_aperture"):
        limit = lateral_period_limit(aperture, stated.get("wavelength"))
        properties["instrument_lateral_period_limit"] = limit
    if not any(settings["contact"].get(key) for key in _LOADS):
        properties["loads"] = "found"  # planned, or for a target
    properties["periodisation"] = window.attrs.get("periodisation", "none")
    properties["measured_by"] = instrument_kind(window.attrs).name
    return properties | {key: window.attrs[key] for key in _OF_WINDOW if key in window.attrs}
