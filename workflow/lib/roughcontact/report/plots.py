"""The figures of the report: each function returns the source of an image, a data URI, same for same data."""

import base64
import io
from contextlib import contextmanager

import numpy as np

from roughcontact.maps import spacing
from roughcontact.quantities import prefix, quantity
from roughcontact.roughness.summits import summit_statistics
from roughcontact.statistics import theory

# Okabe and Ito (2008): eight colours that colour-blind people can tell apart (yellow left out: too pale for
# lines)
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
NOT_MEASURED = "#ff4fa3"
NO_CONTACT = "#e4e4e4"
CONTACT = "#ffffff"

_STYLE = {
    "svg.hashsalt": "roughcontact",
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": True,
    "legend.framealpha": 0.75,
    "legend.edgecolor": "none",
    "legend.fontsize": 8,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
}
_MAP_POINTS = 1200  # along the longer side of a drawn map; finer maps are thinned
_WIDTH = 2.55  # of a square map, inches
_LONGEST_ASPECT = 4.0  # longer maps are drawn out of scale


@contextmanager
def new_figure(width: float, height: float, *, layout="constrained"):
    """Yield a figure of so many inches that belongs to no window and no other figure."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout=layout)
        FigureCanvasAgg(figure)
        yield figure


def as_png(figure) -> str:
    """Return the figure as PNG with a palette: a third of the size, and no dates or versions inside.

    The palette covers all the colours there are, not the frequent ones: the colour bar stays smooth.
    """
    from PIL import Image

    figure.set_dpi(144)
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")
    palette = {"method": Image.Quantize.MAXCOVERAGE, "kmeans": 1, "dither": Image.Dither.NONE}
    buffer = io.BytesIO()
    image.quantize(256, **palette).save(buffer, "png", optimize=True)
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()


def as_svg(figure) -> str:
    """Return the figure as SVG without a date."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    return "data:image/svg+xml;base64," + base64.b64encode(buffer.getvalue()).decode()


def height_map(height, *, rectangle=None) -> str:
    """Draw a height map, points that were not measured in pink; a profile is drawn as a line.

    Parameters
    ----------
    height : DataArray (y, x), m
    rectangle : (x, y, length x, length y) in m, or None
        Outline of the window on the map, from the map's first corner.
    """
    label = "height"
    if 1 in height.shape:
        return _profile(height, [(height.values.ravel(), "height", COLOURS[0])], label=label, unit="m")
    values = height.values - np.nanmean(height.values)
    limits = np.nanpercentile(values, [0.1, 99.9])  # spikes must not take all the colours
    return _map(
        height,
        values,
        label=label,
        unit="m",
        colours="viridis",
        bad=NOT_MEASURED,
        limits=limits,
        extend="both",
        frame=rectangle,
    )


def pressure_map(height, pressure) -> str:
    """Draw the contact pressure over the window, no contact in grey; a profile is drawn as a line.

    Parameters
    ----------
    height : DataArray (y, x), m
        The window, for its coordinates.
    pressure : array (ny, nx), Pa
    """
    if 1 in pressure.shape:
        return _profile(height, [(pressure.ravel(), "pressure", COLOURS[1])], label="pressure", unit="Pa")
    return _map(
        height,
        np.where(pressure > 0, pressure, np.nan),
        label="pressure",
        unit="Pa",
        colours="viridis",
        bad=NO_CONTACT,
        limits=(0, np.percentile(pressure[pressure > 0], 99.5)),  # a few peaks must not take all the colours
        extend="max",
    )


def gap_map(height, gap, pressure) -> str:
    """Draw the gap over the window with the contact in white; a profile shows both faces as lines.

    Parameters
    ----------
    height : DataArray (y, x), m
    gap : array (ny, nx), m
    pressure : array (ny, nx), Pa
    """
    if 1 in gap.shape:
        faces = [
            (height.values.ravel(), "rough surface", COLOURS[0]),
            ((height.values + gap).ravel(), "deformed surface", COLOURS[1]),
        ]
        return _profile(height, faces, label="height", unit="m")
    widest = gap[pressure == 0].max(initial=0.0) or np.ptp(
        height.values
    )  # full contact leaves no gap to scale by
    return _map(
        height,
        np.where(pressure > 0, np.nan, gap),
        label="gap",
        unit="m",
        colours="cividis",
        bad=CONTACT,
        limits=(0, widest),
    )


