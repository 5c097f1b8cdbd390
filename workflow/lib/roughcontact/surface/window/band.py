"""Bandwidth: the wavelengths that a map resolves reliably, and band-limited maps."""

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import side_lengths, spacing
from roughcontact.arguments.measurement import json_attribute
from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.kernels.fourier import halfplane_weights, wavenumbers

# A lens passes half of a wave's contrast at 0.404 of its cut-off frequency 2 NA / wavelength of the light:
# (2 / pi) (acos v - v sqrt(1 - v^2)) = 1/2
_HALF_CONTRAST = 0.4039727532995172
_RELATIVE_MARGIN = 1e-9  # so that a wave of the map exactly at a limit is kept
LIGHT_WAVELENGTH = 550e-9  # m, assumed: files do not state it reliably
GRID = "grid"  # the attribute `band_reason` where no setting limits the band; else the name of that setting


def reliable_wavelength(height: xr.DataArray) -> tuple[float, str]:
    """Return the shortest wavelength (m) that a map resolves reliably, and what limits it.

    It is two pixels (of the coarser pitch) or, if longer, the `lateral_period_limit` of the stated lens.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> height = height_map(np.zeros((4, 4)), 1e-6, instrument={"numerical_aperture": 0.3})
    >>> wavelength, reason = reliable_wavelength(height)
    >>> print(f"{wavelength:.3g} m: {reason}")
    2.27e-06 m: the lens (numerical aperture 0.3)
    >>> reliable_wavelength(height.assign_attrs(instrument="{}"))
    (2e-06, 'two pixels')
    """
    limits = [(2 * max(spacing(height)), "two pixels")]  # of oblong pixels the longer side limits
    aperture = numerical_aperture(json_attribute(height.attrs, "instrument"))
    if aperture:
        limits.append((lateral_period_limit(aperture), f"the lens (numerical aperture {aperture:g})"))
    return max(limits)


def lateral_period_limit(aperture: float, light: float | None = None) -> float:
    """Return the wavelength (m) at which a lens passes half of the contrast (ISO 25178-600:2019).

    It is 1.24 L / NA for a diffraction-limited lens in incoherent light of the wavelength L (m; Goodman 1968,
    Introduction to Fourier Optics, section 6-3).

    Examples
    --------
    >>> f"{lateral_period_limit(0.3):.3g}"
    '2.27e-06'
    """
    return (light or LIGHT_WAVELENGTH) / (2 * aperture * _HALF_CONTRAST)


def shortest_reliable_wave(window: xr.DataArray) -> float:
    """Return the wavelength (m) from which the numbers of a window hold; 0 where its band is not known."""
    return max(float(window.attrs.get(name, 0.0)) for name in ("band_shortest", "reliable_wavelength"))


