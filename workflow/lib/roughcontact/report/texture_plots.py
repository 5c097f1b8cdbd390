"""Charts of the waves of a surface: spectra and autocorrelation.

Each is a data URI, drawn from a periodic window (y, x; m) that is not flat.
"""

import json

import numpy as np
import xarray as xr
from contourpy import contour_generator

from roughcontact.maps import side_lengths, spacing
from roughcontact.quantities import Unit
from roughcontact.report.charts import COLOURS, DASHED, DOTTED, Axis, Chart, log_axis
from roughcontact.report.map_plots import Field, framed
from roughcontact.report.units import length_unit
from roughcontact.roughness import parameters
from roughcontact.roughness.spectrum import areal_spectrum, isotropic_spectrum
from roughcontact.roughness.texture import DECAY, autocorrelation, decay_lengths

_HEIGHT = Unit(1e9, "nm")  # of spectra, which are in nm² by the square of a length
_DECADES = 6  # of power below the strongest wave that the colours show
_SHELLS = 120  # points of the drawn curve per factor of ten in q
_LENGTHS = 3  # range of the autocorrelation to each side, in units of its longest decay length
_FEWEST = 8  # waves or points to each side of the middle that are shown at least


def spectrum(window: xr.DataArray) -> str:
    """Draw the radially averaged power spectrum of a window, with the band that it holds.

    Jacobs, Junge and Pastewka (2017), Surf. Topogr.: Metrol. Prop. 5, 013001.
    """
    q, power = _thinned(*isotropic_spectrum(window))
    profile = 1 in window.shape
    unit_q, length = _inverse_length(window)
    # C is height^2 times area (of a profile times length)
    power = power * (_HEIGHT.factor**2 * unit_q ** -(1 if profile else 2))
    inside = power > 1e-20 * power.max()  # below lies the rounding of waves that were removed
    visible = power[inside]
    step = min(d for n, d in zip(window.shape, spacing(window), strict=True) if n > 1)
    wavenumbers = q[0] * unit_q, np.pi / step * unit_q
    chart = _spectrum_chart(wavenumbers, length, (visible.min() / 30, visible.max() * 5), profile=profile)
    _mark_band(chart, window, q[0] * unit_q, unit_q)
    chart.line(q[inside] * unit_q, visible, colour=COLOURS[0])
    return chart.source()


def fitted_spectrum(window: xr.DataArray) -> str:
    """Draw the mean periodogram of profiles, and that of the surface fitted to them (`profile_spectra`)."""
    unit_q, length = _inverse_length(window)
    spectra = {key: np.array(values) for key, values in json.loads(window.attrs["profile_spectra"]).items()}
    q = spectra.pop("wavenumber") * unit_q
    measured, fitted = (values * _HEIGHT.factor**2 / unit_q for values in spectra.values())
    limits = measured.min() / 3, measured.max() * 3
    chart = _spectrum_chart((q[0], q[-1]), length, limits, profile=True)
    chart.line(q, measured, colour=COLOURS[1], label="profiles")
    chart.line(q, fitted, colour=COLOURS[0], label="fit")
    return chart.source()


def _spectrum_chart(
    wavenumbers: tuple[float, float], length: str, powers: tuple[float, float], *, profile: bool
) -> Chart:
    """Return the axes of a spectrum: wavenumbers and wavelengths in a unit of length, powers."""
    x = log_axis(f"wavenumber q (rad/{length})", np.array(wavenumbers), room=1.3)
    y = Axis(f"C(q) ({_HEIGHT.symbol}² {length}{'' if profile else '²'})", *powers, log=True)
    top = Axis(f"wavelength ({length})", 2 * np.pi / x.low, 2 * np.pi / x.high, log=True)
    return Chart(x, y, top=top)


def _mark_band(chart: Chart, window: xr.DataArray, first: float, unit_q: float) -> None:
    """Mark the waves that were removed, the reliable ones, and the shortest one of the map.

    `first` is the smallest wavenumber that is drawn, `unit_q` the factor from 1/m to its unit.
    """
    step = min(d for n, d in zip(window.shape, spacing(window), strict=True) if n > 1)
    longest, shortest = (2 * np.pi / window.attrs[f"band_{end}"] * unit_q for end in ("longest", "shortest"))
    outside = [(chart.x.low, longest)] if longest > first * 1.01 else []
    if window.attrs["band_shortest"] > 2 * step * 1.01:
        outside.append((shortest, chart.x.high))
    for index, span in enumerate(outside):
        chart.band(*span, label="" if index else "removed")
    reliable, of_map = window.attrs["reliable_wavelength"], parameters.shortest_wavelength(window)
    label = f"reliable: {window.attrs['reliable_reason']}"
    chart.across(x=2 * np.pi / reliable * unit_q, colour=COLOURS[1], dash=DASHED, label=label)
    if np.isfinite(of_map):
        label = "shortest wave of the map"
        chart.across(x=2 * np.pi / of_map * unit_q, colour=COLOURS[2], dash=DOTTED, label=label)


