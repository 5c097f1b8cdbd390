"""Short waves: what they change, those that the instrument hides, and the octave beyond the pixels.

* *The magnification curve* (Persson 2001): the window is solved without its shortest octave of waves, without
  two, and so on, on three points per shortest wave; together this costs about as much as the window. Of more
  than 2048 x 2048 such points the change of a part of the window is solved, around its highest pressure.
  Waves are cut off by a circle in the plane of wavenumbers; the first holds as many as the grid with pixels
  twice as large.
* *Hidden waves*, longer than two pixels, that a stated lens or tip does not resolve, shift the ends of the
  interval. The trend of the resolved octaves is continued to the pixels, over two octaves at most; beyond,
  nothing bounds it.
* *The next octave*, shorter than two pixels, is an answer of its own: its change is bounded by that of the
  last one (`calibration`).
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import scipy
import xarray as xr

from roughcontact.arguments.maps import dimensions, height_map, side_lengths, spacing
from roughcontact.kernels.fourier import wavevectors
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.window.band import is_limited_by_grid
from roughcontact.surface.window.transfer import reliability_length, shortest_transmitted
from roughcontact.uncertainty.calibration import entry, table
from roughcontact.uncertainty.combination import Components, half_widths, one_sided
from roughcontact.uncertainty.discretisation import LARGEST_PART, highest_part
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.scales import ANSWERS, AREA, CONSTRICTIONS, GAP, PEAK, PRESSURE, to_scale

Columns = dict[str, tuple[Any, np.ndarray]]  # variable -> dims, values

_POINTS_PER_WAVE = 3  # of the shortest: with two, areas of small loads are a tenth and peaks a quarter off
_MIN_WAVES_PER_SIDE = 8  # of the shortest, in the last entry
_LARGEST_GRID = 2048**2  # points, beyond which a part tells the change
_MAX_OCTAVES = 2  # that are extrapolated


def remove_shortest_waves(window: xr.DataArray, cutoff: float) -> xr.DataArray:
    """Return a periodic map (m) without waves shorter than `cutoff` (m), on three points per such wave."""
    points, sides = _points_without(window, cutoff), side_lengths(window)
    q, rows = _long_waves(window, points)
    # the spectrum is cut off: neither aliasing nor attenuation changes the waves that stay
    spectrum = np.fft.fft(_transform_along_x(window, q.shape[1]), axis=0)[rows]
    values = np.fft.irfft2(np.where(_passes(q, cutoff), spectrum, 0.0), s=points)
    values *= math.prod(points) / window.size
    steps = [side / n for side, n in zip(sides, points, strict=True)]
    if 1 in points:  # the pitch across a profile is that along it
        steps = [max(steps)] * 2
    return height_map(values, steps, unit="m")


def _points_without(window: xr.DataArray, cutoff: float) -> list[int]:
    """Return how many points (y, x) a map has without waves shorter than `cutoff` (m)."""
    return [
        min(n, scipy.fft.next_fast_len(math.ceil(_POINTS_PER_WAVE * side / cutoff), real=True))
        for n, side in zip(window.shape, side_lengths(window), strict=True)
    ]


def _long_waves(window: xr.DataArray, points: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the wavenumbers (rad/m) of a map on so many points, and the rows of the map's that they are."""
    ky, kx = (n // 2 for n in points)
    rows = np.r_[0 : points[0] - ky, window.shape[0] - ky : window.shape[0]]
    qy, qx = wavevectors(window.shape, spacing(window))
    return np.hypot(qy[rows], qx[:, : kx + 1]), rows


def _transform_along_x(window: xr.DataArray, number: int) -> np.ndarray:
    """Return the first columns of a map's transform along x, some rows at a time: of a large map most go."""
    columns = np.empty((window.shape[0], number), complex)
    step = max(1, _LARGEST_GRID // window.shape[1])
    for start in range(0, len(columns), step):
        columns[start : start + step] = np.fft.rfft(window[start : start + step].values)[:, :number]
    return columns


def shortest_wave(window: xr.DataArray) -> float:
    """Return the shortest wavelength (m) of a circle of as many waves as a map; of a line two pixels."""
    if dimensions(window.shape) == 1:
        return 2 * max(spacing(window))
    return math.sqrt(math.pi * math.prod(spacing(window)))


def _passes(q: np.ndarray, cutoff: float) -> np.ndarray:
    """Return which wavenumbers (rad/m) are of waves as long as a cut-off (m) or longer."""
    return q * cutoff <= 2 * np.pi * (1 + 1e-9)


def magnification_curve(result: Result) -> Columns:
    """Return the results of a periodic window without its shortest waves, octave by octave, as variables.

    `{quantity}_at_cutoff` (load, cutoff) begins with the result; `cutoff_wavelength` (cutoff; m) is the
    shortest wave kept, `gradient_at_cutoff` (cutoff) the rms gradient.
    """
    window = result.window
    levels, gradients = [result.values], [rms_gradient(window)]
    band_limit = 0.0 if is_limited_by_grid(window.attrs) else window.attrs["band_shortest"]
    corner = math.hypot(*(np.abs(q).max() for q in wavevectors(window.shape, spacing(window))))
    lengths = [max(2 * np.pi / corner, band_limit)]
    side = min((s for s, n in zip(side_lengths(window), window.shape, strict=True) if n > 1), default=0.0)
    cutoff = 2 * shortest_wave(window)
    part, of_part, share = window, None, 1.0
    while side >= _MIN_WAVES_PER_SIDE * cutoff:
        is_large = math.prod(_points_without(window, cutoff)) > _LARGEST_GRID
        if is_large and of_part is None:
            part = highest_part(window, LARGEST_PART)
            of_part, share = result.again(part), gradients[0] / rms_gradient(part)
        elif not is_large:
            part, of_part, share = window, None, 1.0
        smoother = remove_shortest_waves(part, cutoff)
        q, _ = _long_waves(part, smoother.shape)
        lengths.append(max(2 * np.pi / q[_passes(q, cutoff)].max(), lengths[0]))
        levels.append(result.again_by_part(smoother, of_part) if of_part else result.again(smoother))
        gradients.append(share * rms_gradient(smoother))
        cutoff *= 2
    numbers = {name: np.stack([results[name] for results in levels], axis=1) for name in result.values}
    numbers[PRESSURE] = np.minimum(result.load[:, None] / numbers[AREA], result.hardness)
    curve: Columns = {f"{name}_at_cutoff": (("load", "cutoff"), values) for name, values in numbers.items()}
    curve["cutoff_wavelength"] = "cutoff", np.array(lengths)
    curve["gradient_at_cutoff"] = "cutoff", np.array(gradients)
    return curve


def band_is_chosen(settings: Mapping[str, Mapping[str, Any]], window: xr.DataArray) -> bool:
    """Return whether the settings, by four pixels or more, and not the pixels, define the shortest wave."""
    limits = settings.get("level", {}).get("s_filter"), settings["window"].get("shortest_wavelength")
    return max(limit or 0.0 for limit in limits) >= 4 * max(spacing(window))


def hidden_waves(
    window: xr.DataArray,
    curve: Columns,
    instrument: Mapping[str, Any],
    true_shapes: Mapping[str, xr.DataArray],
) -> Components:
    """Return the shifts of the ends by waves of the band that a stated lens or tip hides, on the scales.

    `curve` is the `magnification_curve` of the periodic window; what its `true_shapes` (`undone`) have of
    shorter waves does not count twice.
    """
    wavelengths, gradients = curve["cutoff_wavelength"][1], curve["gradient_at_cutoff"][1]
    resolution = shortest_transmitted(instrument)
    reference = true_shapes.get("lens") if resolution > wavelengths[0] else None
    if tip_radius := instrument.get("tip_radius"):
        resolution, reference = max(resolution, reliability_length(window, tip_radius)), true_shapes["tip"]
    if len(wavelengths) < 2 or not gradients.min() > 0:
        return {}
    # an octave below the next entry: of the waves of the window those in the corners of the grid are shorter
    octaves = math.log2(max(2 * resolution / wavelengths[1], 1.0))
    index = min(round(octaves + 0.25), len(wavelengths) - 2)
    if not index:  # less is the width of its own limit
        return {}
    growth = math.log(gradients[index] / gradients[index + 1])
    growth_restored = math.log(rms_gradient(reference) / gradients[index]) if reference is not None else 0.0
    # of the trend what the restored waves do not contain already
    share = min(octaves, _MAX_OCTAVES) - (max(growth_restored, 0.0) / growth if growth > 0 else 0.0)
    components = {}
    for name, change in _changes(curve, index).items():
        shift = max(share, 0.0) * change
        if round(octaves) > _MAX_OCTAVES and name in (AREA, PEAK):  # nothing bounds it
            shift = np.full_like(change, -np.inf if name == AREA else np.inf)
        components[name] = one_sided(shift)
    return components


def next_octave(curve: Columns) -> Components | None:
    """Return how far waves one octave shorter may move each quantity (load), on its scale, by the bank.

    `curve` is the `magnification_curve` of the periodic window. None for a map too small.
    """
    if len(curve["gradient_at_cutoff"][1]) < 2:
        return None
    octave = {}
    for name, change in _changes(curve, 0).items():
        unit = curve[f"{GAP}_at_cutoff"][1][:, 0] if name in CONSTRICTIONS else 1.0
        arms, size = table()["octave"][entry(name)], np.hypot(change, unit)
        octave[name] = half_widths(arms["down"] * size, arms["up"] * size)
    return octave


def _changes(curve: Columns, index: int) -> dict[str, np.ndarray]:
    """Return the change (load) of each quantity on its scale by one octave of the curve; 0 where unknown."""
    changes = {}
    for name in (name for name in (AREA, GAP, PEAK, *ANSWERS) if f"{name}_at_cutoff" in curve):
        fine, coarse = to_scale(name, curve[f"{name}_at_cutoff"][1][:, index : index + 2]).T
        changes[name] = np.nan_to_num(fine - coarse)
    return changes
