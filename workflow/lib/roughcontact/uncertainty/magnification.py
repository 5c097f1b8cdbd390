"""Magnification curve: the results as a function of the shortest wave that is kept (Persson 2001).

The window is solved again without its shortest octave of waves, without two, and so on, on three points per
shortest wave; together this costs about as much as the window. Waves are cut off by a circle in the plane of
wavenumbers; the first holds as many as the grid with pixels twice as large.
"""

import math

import numpy as np
import scipy
import xarray as xr

from roughcontact.fourier import wavenumbers
from roughcontact.maps import height_map, side_lengths, spacing
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.headline import quantities_in
from roughcontact.uncertainty.scales import AREA, PRESSURE

_POINTS_PER_WAVE = 3  # of the shortest: with two, areas of small loads are a tenth and peaks a quarter off
_MIN_WAVES_PER_SIDE = 8  # of the shortest, in the last entry


def without_shortest_waves(window: xr.DataArray, cutoff: float) -> xr.DataArray:
    """Return a periodic map (m) without waves shorter than `cutoff` (m), on three points per such wave."""
    spectrum = np.where(_passes(window, cutoff), np.fft.rfft2(window.values), 0.0)
    sides = side_lengths(window)
    points = [
        min(n, scipy.fft.next_fast_len(math.ceil(_POINTS_PER_WAVE * side / cutoff), real=True))
        for n, side in zip(window.shape, sides, strict=True)
    ]
    ky, kx = (n // 2 for n in points)
    # the spectrum is cut off: neither aliasing nor attenuation changes the waves that stay
    rows = np.r_[0 : points[0] - ky, window.shape[0] - ky : window.shape[0]]
    values = np.fft.irfft2(spectrum[rows, : kx + 1], s=points) * (math.prod(points) / window.size)
    steps = [side / n for side, n in zip(sides, points, strict=True)]
    if 1 in points:  # the pitch across a profile is that along it
        steps = [max(steps)] * 2
    return height_map(values, steps)


def shortest_wave(window: xr.DataArray) -> float:
    """Return the shortest wavelength (m) of a circle of as many waves as a map; of a line two pixels."""
    if 1 in window.shape:
        return 2 * max(spacing(window))
    return math.sqrt(math.pi * math.prod(spacing(window)))


def _passes(window: xr.DataArray, cutoff: float) -> np.ndarray:
    """Return which waves, in the layout of `rfft2`, are as long as a cut-off or longer."""
    return wavenumbers(window.shape, spacing(window)) * cutoff <= 2 * np.pi * (1 + 1e-9)


def magnification_curve(result: Result) -> xr.Dataset:
    """Return the results of a periodic window without its shortest waves, octave by octave.

    `{quantity}_at_cutoff` (load, cutoff) begins with the result; `cutoff_wavelength` (cutoff; m) is the
    shortest wave kept, `gradient_at_cutoff` (cutoff) the rms gradient.
    """
    window = result.window
    maps, q = [window], wavenumbers(window.shape, spacing(window))
    levels = [{**result.values}]
    by_grid = window.attrs.get("band_reason", "the grid") == "the grid"
    lengths = [max(2 * np.pi / q.max(), 0.0 if by_grid else window.attrs["band_shortest"])]
    side = min((s for s, n in zip(side_lengths(window), window.shape, strict=True) if n > 1), default=0.0)
    cutoff = 2 * shortest_wave(window)
    while side >= _MIN_WAVES_PER_SIDE * cutoff:
        maps.append(without_shortest_waves(window, cutoff))
        lengths.append(max(2 * np.pi / q[_passes(window, cutoff)].max(), lengths[0]))
        levels.append(result.again(maps[-1]))
        cutoff *= 2
    for level in levels:
        level[PRESSURE] = np.minimum(result.load / level[AREA], result.hardness)
    return xr.Dataset(
        {
            f"{name}_at_cutoff": (("load", "cutoff"), np.stack([level[name] for level in levels], axis=1))
            for name in quantities_in(levels[0])
        },
        coords={
            "cutoff_wavelength": ("cutoff", lengths),
            "gradient_at_cutoff": ("cutoff", [rms_gradient(m) for m in maps]),
        },
    )
