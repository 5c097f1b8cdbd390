"""A map, levelled as a whole, of which a periodic window is solved."""

from collections.abc import Mapping
from typing import Any, ClassVar

import xarray as xr

from roughcontact.arguments.profiles.lines import check_single_map
from roughcontact.errors import HeightMapError
from roughcontact.surface.faces.placing import overview_with_place
from roughcontact.surface.levelling.level import level
from roughcontact.surface.window.instrument import window_arguments
from roughcontact.surface.window.periodic_window import periodic_window

Settings = Mapping[str, Mapping[str, Any]]


class MapPreparation:
    """What is done to a map before the solver."""

    without_overview: ClassVar[str] = ""  # what it is, where a coarser map around it shows no other places

    @classmethod
    def includes(cls, height: xr.DataArray, settings: Settings) -> bool:
        """Return whether a map (y, x; m), measured or levelled, with these settings is prepared this way."""
        return True

    def level(self, height: xr.DataArray, options: Mapping[str, Any]) -> xr.DataArray:
        """Return the levelled map (y, x; m), by the section `level`."""
        check_single_map(height)
        return level(height, **options)

    def overview(
        self,
        levelled: xr.DataArray,
        overview: xr.DataArray,
        options: Mapping[str, Any],
        position: str = "",
        middle: tuple[float, float] | None = None,
    ) -> xr.DataArray:
        """Return a coarser map of a field around a levelled one, levelled alike, with the place of this.

        `position` states it (`arguments.positions`), of the `middle` that the map had before it was cut.
        """
        if self.without_overview:
            text = f"overview: is of a map of a surface that goes on, not of {self.without_overview}"
            raise HeightMapError(f"{text}; leave it out")
        return overview_with_place(levelled, self.level(overview, options), position, middle)

    def window(self, levelled: xr.DataArray, settings: Settings) -> xr.DataArray:
        """Return the map that is solved (y, x; m), by the sections `window`, `instrument` and `form`."""
        return periodic_window(levelled, **window_arguments(levelled, settings))
