"""One measured face: its heights on its points, between them and, where it is periodic, beyond its edges."""

import json

import numpy as np
import xarray as xr

from roughcontact.checking import check_map
from roughcontact.levelling.forms import form_from_record
from roughcontact.maps import spacing
from roughcontact.window.periodisation import periodic_heights

ON_POINT = 1e-6  # of a step: so near to a point, its height is taken as it is
_RIM = 12  # points beyond which a cubic spline feels nothing: each has 0.27 of the effect of the one before


class Face:
    """A map with what lies between its points and, where it is periodic, beyond its edges.

    Parameters
    ----------
    height : DataArray (y, x), m
        from `level`; NaN where missing.

    Attributes
    ----------
    height : DataArray (y, x), m
        as given.
    name : str
        of its file.
    periodic : bool
        whether the map goes on beyond its edges.
    values : array (ny, nx), m
        heights; of a map that levelling broke, with the form put back.
    filled : bool array (ny, nx)
        points that were filled in.
    shape : (ny, nx)
    step : (dy, dx), m
    lengths : (y, x), m
        sides, a step longer than from the first point to the last.
    middle : (y, x), m
        where the middle lies in the coordinates of the map.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.maps import height_map
    >>> face = Face(height_map(np.arange(6.0).reshape(2, 3), 1.0))
    >>> face.at(np.array([0.5, 0.0]), np.array([1.0, 5.0]))  # the last point, and one beyond the edge
    (array([ 5., nan]), array([False, False]))
    """

    def __init__(self, height: xr.DataArray):
        values = check_map(height)
        removed = json.loads(height.attrs.get("form_removed", "{}"))
        form = form_from_record(removed, height["y"].values, height["x"].values)
        periodic = periodic_heights(values, form)
        self.height = height
        self.name: str = height.attrs.get("source_file") or "the map"
        self.periodic = periodic is not None
        self.values = values if periodic is None else periodic[0]
        self.filled = np.asarray(height.coords.get("filled", np.zeros(values.shape))) > 0
        self.shape = values.shape
        self.step = spacing(height)
        self.lengths = tuple(n * d for n, d in zip(self.shape, self.step, strict=True))
        self.middle = tuple(float(height[d].values[[0, -1]].mean()) for d in ("y", "x"))

    def at(self, y: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return heights and flags of filled points at any positions.

        Parameters
        ----------
        y, x : arrays of one shape, m
            positions off the middle of the map.

        Returns
        -------
        heights : array, m
            NaN where not measured.
        filled : bool array
            whether the height rests on a point that was filled in.
        """
        places = [p / d + (n - 1) / 2 for p, d, n in zip((y, x), self.step, self.shape, strict=True)]
        places = [np.where(np.abs(p - np.rint(p)) < ON_POINT, np.rint(p), p) for p in places]
        if self.periodic:
            inside = np.ones(places[0].shape, dtype=bool)
            places = [p % n for p, n in zip(places, self.shape, strict=True)]
        else:
            inside = np.logical_and.reduce(
                [(p >= 0) & (p <= n - 1) for p, n in zip(places, self.shape, strict=True)]
            )
            places = [np.clip(p, 0, n - 1) for p, n in zip(places, self.shape, strict=True)]
        if all(np.array_equal(p, np.rint(p)) for p in places):
            index = tuple(p.astype(int) for p in places)
            values, filled = self.values[index], self.filled[index]
        else:
            values, filled = self._between(places)
        return np.where(inside, values, np.nan), filled & inside

    def _between(self, places: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Return heights and flags between the points; a point next to a missing one is missing."""
        from scipy.ndimage import distance_transform_edt, map_coordinates

        beyond = "grid-wrap" if self.periodic else "mirror"
        missing = np.isnan(self.values)
        values = self.values
        if missing.any():  # the spline needs a height everywhere; these are masked again
            nearest = distance_transform_edt(missing, return_distances=False, return_indices=True)
            values = values[tuple(nearest)]
        # mirrored, the spline would lie flat at the rim: there it is continued with its slope
        rim = [0 if self.periodic or n == 1 else _RIM for n in self.shape]
        continued = np.pad(values, [(n, n) for n in rim], mode="reflect", reflect_type="odd")
        at = [p + n for p, n in zip(places, rim, strict=True)]
        between = map_coordinates(continued, at, order=3, mode=beyond)
        near = [
            map_coordinates(flags.astype(float), places, order=1, mode=beyond) > ON_POINT
            for flags in (missing, self.filled)
        ]
        return np.where(near[0], np.nan, between), near[1]
