"""The map that repeats itself along both axes: the kind from which all others differ."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, ClassVar, NamedTuple

import xarray as xr

from roughcontact.arguments.kinds import PERIODIC_MAP, KindFacts
from roughcontact.arguments.stacks import bodies_for_solver
from roughcontact.contact.solve import SOLVER_SETTINGS
from roughcontact.errors import HeightMapError
from roughcontact.evaluation.elastic_loads import elastic_loads
from roughcontact.statistics.targets import TARGETS, wanted_loads
from roughcontact.surface.faces.placing import place_attributes
from roughcontact.surface.preparation.periodic_map import MapPreparation, Settings
from roughcontact.surface.window.instrument import window_arguments
from roughcontact.uncertainty.budget import MATERIAL_UNCERTAINTIES, error_budget
from roughcontact.uncertainty.calibration import ALONE
from roughcontact.uncertainty.improvement import add_halving
from roughcontact.uncertainty.overview import scatter_with_overviews
from roughcontact.uncertainty.scales import AREA
from roughcontact.uncertainty.subwindows import Scatter, scatter_of_subwindows

_OVERVIEW_WITHOUT_EFFECT = (
    "The overview counts for nothing: it needs the source window (uncertainty.sources), a map that is large "
    "enough to be divided into parts, a gap that is open, and pixels up to 10 times as large as those of the "
    "map, at another position 5 times."
)
STATED_LOADS = ("mean_pressure", "relative_pressure", "force")


class SolvedMap(NamedTuple):
    """What an error budget starts from."""

    levelled: xr.DataArray  # (y, x), m
    window: xr.DataArray  # (y, x), m
    settings: Settings
    solver: Mapping[str, Any]  # arguments of `solve_contact`
    inputs: xr.Dataset | None = None  # `budget_inputs` of the solution, computed where not given
    overviews: Sequence[xr.DataArray] = ()  # (y, x), m, of `overview_with_place`

    @property
    def contact(self) -> dict[str, Any]:
        """The arguments of the solver, with the uncertainties of load and modulus."""
        return {**self.solver, **{key: self.settings["contact"][key] for key in MATERIAL_UNCERTAINTIES}}


class PeriodicMap(MapPreparation):
    """An elastic half-space under a periodic map."""

    facts: ClassVar[KindFacts] = PERIODIC_MAP

    def solver_arguments(
        self, window: xr.DataArray, settings: Settings, *, threads: int = 1
    ) -> dict[str, Any]:
        """Return the keyword arguments of `solve_contact` for a window, its loads among them."""
        contact = settings["contact"]
        options = {key: contact[key] for key in ("contact_modulus", *SOLVER_SETTINGS)} | {"threads": threads}
        options |= bodies_for_solver(contact["bodies"])
        return options | self.loads(window, settings, options)

    def loads(self, window: xr.DataArray, settings: Settings, solver: Mapping[str, Any]) -> dict[str, Any]:
        """Return the load arguments of `solve_contact`: stated ones, those of targets, or planned ones."""
        contact = settings["contact"]
        try:
            pressures = wanted_loads(window, contact, threads=solver["threads"])
        except HeightMapError as error:
            file = window.attrs.get("source_file")
            raise HeightMapError(f"{f'{file}: ' if file else ''}{error} (section contact)") from error
        if not any(contact.get(key) for key in (*STATED_LOADS, *TARGETS)):
            pressures = elastic_loads(window, pressures, solver)
        return {"mean_pressure": pressures}

    def loads_after_creep(
        self, window: xr.DataArray, settings: Settings, solver: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Return the load arguments of `solve_contact` that change where bodies creep: none."""
        return {}

    def budget(self, solution: SolvedMap) -> xr.Dataset:
        """Return the error budget of a solution."""
        sections, options = self.budget_arguments(solution)
        surface = self.measured_surface(solution)
        budget = error_budget(surface, solution.window, sections, **options, solved=solution.inputs)
        if not solution.overviews:
            return budget
        place = place_attributes(solution.overviews, solution.levelled)
        budget = budget.assign_attrs({f"overview_{name}": number for name, number in place.items()})
        if f"{AREA}_{ALONE}" in budget:  # beside the results with what the overview shows
            return budget
        flag = f"{_OVERVIEW_WITHOUT_EFFECT} {budget.attrs.get('window_flag', '')}".rstrip()
        return budget.assign_attrs(window_flag=flag)

    def budget_arguments(self, solution: SolvedMap) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the sections and the keyword arguments of `error_budget`."""
        settings = solution.settings
        sections = {key: settings[key] for key in ("level", "instrument")}
        sections |= {"window": window_arguments(solution.levelled, settings), "contact": solution.contact}
        return sections, {**settings["uncertainty"], "scatter_of": self.scatter(solution)}

    def scatter(self, solution: SolvedMap) -> Callable[..., Scatter]:
        """Return what the source `window` consists of."""
        if not solution.overviews:
            return scatter_of_subwindows
        return partial(scatter_with_overviews, solution.overviews)

    def measured_surface(self, solution: SolvedMap) -> xr.DataArray:
        """Return the levelled map of which the window is a part."""
        return solution.levelled

    def add_improvement(self, statistics: xr.Dataset) -> xr.Dataset:
        """Return the statistics with what would halve their ±."""
        return add_halving(statistics, overview=not self.without_overview)
