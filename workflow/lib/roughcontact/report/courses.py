"""What a result is solved for beside its loads: the way back, wear over the distance, speeds of rubber.

Each is a part of the page: charts and sentences of a file beside the statistics.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, CONDUCTANCE, ENDS, FRICTION, GAP, PEAK, TITLES, UNITS
from roughcontact.arguments.quantities import number, quantity
from roughcontact.arguments.relaxation import MAX_MISFIT
from roughcontact.report.charts import COLOURS, DASHED, Axis, Chart, curves_chart, load_label, log_axis
from roughcontact.report.template import sentence
from roughcontact.report.units import interval_values, length_unit, unit_of
from roughcontact.results.storage import read_dataset
from roughcontact.statistics.decisions import CLOSED

_UNLOADED = (
    *(AREA, "mean_gap", "contact_stiffness", "thermal_conductance", "electrical_conductance"),
    *("leak_rate_x", "leak_rate_y"),
)
_WORN = (AREA, PEAK, GAP, CONDUCTANCE, "leak_rate_x", "leak_rate_y")
_HEIGHTS = {"Sq": "root mean square", "Spk": "reduced peaks", "Svk": "reduced dales"}
_FRICTIONS = {
    "persson_friction_coefficient": "theory of Persson (2001)",
    "adhesive_friction_coefficient": "by the shear strength, alone",
}
WARM = 10.0  # K, by which the loss of a rubber shifts by half a decade of frequency
_BEFORE = {"wear": "Before sliding", "sliding": "At rest"}  # part -> the contact of which all else is

Part = tuple[dict[str, Chart], list[str]]  # charts by label, sentences


def course_sections(name: str, loading: xr.Dataset, results: Path, folder: Path) -> dict[str, dict[str, Any]]:
    """Return the parts of the page of a result by their place, with what their template needs.

    `loading` are the statistics, loads rising, `results` is the folder of the result, `folder` of the page.
    """
    sections = {}
    for part, (file, content) in _COURSES.items():
        if (path := results / file).is_file():
            charts, sentences = content(loading, read_dataset(path))
            images = {label: chart.source() for label, chart in charts.items()}
            link = Path(os.path.relpath(path, folder)).as_posix()
            sections[part] = {"name": name, "images": images, "sentences": sentences, "link": link}
    return sections


def answer_with_courses(line: str, courses: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the answer of a surface before its `line` of the contact at rest: that of wear or of sliding.

    Examples
    --------
    >>> answer_with_courses("At 1 MPa: ...", {"wear": {"sentences": ["Run in after 3 m: so. Proven: that."]}})
    'Run in after 3 m: so. Before sliding, at 1 MPa: ...'
    """
    for name, before in _BEFORE.items():
        if name in courses:
            first, *_ = courses[name]["sentences"][0].partition(". ")
            line = f"{first}. {before}, {line[:1].lower()}{line[1:]}" if line else f"{first}."
    return line


def _unloading(loading: xr.Dataset, residual: xr.Dataset) -> Part:
    """Return charts of both ways of the load, and a sentence for each peak."""
    suffix = "_as_solved"  # the way back has no correction for the grid either
    as_solved = [key for key in map(str, loading) if key.endswith(suffix)]
    loading = loading.assign({key.removesuffix(suffix): loading[key] for key in as_solved})
    if "peak" not in residual.dims:
        residual = residual.expand_dims("peak")
    peaks = [residual.isel(peak=index) for index in range(residual.sizes["peak"])]
    unloadings = [peak.isel(load=np.isfinite(peak["mean_pressure"].values)) for peak in peaks]
    charts = {TITLES[result]: _loading_and_unloading(loading, unloadings, result) for result in _UNLOADED}
    drawn = {label: chart for label, chart in charts.items() if chart}
    return drawn, [_lowered(loading, unloading) for unloading in unloadings]