def limit_band(
    window: xr.DataArray,
    *,
    shortest_wavelength: float | None = None,
    longest_wavelength: float | None = None,
    reliable_band: bool = False,
) -> xr.DataArray:
    """Return a periodic map (m) limited to waves from the shortest to the longest one, with a record.

    `reliable_band` removes waves shorter than `reliable_wavelength` as well; the mean is unchanged.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> x = np.arange(64)
    >>> long, short = np.cos(2 * np.pi * x / 32), np.cos(2 * np.pi * x / 4)
    >>> window = height_map((long + short)[None, :], 1.0)
    >>> limited = limit_band(window, shortest_wavelength=8.0)
    >>> bool(np.allclose(limited, long)), round(limited.attrs["band_removed_rms_height"], 3)
    (True, 0.707)
    """
    shortest, longest = shortest_wavelength, longest_wavelength
    for name, value in (("shortest", shortest), ("longest", longest)):
        if value is not None and not 0 < value < math.inf:
            raise SettingsError(
                f"window.{name}_wavelength = {value!r}: give a positive length in m, or null for no limit"
            )
    if shortest and longest and shortest >= longest:
        raise SettingsError(
            f"window.shortest_wavelength = {shortest:g} m is not below window.longest_wavelength = "
            f"{longest:g} m",
            keys=("window.shortest_wavelength", "window.longest_wavelength"),
        )
    limit, limit_reason = reliable_wavelength(window)
    cutoffs = [(shortest, "window.shortest_wavelength")] if shortest else []
    cutoffs += [(limit, "window.reliable_band")] if reliable_band else []
    shortest, reason = max(cutoffs, default=(None, GRID))
    step = spacing(window)
    q = wavenumbers(window.shape, step)
    # the mean is no wave, and stays
    outside = _outside(q, shortest, longest)
    values, removed_power = window.values, np.zeros(q.shape)
    # heights less the first one: a flat map keeps exactly no waves
    if outside.any():
        spectrum = np.where(outside, np.fft.rfft2(values - values.flat[0]), 0.0)
        removed_power = halfplane_weights(values.shape) * np.abs(spectrum / values.size) ** 2
        if np.ptp(values) and outside.flat[1:].all():
            raise HeightMapError(
                f"{window.attrs.get('source_file') or 'the map'}: no wave of the window lies between "
                f"{shortest or 0:g} m and {longest or math.inf:g} m: widen the band "
                "(window.shortest_wavelength, window.longest_wavelength, window.reliable_band)"
            )
        # what lies outside is taken away, so that heights within the band keep all their digits
        values = values - np.fft.irfft2(spectrum, s=values.shape)
    return window.copy(data=values).assign_attrs(
        band_shortest=float(max(shortest or 0.0, 2 * min(step))),
        band_longest=float(min(longest or math.inf, max(side_lengths(window)))),
        band_reason=reason,
        band_removed_rms_height=math.sqrt(removed_power.sum()),
        band_removed_rms_gradient=math.sqrt((q**2 * removed_power).sum()),
        reliable_wavelength=limit,
        reliable_reason=limit_reason,
    )


def is_limited_by_grid(attrs: Mapping[Any, Any]) -> bool:
    """Return whether the grid alone limits the short waves of a map, by its attributes, and no setting."""
    return bool(attrs.get("band_reason", GRID) == GRID)


def removed_by_band(q: np.ndarray, attrs: Mapping[str, Any]) -> np.ndarray:
    """Return which wavenumbers (rad/m) a map has lost to its band, by its attributes."""
    shortest = None if is_limited_by_grid(attrs) else attrs["band_shortest"]
    return _outside(q, shortest, attrs.get("band_longest"))


def _outside(q: np.ndarray, shortest: float | None, longest: float | None) -> np.ndarray:
    """Return which wavenumbers (rad/m) lie outside a band of wavelengths (m)."""
    outside = q > (2 * np.pi / shortest * (1 + _RELATIVE_MARGIN) if shortest else math.inf)
    # a wave of the map exactly at a limit stays in the band
    return outside | (q > 0) & (q < (2 * np.pi / longest * (1 - _RELATIVE_MARGIN) if longest else 0.0))


def in_band(window: xr.DataArray, **options: Any) -> xr.DataArray:
    """Return a periodic map (m) limited to the band that is asked of `periodic_window`, unchanged if none."""
    names = ("shortest_wavelength", "longest_wavelength", "reliable_band")
    limits = {name: options[name] for name in names if options.get(name)}
    return limit_band(window, **limits) if limits else window


def numerical_aperture(instrument: Mapping) -> float | None:
    """Return the numerical aperture from the file's metadata, an entry of its own or a comment `NA: 0.60`.

    Examples
    --------
    >>> numerical_aperture({"numerical_aperture": 0.3}), numerical_aperture({"comment": "20x, NA: 0.60"})
    (0.3, 0.6)
    """
    if "numerical_aperture" in instrument:
        return float(instrument["numerical_aperture"])
    # as instrument software writes it into comments
    match = re.search(r"\bNA\s*[:=]?\s*(0?\.\d+|1\.[0-5]\d*)", str(instrument.get("comment", "")))
    return float(match[1]) or None if match else None
