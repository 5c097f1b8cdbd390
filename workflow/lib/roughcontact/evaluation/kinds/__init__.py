"""Kinds of problem: each module alone knows what differs for its kind; everything else asks `kind_of`.

Holds the loads of a kind, its solution and its ±; each inherits from `surface.preparation` how its map is
levelled and windowed. May import what lies below `report`; a new kind is a module here and a line in `KINDS`.
"""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from roughcontact.evaluation.kinds.finite_body import FiniteBody
from roughcontact.evaluation.kinds.local_scale import LocalScale
from roughcontact.evaluation.kinds.periodic_map import PeriodicMap
from roughcontact.evaluation.kinds.profiles.ridges import Ridges
from roughcontact.evaluation.kinds.profiles.surface_behind import SurfaceBehindProfiles

KINDS: tuple[type[PeriodicMap], ...] = (SurfaceBehindProfiles, FiniteBody, Ridges, PeriodicMap)


def kind_of(height: xr.DataArray, settings: Mapping[str, Any]) -> PeriodicMap:
    """Return the kind of problem of a map (y, x; m), or its window, by the complete sections of the settings.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> kind_of(rough_reference_surface(64), {"contact": {"boundary": "free"}}).facts.name
    'finite body'
    """
    kind = next(kind for kind in KINDS if kind.includes(height, settings))()
    return LocalScale(kind) if LocalScale.includes(height, settings) else kind
