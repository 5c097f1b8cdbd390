"""Charts of the waves of a surface: its spectra.

Each is a data URI, drawn from a periodic window (y, x; m) that is not flat.
"""

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import dimensions, side_lengths, spacing
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.quantities import Unit
from roughcontact.report.charts import COLOURS, DASHED, DOTTED, Axis, Chart, log_axis
from roughcontact.report.units import length_unit
from roughcontact.surface.roughness import parameters
from roughcontact.surface.roughness.spectrum import isotropic_spectrum

_HEIGHT = Unit(1e9, "nm")  # of spectra, which are in nm² by the square of a length
_SHELLS = 120  # points of the drawn curve per factor of ten in q


def pictures(window: xr.DataArray, caption: str) -> list[tuple[str, str, str]]:
    """Return (title, image, caption) of the spectra of a window, of which the `caption` is of its own one."""
    of_window = [("Power spectrum", spectrum(window), caption)]
    if "profile_spectra" not in window.attrs:
        return of_window
    text = "Of the profiles, and of such profiles of the surface that was fitted to them."
    return [("Spectrum of the profiles", fitted_spectrum(window), text), *of_window]


def spectrum(window: xr.DataArray) -> str:
    """Draw the radially averaged power spectrum of a window, with the band that it holds.

    Jacobs, Junge and Pastewka (2017), Surf. Topogr.: Metrol. Prop. 5, 013001.
    """
    q, power = _thinned(*isotropic_spectrum(window))
    axes = dimensions(window.shape)
    unit_q, length = _inverse_length(window)
    # C is height^2 times area (of a profile times length)
    power = power * (_HEIGHT.factor**2 * unit_q**-axes)
    inside = power > 1e-20 * power.max()  # below lies the rounding of waves that were removed
    visible = power[inside]
    wavenumbers = q[0] * unit_q, np.pi / min(spacing(window)) * unit_q
    chart = _spectrum_chart(wavenumbers, length, (visible.min() / 30, visible.max() * 5), axes=axes)
    _mark_band(chart, window, q[0] * unit_q, unit_q)
    chart.line(q[inside] * unit_q, visible, colour=COLOURS[0])
    return chart.source()


def fitted_spectrum(window: xr.DataArray) -> str:
    """Draw the mean periodogram of profiles, and that of the surface fitted to them (`profile_spectra`)."""
    unit_q, length = _inverse_length(window)
    spectra = json_attribute(window.attrs, "profile_spectra")
    q = np.array(spectra.pop("wavenumber")) * unit_q
    periodogram, fit = (np.array(values) * _HEIGHT.factor**2 / unit_q for values in spectra.values())
    limits = periodogram.min() / 3, periodogram.max() * 3
    chart = _spectrum_chart((q[0], q[-1]), length, limits, axes=1)
    chart.line(q, periodogram, colour=COLOURS[1], label="profiles")
    chart.line(q, fit, colour=COLOURS[0], label="fit")
    return chart.source()


def _spectrum_chart(
    wavenumbers: tuple[float, float], length: str, powers: tuple[float, float], *, axes: int
) -> Chart:
    """Return the axes of a spectrum of a map of 1 or 2 axes: wavenumbers and wavelengths, powers."""
    x = log_axis(f"wavenumber q (rad/{length})", np.array(wavenumbers), room=1.3)
    y = Axis(f"C(q) ({_HEIGHT.symbol}² {length}{'²' if axes == 2 else ''})", *powers, log=True)
    top = Axis(f"wavelength ({length})", 2 * np.pi / x.low, 2 * np.pi / x.high, log=True)
    return Chart(x, y, top=top)


def _mark_band(chart: Chart, window: xr.DataArray, longest_wave: float, unit_q: float) -> None:
    """Mark the waves that were removed, the reliable ones, and the shortest one of the map.

    `longest_wave` is the smallest wavenumber that is drawn, `unit_q` the factor from 1/m to its unit.
    """
    longest, shortest = (2 * np.pi / window.attrs[f"band_{end}"] * unit_q for end in ("longest", "shortest"))
    outside = [(chart.x.low, longest)] if longest > longest_wave * 1.01 else []
    if window.attrs["band_shortest"] > 2 * min(spacing(window)) * 1.01:
        outside.append((shortest, chart.x.high))
    for index, span in enumerate(outside):
        chart.band(*span, label="" if index else "removed")
    reliable, of_map = window.attrs["reliable_wavelength"], parameters.shortest_wavelength(window)
    label = f"reliable: {window.attrs['reliable_reason']}"
    chart.across(x=2 * np.pi / reliable * unit_q, colour=COLOURS[1], dash=DASHED, label=label)
    if np.isfinite(of_map):
        label = "shortest wave of the map"
        chart.across(x=2 * np.pi / of_map * unit_q, colour=COLOURS[2], dash=DOTTED, label=label)


def _thinned(q: np.ndarray, power: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the spectrum with shells put together where there are many per factor of ten."""
    bins = np.floor(_SHELLS * np.log10(q / q[0]) + 1e-9).astype(int)
    _, bins, count = np.unique(bins, return_inverse=True, return_counts=True)
    return np.bincount(bins, weights=q) / count, np.bincount(bins, weights=power) / count


def _inverse_length(window: xr.DataArray) -> tuple[float, str]:
    """Return the factor that brings wavenumbers into the unit of a window, and the name of its length."""
    factor, length = length_unit(max(side_lengths(window)))
    return 1 / factor, length
