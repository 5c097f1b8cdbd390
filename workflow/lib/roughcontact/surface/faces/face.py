"""One measured face: heights at any position, beyond its edges if it is periodic."""

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_map
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.measurement import json_attribute
from roughcontact.surface.levelling.forms import form_from_record
from roughcontact.surface.window.periodisation import periodic_heights

POINT_TOLERANCE = 1e-6  # of a step: positions as close to a point take its height
_SPLINE_MARGIN = 24  # points; the influence on a cubic spline falls by a factor of 0.27 per point


class Face:
    """A map (y, x; m; NaN missing) as a function of position, interpolated, continued if periodic.

    `values` (ny, nx; m) have the form restored if its removal made the map aperiodic; `filled` is the mask of
    filled points, `step` (dy, dx; m), `lengths` (y, x; m) the sides, one step longer than from first to last
    point.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> face = Face(height_map(np.arange(6.0).reshape(2, 3), 1.0))
    >>> face.at(np.array([0.5, 0.0]), np.array([1.0, 5.0]))  # the last point, and one beyond the edge
    (array([ 5., nan]), array([False, False]))
    """

    def __init__(self, height: xr.DataArray):
        values = check_map(height)
        form_record = json_attribute(height.attrs, "form_removed")
        form = form_from_record(form_record, height["y"].values, height["x"].values)
        # periodic with its form: continued with it
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
        """Return heights (NaN where not measured), and the mask of those that depend on filled points.

        The positions y, x (m, arrays of one shape) are relative to the middle of the map.
        """
        step, points = (np.reshape(sides, (2, *(1,) * y.ndim)) for sides in (self.step, self.shape))
        # in pixels from the first point
        indices = np.array([y, x]) / step + (points - 1) / 2
        # points that meet need no interpolation, which would smooth them
        nearest = np.rint(indices)
        indices = np.where(np.abs(indices - nearest) < POINT_TOLERANCE, nearest, indices)
        if self.periodic:
            inside, indices = np.ones(y.shape, dtype=bool), indices % points
        else:
            inside = ((indices >= 0) & (indices <= points - 1)).all(axis=0)
            # any valid place: the height there is masked below
            indices = np.clip(indices, 0, points - 1)
        if np.array_equal(indices, np.rint(indices)):
            index = tuple(indices.astype(int))
            values, on_filled = self.values[index], self.filled[index]
        else:
            values, on_filled = self._interpolate(indices)
        return np.where(inside, values, np.nan), on_filled & inside

    def _interpolate(self, indices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return heights and mask between the points; positions next to a missing point are missing."""
        from scipy.interpolate import make_interp_spline
        from scipy.ndimage import distance_transform_edt, map_coordinates

        mode = "grid-wrap" if self.periodic else "mirror"
        missing = np.isnan(self.values)
        values = self.values
        if missing.any():  # the spline needs a height everywhere; these points are masked again below
            nearest = distance_transform_edt(missing, return_distances=False, return_indices=True)
            values = values[tuple(nearest)]  # by the nearest measured height
        # beyond the rim the cubic of the last intervals (not-a-knot); a point reflection has no curvature
        rim = [0 if self.periodic or n == 1 else _SPLINE_MARGIN for n in self.shape]
        for axis, (n, margin) in enumerate(zip(self.shape, rim, strict=True)):
            if margin:
                # few points allow no cubic
                spline = make_interp_spline(np.arange(n), values, k=min(3, n - 1), axis=axis)
                margins = spline(np.arange(-margin, 0)), spline(np.arange(n, n + margin))
                values = np.concatenate([margins[0], values, margins[1]], axis=axis)
        spline_indices = [p + margin for p, margin in zip(indices, rim, strict=True)]
        spline_values = map_coordinates(values, spline_indices, order=3, mode=mode)
        neighbours = [
            map_coordinates(flags.astype(float), indices, order=1, mode=mode) > POINT_TOLERANCE
            for flags in (missing, self.filled)
        ]
        return np.where(neighbours[0], np.nan, spline_values), neighbours[1]
