"""The figures of the report that show results against the load: area, gap, distribution of the pressure."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from roughcontact.quantities import prefix, quantity
from roughcontact.report.figures import COLOURS, MARKERS, as_svg, new_figure
from roughcontact.roughness.summits import summit_statistics
from roughcontact.statistics import theory


def area_against_load(statistics: xr.Dataset, window: xr.DataArray) -> str:
    """Draw the contact area against the load, corrected and counted, with the theories as lines.

    Parameters
    ----------
    statistics : Dataset
        of one surface, with a finite relative pressure at every load.
    window : DataArray (y, x), m
        the map that was solved, for its summits.

    Returns
    -------
    str
        source of the image, a data URI.

    References
    ----------
    .. [1] Persson (2001), J. Chem. Phys. 115, 3840.
    .. [2] Xu, Li, Chen and Zhou (2024), Int. J. Solids Struct., 112684.
    .. [3] Bush, Gibson and Thomas (1975), Wear 35, 87.
    .. [4] Greenwood and Williamson (1966), Proc. R. Soc. A 295, 300.
    """
    unit = float(statistics["contact_modulus"] * statistics["rms_gradient"])
    load = statistics["relative_pressure"].values
    with new_figure(4.3, 3.6) as figure:
        axes = figure.add_subplot()
        line = _theory_lines(axes, load)
        modulus = float(statistics["contact_modulus"])
        summits = summit_statistics(window)
        area = theory.greenwood_williamson_area(line * unit, summits, contact_modulus=modulus)
        if np.isfinite(area).any():
            axes.plot(
                line, area, color="#8a5a00", linestyle="-.", linewidth=1.1, label="Greenwood-Williamson"
            )
        order = np.argsort(load)
        counted, corrected = (
            statistics[f"relative_contact_area{name}"].values[order] for name in ("_pixels", "")
        )
        for values, filling, label in (
            (counted, "none", "solved, pixels counted"),
            (corrected, "full", "solved, corrected"),
        ):
            axes.plot(
                load[order],
                values,
                fillstyle=filling,
                label=label,
                color=COLOURS[0],
                marker="o",
                markersize=5,
                linestyle="none",
            )
        _area_axes(axes, load, corrected)
        factor, shown = prefix(float(np.median(load)) * unit, "Pa")
        pascal = unit * factor
        top = axes.secondary_xaxis(
            "top", functions=(lambda p: np.asarray(p) * pascal, lambda p: np.asarray(p) / pascal)
        )
        top.set_xlabel(f"mean pressure p̄ ({shown})")
        axes.legend(loc="lower right")
        return as_svg(figure)


def compare_areas(series: Sequence[tuple[str, np.ndarray, np.ndarray]]) -> str:
    """Draw the contact area against the load of several surfaces or cases, with the theories that fit all.

    Parameters
    ----------
    series : sequence of (label, relative pressures, relative contact areas)
        one entry for each surface under each case.

    Returns
    -------
    str
        source of the image, a data URI.

    Examples
    --------
    >>> import numpy as np
    >>> compare_areas([("one", np.array([0.01, 0.1]), np.array([0.02, 0.2]))]).partition(",")[0]
    'data:image/svg+xml;base64'
    """
    loads = np.concatenate([load for _, load, _ in series])
    areas = np.concatenate([area for _, _, area in series])
    rows = -(-len(series) // 3)
    with new_figure(6.6, 4.3 + 0.22 * rows) as figure:
        axes = figure.add_subplot()
        _theory_lines(axes, loads)
        theories = axes.legend(loc="lower right")
        drawn = []
        for index, (label, load, area) in enumerate(series):
            order = np.argsort(load)
            drawn += axes.plot(
                load[order],
                area[order],
                color=COLOURS[index % len(COLOURS)],
                marker=MARKERS[(index // len(COLOURS) + index) % len(MARKERS)],
                markersize=5,
                linewidth=0.8,
                label=label,
            )
        axes.add_artist(theories)
        _area_axes(axes, loads, areas)
        figure.legend(handles=drawn, loc="outside lower center", ncols=3)
        return as_svg(figure)


def _theory_lines(axes: Axes, loads: np.ndarray) -> np.ndarray:
    """Draw the theories that depend on p' alone; return the loads at which they are drawn."""
    line = np.geomspace(loads.min() / 1.5, loads.max() * 1.5, 200)
    for area, style, label in (
        (theory.persson_area(line), "--", "Persson"),
        (theory.xu_area(line), "-", "Xu et al."),
        (theory.bush_gibson_thomas_area(line), ":", "Bush-Gibson-Thomas, low load"),
    ):
        axes.plot(line, area, linestyle=style, label=label, color="#444444", linewidth=1.1)
    return line


