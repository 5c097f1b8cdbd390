"""Profiles with a surface behind them: an example of the surfaces with their spectrum is solved."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from roughcontact.arguments.kinds import facts_of_settings
from roughcontact.arguments.profiles.lays import lay_facts
from roughcontact.arguments.quantities import counted_noun
from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.surface.preparation.periodic_map import MapPreparation, Settings
from roughcontact.surface.profiles.surface import levelled_profiles, surface_from_profiles


class ProfilesPreparation(MapPreparation):
    """What is done to profiles before the solver."""

    without_overview = "profiles"  # which have no place in it

    @classmethod
    def includes(cls, height: xr.DataArray, settings: Settings) -> bool:
        """Return whether profiles, or the window made of them, have a surface behind them."""
        return lay_facts(height.attrs).has_surface_behind

    def level(self, height: xr.DataArray, options: Mapping[str, Any]) -> xr.DataArray:
        """Return profiles (number, x; m), each levelled by itself."""
        return levelled_profiles(height, options)

    def window(self, levelled: xr.DataArray, settings: Settings) -> xr.DataArray:
        """Return one of the surfaces (y, x; m) with the spectrum of profiles (number, x; m)."""
        if reason := facts_of_settings(settings).reason_against("surface behind profiles"):
            raise HeightMapError(reason)
        if settings.get("instrument", {}).get("correct"):
            name = levelled.attrs.get("source_file") or "this stack"
            raise SettingsError(
                f"instrument.correct = true: {name} is of profiles with a surface behind them, on which the "
                "noise of lines is not white; leave it out: the ± then includes noise and lens",
                keys=["instrument.correct"],
            )
        # with the seed 0: the same surface in every run
        surface = surface_from_profiles([levelled])
        # it is periodic without its form, and has no points that were rejected
        surface = surface.assign_attrs(form="none", form_removed="{}", outliers_rejected=0)
        window = super().window(surface, settings)
        attrs = {key: levelled.attrs[key] for key in ("form", "form_removed")}
        # of which the window is an example
        ensemble = lay_facts(surface.attrs).ensemble.format(
            profiles=counted_noun(surface.attrs["profiles"], "profile")
        )
        return window.assign_attrs(attrs, ensemble=ensemble, window_reason=f"One of {ensemble}.")
