"""What a result is solved for beside its loads: the way back, wear over the distance, speeds of rubber.

Each is a part of the page: charts and sentences of a file beside the statistics.
"""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, CONDUCTANCE, ENDS, FRICTION, GAP, PEAK, TITLES, UNITS
from roughcontact.arguments.quantities import number, quantity
from roughcontact.arguments.relaxation import MAX_MISFIT
from roughcontact.report.allowed import Sentence
from roughcontact.report.charts import Axis, Chart, curves_chart, log_axis
from roughcontact.report.template import sentence
from roughcontact.report.units import interval_values, length_unit, unit_of
from roughcontact.results.storage import FAILURE, opened_dataset
from roughcontact.statistics.decisions import CLOSED

_LEAKS = ("leak_rate_x", "leak_rate_y")
_UNLOADED = (AREA, GAP, "contact_stiffness", "thermal_conductance", "electrical_conductance", *_LEAKS)
_WORN = (AREA, PEAK, GAP, CONDUCTANCE, *_LEAKS)
_HEIGHTS = {"Sq": "root mean square", "Spk": "reduced peaks", "Svk": "reduced dales"}
_FRICTIONS = {
    "persson_friction_coefficient": "theory of Persson (2001)",
    "adhesive_friction_coefficient": "by the shear strength, alone",
}
WARM = 10.0  # K, by which the loss of a rubber shifts by half a decade of frequency
# part -> the contact of which all else is
_BEFORE = {"wear": "Before sliding", "sliding": "At rest", "unloading": "On loading"}

Charts = dict[str, Chart]  # by their labels
Paragraph = tuple[str, str]  # its opening sentence, which the answer has, and what follows
Part = tuple[list[Paragraph], Callable[[], Charts]]  # with what draws the charts


def course_sections(name: str, loading: xr.Dataset, results: Path, folder: Path) -> dict[str, dict[str, Any]]:
    """Return the parts of the page of a result by their place, with what their template needs.

    `loading` are the statistics, loads rising, `results` is the folder of the result, `folder` of the page.
    """
    sections = {}
    for path in (results / file for file in _COURSES if (results / file).is_file()):
        part, section = course_section(loading, path, drawn=True)
        link = Path(os.path.relpath(path, folder)).as_posix()
        sections[part] = section | {"name": name, "link": link}
    return sections


def course_section(loading: xr.Dataset, path: Path, *, drawn: bool = False) -> tuple[str, dict[str, Any]]:
    """Return the part of the page that a file is, its `opening`, its sentences, and its charts.

    Where there is nothing they say why.
    """
    part, content = _COURSES[path.name]
    with opened_dataset(path) as over:
        if reason := over.attrs.get(FAILURE):
            text = f"{part.capitalize()} is not known: {reason}."
            return part, {"opening": text, "sentences": [text], "images": {}}
        paragraphs, draw = content(loading, over)
        images = {label: chart.source() for label, chart in draw().items()} if drawn else {}
        texts = [" ".join(paragraph) for paragraph in paragraphs]
        return part, {"opening": paragraphs[0][0], "sentences": texts, "images": images}


def answer_with_courses(
    answer: Sequence[Sentence], sections: Mapping[str, Mapping[str, Any]]
) -> list[Sentence]:
    """Return the answer of a surface: of wear, sliding and the way back, then its `answer`.

    Examples
    --------
    >>> sections = {"wear": {"opening": "Run in after about 3 m."}}
    >>> [str(sentence) for sentence in answer_with_courses([Sentence("At 1 MPa: ...")], sections)]
    ['Run in after about 3 m.', 'Before sliding, at 1 MPa: ...']
    >>> sections["unloading"] = {"opening": "After 5 MPa: so."}
    >>> [str(sentence) for sentence in answer_with_courses([Sentence("At 1 MPa: ...")], sections)]
    ['After 5 MPa: so.', 'Run in after about 3 m.', 'On loading, before sliding, at 1 MPa: ...']
    """
    parts = [part for part in reversed(_BEFORE) if part in sections]
    occasions = ", ".join(_BEFORE[part] for part in parts).capitalize()
    at_rest = [statement.continued(occasions) if parts else statement for statement in answer[:1]]
    return [*(Sentence(sections[part]["opening"]) for part in parts), *at_rest, *answer[1:]]