def _loading_and_unloading(
    loading: xr.Dataset, unloadings: Sequence[xr.Dataset], result: str
) -> Chart | None:
    """Draw one result on loading and on unloading against the load, both logarithmic, if all have it."""
    curves = [loading.sortby("mean_pressure"), *unloadings]
    if not all(result in curve for curve in curves):
        return None
    pascals, unit = unit_of(loading, "Pa"), unit_of(loading, UNITS[result])
    loads = [curve["mean_pressure"].values * pascals.factor for curve in curves]
    values = [curve[result].values * unit.factor for curve in curves]
    if not (np.concatenate(values) > 0).any():
        return None
    y_axis = log_axis(f"{TITLES[result]} ({unit.symbol})", np.concatenate(values), room=1.6)
    chart = Chart(log_axis(load_label(pascals), np.concatenate(loads)), y_axis)
    for index, (curve, x, y) in enumerate(zip(curves, loads, values, strict=True)):
        unloading = f"unloading from {quantity(float(curve['peak_pressure']), 'Pa')}" if index else "loading"
        chart.line(x, y, colour=COLOURS[index % len(COLOURS)], dash=DASHED if index else "", label=unloading)
    return chart


def _lowered(loading: xr.Dataset, unloading: xr.Dataset) -> str:
    """Return what flow has lowered by how much, and the area of both ways at the lowest load, in words."""
    lightest = unloading.isel(load=int(np.argmin(unloading["mean_pressure"].values)))
    loads, areas = (loading.sortby("mean_pressure")[name].values for name in ("mean_pressure", AREA))
    load = float(lightest["mean_pressure"])
    ways = {"on loading": np.interp(load, loads, areas, left=np.nan), "on unloading": lightest[AREA]}
    areas_by_way = {way: float(area) for way, area in ways.items() if np.isfinite(area)}
    return sentence("flow_has_lowered", _scalars(unloading), load, areas_by_way)


def _sliding(_: xr.Dataset, over: xr.Dataset) -> Part:
    """Return charts of friction and contact over the speed, and the sentence of the friction.

    Of several directions all but the friction is of the one with the largest.
    """
    from roughcontact.report.map_plots import pressure_map  # with all that levels maps, for few pages

    over = over if "direction" in over.dims else over.expand_dims("direction")
    ways = [over.isel(direction=index) for index in range(over.sizes["direction"])]
    highest = [way.isel(speed=int(way[FRICTION].values.argmax())) for way in ways]
    first = int(np.argmax([way[FRICTION].item() for way in highest]))
    course, speed = ways[first], over["speed"].values
    x_axis = log_axis("sliding speed v (m/s)", speed, room=1.3)
    way_labels = [f", {way['direction'].item():g}°" if len(ways) > 1 else "" for way in ways]
    curves = {
        f"hysteresis, as solved{name}": interval_values(way, FRICTION)
        for way, name in zip(ways, way_labels, strict=True)
    }
    curves |= {label: [course[name].values] for name, label in _FRICTIONS.items() if name in over}
    charts = {
        "coefficient of friction over the speed": curves_chart(
            x_axis, speed, "coefficient of friction μ", curves
        ),
        f"pressure at {highest[first]['speed'].item():.3g} m/s{way_labels[first]}": pressure_map(
            xr.zeros_like(highest[first]["pressure"]), highest[first]["pressure"].values
        ),
        "share of the friction by wavelength": _octaves(highest[first]),
    }
    charts |= {
        f"{TITLES[name]} over the speed": _course_chart(course, name, speed, x_axis) for name in (AREA, GAP)
    }
    peaks = [(_scalars(way), [way[f"{FRICTION}{suffix}"].item() for suffix in ENDS]) for way in highest]
    misfit = float(over.attrs["relaxation_misfit"])  # of the table from every linear material
    misfit = misfit if misfit > MAX_MISFIT else 0.0
    others = peaks[:first] + peaks[first + 1 :]
    return charts, [sentence("slides", *peaks[first], others, misfit, _warm_from(course))]


