"""The figures of the report that show the waves of a surface: spectra and autocorrelation."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from roughcontact.maps import spacing
from roughcontact.quantities import prefix
from roughcontact.report.figures import COLOURS, as_png, as_svg, new_figure, new_picture
from roughcontact.roughness import parameters
from roughcontact.roughness.spectrum import areal_spectrum, isotropic_spectrum
from roughcontact.roughness.texture import DECAY, autocorrelation, decay_lengths

_DECADES = 6  # of power below the strongest wave that the colours show
_SHELLS = 120  # points of the drawn curve per factor of ten in q
_LENGTHS = 3  # longest decay lengths of the autocorrelation that are shown to each side
_FEWEST = 8  # waves or points to each side of the middle that are shown at least


def spectrum(window: xr.DataArray) -> str:
    """Draw the radially averaged power spectrum of a window, with the band that it holds.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic, not flat, with the attributes that `periodic_window` leaves.

    Returns
    -------
    str
        source of the image, a data URI.

    References
    ----------
    .. [1] Jacobs, Junge and Pastewka (2017), Surf. Topogr.: Metrol. Prop. 5, 013001.
    """
    q, power = _thinned(*isotropic_spectrum(window))
    profile = 1 in window.shape
    unit_q, length = _inverse_length(q)
    scale, height_unit = _height_unit(window)
    # C is height^2 times area (of a profile times length)
    power = power * (scale**2 * unit_q ** -(1 if profile else 2))
    inside = power > 1e-20 * power.max()  # below lies the rounding of waves that were taken out
    with new_figure(4.3, 3.6) as figure:
        axes = figure.add_subplot()
        axes.loglog(q[inside] * unit_q, power[inside], color=COLOURS[0], linewidth=1.3)
        _mark_band(axes, window, q[0], unit_q)
        seen = power[inside]
        axes.set_ylim(seen.min() / 30, seen.max() * 5)
        axes.set_xlabel(f"wavenumber q (rad/{length})")
        axes.set_ylabel(f"C(q) ({height_unit}² {length}{'' if profile else '²'})")
        top = axes.secondary_xaxis("top", functions=(_turn_over, _turn_over))
        top.set_xlabel(f"wavelength ({length})")
        axes.legend(loc="lower left")
        return as_svg(figure)


def _mark_band(axes: Axes, window: xr.DataArray, first: float, unit_q: float) -> None:
    """Show which waves were taken out, which are reliable, and which is the shortest one of the map.

    `first` is the smallest wavenumber (1/m) that is drawn, `unit_q` the factor of the drawn unit.
    """
    step = min(d for n, d in zip(window.shape, spacing(window), strict=True) if n > 1)
    limits = first * unit_q / 1.3, np.pi / step * unit_q * 1.3
    longest, shortest = (2 * np.pi / window.attrs[f"band_{end}"] * unit_q for end in ("longest", "shortest"))
    outside = [(limits[0], longest)] if longest > first * unit_q * 1.01 else []
    if window.attrs["band_shortest"] > 2 * step * 1.01:
        outside.append((shortest, limits[1]))
    for index, span in enumerate(outside):
        axes.axvspan(*span, color="#e4e4e4", linewidth=0, label=None if index else "taken out")
    axes.axvline(
        2 * np.pi / window.attrs["reliable_wavelength"] * unit_q,
        color=COLOURS[1],
        linestyle="--",
        linewidth=1.1,
        label=f"reliable: {window.attrs['reliable_reason']}",
    )
    of_map = parameters.shortest_wavelength(window)
    if np.isfinite(of_map):
        axes.axvline(
            2 * np.pi / of_map * unit_q,
            color=COLOURS[2],
            linestyle=":",
            linewidth=1.3,
            label="shortest wave of the map",
        )
    axes.set_xlim(*limits)


def directional_spectrum(window: xr.DataArray) -> str:
    """Draw the power of the waves of a window over their direction, logarithmic, the longest in the middle.

    The mean over 3 x 3 waves is drawn, out to the waves that carry 99 % of the mean square gradient.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic, not flat, no profile.

    Returns
    -------
    str
        source of the image, a data URI.
    """
    from scipy.ndimage import uniform_filter

    qy, qx, power = areal_spectrum(window)
    power = uniform_filter(np.fft.fftshift(power), 3, mode="wrap")
    qy, qx = np.fft.fftshift(qy), np.fft.fftshift(qx)
    shortest = parameters.shortest_wavelength(window)
    reach = max(2 * np.pi / shortest, _FEWEST * (qy[1] - qy[0]), _FEWEST * (qx[1] - qx[0]))
    rows, columns = np.abs(qy) <= reach, np.abs(qx) <= reach
    unit_q, length = _inverse_length(qx[columns])
    scale, height_unit = _height_unit(window)
    shown = np.log10(np.maximum(power[np.ix_(rows, columns)] * scale**2 * unit_q**-2, 1e-300))
    return _picture(
        window,
        shown,
        (qx[columns] * unit_q, qy[rows] * unit_q),
        axes_label=f"q along {{}} (rad/{length})",
        bar_label=f"log₁₀ C ({height_unit}² {length}²)",
        limits=(shown.max() - _DECADES, shown.max()),
        colours="magma",
    )


def autocorrelation_map(window: xr.DataArray) -> str:
    """Draw the autocorrelation of a window for shifts around zero, with the line where it falls to 0.2.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic, not flat; a profile is drawn as a line.

    Returns
    -------
    str
        source of the image, a data URI.

    References
    ----------
    .. [1] ISO 25178-2 (2021), autocorrelation length Sal.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.maps import height_map
    >>> wave = height_map(np.sin(np.arange(32) * np.pi / 8)[None, :] * 1e-6, 1e-6)
    >>> autocorrelation_map(wave).partition(",")[0]
    'data:image/svg+xml;base64'
    """
    correlation, steps = autocorrelation(window), spacing(window)
    _, longest = decay_lengths(correlation, steps)
    shifts = [(np.arange(n) - n // 2) * d for n, d in zip(correlation.shape, steps, strict=True)]
    reach = max(_LENGTHS * longest, *(_FEWEST * d for d in steps))
    rows, columns = (np.abs(shift) <= reach for shift in shifts)
    shown = correlation[np.ix_(rows, columns)]
    factor, unit = prefix(max(np.abs(shifts[0][rows]).max(), np.abs(shifts[1][columns]).max()), "m")
    y, x = shifts[0][rows] * factor, shifts[1][columns] * factor
    if 1 in window.shape:
        with new_figure(4.3, 3.6) as figure:
            axes = figure.add_subplot()
            axes.plot(x if x.size > 1 else y, shown.ravel(), color=COLOURS[0], linewidth=1.3)
            axes.axhline(DECAY, color="#444444", linestyle="--", linewidth=1.1, label=f"{DECAY:g}: Sal")
            axes.set_xlabel(f"shift along {'x' if x.size > 1 else 'y'} ({unit})")
            axes.set_ylabel("autocorrelation")
            axes.legend(loc="upper right")
            return as_svg(figure)
    return _picture(
        window,
        shown,
        (x, y),
        axes_label=f"shift along {{}} ({unit})",
        bar_label="autocorrelation",
        limits=(min(float(shown.min()), 0.0), 1.0),
        colours="viridis",
        contour=DECAY,
    )


def _picture(
    window: xr.DataArray,
    values: np.ndarray,
    positions: tuple[np.ndarray, np.ndarray],
    *,
    axes_label: str,
    bar_label: str,
    limits: tuple[float, float],
    colours: str,
    contour: float | None = None,
) -> str:
    """Draw values over the positions (x, y) of their points, upright as the maps are."""
    x, y = positions
    half_x, half_y = ((p[1] - p[0]) / 2 if p.size > 1 else 0.5 for p in (x, y))
    extent = (x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y)
    with new_picture((extent[3] - extent[2]) / (extent[1] - extent[0]), left=0.75) as picture:
        axes = picture.axes
        image = axes.imshow(
            values,
            origin="lower",
            extent=extent,
            cmap=colours,
            vmin=limits[0],
            vmax=limits[1],
            aspect="auto",
            interpolation="nearest",
        )
        if contour is not None:
            axes.contour(x, y, values, levels=[contour], colors="white", linewidths=1.2)
        if window.attrs.get("first_row") == "top":
            axes.invert_yaxis()
        axes.set_xlabel(axes_label.format("x"))
        axes.set_ylabel(axes_label.format("y"))
        picture.add_colour_bar(image, bar_label)
        return as_png(picture.figure)


def _thinned(q: np.ndarray, power: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the spectrum with shells put together where there are many per factor of ten."""
    bins = np.floor(_SHELLS * np.log10(q / q[0]) + 1e-9).astype(int)
    _, bins, count = np.unique(bins, return_inverse=True, return_counts=True)
    return np.bincount(bins, weights=q) / count, np.bincount(bins, weights=power) / count


def _turn_over(value: ArrayLike) -> np.ndarray:
    """Return the wavelength that belongs to a wavenumber, or the other way round."""
    return 2 * np.pi / np.maximum(value, 1e-300)


def _inverse_length(q: np.ndarray) -> tuple[float, str]:
    """Return the factor that brings wavenumbers into a handy unit, and the name of its length."""
    factor, length = prefix(2 * np.pi / np.median(np.abs(q[q != 0])), "m")
    return 1 / factor, length


def _height_unit(window: xr.DataArray) -> tuple[float, str]:
    """Return the factor and the name of the unit that suits the heights."""
    return prefix(float(np.std(window.values)), "m")