def _map(height, values, *, label, unit, colours, bad, limits, extend="neither", frame=None) -> str:
    """Draw values over the extent of `height`; NaN in the colour `bad`, an arrow where colours end early.

    The first row is drawn where the instrument's own software draws it. A map finer than the picture is
    drawn as it looks from afar: colours, not values, are averaged, so that the contact keeps its share.
    """
    import matplotlib
    from matplotlib.patches import Rectangle

    lengths = [n * pitch for n, pitch in zip(height.shape, spacing(height), strict=True)]
    factor, length_unit = prefix(max(lengths), "m")
    ly, lx = (length * factor for length in lengths)
    scale, value_unit = prefix(max(abs(limits[0]), abs(limits[1])), unit)
    aspect = ly / lx
    in_scale = 1 / _LONGEST_ASPECT <= aspect <= _LONGEST_ASPECT
    if not in_scale:
        aspect = 1.0
    # margins in inches: the labels always fit, and maps of one shape come out alike
    width = min(_WIDTH, 3.6 / aspect)
    full = (_WIDTH + 1.65, width * aspect + 0.65)
    with new_figure(*full, layout=None) as figure:
        axes = figure.add_axes((0.7 / full[0], 0.5 / full[1], width / full[0], width * aspect / full[1]))
        axes.grid(False)
        colour_map = matplotlib.colormaps[colours].with_extremes(bad=bad)
        image = axes.imshow(
            np.ma.masked_invalid(values[:: _step(values.shape[0]), :: _step(values.shape[1])] * scale),
            origin="lower",
            extent=(0, lx, 0, ly),
            cmap=colour_map,
            vmin=limits[0] * scale,
            vmax=limits[1] * scale if limits[1] > limits[0] else limits[0] * scale + 1,
            interpolation="auto",
            interpolation_stage="rgba",
            aspect="auto",
        )
        if height.attrs.get("first_row") == "top":
            axes.invert_yaxis()
        if frame is not None:
            x, y, *sides = (value * factor for value in frame)
            for colour, line in (("white", 3.0), ("#d00000", 1.5)):
                axes.add_patch(Rectangle((x, y), *sides, fill=False, edgecolor=colour, linewidth=line))
        axes.set_xlabel(f"x ({length_unit})")
        axes.set_ylabel(f"y ({length_unit})" + ("" if in_scale else ", not to scale"))
        beside = figure.add_axes(
            ((0.8 + width) / full[0], 0.5 / full[1], 0.12 / full[0], width * aspect / full[1])
        )
        bar = figure.colorbar(image, cax=beside, extend=extend, label=f"{label} ({value_unit})")
        bar.outline.set_linewidth(0.5)
        return as_png(figure)


def _profile(height, lines, *, label, unit) -> str:
    """Draw one or more lines along a profile, gaps where values are missing."""
    along = "x" if height.sizes["x"] > 1 else "y"
    position = height[along].values - height[along].values[0]
    factor, length_unit = prefix(float(position[-1]), "m")
    scale, value_unit = prefix(float(np.nanmax([np.nanmax(np.abs(line[0])) for line in lines])), unit)
    with new_figure(4.0, 2.6) as figure:
        axes = figure.add_subplot()
        for values, name, colour in lines:
            axes.plot(position * factor, values * scale, color=colour, linewidth=0.9, label=name)
        axes.set_xlabel(f"{along} ({length_unit})")
        axes.set_ylabel(f"{label} ({value_unit})")
        if len(lines) > 1:
            axes.legend()
        return as_svg(figure)


def area_against_load(statistics, window) -> str:
    """Draw the contact area against the load, corrected and raw, with the theories as lines.

    Parameters
    ----------
    statistics : Dataset
        Of one surface, with a finite relative pressure at every load.
    window : DataArray (y, x), m
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
        raw, corrected = (
            statistics[f"relative_contact_area{name}"].values[order] for name in ("_pixels", "")
        )
        style = {"color": COLOURS[0], "marker": "o", "markersize": 5, "linestyle": "none"}
        axes.plot(load[order], raw, fillstyle="none", label="solved, pixels counted", **style)
        axes.plot(load[order], corrected, label="solved, corrected", **style)
        _area_axes(axes, load, corrected)
        factor, shown = prefix(float(np.median(load)) * unit, "Pa")
        pascal = unit * factor
        top = axes.secondary_xaxis("top", functions=(lambda p: p * pascal, lambda p: p / pascal))
        top.set_xlabel(f"mean pressure p̄ ({shown})")
        axes.legend(loc="lower right")
        return as_svg(figure)


def compare_areas(series) -> str:
    """Draw the contact area against the load of several surfaces or cases, with the theories that fit all.

    Parameters
    ----------
    series : list of (label, relative pressures, relative contact areas)
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


def _theory_lines(axes, loads) -> np.ndarray:
    """Draw the theories that depend on p' alone; return the loads at which they are drawn."""
    line = np.geomspace(loads.min() / 1.5, loads.max() * 1.5, 200)
    style = {"color": "#444444", "linewidth": 1.1}
    axes.plot(line, theory.persson_area(line), linestyle="--", label="Persson", **style)
    axes.plot(line, theory.xu_area(line), label="Xu et al.", **style)
    low = theory.bush_gibson_thomas_area(line)
    axes.plot(line, low, linestyle=":", label="Bush-Gibson-Thomas, low load", **style)
    return line


def _area_axes(axes, loads, areas) -> None:
    """Set the log-log axes of area against load."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(loads.min() / 1.5, loads.max() * 1.5)
    axes.set_ylim(max(np.min(areas[areas > 0], initial=1.0) / 3, 1e-8), 1.4)
    axes.set_xlabel("relative pressure p′ = p̄ / (E* g)")
    axes.set_ylabel("relative contact area A/A₀")


def gap_against_load(statistics) -> str:
    """Draw the mean gap against the mean pressure (logarithmic), the rms height beside it.

    Parameters
    ----------
    statistics : Dataset
        Of one surface.
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


def pressure_distribution(statistics, loads) -> str:
    """Draw the distribution of the contact pressure at a few loads, contact points only.

    The share of the contact per factor e of pressure, p P(p), so that equal areas are equal shares.

    Parameters
    ----------
    statistics : Dataset
        Of one surface.
    loads : list of int
        Which loads to draw.
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


def _step(points: int) -> int:
    """Return every how manieth of so many points is drawn."""
    return -(-points // _MAP_POINTS)
