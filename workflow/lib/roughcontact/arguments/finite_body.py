"""The form of a body of finite size: attributes of its map, which are written and read here alone."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.kinds import FINITE_BODY

_ROUNDING = 8 * np.finfo(float).eps  # of the range of a map whose form was added and taken off


def form_attributes(radius: Sequence[float] | None, edges: bool) -> dict[str, Any]:
    """Return the attributes of a map on a form of one radius or two (m), or ending at its edges."""
    radii = {"form_radius_x": radius[0], "form_radius_y": radius[-1]} if radius else {}
    return radii | ({"form_edges": 1} if edges else {}) | {"boundary": FINITE_BODY.boundary}


def form_radii(attrs: Mapping[str, Any]) -> list[float]:
    """Return the radii (m; along x, y) of the form that was added to a map, none of a map without one.

    Examples
    --------
    >>> form_radii(form_attributes([1e-3], edges=False)), form_radii({})
    ([0.001, 0.001], [])
    """
    return [attrs[name] for name in ("form_radius_x", "form_radius_y") if name in attrs]


def ends_at_edges(attrs: Mapping[str, Any]) -> bool:
    """Return whether a body ends at the borders of its map."""
    return "form_edges" in attrs


def recover_roughness(body: xr.DataArray) -> xr.DataArray:
    """Return the map (y, x; m) of which `window.finite_body` made a body, without its form."""
    if not (radii := form_radii(body.attrs)):
        return body
    y, x = (body[axis] - (body[axis][0] + body[axis][-1]) / 2 for axis in "yx")
    form = x**2 / (2 * radii[0]) + y**2 / (2 * radii[1])
    roughness = (body + form).transpose("y", "x").assign_attrs(body.attrs)
    if np.ptp(roughness.values) <= _ROUNDING * float(abs(body).max()):  # a flat map, and noise of the sum
        roughness.values[...] = roughness.values.mean()
    return roughness
