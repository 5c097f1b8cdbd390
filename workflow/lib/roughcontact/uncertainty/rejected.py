"""The points that levelling rejected, put back: what load they would carry."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.solve import solve_contact
from roughcontact.uncertainty.ensemble import solver_arguments
from roughcontact.uncertainty.headline import fields_of
from roughcontact.window.periodic_window import periodic_window

_TOLERANCE = 1e-3  # of the pressure: the share is given to a percent


def with_rejected(levelled: xr.DataArray, which: np.ndarray | None = None) -> xr.DataArray:
    """Return a levelled map with rejected points put back where they were filled in.

    Those that are open to the border stay missing, so that the window is the same.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`.
    which : bool array (ny, nx) or None
        points to put back; all that were rejected where none are given.

    Returns
    -------
    DataArray (y, x), m
        the coordinate `filled` is 0 on the points put back.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> height[20, 30] += 1.0
    >>> levelled = level(height, form="none")
    >>> bool(np.allclose(with_rejected(levelled), height)), bool(np.allclose(levelled, height))
    (True, False)
    """
    back = rejected_points(levelled)
    if which is not None:
        back &= which
    if not back.any():
        return levelled
    values = np.where(back, levelled["rejected_height"].values, levelled.values)
    filled = np.where(back, 0, levelled["filled"].values).astype(np.int8)
    return levelled.copy(data=values).assign_coords(filled=(("y", "x"), filled))


def rejected_points(levelled: xr.DataArray) -> np.ndarray:
    """Return where a levelled map could have a rejected point put back.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`.

    Returns
    -------
    bool array (ny, nx)

    Examples
    --------
    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> bool(rejected_points(level(rough_reference_surface(64))).any())
    False
    """
    if "rejected_height" not in levelled.coords:
        return np.zeros(levelled.shape, dtype=bool)
    rejected = ~np.isnan(levelled["rejected_height"].values)
    closed = levelled.attrs.get("fill_method") == "none" or ~np.isnan(levelled.values)
    return np.asarray(rejected & closed)


def rejected_load_share(
    levelled: xr.DataArray, *, window: Mapping[str, Any], contact: Mapping[str, Any]
) -> xr.DataArray:
    """Return the share of the load that the rejected points would carry if they were kept.

    The map is made periodic and solved once more with them, to a tolerance of 1e-3 of the pressure. Points
    that the periodic window blends with a rejected one count as rejected.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`.
    window, contact : dict
        keyword arguments of `periodic_window` and `solve_contact` (loads included).

    Returns
    -------
    DataArray (load)
        0 where nothing was rejected; NaN where a load misses the tolerance, or where the points are no
        longer known (the sum of two faces).

    Raises
    ------
    ConvergenceError
        where a load misses the tolerance, unless `contact` says otherwise.

    Examples
    --------
    One point far above all others carries next to everything.

    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> height[20, 30] += 10.0
    >>> problem = {"contact_modulus": 1.0, "mean_pressure": [1e-3]}
    >>> rejected_load_share(level(height), window={}, contact=problem).round(2).values
    array([1.])
    """
    loads = np.atleast_1d(np.asarray(contact["mean_pressure"], float))
    rejected = rejected_points(levelled)
    unknown = "rejected_height" not in levelled.coords and levelled.attrs.get("outliers_rejected", 0)
    share = np.full(loads.shape, np.nan if unknown else 0.0)
    if rejected.any():
        # the flags follow the points into the window, blended edges included
        marked = with_rejected(levelled).assign_coords(filled=(("y", "x"), rejected.astype(np.int8)))
        kept = periodic_window(marked, **window)
        on_rejected = kept["filled"].values != 0
        if on_rejected.any():

            def count(solved: xr.Dataset) -> xr.Dataset:
                shares = [pressure[on_rejected].sum() / pressure.sum() for pressure, _ in fields_of(solved)]
                return xr.Dataset({"share": ("load", shares)})

            found = solve_contact(kept, **solver_arguments(contact, tolerance=_TOLERANCE), reduce=count)
            share = np.where(found["converged"].values == 1, found["share"].values, np.nan)
    return xr.DataArray(share, dims="load", name="rejected_load_share")
