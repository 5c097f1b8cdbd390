"""Restoration of points that levelling rejected."""

import numpy as np
import xarray as xr


def with_rejected(levelled: xr.DataArray, mask: np.ndarray | None = None) -> xr.DataArray:
    """Return a levelled map with rejected points (within the mask (ny, nx)) restored where filled.

    Those connected to the border stay missing: the window does not change; `filled` is 0 on restored ones.

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
    restored = rejected_points(levelled)
    if mask is not None:
        restored &= mask
    if not restored.any():
        return levelled
    values = np.where(restored, _heights(levelled), levelled.values)
    filled = np.where(restored, 0, levelled["filled"].values).astype(np.int8)
    return levelled.copy(data=values).assign_coords(filled=(("y", "x"), filled))


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

    Examples
    --------
    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> int(with_rejected_marked(level(rough_reference_surface(64)))["filled"].sum())
    0
    """
    marks = rejected_points(levelled).astype(np.int8)
    return with_rejected(levelled).assign_coords(filled=(("y", "x"), marks))


def _heights(levelled: xr.DataArray) -> np.ndarray:
    """Return the levelled heights of rejected points, without caching those read from a file."""
    return levelled["rejected_height"].copy(deep=False).values
