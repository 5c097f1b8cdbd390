"""Load share of the points that levelling rejected as outliers."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.fields import solved_fields
from roughcontact.surface.levelling.rejected import rejected_points, restore_rejected
from roughcontact.surface.window.periodic_window import periodic_window
from roughcontact.uncertainty.ensemble import TOLERANCE, loads_of


def rejected_load_share(
    levelled_map: xr.DataArray, *, window: Mapping[str, Any], contact: Mapping[str, Any]
) -> np.ndarray:
    """Return the share (load) of the load that the rejected points would carry if they were kept.

    The map with them is made periodic and solved again; points blended with one count. NaN where a load
    misses the tolerance or rejected heights are unknown, 0 without rejected points.
    """
    loads = loads_of(contact)
    if "rejected_height" not in levelled_map.coords and levelled_map.attrs.get("outliers_rejected", 0):
        return np.full(loads.shape, np.nan)
    copy = levelled_map.copy(deep=False)  # heights loaded into the copy are freed before the solve
    if not rejected_points(copy).any():
        return np.zeros(loads.shape)
    # periodisation carries the marks into the window, blended edges included
    restored_map = periodic_window(restore_rejected(copy), **window)
    del copy
    is_rejected = restored_map["filled"].values != 0
    if not is_rejected.any():
        return np.zeros(loads.shape)
    share, tolerance = np.full(loads.shape, np.nan), max(TOLERANCE, contact.get("tolerance", 0.0))
    for load, pressure, *_ in solved_fields(restored_map, contact, tolerance=tolerance):
        share[load] = pressure[is_rejected].sum(dtype=float) / pressure.sum(dtype=float)
    return share
