"""A body of finite size, of which a map is the roughness."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from roughcontact.arguments.finite_body import form_attributes
from roughcontact.arguments.maps import spacing


def finite_body(
    roughness: xr.DataArray, *, radius: Sequence[float] | None = None, edges: bool = False
) -> xr.DataArray:
    """Return a map (y, x; m) on a paraboloid of one radius or two (m; along x, y), or ending at its edges."""
    heights, steps = roughness.values.astype(float), spacing(roughness)
    if radius:
        # the top of the form is in the middle of the map
        y, x = ((np.arange(n) - (n - 1) / 2) * d for n, d in zip(heights.shape, steps, strict=True))
        heights = heights - x**2 / (2 * radius[0]) - y[:, None] ** 2 / (2 * radius[-1])
    return roughness.copy(data=heights).assign_attrs(form_attributes(radius, edges))
