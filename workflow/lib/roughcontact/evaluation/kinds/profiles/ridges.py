"""One profile across a lay, solved as endless ridges."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import dimensions
from roughcontact.arguments.profiles.lays import lay_facts
from roughcontact.errors import HeightMapError
from roughcontact.evaluation.kinds.periodic_map import PeriodicMap, Settings, SolvedMap
from roughcontact.surface.profiles.surface import surface_from_profiles
from roughcontact.uncertainty.ensemble import solve_member
from roughcontact.uncertainty.scales import AREA, GAP


class Ridges(PeriodicMap):
    """A periodic map of a single row or column."""

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
        isotropic = _isotropic_contact(solution.levelled, solution.solver)
        return budget.assign({f"{name}_if_isotropic": ("load", value) for name, value in isotropic.items()})


def _isotropic_contact(profile: xr.DataArray, contact: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return contact area and mean gap (load) of the isotropic surface behind a profile, if there is one."""
    try:
        surface = surface_from_profiles([profile])
    except HeightMapError:
        return {}
    return solve_member(surface, {**contact, "on_failure": "flag"}, names=[AREA, GAP])
