"""Height parameters of a levelled map, and whether those among its attributes are of its own heights."""

import math

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import dimensions, spacing
from roughcontact.arguments.si import as_si
from roughcontact.surface.roughness.bearing import BEARING_PARAMETERS, bearing_parameters

HEIGHT_PARAMETERS = ("Sa", "Sq", "Ssk", "Sku", "Sp", "Sv", "Sz", "Sdq", "Sdr", *BEARING_PARAMETERS)
_ROWS_PER_BLOCK = 128
_SUMMIT = "summit_height"  # attribute: highest point above the mean (m) of the map that was described
_SAME = 1e-5  # relative, above the rounding of single precision


@as_si
def height_parameters(height: xr.DataArray) -> dict[str, float]:
    """Return the ISO 25178-2 height parameters, Sdq and Sdr of a levelled map, periodic or not.

    With z the height above the mean of all measured points:

    * `Sa` = mean |z|, `Sq` = sqrt(mean z^2), m
    * `Ssk` = mean z^3 / Sq^3, `Sku` = mean z^4 / Sq^4; NaN for a flat map
    * `Sp` = max z, `Sv` = -min z, `Sz` = Sp + Sv, m
    * `Sdq` = sqrt(mean (dz/dx)^2 + mean (dz/dy)^2) from the differences of neighbouring points, averaged in
      each direction over its pairs of measured points. It depends on the pitch
      (`parameters.rms_gradient` is spectral).
    * `Sdr` = developed area over projected area, less 1: the area of each cell between four measured points
      is averaged over its two divisions into triangles.
    * `Sk` and all others of `bearing.bearing_parameters`.

    Parameters
    ----------
    height : DataArray (y, x), m
        NaN where missing; missing points are ignored.

    Returns
    -------
    dict of float
        `Ssk`, `Sku`, `Sdq`, `Sdr`, `Smr1`, `Smr2` without unit, the others in m.

    References
    ----------
    .. [1] ISO 25178-2:2021, 4.2, 4.4 and 4.5, and D.3 for the developed area.

    Examples
    --------
    >>> from roughcontact.arguments.maps import height_map
    >>> found = height_parameters(height_map([[1.0, -1.0, 1.0, -1.0]], 0.5))
    >>> [found[name] for name in ("Sa", "Sq", "Ssk", "Sku", "Sz", "Sdq")]
    [1.0, 1.0, 0.0, 1.0, 2.0, 4.0]
    """
    values = height.values
    z = values[~np.isnan(values)]
    z = z - z[0]  # exactly zero for a flat map, whatever its height
    z -= z.mean()
    # the standard deviation, of the points that are measured
    sq = math.sqrt(np.mean(z**2))
    slopes = 0.0
    for axis, pitch in enumerate(spacing(height)):
        # between neighbours, as ISO 25178-2 of a map that is not periodic; spectra would see its seams
        steps = np.diff(values, axis=axis)
        steps = steps[~np.isnan(steps)]
        steps /= pitch
        if steps.size:
            slopes += float(np.mean(np.square(steps, out=steps)))
    del steps  # memory may not hold more than is needed of a large map
    # products: a power takes twenty times as long
    scaled = z / (sq or math.nan)
    squares = np.square(scaled)
    return {
        "Sa": float(np.mean(np.abs(z))),
        "Sq": sq,
        "Ssk": float(np.mean(np.multiply(squares, scaled, out=scaled))),
        "Sku": float(np.mean(np.square(squares, out=squares))),
        "Sp": float(z.max()),
        "Sv": float(-z.min()),
        "Sz": float(np.ptp(z)),
        "Sdq": math.sqrt(slopes),
        "Sdr": _developed_excess(values, spacing(height)),
    } | bearing_parameters(z)


def _developed_excess(values: np.ndarray, steps: tuple[float, float]) -> float:
    """Return developed over projected area, less 1, of the cells without missing points."""
    if dimensions(values.shape) == 1:  # the length of a profile
        axis = int(np.argmax(values.shape))
        slopes = np.diff(values, axis=axis) / steps[axis]
        # a gap in a profile leaves its steps out
        return float(np.nanmean(_excess(slopes**2))) if not np.isnan(slopes).all() else 0.0
    corners = np.empty((values.shape[0] - 1, values.shape[1] - 1))
    for start in range(0, len(corners), _ROWS_PER_BLOCK):  # in blocks, to save memory
        rows = values[start : start + _ROWS_PER_BLOCK + 1]
        slope_y, slope_x = (np.diff(rows, axis=axis) / steps[axis] for axis in (0, 1))
        # each corner of a cell belongs to one triangle, with one edge along x and one along y
        corners[start : start + _ROWS_PER_BLOCK] = sum(
            _excess(along_x**2 + along_y**2)
            for along_x in (slope_x[:-1], slope_x[1:])
            for along_y in (slope_y[:, :-1], slope_y[:, 1:])
        )
    return float(np.nanmean(corners)) / 4 if not np.isnan(corners).all() else 0.0


def _excess(squares: np.ndarray) -> np.ndarray:
    """Return sqrt(1 + s) - 1 without cancellation for small s."""
    return squares / (np.sqrt(1 + squares) + 1)


def record_summit(height: xr.DataArray) -> xr.DataArray:
    """Return a map (y, x; m) that tells by its attributes which heights these describe.

    Parameters
    ----------
    height : DataArray (y, x), m

    Returns
    -------
    DataArray
        the same heights.
    """
    return height.assign_attrs({_SUMMIT: _summit(height)})


def renew_parameters(height: xr.DataArray) -> xr.DataArray:
    """Return a map (y, x; m) whose attributes have the height parameters of its own measured points.

    Arithmetic, filters and selections keep those of another map: they are computed again, and the row jitter,
    which only levelling knows, is left out.

    Parameters
    ----------
    height : DataArray (y, x), m

    Returns
    -------
    DataArray
        the same heights.
    """
    if math.isclose(height.attrs.get(_SUMMIT, math.nan), _summit(height), rel_tol=_SAME):
        return height
    return own_parameters(height)


def own_parameters(height: xr.DataArray) -> xr.DataArray:
    """Return a map (y, x; m) with its own height parameters, where others describe what it was cut from.

    Parameters
    ----------
    height : DataArray (y, x), m

    Returns
    -------
    DataArray
        the same heights.
    """
    is_measured = np.isfinite(height) & (height.coords.get("filled", 0) == 0)
    result = height.copy(deep=False)
    result.attrs = {name: value for name, value in height.attrs.items() if name != "row_jitter"}
    return record_summit(result.assign_attrs(height_parameters(height.astype(float).where(is_measured))))


def _summit(height: xr.DataArray) -> float:
    """Return the height of the highest point above the mean (m)."""
    values = np.asarray(height.values, dtype=float)  # no copy of a large map
    finite = np.isfinite(values)
    return float(values.max(initial=-np.inf, where=finite) - values.mean(where=finite))