def _area_axes(axes: Axes, loads: np.ndarray, areas: np.ndarray) -> None:
    """Set the log-log axes of area against load."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(loads.min() / 1.5, loads.max() * 1.5)
    axes.set_ylim(max(np.min(areas[areas > 0], initial=1.0) / 3, 1e-8), 1.4)
    axes.set_xlabel("relative pressure p′ = p̄ / (E* g)")
    axes.set_ylabel("relative contact area A/A₀")


def gap_against_load(statistics: xr.Dataset) -> str:
    """Draw the mean gap against the mean pressure (logarithmic), the rms height beside it.

    Parameters
    ----------
    statistics : Dataset
        of one surface.

    Returns
    -------
    str
        source of the image, a data URI.

    Examples
    --------
    >>> import xarray as xr
    >>> numbers = xr.Dataset({"mean_pressure": ("load", [1e6, 2e6]), "mean_gap": ("load", [2e-7, 1e-7])})
    >>> gap_against_load(numbers.assign(rms_height=3e-7)).partition(",")[0]
    'data:image/svg+xml;base64'
    """
    order = np.argsort(statistics["mean_pressure"].values)
    load, gap = (statistics[name].values[order] for name in ("mean_pressure", "mean_gap"))
    rms = float(statistics["rms_height"])
    factor, load_unit = prefix(float(np.median(load)), "Pa")
    scale, gap_unit = prefix(max(float(gap.max()), rms), "m")
    with new_figure(4.3, 3.6) as figure:
        axes = figure.add_subplot()
        axes.axhline(rms * scale, color="#444444", linestyle="--", linewidth=1.1, label="rms height")
        axes.plot(load * factor, gap * scale, "o-", color=COLOURS[2], markersize=5, label="mean gap")
        axes.set_xscale("log")
        axes.set_ylim(bottom=0)
        axes.set_xlabel(f"mean pressure p̄ ({load_unit})")
        axes.set_ylabel(f"mean gap ū ({gap_unit})")
        axes.legend()
        return as_svg(figure)


def pressure_distribution(statistics: xr.Dataset, loads: Sequence[int]) -> str:
    """Draw the distribution of the contact pressure at a few loads, contact points only.

    The share of the contact per factor e of pressure, p P(p), so that equal areas are equal shares.

    Parameters
    ----------
    statistics : Dataset
        of one surface.
    loads : sequence of int
        which loads to draw.

    Returns
    -------
    str
        source of the image, a data URI.
    """
    bounds = statistics["pressure_bin_bounds"].values
    shares = statistics["pressure_density"].values * np.diff(bounds, axis=1).ravel()
    peak = float(statistics["max_pressure"].values[loads].max())
    factor, unit = prefix(peak, "Pa")
    widths = np.log(bounds[1:, 1] / bounds[1:, 0])
    with new_figure(4.3, 3.6) as figure:
        axes = figure.add_subplot()
        for index, load in enumerate(loads):
            label = f"p̄ = {quantity(float(statistics['mean_pressure'][load]), 'Pa')}"
            colour = COLOURS[index]
            edges = np.append(bounds[1:, 0], bounds[-1, 1]) * factor
            axes.stairs(shares[load, 1:] / widths, edges, color=colour, linewidth=1.3, label=label)
            mean = float(statistics["mean_contact_pressure"][load]) * factor
            axes.axvline(mean, color=colour, linestyle=":", linewidth=1.1)
        axes.set_xscale("log")
        carrying = np.nonzero((shares[loads, 1:] > 1e-4).any(axis=0))[0]
        first = carrying[0] if carrying.size else 0
        axes.set_xlim(bounds[1 + first, 0] * factor, peak * factor * 1.3)
        axes.set_ylim(0, 1.35 * float((shares[loads, 1:] / widths).max()))  # room for the legend
        axes.set_xlabel(f"contact pressure p ({unit})")
        axes.set_ylabel("p P(p), share of the contact per factor e")
        axes.legend(loc="upper left", title="dotted: mean over the contact", title_fontsize=8)
        return as_svg(figure)
