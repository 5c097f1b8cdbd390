"""One profile across a lay, solved as endless ridges."""

import xarray as xr

from roughcontact.arguments.lays import lay_facts
from roughcontact.arguments.maps import dimensions
from roughcontact.evaluation.kinds.periodic_map import PeriodicMap, Settings, SolvedMap
from roughcontact.uncertainty.profiles.scatter import isotropic_contact


class Ridges(PeriodicMap):
    """A periodic map of a single row or column."""

    name = "ridges"
    without_overview = "ridges"

    @classmethod
    def includes(cls, height: xr.DataArray, settings: Settings) -> bool:
        """Return whether a map is a single row or column."""
        return dimensions(height.shape) == 1

    def budget(self, solution: SolvedMap) -> xr.Dataset:
        """Return the error budget, with the contact of an isotropic surface unless a lay is stated."""
        budget = super().budget(solution)
        if lay_facts(solution.window.attrs).finding or not solution.settings["uncertainty"]["sources"]:
            return budget
        isotropic = isotropic_contact(solution.levelled, solution.solver)
        return budget.assign({f"{name}_if_isotropic": ("load", value) for name, value in isotropic.items()})
