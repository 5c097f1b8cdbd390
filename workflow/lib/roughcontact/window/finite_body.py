"""The map that is solved: the periodic window, or a body of finite size of which the map is the roughness."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.errors import HeightMapError
from roughcontact.maps import RIM, height_map, spacing
from roughcontact.window.instrument import window_arguments
from roughcontact.window.periodic_window import periodic_window

_DEPTH = 10.0  # of the points beyond an edge, over the range of heights or a thousandth of the side


def solved_map(levelled: xr.DataArray, settings: Mapping[str, Any]) -> xr.DataArray:
    """Return the map to solve (y, x; m) of a levelled one, by the sections `window`, `form` and `contact`."""
    if settings.get("contact", {}).get("boundary") != "free":
        return periodic_window(levelled, **window_arguments(levelled, settings))
    arguments = {key: settings["window"][key] for key in ("min_share",) if key in settings["window"]}
    form = {key: settings["form"][key] for key in ("radius", "edges")}
    return finite_body(periodic_window(levelled, method="raw", **arguments), **form)


def finite_body(
    roughness: xr.DataArray,
    *,
    radius: Sequence[float] | None = None,
    edges: bool = False,
    rim: int = RIM,
) -> xr.DataArray:
    """Return a map (y, x; m) on a paraboloid of one radius or two (m; along x, y), or ending at its edges.

    `rim`: points beyond the edges.
    """
    heights, steps = roughness.values.astype(float), spacing(roughness)
    if min(heights.shape) < 2:
        raise HeightMapError("a profile is no body of finite size: solve it with contact.boundary: periodic")
    if radius:
        y, x = ((np.arange(n) - (n - 1) / 2) * d for n, d in zip(heights.shape, steps, strict=True))
        heights = heights - x**2 / (2 * radius[0]) - y[:, None] ** 2 / (2 * radius[-1])
    stated = {"form_radius_x": radius[0], "form_radius_y": radius[-1]} if radius else {}
    margin = 0
    if edges:
        margin, stated["form_edges"] = rim, 1
        below = float(heights.min()) - _DEPTH * max(np.ptp(heights), max(heights.shape) * max(steps) * 1e-3)
        heights = np.pad(heights, rim, constant_values=below)
    body = height_map(heights, steps)
    first = {axis: float(roughness[axis][0]) - margin * step for axis, step in zip("yx", steps, strict=True)}
    body = body.assign_coords({axis: body[axis] - body[axis][0] + first[axis] for axis in "yx"})
    return body.assign_attrs(roughness.attrs | stated | {"boundary": "free"})
