"""Load share of the points that levelling rejected as outliers."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.fields import solved_fields
from roughcontact.levelling.rejected import rejected_points, with_rejected_marked
from roughcontact.window.periodic_window import periodic_window

_TOLERANCE = 1e-3  # of the pressure: one percent of the load share is enough


def rejected_load_share(
    levelled: xr.DataArray, *, window: Mapping[str, Any], contact: Mapping[str, Any]
) -> xr.DataArray:
    """Return the share of the load that the rejected points would carry if they were kept.

    The map is made periodic and solved again with these points restored, to a tolerance of 1e-3 of the
    pressure. Points that the periodisation blends with a rejected one count as rejected.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`.
    window, contact : dict
        keyword arguments of `periodic_window` and `solve_contact` (loads included).

    Returns
    -------
    DataArray (load)
        0 where nothing was rejected; NaN where a load misses the tolerance, or where the heights of the
        rejected points are unknown.

    Examples
    --------
    A single point far above all others carries nearly the whole load.

    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> height[20, 30] += 10.0
    >>> problem = {"contact_modulus": 1.0, "mean_pressure": [1e-3]}
    >>> rejected_load_share(level(height), window={}, contact=problem).round(2).values
    array([1.])
    """
    loads = np.atleast_1d(np.asarray(contact["mean_pressure"], float))
    unknown = "rejected_height" not in levelled.coords and levelled.attrs.get("outliers_rejected", 0)
    share = np.full(loads.shape, np.nan if unknown else 0.0)
    own = levelled.copy(deep=False)  # heights loaded into the copy are freed before the solve
    if rejected_points(own).any():
        # periodisation carries the marks into the window, blended edges included
        kept = periodic_window(with_rejected_marked(own), **window)
        del own
        on_rejected = kept["filled"].values != 0
        if on_rejected.any():
            share = np.full(loads.shape, np.nan)
            tolerance = max(_TOLERANCE, contact.get("tolerance", 0.0))
            for solution in solved_fields(kept, contact, tolerance=tolerance):
                if solution.error_bound <= tolerance:
                    pressure = solution.pressure
                    share[solution.load_index] = pressure[on_rejected].sum(dtype=float) / pressure.sum(
                        dtype=float
                    )
    return xr.DataArray(share, dims="load", name="rejected_load_share")