def directional_spectrum(window: xr.DataArray) -> str:
    """Draw the power of the waves of a window by direction, logarithmic, the longest in the middle.

    The mean over 3 x 3 waves is drawn, out to the waves that carry 99 % of the mean square gradient.
    """
    from scipy.ndimage import uniform_filter

    qy, qx, power = areal_spectrum(window)
    power = uniform_filter(np.fft.fftshift(power), 3, mode="wrap")
    qy, qx = np.fft.fftshift(qy), np.fft.fftshift(qx)
    shortest = parameters.shortest_wavelength(window)
    reach = max(2 * np.pi / shortest, _FEWEST * (qy[1] - qy[0]), _FEWEST * (qx[1] - qx[0]))
    rows, columns = np.abs(qy) <= reach, np.abs(qx) <= reach
    unit_q, length = _inverse_length(window)
    displayed = np.log10(np.maximum(power[np.ix_(rows, columns)] * _HEIGHT.factor**2 * unit_q**-2, 1e-300))
    x = _centred(f"q along x (rad/{length})", qx[columns] * unit_q)
    y = _centred(f"q along y (rad/{length})", qy[rows] * unit_q)
    bar = Axis(f"log₁₀ C ({_HEIGHT.symbol}² {length}²)", displayed.max() - _DECADES, displayed.max())
    return framed(Field(bar.label, "magma"), x, y, displayed, bar=bar).source()


def autocorrelation_map(window: xr.DataArray) -> str:
    """Draw the autocorrelation of a window (ISO 25178-2, 2021), with the line where it falls to 0.2."""
    correlation, steps = autocorrelation(window), spacing(window)
    _, longest, _ = decay_lengths(correlation, steps)
    shifts = [(np.arange(n) - n // 2) * d for n, d in zip(correlation.shape, steps, strict=True)]
    reach = max(_LENGTHS * longest, *(_FEWEST * d for d in steps))
    rows, columns = (np.abs(shift) <= reach for shift in shifts)
    displayed = correlation[np.ix_(rows, columns)]
    factor, unit = length_unit(max(side_lengths(window)))
    y, x = shifts[0][rows] * factor, shifts[1][columns] * factor
    if 1 in window.shape:
        shift = x if x.size > 1 else y
        chart = Chart(
            Axis(f"shift along {'x' if x.size > 1 else 'y'} ({unit})", shift[0], shift[-1]),
            Axis("autocorrelation", min(1.05 * float(displayed.min()), -0.05), 1.05),
        )
        chart.across(y=DECAY, dash=DASHED, label=f"{DECAY:g}: Sal")
        chart.line(shift, displayed.ravel(), colour=COLOURS[0])
        return chart.source()
    bar = Axis("autocorrelation", min(float(displayed.min()), 0.0), 1.0)
    axes = _centred(f"shift along x ({unit})", x), _centred(f"shift along y ({unit})", y)
    chart = framed(Field(bar.label, "viridis"), *axes, displayed, bar=bar)
    chart.line(*_contour(x, y, displayed, DECAY), colour="#ffffff")
    return chart.source()


def _centred(label: str, positions: np.ndarray) -> Axis:
    """Return the axis of a picture with its points at these positions, in their middles."""
    half = (positions[1] - positions[0]) / 2 if positions.size > 1 else 0.5
    return Axis(label, positions[0] - half, positions[-1] + half)


def _contour(x: np.ndarray, y: np.ndarray, values: np.ndarray, level: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the line where values reach a level, in pieces with NaN between."""
    gap = np.full((1, 2), np.nan)
    pieces = contour_generator(x, y, values).lines(level)
    line = np.concatenate([gap, *(points for piece in pieces for points in (piece, gap))])
    return line[:, 0], line[:, 1]


def _thinned(q: np.ndarray, power: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the spectrum with shells put together where there are many per factor of ten."""
    bins = np.floor(_SHELLS * np.log10(q / q[0]) + 1e-9).astype(int)
    _, bins, count = np.unique(bins, return_inverse=True, return_counts=True)
    return np.bincount(bins, weights=q) / count, np.bincount(bins, weights=power) / count


def _inverse_length(window: xr.DataArray) -> tuple[float, str]:
    """Return the factor that brings wavenumbers into the unit of a window, and the name of its length."""
    factor, length = length_unit(max(side_lengths(window)))
    return 1 / factor, length