def _unloading(loading: xr.Dataset, residual: xr.Dataset) -> Part:
    """Return a paragraph for each peak, and what draws both ways of the load."""
    suffix = "_as_solved"  # the way back has no correction for the grid either
    as_solved = {key.removesuffix(suffix): loading[key] for key in map(str, loading) if key.endswith(suffix)}
    loading = loading.assign(as_solved).sortby("mean_pressure")
    unloadings = [way.isel(load=np.isfinite(way["mean_pressure"].values)) for way in _along(residual, "peak")]
    pascals = unit_of(loading, "Pa")
    # its intervals are of the corrected numbers
    ways = {"loading": loading.drop_vars([name for name in map(str, loading) if name.endswith(ENDS[1:])])}
    ways |= {f"unloading from {quantity(way['peak_pressure'].item(), 'Pa')}": way for way in unloadings}
    curves = {label: (way["mean_pressure"].values * pascals.factor, way) for label, way in ways.items()}
    all_loads = np.concatenate([loads for loads, _ in curves.values()])
    x_axis = log_axis(f"mean pressure ({pascals.symbol})", all_loads)
    draw = partial(_over, curves, _UNLOADED, x_axis)
    return [_lowered(loading, unloading) for unloading in unloadings], draw


def _lowered(loading: xr.Dataset, unloading: xr.Dataset) -> Paragraph:
    """Return what flow has lowered by how much, and the area of both ways at the lowest load, in words."""
    lightest = unloading.isel(load=int(np.argmin(unloading["mean_pressure"].values)))
    load = float(lightest["mean_pressure"])
    on_loading = np.interp(load, loading["mean_pressure"].values, loading[AREA].values, left=np.nan)
    areas = {"on loading": float(on_loading), "on unloading": lightest[AREA].item()}
    numbers = _scalars(unloading)
    return sentence("unloaded", numbers, load, areas), sentence("flow_has_lowered", numbers)


def _sliding(_: xr.Dataset, over: xr.Dataset) -> Part:
    """Return the paragraph of the friction, and what draws the charts."""
    ways = _along(over, "direction")
    highest = [way.isel(speed=int(way[FRICTION].values.argmax())) for way in ways]
    index = int(np.argmax([way[FRICTION].item() for way in highest]))
    other_ways = [_scalars(way) for way in highest if way is not highest[index]]
    misfit = float(over.attrs["relaxation_misfit"])  # of the table from every linear material
    numbers, speeds = _scalars(highest[index]), over["speed"].values.tolist()
    text = sentence("slides", numbers, other_ways, speeds)
    further = sentence("hysteresis", numbers, misfit, MAX_MISFIT, _warm_from(ways[index]))
    return [(text, further)], partial(_sliding_charts, over, ways, highest, index)


def _sliding_charts(
    over: xr.Dataset, ways: Sequence[xr.Dataset], highest: Sequence[xr.Dataset], index: int
) -> Charts:
    """Draw friction and contact over the speed; all but the friction of the direction `index` alone."""
    from roughcontact.report.map_plots import pressure_map  # with all that levels maps, for few pages

    course, fastest, speed = ways[index], highest[index], over["speed"].values
    way_labels = [f", {way['direction'].item():g}°" if len(ways) > 1 else "" for way in ways]
    curves = {
        f"hysteresis, as solved{name}": [speed, *interval_values(way, FRICTION)]
        for way, name in zip(ways, way_labels, strict=True)
    }
    curves |= {label: [speed, course[name].values] for name, label in _FRICTIONS.items() if name in over}
    x_axis = log_axis("sliding speed v (m/s)", speed, room=1.3)
    of_friction = curves_chart(x_axis, "coefficient of friction μ", curves)
    pressure = pressure_map(xr.zeros_like(fastest["pressure"]), fastest["pressure"].values)
    return {
        "coefficient of friction over the speed": of_friction,
        f"pressure at {fastest['speed'].item():.3g} m/s{way_labels[index]}": pressure,
        "share of the friction by wavelength": _octaves(fastest),
        **_over({"": (speed, course)}, (AREA, GAP), x_axis, " over the speed"),
    }


def _warm_from(over: xr.Dataset) -> tuple[float, float] | None:
    """Return the speed (m/s) from which on the contact is 10 K warmer, and the highest; None: not known."""
    if "max_flash_temperature" not in over:
        return None
    # between two speeds by power laws
    warmest, speed = np.maximum.accumulate(over["max_flash_temperature"].values), over["speed"].values
    warm = np.interp(np.log(WARM), np.log(warmest), np.log(speed), right=np.inf)
    return float(np.exp(warm)), float(speed[-1])


