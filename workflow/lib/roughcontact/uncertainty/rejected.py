"""Load share of the points that levelling rejected as outliers."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.fields import solved_fields
from roughcontact.levelling.rejected import rejected_points, with_rejected_marked
from roughcontact.uncertainty.ensemble import CHANGE_TOLERANCE, loads_of
from roughcontact.window.periodic_window import periodic_window


def rejected_load_share(
    levelled: xr.DataArray, *, window: Mapping[str, Any], contact: Mapping[str, Any]
) -> np.ndarray:
    """Return the share (load) of the load that the rejected points would carry if they were kept.

    The map is made periodic and solved again with these points restored. Points that the periodisation blends
    with a rejected one count as rejected. 0 where nothing was rejected; NaN where a load misses the
    tolerance, or where the heights of the rejected points are unknown.

    Examples
    --------
    A single point far above all others carries nearly the whole load.

    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> height[20, 30] += 10.0
    >>> problem = {"contact_modulus": 1.0, "mean_pressure": [1e-3]}
    >>> rejected_load_share(level(height), window={}, contact=problem).round(2)
    array([1.])
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
    share, tolerance = np.full(loads.shape, np.nan), max(CHANGE_TOLERANCE, contact.get("tolerance", 0.0))
    for solution in solved_fields(restored, contact, tolerance=tolerance):
        if solution.error_bound <= tolerance:
            pressure = solution.pressure
            share[solution.load_index] = pressure[rejected].sum(dtype=float) / pressure.sum(dtype=float)
    return share
