"""A body of finite size on a half-space, loaded by a force."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from roughcontact.arguments.answers import ENDS
from roughcontact.arguments.kinds import FINITE_BODY
from roughcontact.contact.solve import solve_contact
from roughcontact.evaluation.kinds.periodic_map import PeriodicMap, Settings, SolvedMap
from roughcontact.surface.preparation.finite_body import FiniteBodyPreparation
from roughcontact.uncertainty.budget_inputs import budget_inputs
from roughcontact.uncertainty.finite_body import finite_body_budget


class FiniteBody(FiniteBodyPreparation, PeriodicMap):
    """A ball, a block: the map is its roughness, on a form or within edges."""

    name = FINITE_BODY.name
    facts = FINITE_BODY

    def loads(self, window: xr.DataArray, settings: Settings, solver: Mapping[str, Any]) -> dict[str, Any]:
        """Return boundary and forces."""
        return {"boundary": self.facts.boundary, self.facts.load: settings["contact"][self.facts.load]}

    def budget(self, solution: SolvedMap) -> xr.Dataset:
        """Return the error budget of the roughness, solved on its form."""
        window, settings, inputs = solution.window, solution.settings, solution.inputs
        inputs = solve_contact(window, **solution.solver, reduce=budget_inputs) if inputs is None else inputs
        options = {key: settings["uncertainty"][key] for key in ("sources", "windows")}
        return finite_body_budget(window, {**settings, "contact": solution.contact}, solved=inputs, **options)

    def with_corrected_sizes(self, statistics: xr.Dataset, solved: xr.Dataset) -> xr.Dataset:
        """Return the statistics with area and radius of the contact that follow from the relative area."""
        sizes = {}
        for name, power in (("contact_area", 1.0), ("contact_radius", 0.5)):
            for suffix in ENDS:
                if (area := f"relative_contact_area{suffix}") in statistics:
                    ratio = statistics[area] / solved["relative_contact_area"]
                    sizes[f"{name}{suffix}"] = solved[name] * ratio**power
        return statistics.assign(sizes)

    def add_improvement(self, statistics: xr.Dataset) -> xr.Dataset:
        """Return the statistics as they are: a longer map does not bring the positions nearer together."""
        return statistics
