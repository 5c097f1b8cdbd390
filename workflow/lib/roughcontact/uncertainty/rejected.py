"""Load share of the points that levelling rejected as outliers."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.fields import solved_fields
from roughcontact.levelling.rejected import rejected_points, with_rejected_marked
from roughcontact.uncertainty.ensemble import TOLERANCE, loads_of
from roughcontact.window.periodic_window import periodic_window


def rejected_load_share(
    levelled: xr.DataArray, *, window: Mapping[str, Any], contact: Mapping[str, Any]
) -> np.ndarray:
    """Return the share (load) of the load that the rejected points would carry if they were kept.

    The map with them is made periodic and solved again; points blended with one count. NaN where a load
    misses the tolerance or rejected heights are unknown, 0 without rejected points.
    """
    loads = loads_of(contact)
    if "rejected_height" not in levelled.coords and levelled.attrs.get("outliers_rejected", 0):
        return np.full(loads.shape, np.nan)
    copy = levelled.copy(deep=False)  # heights loaded into the copy are freed before the solve
    if not rejected_points(copy).any():
        return np.zeros(loads.shape)
    # periodisation carries the marks into the window, blended edges included
    restored = periodic_window(with_rejected_marked(copy), **window)
    del copy
    rejected = restored["filled"].values != 0
    if not rejected.any():
        return np.zeros(loads.shape)
    share, tolerance = np.full(loads.shape, np.nan), max(TOLERANCE, contact.get("tolerance", 0.0))
    for load, pressure, _ in solved_fields(restored, contact, tolerance=tolerance):
        share[load] = pressure[rejected].sum(dtype=float) / pressure.sum(dtype=float)
    return share
