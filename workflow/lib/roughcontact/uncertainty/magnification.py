"""Magnification curve: the results as a function of the shortest wave that is kept.

A measured surface has no contact area as such, only one for the waves down to some length (Persson 2001): the
shorter the waves that a map resolves, the smaller is the area and the larger the pressure. The window is
solved again without its shortest octave of waves on a grid half as fine, then without two octaves, and so on;
all these solutions together cost a third of that of the window.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.maps import height_map, spacing
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.uncertainty.answers import counter_of, quantities_in
from roughcontact.uncertainty.ensemble import solve_member

_TOLERANCE = 1e-2  # of the pressure, as of the members of the ensembles
_MIN_POINTS_PER_SIDE = 16  # of the coarsest grid
_MAX_OCTAVES = 4


def without_shortest_waves(window: xr.DataArray, factor: int) -> xr.DataArray:
    """Return a periodic map on a grid `factor` times as coarse, without the waves that it cannot hold.

    The spectrum is cut off; neither aliasing nor attenuation changes the waves that stay.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic. An axis of one point keeps it.
    factor : int
        1 or more.

    Returns
    -------
    DataArray (y, x), m

    Examples
    --------
    >>> import numpy as np
    >>> x = 2 * np.pi * np.arange(32) / 32
    >>> coarse = without_shortest_waves(height_map((np.cos(x) + np.cos(14 * x))[None, :], 1.0), 4)
    >>> coarse.shape, bool(np.allclose(coarse, np.cos(x[None, ::4])))
    ((1, 8), True)
    """
    kept = [n if n == 1 else n // factor for n in window.shape]
    if factor == 1:
        return window
    spectrum = np.fft.rfft2(window.values)
    ky, kx = (k // 2 for k in kept)
    rows = np.r_[0 : kept[0] - ky, window.shape[0] - ky : window.shape[0]]
    spectrum = spectrum[rows, : kx + 1]
    if kept[0] % 2 == 0:  # the wave at the limit of the coarse grid is left out
        spectrum[kept[0] - ky] = 0.0
    if kept[1] % 2 == 0:
        spectrum[:, kx] = 0.0
    values = np.fft.irfft2(spectrum, s=kept) * (kept[0] * kept[1] / window.size)
    steps = [s * n / k for s, n, k in zip(spacing(window), window.shape, kept, strict=True)]
    if 1 in kept:  # the pitch across a profile is that along it
        steps = [max(steps)] * 2
    return height_map(values, steps)


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
        coordinates `cutoff_wavelength` (cutoff; m), the shortest wave, and `gradient_at_cutoff` (cutoff), the
        rms gradient. A single entry where the window is too small to be coarsened.

    Examples
    --------
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> from roughcontact.uncertainty.headline import headline
    >>> window, problem = rough_reference_surface(64), {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> solved = solve_contact(window, **problem, reduce=headline)
    >>> curve = magnification_curve(window, contact=problem, solved=solved)
    >>> curve["relative_contact_area_at_cutoff"].round(2).values.tolist()
    [[0.34, 0.35, 0.4]]
    """
    names, count = quantities_in(solved), counter_of(solved)
    levels = [{name: solved[name].values for name in names}]
    maps = [window]
    sides = [n for n in window.shape if n > 1]
    for octave in range(1, _MAX_OCTAVES + 1):
        if not sides or min(sides) // 2**octave < _MIN_POINTS_PER_SIDE:
            break
        maps.append(without_shortest_waves(window, 2**octave))
        levels.append(
            solve_member(maps[-1], contact, tolerance=_TOLERANCE, count=count, result=solved).values
        )
    wavelengths = [
        2 * max(s for n, s in zip(m.shape, spacing(m), strict=True) if n > 1 or not sides) for m in maps
    ]
    return xr.Dataset(
        {
            f"{n}_at_cutoff": (("load", "cutoff"), np.stack([each[n] for each in levels], axis=1))
            for n in names
        },
        coords={
            "cutoff_wavelength": ("cutoff", wavelengths),
            "gradient_at_cutoff": ("cutoff", [rms_gradient(m) for m in maps]),
        },
    )
