"""A form wider than its map: each place of the smooth contact has the map under Hertz's pressure there."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from roughcontact.arguments.kinds import LOCAL_SCALE, facts_of_settings
from roughcontact.evaluation.kinds.periodic_map import PeriodicMap, Settings, SolvedMap
from roughcontact.uncertainty.local_scale import hertz_pressures, whole_contact


class LocalScale(PeriodicMap):
    """A kind of periodic map, whose loads are the largest pressures of a smooth form."""

    name = LOCAL_SCALE.name
    facts = LOCAL_SCALE

    def __init__(self, base: PeriodicMap):
        self._base = base

    @classmethod
    def includes(cls, height: xr.DataArray, settings: Settings) -> bool:
        """Return whether the settings have a form of local scale."""
        return facts_of_settings(settings) is LOCAL_SCALE

    def level(self, height: xr.DataArray, options: Mapping[str, Any]) -> xr.DataArray:
        """Return the map, levelled as of its own kind."""
        return self._base.level(height, options)

    def window(self, levelled: xr.DataArray, settings: Settings) -> xr.DataArray:
        """Return the map that is solved, as of its own kind."""
        return self._base.window(levelled, settings)

    def loads(self, window: xr.DataArray, settings: Settings, solver: Mapping[str, Any]) -> dict[str, Any]:
        """Return the largest nominal pressure of the form under each force."""
        return {"mean_pressure": hertz_pressures(settings["contact"], settings["form"]["radius"])}

    loads_after_creep = loads  # a softer form spreads the force over a larger contact

    def budget(self, solution: SolvedMap) -> xr.Dataset:
        """Return the error budget of the map, and the whole contact under each force."""
        (sections, options), contact = self._base.budget_arguments(solution), solution.settings["contact"]
        options |= {"forces": contact["force"], "bodies": contact["bodies"]}
        options |= {"radius": solution.settings["form"]["radius"]}
        surface = self._base.measured_surface(solution)
        return self._base.budget(solution).assign(
            whole_contact(surface, solution.window, sections, **options)
        )
