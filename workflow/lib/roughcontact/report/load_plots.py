"""The figures of the report that show results against the load: area, gap, distribution of the pressure."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from roughcontact.quantities import prefix, quantity
from roughcontact.report.charts import (
    COLOURS,
    DASH_DOTTED,
    DASHED,
    DOTTED,
    GREY,
    MARKERS,
    Axis,
    Chart,
)
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
    factor, shown = prefix(float(np.median(load)) * unit, "Pa")
    corrected = statistics["relative_contact_area"].values
    chart = _area_chart(load, corrected, pascal=(unit * factor, shown))
    line = _theory_lines(chart, load)
    modulus = float(statistics["contact_modulus"])
    summits = summit_statistics(window)
    area = theory.greenwood_williamson_area(line * unit, summits, contact_modulus=modulus)
    if np.isfinite(area).any():
        chart.line(line, area, colour="#8a5a00", dash=DASH_DOTTED, width=1.3, label="Greenwood-Williamson")
    counted = statistics["relative_contact_area_pixels"].values
    chart.marks(load, counted, colour=COLOURS[0], filled=False, label="solved, pixels counted")
    chart.marks(load, corrected, colour=COLOURS[0], label="solved, corrected")
    return chart.source("lower right")


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
    'data:image/svg+xml'
    """
    loads = np.concatenate([load for _, load, _ in series])
    areas = np.concatenate([area for _, _, area in series])
    chart = _area_chart(loads, areas, size=(660.0, 430.0))
    _theory_lines(chart, loads)
    for index, (label, load, area) in enumerate(series):
        order = np.argsort(load)
        marker = MARKERS[(index // len(COLOURS) + index) % len(MARKERS)]
        colour = COLOURS[index % len(COLOURS)]
        chart.marks(load[order], area[order], colour=colour, marker=marker, joined=1.0, label=label)
    return chart.source("below")


def spread_of_areas(groups: Mapping[str, Sequence[tuple[np.ndarray, np.ndarray]]]) -> str:
    """Draw the contact area against the load of very many surfaces: each as a faint line, medians in colour.

    Parameters
    ----------
    groups : mapping
        name of a case ("" in a run without cases) -> (relative pressures, relative contact areas) of each of
        its surfaces.

    Returns
    -------
    str
        source of the image, a data URI.

    Examples
    --------
    >>> import numpy as np
    >>> one = np.array([0.01, 0.1]), np.array([0.02, 0.2])
    >>> spread_of_areas({"": [one] * 3}).partition(",")[0]
    'data:image/svg+xml'
    """
    loads = np.concatenate([load for group in groups.values() for load, _ in group])
    areas = np.concatenate([area for group in groups.values() for _, area in group])
    chart = _area_chart(loads, areas, size=(660.0, 430.0))
    medians = []
    for index, (name, group) in enumerate(groups.items()):
        colour = COLOURS[index % len(COLOURS)]
        line = np.geomspace(min(load.min() for load, _ in group), max(load.max() for load, _ in group), 60)
        curves = []
        for load, area in group:
            order = np.argsort(load)
            chart.line(load[order], area[order], colour=f"{colour}38", width=0.8)
            logs = np.log(load[order]), np.log(np.maximum(area[order], 1e-300))
            curves.append(np.exp(np.interp(np.log(line), *logs, left=np.nan, right=np.nan)))
        known = np.isfinite(curves).sum(axis=0) >= max(len(group) / 2, 1)
        median = np.full(line.size, np.nan)
        median[known] = np.nanmedian(np.array(curves)[:, known], axis=0)
        medians.append((line, median, colour, f"median, {name}" if name else "median of the surfaces"))
    _theory_lines(chart, loads)
    for line, median, colour, label in medians:
        chart.line(line, median, colour=colour, width=2.6, label=label)
    return chart.source("below")


def _theory_lines(chart: Chart, loads: np.ndarray) -> np.ndarray:
    """Draw the theories that depend on p' alone; return the loads at which they are drawn."""
    line = np.geomspace(loads.min() / 1.5, loads.max() * 1.5, 100)
    for area, dash, label in (
        (theory.persson_area(line), DASHED, "Persson"),
        (theory.xu_area(line), "", "Xu et al."),
        (theory.bush_gibson_thomas_area(line), DOTTED, "Bush-Gibson-Thomas, low load"),
    ):
        chart.line(line, area, dash=dash, label=label, colour=GREY, width=1.3)
    return line


def _area_chart(
    loads: np.ndarray,
    areas: np.ndarray,
    *,
    size: tuple[float, float] = (430.0, 360.0),
    pascal: tuple[float, str] | None = None,
) -> Chart:
    """Return the log-log axes of area against load; `pascal` is a relative pressure of 1 and its unit."""
    low, high = loads.min() / 1.5, loads.max() * 1.5
    top = None
    if pascal is not None:
        factor, unit = pascal
        top = Axis(f"mean pressure p̄ ({unit})", low * factor, high * factor, log=True)
    least = max(np.min(areas[areas > 0], initial=1.0) / 3, 1e-8)
    return Chart(
        Axis("relative pressure p′ = p̄ / (E* g)", low, high, log=True),
        Axis("relative contact area A/A₀", least, 1.4, log=True),
        top=top,
        size=size,
    )


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
    'data:image/svg+xml'
    """
    order = np.argsort(statistics["mean_pressure"].values)
    load, gap = (statistics[name].values[order] for name in ("mean_pressure", "mean_gap"))
    rms = float(statistics["rms_height"])
    factor, load_unit = prefix(float(np.median(load)), "Pa")
    scale, gap_unit = prefix(max(float(gap.max()), rms), "m")
    ends = load[0] * factor / 1.5, load[-1] * factor * 1.5
    chart = Chart(
        Axis(f"mean pressure p̄ ({load_unit})", *ends, log=True),
        Axis(f"mean gap ū ({gap_unit})", 0.0, 1.08 * max(float(gap.max()), rms) * scale),
    )
    chart.across(y=rms * scale, dash=DASHED, label="rms height")
    chart.marks(load * factor, gap * scale, colour=COLOURS[2], joined=1.5, label="mean gap")
    return chart.source()


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
    carrying = np.nonzero((shares[loads, 1:] > 1e-4).any(axis=0))[0]
    first = carrying[0] if carrying.size else 0
    highest = 1.35 * float((shares[loads, 1:] / widths).max())  # room for the legend
    chart = Chart(
        Axis(f"contact pressure p ({unit})", bounds[1 + first, 0] * factor, peak * factor * 1.3, log=True),
        Axis("p P(p), share of the contact per factor e", 0.0, highest),
    )
    for index, load in enumerate(loads):
        edges = np.repeat(np.append(bounds[1:, 0], bounds[-1, 1]) * factor, 2)
        steps = np.concatenate([[0.0], np.repeat(shares[load, 1:] / widths, 2), [0.0]])
        label = f"p̄ = {quantity(float(statistics['mean_pressure'][load]), 'Pa')}"
        chart.line(edges, steps, colour=COLOURS[index], label=label)
        mean = float(statistics["mean_contact_pressure"][load]) * factor
        words = "mean over the contact" if load == loads[-1] else ""
        chart.across(x=mean, colour=COLOURS[index], dash=DOTTED, label=words)
    return chart.source("upper left")