def _warm_from(over: xr.Dataset) -> tuple[float, float] | None:
    """Return the speed (m/s) from which on the contact is 10 K warmer, and the highest; None: not known."""
    if "max_flash_temperature" not in over:
        return None
    warmer, speed = over["max_flash_temperature"].values, over["speed"].values
    above = np.flatnonzero(warmer >= WARM)
    if not above.size or above[0] == 0:
        return (float(speed[0]) if above.size else np.inf), float(speed[-1])
    pair = slice(above[0] - 1, above[0] + 1)  # between two speeds by power laws
    return float(np.exp(np.interp(np.log(WARM), *np.log([warmer[pair], speed[pair]])))), float(speed[-1])


def _octaves(highest: xr.Dataset) -> Chart:
    """Draw the share of the friction that each octave of wavelengths makes."""
    wavelength, shares = highest["octave_wavelength"].values, highest["friction_share_of_octave"].values
    unit = length_unit(float(wavelength.max()))
    x_axis = log_axis(f"octave of waves up to ({unit.symbol})", wavelength * unit.factor, room=1.3)
    chart = Chart(x_axis, Axis("share of the friction (%)", 0.0, 110 * float(shares.max() or 1.0)))
    chart.series(0, wavelength * unit.factor, 100 * shares, label="")
    return chart


def _wear(_: xr.Dataset, over: xr.Dataset) -> Part:
    """Return maps before and after wear, charts over the distance, and the sentence of a worn face."""
    from roughcontact.report.map_plots import height_map  # with all that levels maps, for few pages

    before, after = over.isel(sliding_distance=0), over.isel(sliding_distance=-1)
    last = _scalars(after)
    faces = {"before wear": before, f"after {number(last['sliding_distance'])} m": after}
    charts = {
        f"heights {text}": height_map(face["height"], like=before["height"]) for text, face in faces.items()
    }
    distances = over["sliding_distance"].values.copy()
    distances[distances == 0] = distances[distances > 0].min() / 3  # the face as it is stands at the left end
    x_axis = log_axis("sliding distance s (m), leftmost: 0", distances, room=1.3)
    charts |= {
        f"{TITLES[result]} over the distance": _course_chart(over, result, distances, x_axis)
        for result in _WORN
        if result in over
    }
    unit = unit_of(before, "m")
    heights = over[[*_HEIGHTS]].where(over[[*_HEIGHTS]] >= CLOSED) * unit.factor
    curves = {f"{name}, {words}": [heights[name].values] for name, words in _HEIGHTS.items()}
    chart = curves_chart(x_axis, distances, f"height ({unit.symbol})", curves)
    charts["height parameters over the distance"] = chart
    settled = [over[f"running_in_distance{suffix}"].item() for suffix in ENDS]
    areas, rms_heights = ([face[name].item() for face in (before, after)] for name in (AREA, "Sq"))
    return charts, [sentence("runs_in", last, settled, areas, rms_heights, CLOSED)]


def _course_chart(course: xr.Dataset, result: str, abscissa: np.ndarray, x_axis: Axis) -> Chart:
    """Draw one result with its interval over a single dimension, along a logarithmic axis."""
    (dimension,) = course[result].dims
    unit = unit_of(course.isel({dimension: 0}), UNITS[result])
    # a hardness along the course is no limit of a single contact
    curves = interval_values(course.drop_vars("hardness", errors="ignore"), result)
    lowest = CLOSED if result == GAP else 0.0  # finer than atoms nothing is known
    curve = [np.where(values >= lowest, values * unit.factor, np.nan) for values in curves]
    return curves_chart(x_axis, abscissa, f"{TITLES[result]} ({unit.symbol})", {"": curve})


def _scalars(numbers: xr.Dataset) -> dict[str, Any]:
    """Return the numbers of a dataset without dimensions."""
    return {str(name): value.values.item() for name, value in numbers.variables.items() if not value.dims}


# part of the page -> its file of a result, and what makes it of the statistics and of that
_COURSES: dict[str, tuple[str, Callable[[xr.Dataset, xr.Dataset], Part]]] = {
    "unloading": ("residual.nc", _unloading),
    "sliding": ("sliding.nc", _sliding),
    "wear": ("worn.nc", _wear),
}
