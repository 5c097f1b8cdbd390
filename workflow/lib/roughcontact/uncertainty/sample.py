"""What is said of the subwindows of a map: what they are, and where they tell little."""

import math
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import dimensions
from roughcontact.arguments.quantities import number, percent
from roughcontact.statistics.sealing.percolation import half_way_levels
from roughcontact.uncertainty.scales import CONSTRICTIONS, GAP
from roughcontact.uncertainty.subwindows import Scatter

MEASURAND_IN_WORDS = "the mean of maps of this size all over the surface, in the band of waves of this map"
_KURTOSIS_LIMIT = 8.0  # above it a few places hold most of the mean square height
_LAY_LIMIT = 0.07  # texture aspect ratio below which the subwindows along a lay hold the same ridges
_GROOVE_AREA_LIMIT = 0.2  # of the window: random valleys, of waves up to a third of the map, take up more


def sample_attributes(scatter: Scatter, height: xr.DataArray, *, aspect: float) -> dict[str, Any]:
    """Return what is said of the members of a map of a texture aspect ratio, and what they do not tell.

    `window_advice`, with which `window_flag` ends, is what to do about that.
    """
    has_failure = np.isnan(scatter.members[GAP]).any()
    if scatter.reason:
        flag = "The solution of a surface missed the tolerance." if has_failure else ""
        return {"window_reason": scatter.reason, "window_flag": flag}
    ny, nx = height.isel(scatter.slices[0]).shape
    parts = len(scatter.slices)
    if parts == 1:
        reason = f"The window of {nx} × {ny} points is too small to be divided into parts."
        flag = (
            f"The map is too small to estimate how well it represents the surface: {nx} × {ny} points cannot "
            "be divided into parts."
        )
        return {"window_reason": reason, **_flagged(flag, "Measure more places, or a larger one.")}
    coverage = sum(math.prod(height.isel(area).shape) for area in scatter.slices) / height.size
    reason = (
        f"The ± is for {MEASURAND_IN_WORDS}. {parts} parts of about {nx} × {ny} points, "
        f"{percent(coverage)} of the map, were solved separately; their scatter is held against that of "
        "measured and synthetic surfaces."
    )
    reason += f" {scatter.overview}" if scatter.overview else ""
    if scatter.open_ended:
        axes = " and ".join(name[-1] for name in scatter.open_ended)
        reason += (
            f" Grooves or valleys lead out of the map along {axes}: their narrowest place has no upper "
            "limit, as it may be wider elsewhere."
        )
    flag, advice, kurtosis = "", "", height.attrs.get("Sku", 3.0)
    if has_failure:
        flag = "The solution of a part of the window missed the tolerance."
    elif kurtosis > _KURTOSIS_LIMIT:
        flag = (
            "A few places, deep pits or high peaks, contribute most of the mean square height (Sku = "
            f"{number(kurtosis)}): a single map does not tell their number elsewhere."
        )
        advice = "Measure more places."
    elif aspect < _LAY_LIMIT:
        flag = (
            f"The surface has a lay, and parts along it contain the same ridges: the {parts} parts are worth "
            "no more than three independent ones."
        )
        advice = "Measure a map that is longer across the lay, or more places."
    return {"window_reason": reason, **_flagged(flag, advice)}


def _flagged(flag: str, advice: str) -> dict[str, str]:
    """Return the attributes of a deficiency, and what to do about it."""
    return {"window_flag": f"{flag} {advice}".strip(), "window_advice": advice}


def constrictions_in_grooves(window: xr.DataArray) -> list[str]:
    """Return the critical constrictions that lie in grooves, or valleys, leading out of a periodic map.

    Random heights percolate when about half of the area is open (Dapp, Lücke, Persson and Müser 2012, Phys.
    Rev. Lett. 108, 244301), grooves with much less, here by paths half as long as the map.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface, westergaard_surface
    >>> constrictions_in_grooves(westergaard_surface((64, 64), 1e-6, amplitude=1e-6, wavelength=32e-6))
    ['critical_constriction_y']
    >>> constrictions_in_grooves(rough_reference_surface(64))
    []
    """
    if dimensions(window.shape) == 1:
        return []
    depth = window.values.max() - window.values
    levels = half_way_levels(depth)
    return [name for name in CONSTRICTIONS if np.mean(depth >= levels[name]) < _GROOVE_AREA_LIMIT]
