"""The figures of the report that show the waves of a surface: spectra and autocorrelation."""

import numpy as np

from roughcontact.maps import spacing
from roughcontact.quantities import prefix
from roughcontact.report.plots import COLOURS, as_png, as_svg, new_figure
from roughcontact.roughness import parameters
from roughcontact.roughness.spectrum import areal_spectrum, isotropic_spectrum
from roughcontact.roughness.texture import DECAY, autocorrelation, decay_lengths

_WIDTH = 2.55  # of the longer side of a map, inches
_DECADES = 6  # of power below the strongest wave that the colours show
_SHELLS = 120  # points of the drawn curve per factor of ten in q
_LENGTHS = 3  # longest decay lengths of the autocorrelation that are shown to each side
_FEWEST = 8  # waves or points to each side of the middle that are shown at least


def spectrum(window) -> str:
    """Draw the radially averaged power spectrum of a window, with the band that it holds.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic, not flat, with the attributes that `periodic_window` leaves.
    """
    q, power = _thinned(*isotropic_spectrum(window))
    dimension = 3 if 1 in window.shape else 4
    unit_q, length = _inverse_length(q)
    scale, height_unit = _height_unit(window)
    # C is height^2 times area (of a profile times length)
    unit_power = scale**2 * unit_q ** -(dimension - 2)
    inside = power > 1e-20 * power.max()  # below lies the rounding of waves that were taken out
    with new_figure(4.3, 3.6) as figure:
        axes = figure.add_subplot()
        axes.loglog(q[inside] * unit_q, power[inside] * unit_power, color=COLOURS[0], linewidth=1.3)
        limits = q[0] * unit_q / 1.3, np.pi / min(_steps(window)) * unit_q * 1.3
        band = [2 * np.pi / window.attrs[f"band_{end}"] * unit_q for end in ("longest", "shortest")]
        outside = [(limits[0], band[0])] if band[0] > q[0] * unit_q * 1.01 else []
        if window.attrs["band_shortest"] > 2 * min(_steps(window)) * 1.01:
            outside.append((band[1], limits[1]))
        for index, span in enumerate(outside):
            axes.axvspan(*span, color="#e4e4e4", linewidth=0, label=None if index else "taken out")
        reliable = 2 * np.pi / window.attrs["reliable_wavelength"] * unit_q
        axes.axvline(
            reliable,
            color=COLOURS[1],
            linestyle="--",
            linewidth=1.1,
            label=f"reliable: {window.attrs['reliable_reason']}",
        )
        shortest = parameters.shortest_wavelength(window)
        if np.isfinite(shortest):
            axes.axvline(
                2 * np.pi / shortest * unit_q,
                color=COLOURS[2],
                linestyle=":",
                linewidth=1.3,
                label="shortest wave of the map",
            )
        axes.set_xlim(*limits)
        seen = power[inside] * unit_power
        axes.set_ylim(seen.min() / 30, seen.max() * 5)
        axes.set_xlabel(f"wavenumber q (rad/{length})")
        axes.set_ylabel(f"C(q) ({height_unit}² {length}{'²' if dimension == 4 else ''})")
        top = axes.secondary_xaxis("top", functions=(_turn_over, _turn_over))
        top.set_xlabel(f"wavelength ({length})")
        axes.legend(loc="lower left")
        return as_svg(figure)


def directional_spectrum(window) -> str:
    """Draw the power of the waves of a window over their direction, logarithmic, the longest in the middle.

    The mean over 3 x 3 waves is drawn, out to the waves that carry 99 % of the mean square gradient.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic, not flat, no profile.
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


def autocorrelation_map(window) -> str:
    """Draw the autocorrelation of a window around no shift, with the line where it falls to 0.2.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic, not flat; a profile is drawn as a line.
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


def _picture(window, values, positions, *, axes_label, bar_label, limits, colours, contour=None) -> str:
    """Draw values over the positions (x, y) of their points, upright as the maps are."""
    x, y = positions
    half_x, half_y = ((p[1] - p[0]) / 2 if p.size > 1 else 0.5 for p in (x, y))
    extent = (x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y)
    aspect = (extent[3] - extent[2]) / (extent[1] - extent[0])
    aspect = aspect if 0.25 <= aspect <= 4 else 1.0
    width = min(_WIDTH, 3.6 / aspect)
    full = (_WIDTH + 1.65, width * aspect + 0.65)
    with new_figure(*full, layout=None) as figure:
        axes = figure.add_axes((0.75 / full[0], 0.5 / full[1], width / full[0], width * aspect / full[1]))
        axes.grid(False)
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
        beside = figure.add_axes(
            ((0.85 + width) / full[0], 0.5 / full[1], 0.12 / full[0], width * aspect / full[1])
        )
        bar = figure.colorbar(image, cax=beside, label=bar_label)
        bar.outline.set_linewidth(0.5)
        return as_png(figure)


def _thinned(q, power):
    """Return the spectrum with shells put together where there are many per factor of ten."""
    bins = np.floor(_SHELLS * np.log10(q / q[0]) + 1e-9).astype(int)
    _, bins, count = np.unique(bins, return_inverse=True, return_counts=True)
    return np.bincount(bins, weights=q) / count, np.bincount(bins, weights=power) / count


def _turn_over(value):
    """Return the wavelength that belongs to a wavenumber, or the other way round."""
    return 2 * np.pi / np.maximum(value, 1e-300)


def _steps(window):
    return [d for n, d in zip(window.shape, spacing(window), strict=True) if n > 1]


def _inverse_length(q):
    """Return the factor that brings wavenumbers into a handy unit, and the name of its length."""
    factor, length = prefix(2 * np.pi / np.median(np.abs(q[q != 0])), "m")
    return 1 / factor, length


def _height_unit(window):
    """Return the factor and the name of the unit that suits the heights."""
    return prefix(float(np.std(window.values)), "m")
