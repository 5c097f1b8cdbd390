"""Before the solver: how the map of each kind of problem is levelled, and made the map that is solved.

Holds one module for each way. `evaluation.kinds` goes on from them; they are apart from it so that an edit of
the solver does not make Snakemake prepare every map again. May import what lies below `surface`.
"""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from roughcontact.surface.preparation.finite_body import FiniteBodyPreparation
from roughcontact.surface.preparation.periodic_map import MapPreparation
from roughcontact.surface.preparation.profiles import ProfilesPreparation

# the first that includes a map prepares it; the last one includes all
PREPARATIONS: tuple[type[MapPreparation], ...] = (ProfilesPreparation, FiniteBodyPreparation, MapPreparation)


def preparation_of(height: xr.DataArray, settings: Mapping[str, Any]) -> MapPreparation:
    """Return what levels a map (y, x; m), and makes of it the map that is solved.

    Of the settings `contact` and `form` count, where they are among them.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> preparation = preparation_of(rough_reference_surface(64), {"contact": {"boundary": "free"}})
    >>> type(preparation).__name__
    'FiniteBodyPreparation'
    """
    return next(preparation for preparation in PREPARATIONS if preparation.includes(height, settings))()
