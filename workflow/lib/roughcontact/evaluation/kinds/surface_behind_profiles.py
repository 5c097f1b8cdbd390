"""The surface behind profiles: an example of the surfaces with their spectrum is solved."""

from collections.abc import Callable
from functools import partial

import xarray as xr

from roughcontact.evaluation.kinds.periodic_map import PeriodicMap, SolvedMap
from roughcontact.surface.preparation.profiles import ProfilesPreparation
from roughcontact.uncertainty.profiles.scatter import scatter_of_surfaces
from roughcontact.uncertainty.subwindows import Scatter


class SurfaceBehindProfiles(ProfilesPreparation, PeriodicMap):
    """A periodic map drawn from the spectrum of profiles."""

    name = "surface behind profiles"

    def scatter(self, solution: SolvedMap) -> Callable[..., Scatter]:
        """Return the scatter of the surfaces that the profiles leave open."""
        return partial(scatter_of_surfaces, solution.levelled)

    def measured_surface(self, solution: SolvedMap) -> xr.DataArray:
        """Return the window itself: the profiles are lines on such a surface."""
        return solution.window