def _octaves(highest: xr.Dataset) -> Chart:
    """Draw the share of the friction that each octave of wavelengths makes."""
    wavelength, shares = highest["octave_wavelength"].values, highest["friction_share_of_octave"].values
    unit = length_unit(float(wavelength.max()))
    x_axis = log_axis(f"octave of waves up to ({unit.symbol})", wavelength * unit.factor, room=1.3)
    chart = Chart(x_axis, Axis("share of the friction (%)", 0.0, 110 * float(shares.max() or 1.0)))
    chart.series(0, wavelength * unit.factor, 100 * shares, label="")
    return chart


def _wear(_: xr.Dataset, over: xr.Dataset) -> Part:
    """Return the paragraph of a worn face, and what draws the charts."""
    unworn, last = (_scalars(over.isel(sliding_distance=index)) for index in (0, -1))
    return [(sentence("runs_in", last), sentence("worn", last, unworn, CLOSED))], partial(_wear_charts, over)


def _wear_charts(over: xr.Dataset) -> Charts:
    """Draw maps before and after wear, and answers over the distance."""
    from roughcontact.report.map_plots import height_map  # with all that levels maps, for few pages

    unworn, worn = over.isel(sliding_distance=0), over.isel(sliding_distance=-1)
    unit = unit_of(unworn, "m")
    distances = over["sliding_distance"].values
    # the face as it is stands at the left end
    distances = np.where(distances == 0, distances[distances > 0].min() / 3, distances)
    x_axis = log_axis("sliding distance s (m), leftmost: 0", distances, room=1.3)
    heights = over[[*_HEIGHTS]].where(over[[*_HEIGHTS]] >= CLOSED) * unit.factor
    curves = {f"{name}, {words}": [distances, heights[name].values] for name, words in _HEIGHTS.items()}
    return {
        "heights before wear": height_map(unworn["height"], like=unworn["height"]),
        f"heights after {number(distances[-1])} m": height_map(worn["height"], like=unworn["height"]),
        **_over({"": (distances, over)}, _WORN, x_axis, " over the distance"),
        "height parameters over the distance": curves_chart(x_axis, f"height ({unit.symbol})", curves),
    }


def _over(
    curves: Mapping[str, tuple[np.ndarray, xr.Dataset]], results: Iterable[str], x_axis: Axis, words: str = ""
) -> Charts:
    """Draw results, with their intervals, of curves that have abscissas and numbers each.

    Results that a curve lacks, or that are zero, are left out; words are added to their titles.
    """
    courses, charts = [course for _, course in curves.values()], {}
    for result in (name for name in results if all(name in course for course in courses)):
        reference = courses[0].isel({dim: 0 for dim in courses[0][result].dims if dim != "load"})
        unit = unit_of(reference, UNITS[result])
        lowest = CLOSED if result == GAP else 0.0  # finer than atoms nothing is known
        values = {}
        for name, (abscissa, course) in curves.items():
            # a hardness along the course is no limit of a single contact
            bars = interval_values(course.drop_vars("hardness", errors="ignore"), result)
            values[name] = [abscissa, *(np.where(bar >= lowest, bar * unit.factor, np.nan) for bar in bars)]
        if any((value > 0).any() for _, value, *_ in values.values()):
            charts[TITLES[result] + words] = curves_chart(x_axis, f"{TITLES[result]} ({unit.symbol})", values)
    return charts


def _along(numbers: xr.Dataset, dimension: str) -> list[xr.Dataset]:
    """Return what a dataset has at each position of a dimension, which it may lack."""
    several = numbers if dimension in numbers.dims else numbers.expand_dims(dimension)
    return [several.isel({dimension: index}) for index in range(several.sizes[dimension])]


def _scalars(numbers: xr.Dataset) -> dict[str, Any]:
    """Return the numbers of a dataset without dimensions."""
    return {str(name): value.values.item() for name, value in numbers.variables.items() if not value.dims}


# file of a result -> the part of the page that it is, and what makes it of the statistics and of that
_COURSES: dict[str, tuple[str, Callable[[xr.Dataset, xr.Dataset], Part]]] = {
    "residual.nc": ("unloading", _unloading),
    "sliding.nc": ("sliding", _sliding),
    "worn.nc": ("wear", _wear),
}
