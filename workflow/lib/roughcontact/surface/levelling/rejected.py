"""Restoration of points that levelling rejected."""

import numpy as np
import xarray as xr


def rejected_points(levelled_map: xr.DataArray) -> np.ndarray:
    """Return the mask (ny, nx) of rejected points that can be restored.

    Examples
    --------
    >>> from roughcontact.surface.levelling.level import level
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> bool(rejected_points(level(rough_reference_surface(64))).any())
    False
    """
    if "rejected_height" not in levelled_map.coords:
        return np.zeros(levelled_map.shape, dtype=bool)
    is_rejected = ~np.isnan(_heights(levelled_map))
    # points open to the border were left out of the map by filling, and stay out
    is_filled = levelled_map.attrs.get("fill_method") == "none" or ~np.isnan(levelled_map.values)
    return np.asarray(is_rejected & is_filled)


def restore_rejected(levelled_map: xr.DataArray) -> xr.DataArray:
    """Return a levelled map with rejected points restored, and the coordinate `filled` 1 on these alone.

    Those connected to the border stay missing: the window does not change.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.surface.levelling.level import level
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> height[20, 30] += 1.0
    >>> levelled = level(height, form="none")
    >>> restored = restore_rejected(levelled)
    >>> bool(np.allclose(restored, height)), bool(np.allclose(levelled, height))
    (True, False)
    """
    mask = rejected_points(levelled_map)
    if mask.any():
        levelled_map = levelled_map.copy(data=np.where(mask, _heights(levelled_map), levelled_map.values))
    return levelled_map.assign_coords(filled=(("y", "x"), mask.astype(np.int8)))


def _heights(levelled_map: xr.DataArray) -> np.ndarray:
    """Return the levelled heights of rejected points, without caching those read from a file."""
    return levelled_map["rejected_height"].copy(deep=False).values
