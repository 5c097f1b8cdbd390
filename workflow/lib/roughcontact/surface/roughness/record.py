"""Height parameters among the attributes of a map, and whether they are those of its heights."""

import math

import numpy as np
import xarray as xr

from roughcontact.surface.roughness.heights import height_parameters

_SUMMIT = "summit_height"  # attribute: highest point above the mean (m) of the map that was described
_SAME = 1e-5  # relative, above the rounding of single precision


def record_summit(height: xr.DataArray) -> xr.DataArray:
    """Return a map (y, x; m) that tells by its attributes which heights these describe."""
    return height.assign_attrs({_SUMMIT: _summit(height)})


def renew_parameters(height: xr.DataArray) -> xr.DataArray:
    """Return a map (y, x; m) whose attributes have the height parameters of its own measured points.

    Arithmetic, filters and selections keep those of another map: they are computed again, and the row jitter,
    which only levelling knows, is left out.
    """
    if math.isclose(height.attrs.get(_SUMMIT, math.nan), _summit(height), rel_tol=_SAME):
        return height
    return own_parameters(height)


def own_parameters(height: xr.DataArray) -> xr.DataArray:
    """Return a map (y, x; m) with its own height parameters, where others describe what it was cut from."""
    points = height.where(height["filled"] == 0) if "filled" in height.coords else height
    result = height.copy(deep=False)
    result.attrs = {name: value for name, value in height.attrs.items() if name != "row_jitter"}
    return record_summit(result.assign_attrs(height_parameters(points.astype(float))))


def _summit(height: xr.DataArray) -> float:
    """Return the height of the highest point above the mean (m)."""
    values = np.asarray(height.values, dtype=float)  # no copy of a large map
    finite = np.isfinite(values)
    return float(values.max(initial=-np.inf, where=finite) - values.mean(where=finite))
