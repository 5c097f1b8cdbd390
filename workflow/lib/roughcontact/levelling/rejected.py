"""Restoration of points that levelling rejected."""

import numpy as np
import xarray as xr


def rejected_points(levelled: xr.DataArray) -> np.ndarray:
    """Return the mask (ny, nx) of rejected points that can be restored.

    Examples
    --------
    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> bool(rejected_points(level(rough_reference_surface(64))).any())
    False
    """
    if "rejected_height" not in levelled.coords:
        return np.zeros(levelled.shape, dtype=bool)
    rejected = ~np.isnan(_heights(levelled))
    closed = levelled.attrs.get("fill_method") == "none" or ~np.isnan(levelled.values)
    return np.asarray(rejected & closed)


def with_rejected_marked(levelled: xr.DataArray) -> xr.DataArray:
    """Return a levelled map with rejected points restored, and the coordinate `filled` 1 on these alone.

    Those connected to the border stay missing: the window does not change.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> height[20, 30] += 1.0
    >>> levelled = level(height, form="none")
    >>> restored = with_rejected_marked(levelled)
    >>> bool(np.allclose(restored, height)), bool(np.allclose(levelled, height))
    (True, False)
    """
    restored = rejected_points(levelled)
    if restored.any():
        levelled = levelled.copy(data=np.where(restored, _heights(levelled), levelled.values))
    return levelled.assign_coords(filled=(("y", "x"), restored.astype(np.int8)))


def _heights(levelled: xr.DataArray) -> np.ndarray:
    """Return the levelled heights of rejected points, without caching those read from a file."""
    return levelled["rejected_height"].copy(deep=False).values
