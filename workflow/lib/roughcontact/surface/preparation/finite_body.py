"""A map that is the roughness of a body of finite size: nothing is blended at its borders."""

import xarray as xr

from roughcontact.arguments.kinds import FINITE_BODY, facts_of_settings
from roughcontact.surface.preparation.periodic_map import MapPreparation, Settings
from roughcontact.surface.window.finite_body import finite_body
from roughcontact.surface.window.periodic_window import periodic_window


class FiniteBodyPreparation(MapPreparation):
    """What is done to the map of a body before the solver."""

    without_overview = "a finite body"  # it ends with its map

    @classmethod
    def includes(cls, height: xr.DataArray, settings: Settings) -> bool:
        """Return whether the settings have a free boundary."""
        return facts_of_settings(settings) is FINITE_BODY

    def window(self, levelled: xr.DataArray, settings: Settings) -> xr.DataArray:
        """Return the body (y, x; m): the largest rectangle of measured points, on its form."""
        # of all settings of the window only the smallest share of the map applies
        arguments = {key: settings["window"][key] for key in ("min_share",) if key in settings["window"]}
        form = {key: settings["form"][key] for key in ("radius", "edges")}
        return finite_body(periodic_window(levelled, method="raw", **arguments), **form)
