"""Magnification curve: the results as a function of the shortest wave that is kept.

A measured surface has no contact area as such, only one for the waves down to some length (Persson 2001): the
shorter the waves that a map resolves, the smaller is the area and the larger the pressure. The window is
solved again without its shortest octave of waves, without two octaves, and so on, on grids of three points
per shortest wave; all these solutions together cost about as much as that of the window.

Waves are cut off by a circle in the plane of wavenumbers, in all directions at the same length. The first
circle holds as many waves as the grid with pixels twice as large, so that it is an octave below those of the
window; the few waves in the corners of a rectangle are shorter than two pixels.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import scipy
import xarray as xr

from roughcontact.fourier import wavenumbers
from roughcontact.maps import height_map, side_lengths, spacing
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.uncertainty.ensemble import solve_member
from roughcontact.uncertainty.headline import quantities_in
from roughcontact.uncertainty.loads import carried_to_all_loads, few_loads
from roughcontact.uncertainty.scales import AREA, PRESSURE

_TOLERANCE = 1e-2  # of the pressure, as of the members of the ensembles
_POINTS_PER_WAVE = 3  # of the shortest: with two, areas of small loads are a tenth and peaks a quarter off
_MIN_WAVES_PER_SIDE = 8  # of the shortest, in the last entry
_MAX_OCTAVES = 4
_LOADS = 4  # at which a window without its shortest waves is solved


def without_shortest_waves(window: xr.DataArray, cutoff: float) -> xr.DataArray:
    """Return a periodic map without waves shorter than a cut-off, on a grid of three points per such wave.

    The spectrum is cut off; neither aliasing nor attenuation changes the waves that stay.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic. An axis of one point keeps it; no grid becomes finer.
    cutoff : float, m
        the shortest wavelength that is kept, shorter than the map.

    Returns
    -------
    DataArray (y, x), m

    Examples
    --------
    >>> import numpy as np
    >>> x = 2 * np.pi * np.arange(32) / 32
    >>> coarse = without_shortest_waves(height_map((np.cos(x) + np.cos(14 * x))[None, :], 1.0), 12.0)
    >>> coarse.shape, bool(np.allclose(coarse, np.cos(x[None, ::4])))
    ((1, 8), True)
    """
    spectrum = np.where(_kept(window, cutoff), np.fft.rfft2(window.values), 0.0)
    sides = side_lengths(window)
    wanted = (
        scipy.fft.next_fast_len(math.ceil(_POINTS_PER_WAVE * side / cutoff), real=True) for side in sides
    )
    points = [min(n, enough) for n, enough in zip(window.shape, wanted, strict=True)]
    ky, kx = (n // 2 for n in points)
    rows = np.r_[0 : points[0] - ky, window.shape[0] - ky : window.shape[0]]
    values = np.fft.irfft2(spectrum[rows, : kx + 1], s=points) * (math.prod(points) / window.size)
    steps = [side / n for side, n in zip(sides, points, strict=True)]
    if 1 in points:  # the pitch across a profile is that along it
        steps = [max(steps)] * 2
    return height_map(values, steps)


def shortest_wave(window: xr.DataArray) -> float:
    """Return the shortest wavelength (m) of a circle of as many waves as a map; of a line two pixels.

    Examples
    --------
    >>> round(shortest_wave(height_map(np.zeros((8, 8)), 1.0)), 3)
    1.772
    """
    if 1 in window.shape:
        return 2 * max(spacing(window))
    return math.sqrt(math.pi * math.prod(spacing(window)))


def _kept(window: xr.DataArray, cutoff: float) -> np.ndarray:
    """Return which waves, in the layout of `rfft2`, are as long as a cut-off or longer."""
    return wavenumbers(window.shape, spacing(window)) * cutoff <= 2 * np.pi * (1 + 1e-9)


def magnification_curve(
    window: xr.DataArray, *, contact: Mapping[str, Any], solved: xr.Dataset
) -> xr.Dataset:
    """Return the results of a window without its shortest waves, octave by octave.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic.
    contact : dict
        keyword arguments of `solve_contact`.
    solved : Dataset
        results of the window itself along `load`: `QUANTITIES`, and answers where these are asked for.

    Returns
    -------
    Dataset
        `{quantity}_at_cutoff` (load, cutoff), the first entry being the result of the window, with the
        coordinates `cutoff_wavelength` (cutoff; m), the shortest wave that is kept, and `gradient_at_cutoff`
        (cutoff), the rms gradient. The pressure in contact is the load over the corrected area, which hardly
        depends on the grid, and at most the hardness. A single entry where the window is too small to be
        coarsened.

    Examples
    --------
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> from roughcontact.uncertainty.headline import headline
    >>> window, problem = rough_reference_surface(64), {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> solved = solve_contact(window, **problem, reduce=headline)
    >>> curve = magnification_curve(window, contact=problem, solved=solved)
    >>> curve["relative_contact_area_at_cutoff"].round(2).values.tolist()
    [[0.34, 0.34, 0.37]]
    """
    names, load = quantities_in(solved), solved["mean_pressure"].values
    some = few_loads(load, _LOADS)
    levels = [{name: solved[name].values for name in names}]
    maps, q = [window], wavenumbers(window.shape, spacing(window))
    by_grid = window.attrs.get("band_reason", "the grid") == "the grid"
    lengths = [max(2 * np.pi / q.max(), 0.0 if by_grid else window.attrs["band_shortest"])]
    sides = [side for side, n in zip(side_lengths(window), window.shape, strict=True) if n > 1]
    for cutoff in shortest_wave(window) * 2.0 ** np.arange(1, _MAX_OCTAVES + 1):
        if not sides or min(sides) < _MIN_WAVES_PER_SIDE * cutoff:
            break
        maps.append(without_shortest_waves(window, cutoff))
        lengths.append(max(2 * np.pi / q[_kept(window, cutoff)].max(), lengths[0]))
        member = solve_member(maps[-1], contact, tolerance=_TOLERANCE, names=names, loads=some)
        levels.append({n: carried_to_all_loads(n, member[n], some, load, solved[n].values) for n in names})
    limit = contact.get("hardness") or math.inf
    for level in levels:
        level[PRESSURE] = np.minimum(solved["mean_pressure"].values / level[AREA], limit)
    return xr.Dataset(
        {
            f"{n}_at_cutoff": (("load", "cutoff"), np.stack([each[n] for each in levels], axis=1))
            for n in names
        },
        coords={
            "cutoff_wavelength": ("cutoff", lengths),
            "gradient_at_cutoff": ("cutoff", [rms_gradient(m) for m in maps]),
        },
    )
