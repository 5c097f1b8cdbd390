"""Charts of results against load: area, gap, pressure; of distributions and comparisons, as data URIs."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, GAP, PEAK, PRESSURE, UNITS
from roughcontact.report.charts import COLOURS, DASHED, DASHES, DOTTED, FOR_COMPARISON, Axis, Chart, log_axis
from roughcontact.report.units import common_pressure, interval_values, is_unbounded, stated_loads, unit_of
from roughcontact.statistics import theory
from roughcontact.statistics.theory import AREAS
from roughcontact.surface.roughness.summits import summit_statistics

_MAX_FLOW = 0.1  # of the load, up to which elastic theories are drawn beside a contact that yields
_SHOWN_BELOW = 0.1  # of the least area: an interval that ends below is drawn as far as the axis reaches


def area_against_load(statistics: xr.Dataset, window: xr.DataArray | None) -> Chart:
    """Draw the contact area against the load, corrected and counted, with the theories as lines.

    Persson (2001), J. Chem. Phys. 115, 3840; Xu, Li, Chen and Zhou (2024), Int. J. Solids Struct., 112684;
    Bush, Gibson and Thomas (1975), Wear 35, 87; Greenwood and Williamson (1966), Proc. R. Soc. A 295, 300,
    from the summits of `window`.
    """
    unit = float(statistics["contact_modulus"] * statistics["rms_gradient"])
    pascals, (_, load, label, _) = unit_of(statistics, "Pa"), stated_loads(statistics)
    relative = statistics["relative_pressure"].values
    elastic = relative[statistics.get("load_share_above_hardness", 0 * relative) < _MAX_FLOW]
    estimate, *bounds = interval_values(statistics, AREA)
    areas = np.concatenate([estimate, _clipped_ends(bounds[0], estimate), theory.persson_area(relative)])
    chart = _area_chart(load, areas, label=label)
    if has_theories(statistics):
        line = np.geomspace(elastic.min() / 1.5, elastic.max() * 1.5, 100)
        x = line * unit * pascals.factor
        chart.line(x, 100 * theory.persson_area(line), dash=DASHED, label="Persson", **FOR_COMPARISON)
        chart.line(x, 100 * theory.xu_area(line), label="Xu et al.", **FOR_COMPARISON)
        low_load = 100 * theory.bush_gibson_thomas_area(line)
        chart.line(x, low_load, dash=DOTTED, label="Bush et al., low load", **FOR_COMPARISON)
        if window is not None:
            modulus, summits = float(statistics["contact_modulus"]), summit_statistics(window)
            area = theory.greenwood_williamson_area(line * unit, summits, contact_modulus=modulus)
            if np.isfinite(area).any():
                look = FOR_COMPARISON | {"colour": "#8a5a00", "dash": DASHES[-1]}
                chart.line(x, 100 * area, label="Greenwood-Williamson", **look)
    chart.bars(load, *(100 * bound for bound in bounds), colour=COLOURS[0])
    pixels = 100 * statistics[f"{AREA}_pixels"].values
    chart.marks(load, pixels, colour=COLOURS[0], filled=False, label="solved, pixels counted")
    chart.marks(load, 100 * estimate, colour=COLOURS[0], label="solved, corrected")
    return chart


def has_theories(statistics: xr.Dataset) -> bool:
    """Return whether the theories, which are of elastic half-spaces, are of these bodies."""
    is_elastic = statistics.get("load_share_above_hardness", xr.DataArray(0.0)) < _MAX_FLOW
    return bool(np.isfinite(np.asarray(statistics.get(AREAS[0], 1.0))).any() and is_elastic.any())


def compare_areas(results: Mapping[str, xr.Dataset], styles: Mapping[str, dict[str, Any]]) -> str:
    """Draw the contact area with its interval against the load of surfaces or groups, by their labels.

    Of groups (of `group_statistics`) each map is drawn, too. `styles` are those of `series_style`. The loads,
    which rise, are mean pressures.
    """
    pressure = common_pressure(results.values())
    loads = {name: result["mean_pressure"].values * pressure.factor for name, result in results.items()}
    intervals = {name: interval_values(result, AREA) for name, result in results.items()}
    maps = {name: result.get(f"{AREA}_of_maps", xr.DataArray([])) for name, result in results.items()}
    areas, lower, _ = (np.concatenate(values) for values in zip(*intervals.values(), strict=True))
    points = [areas, _clipped_ends(lower, areas), *map(np.ravel, maps.values())]
    y, x = np.concatenate(points), np.concatenate([*loads.values()])
    chart = _area_chart(x, y, size=(560.0, 430.0), letters=13.0, label=f"mean pressure ({pressure.symbol})")
    room = min(0.08, 0.3 / len(results))  # ln(load) between the maps of a group and its mean
    for index, (name, style) in enumerate(styles.items()):
        is_group = maps[name].size > 0
        # groups are a little apart at each load, so that none hides another
        load = loads[name] * np.exp(is_group * room * (2 * index - len(results) + 1.5))
        for of_map in maps[name].values:
            chart.marks(load * np.exp(-room), 100 * of_map, **style | {"filled": False})
        area, *bounds = (100 * values for values in intervals[name])
        chart.bars(load, *bounds, colour=style["colour"])
        chart.marks(load, area, width=0.0 if is_group else 1.0, label=name, **style)
    return chart.source()


def bars_in_words(numbers: xr.Dataset, *names: str) -> str:
    """Return how the bars of these quantities in a figure are to be read, where there are any."""
    available = [name for name in names if f"{name}_lower" in numbers]
    arrow = any(is_unbounded(numbers, name) for name in available)
    return f"Bars: the ±{'; an arrow: nothing bounds it upwards' * arrow}." if available else ""


def _area_chart(loads: np.ndarray, areas: np.ndarray, *, label: str, **options: Any) -> Chart:
    """Return the log-log axes of area (percent) against load that hold these shares; `options` of `Chart`."""
    lowest = max(np.min(areas[areas > 0], initial=1.0) / 2, 1e-8)  # down to half of the smallest area
    y = Axis("contact area (%)", 100 * lowest, 100.0, log=True)
    return Chart(log_axis(label, loads), y, **options)


def _clipped_ends(lower_bounds: np.ndarray, areas: np.ndarray) -> np.ndarray:
    """Return lower ends of areas as far as an axis shows them, down to a tenth of the least area."""
    return np.maximum(lower_bounds, _SHOWN_BELOW * np.min(areas[areas > 0], initial=1.0))


def gap_against_load(statistics: xr.Dataset) -> Chart:
    """Draw the mean gap with its interval against the load, both logarithmic, with the rms height."""
    return _load_chart(statistics, "mean gap", [(GAP, "mean gap", COLOURS[2], "o")], limit="rms_height")


def pressure_against_load(statistics: xr.Dataset) -> Chart:
    """Draw mean and largest pressure of the contact with their intervals against the load, logarithmic."""
    lines = [(PEAK, "largest", COLOURS[1], "^"), (PRESSURE, "mean over the contact", COLOURS[0], "o")]
    return _load_chart(statistics, "pressure in contact", lines, limit="hardness")


def _load_chart(
    statistics: xr.Dataset, label: str, lines: Sequence[tuple[str, str, str, str]], *, limit: str
) -> Chart:
    """Draw results (name, label, colour, marker) and a `limit`, by its name, against the load."""
    (_, load, name_of_load, _), unit = stated_loads(statistics), unit_of(statistics, UNITS[lines[0][0]])
    results = [[values * unit.factor for values in interval_values(statistics, name)] for name, *_ in lines]
    at_limit = float(statistics.get(limit, np.nan)) * unit.factor
    all_values = np.concatenate([*(values for result in results for values in result), [at_limit]])
    # a gap that is closed but for rounding would make the axis endless
    all_values[all_values < 1e-5 * np.nanmax(all_values)] = np.nan
    y = log_axis(f"{label} ({unit.symbol})", all_values, room=1.6)
    chart = Chart(log_axis(name_of_load, load), y)
    if np.isfinite(at_limit):
        chart.across(y=at_limit, dash=DASHED, label=limit.replace("_", " "))
    for (_, text, colour, marker), (value, *bounds) in zip(lines, results, strict=True):
        chart.bars(load, *bounds, colour=colour)
        chart.marks(load, value, colour=colour, marker=marker, width=1.4, label=text)
    return chart


def pressure_distribution(statistics: xr.Dataset, loads: Sequence[int]) -> Chart:
    """Draw the distribution of the contact pressure at the loads of these indices, contact points only.

    The share of the contact per factor e of pressure, p P(p), so that equal areas are equal shares; dotted
    lines are the means over the contact.
    """
    bounds, (factor, symbol) = statistics["pressure_bin_bounds"].values, unit_of(statistics, "Pa")
    shares = statistics["pressure_density"].fillna(0.0).values * np.diff(bounds, axis=1).ravel()
    widths = np.log(bounds[1:, 1] / bounds[1:, 0])
    carrying = np.nonzero((shares[loads, 1:] > 1e-4).any(axis=0))[0]
    lowest, last = (carrying[0], carrying[-1]) if carrying.size else (0, len(widths) - 1)
    low, high = bounds[1 + lowest, 0], bounds[1 + last, 1]
    highest = 1.05 * float((shares[loads, 1:] / widths).max()) or 1.0
    x = Axis(f"contact pressure p ({symbol})", low * factor, high * factor * 1.15, log=True)
    chart = Chart(x, Axis("share of the contact per factor e", 0.0, highest))
    for index, load in enumerate(loads):
        edges = np.repeat(np.append(bounds[1:, 0], bounds[-1, 1]) * factor, 2)
        steps = np.concatenate([[0.0], np.repeat(shares[load, 1:] / widths, 2), [0.0]])
        chart.line(edges, steps, colour=COLOURS[index], label=stated_loads(statistics).texts[load])
        mean = float(statistics[PRESSURE][load]) * factor
        text = "mean over the contact" if load == loads[-1] else ""
        chart.across(x=mean, colour=COLOURS[index], dash=DOTTED, label=text)
    return chart
