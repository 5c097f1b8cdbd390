"""Discretisation: what finer pixels of the same waves change, taken off by extrapolation to no pixels at all.

The surface is taken to be the Fourier interpolant of the map (`refined`), solved again with pixels half as
large. For an error of order 2 in the pixel size the limit is (Richardson extrapolation)

    t(0) = t(h) + 4/3 (t(h/2) - t(h)),

t being a quantity on its scale. Of 39 windows of measured and synthetic surfaces, solved with pixels a
quarter as large, the median error at p/(E* g) = 0.02 to 0.4 falls from 1.6 to 0.7 % (area), 8 to 2.5 %
(largest pressure), 0.13 to 0.05 % (mean gap) and 0.6 to 0.5 % (conductance); the mean pressure over whole
pixels, 11 % too low, becomes the load over the corrected area. What remains uncertain is 1.25 times
the change, and no smaller than a floor that the bank of errors gives (`calibration`), and for the area
than chance: the random position of the edge of the contact within its pixel, 0.5 sqrt(M)/N for M switches
between contact and non-contact among N points. M follows from the
correction of the area by the perimeter.

A large window is represented by a part of it around the highest pressure.

References
----------
Richardson (1911), Phil. Trans. R. Soc. A 210, 307; Roache (1994), J. Fluids Eng. 116, 405.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.maps import refined, spacing
from roughcontact.statistics.contact_geometry import PERIMETER_CORRECTION
from roughcontact.uncertainty.calibration import discretisation_floor
from roughcontact.uncertainty.ensemble import solve_member
from roughcontact.uncertainty.loads import at_all_loads, few_loads
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, GAP, PEAK, to_scale
from roughcontact.window.periodisation import periodic_plus_smooth

CORRECTED = (AREA, GAP, PEAK)  # the pressure in contact follows from the area
ORDER = 2  # of the error in the pixel size
_TOLERANCE = 1e-3  # of the pressure, on both grids
_LOADS = 3
_REMAINING = 1.25  # of the change, that stays uncertain after the correction
_EDGE_NOISE = 0.5  # pixels per switch between contact and non-contact; random
_LEAST_POINTS = 128**2  # windows up to this size are refined whole, larger ones on a quarter of their points


def discretisation_error(
    window: xr.DataArray,
    *,
    contact: Mapping[str, Any],
    values: Mapping[str, np.ndarray],
    pixel_share: np.ndarray,
    peak_index: int,
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return for each quantity the correction to no pixels, and what stays uncertain of it.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic.
    contact : dict
        keyword arguments of `solve_contact`.
    values : mapping
        quantity -> array (load) of the window.
    pixel_share : array (load)
        share of the pixels in contact, from which the area was corrected.
    peak_index : int
        index of the point of the highest pressure, counted row by row.

    Returns
    -------
    dict
        quantity -> change to no pixels and half-width (load), both on the scale of the quantity. Those not in
        `CORRECTED` are not to be corrected: the change is in their half-width.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> window, problem = rough_reference_surface(64), {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> values = solve_member(window, problem, tolerance=1e-3, names=["relative_contact_area"])
    >>> share = values["relative_contact_area"] + 0.02
    >>> found = discretisation_error(
    ...     window, contact=problem, values=values, pixel_share=share, peak_index=0
    ... )
    >>> correction, half_width = found["relative_contact_area"]
    >>> bool(abs(correction[0]) < 0.05)
    True
    """
    load = np.atleast_1d(np.asarray(contact["mean_pressure"], float))
    part, names = _part_around(window, peak_index), list(values)
    solved = few_loads(load, _LOADS)
    coarse = solve_member(part, contact, tolerance=_TOLERANCE, names=names, loads=solved)
    fine = solve_member(refined(part, 2), contact, tolerance=_TOLERANCE, names=names, loads=solved)
    found = {}
    for name in names:
        change = to_scale(name, fine[name]) - to_scale(name, coarse[name])
        if name in CONSTRICTIONS:  # a length, as the gap beside it
            with np.errstate(divide="ignore", invalid="ignore"):
                change = np.nan_to_num(change * values[GAP][solved] / coarse[GAP])
            found[name] = np.zeros(load.shape), 2 * np.abs(at_all_loads(change, solved, load))
            continue
        # full contact: nothing is open, nothing changes
        change = at_all_loads(np.where(np.isfinite(change), change, 0.0), solved, load)
        correction = change * 2**ORDER / (2**ORDER - 1)
        remaining = _REMAINING * change if name in CORRECTED else 2 * change
        found[name] = correction, np.hypot(remaining, discretisation_floor(name))
    if AREA in found:
        correction, half_width = found[AREA]
        switches = np.maximum(pixel_share - values[AREA], 0.0) / PERIMETER_CORRECTION  # M/N
        chance = values[AREA] + _EDGE_NOISE * np.sqrt(switches / part.size)
        found[AREA] = correction, np.hypot(half_width, to_scale(AREA, chance) - to_scale(AREA, values[AREA]))
    return found


def _part_around(window: xr.DataArray, index: int) -> xr.DataArray:
    """Return a periodic quarter of a window around a point, or the window itself if it is small."""
    if window.size <= _LEAST_POINTS:
        return window
    share = max(0.25, _LEAST_POINTS / window.size)
    sides = [
        n if n == 1 else 2 * math.ceil(n * share ** (1 / _extended_axes(window)) / 2) for n in window.shape
    ]
    middle = np.unravel_index(index, window.shape)
    rows, columns = (
        np.arange(at - side // 2, at - side // 2 + side) % n
        for at, side, n in zip(middle, sides, window.shape, strict=True)
    )
    heights = window.values[rows[:, None], columns]
    return window[: sides[0], : sides[1]].copy(data=periodic_plus_smooth(heights, spacing(window)))


def _extended_axes(window: xr.DataArray) -> int:
    """Return the number of axes with more than one point."""
    return sum(n > 1 for n in window.shape)
