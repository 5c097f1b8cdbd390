"""The panel of a surface: its section of the report, with checks, pictures and numbers."""

import json
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import dimensions, side_lengths
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.quantities import percent
from roughcontact.report import facts, glance, load_plots, map_plots, tables, texture_plots
from roughcontact.report.budget_plots import shown_budget
from roughcontact.report.courses import answer_with_courses, course_section
from roughcontact.report.groups import name_under
from roughcontact.report.methods import methods_paragraph
from roughcontact.report.summary import relative_links, write_summary
from roughcontact.report.template import sentence, template
from roughcontact.report.units import stated_loads, unit_of
from roughcontact.results.storage import opened_dataset, read_dataset, write_text
from roughcontact.statistics import checks, outcome
from roughcontact.statistics.finite_body import hertz_contact
from roughcontact.statistics.kinds import facts_of_numbers
from roughcontact.surface.faces.placing import frame_of_place, place_in_words, separate_overviews

_TITLES = {  # of the maps by the number of measured faces
    1: ("As measured", "Levelled"),
    2: ("Face, as measured", "Counter-face, as measured", "Sum of both, levelled"),
}
_LINE = 200  # letters of a reason; a line of a wide page has some 185


def write_panel(
    path: str | Path,
    *,
    surface: str,
    case: str | None = None,
    settings: dict,
    counter_faces: Sequence[str | Path] = (),
    courses: Sequence[str | Path] = (),
    overview: str | Path | None = None,
    linked: bool = True,
    **files: str | Path,
) -> None:
    """Write one surface's part of the report: an HTML fragment, and its summary (`.json`), from its files.

    `files` are `height`, `levelled`, `window`, `contact` and `statistics`; where `contact` keeps no maps the
    part says so. `counter_faces` has the other file of a pair, `courses` those of wear, sliding and
    unloading, which the answer has, `overview` that of the coarser maps around this one; `linked` puts links
    to the files.
    """
    measured_map, plane, window_map = (_read_map(files[stage]) for stage in ("height", "levelled", "window"))
    numbers = read_dataset(files["statistics"])
    order = np.argsort(numbers["mean_pressure"].values, kind="stable")
    numbers = numbers.isel(load=order)
    indices = glance.usable_loads(numbers)
    all_checks = checks.window_checks(numbers, window_map)
    judged_checks = all_checks
    if numbers.attrs.get("loads") == "planned":  # of loads that nobody stated those are judged that are shown
        judged_checks = checks.window_checks(numbers.isel(load=indices), window_map)
    verdict = glance.verdict_on_asked(numbers, indices, outcome.worst_result(judged_checks))
    doubts = outcome.sort_by_importance(outcome.not_passed(all_checks))
    reason = glance.main_doubt(numbers, doubts)
    cells = glance.glance_rows(numbers, indices=indices[-1:])[0]
    sections = dict(course_section(numbers, Path(course)) for course in courses)
    answer = glance.answer_sentences(numbers, indices[-1], cells)
    summary: dict[str, Any] = {
        "identifier": surface if case is None else f"{case}--{surface}",
        "name": name_under(surface, case),
        "surface": surface,
        "answer": " ".join(map(str, answer_with_courses(answer, sections))),
        "verdict": verdict,
        "reasons": [outcome.reason_text(check) for check in doubts],
        "doubts": [str(check.name) for check in doubts],
        "main_reason": outcome.brief_reason(reason, _LINE) if reason else "",
        **{name: str(numbers.attrs.get(name, "")) for name in ("halve", "halved", "places", "overview")},
        "loads": indices,
        "measured": facts.date_text(measured_map),
        "waves": facts.waves_in_words(window_map),
    }
    values_shown = {
        "facts": facts.surface_facts(measured_map, plane, window_map, numbers),
        "maps": _maps([measured_map, *map(_read_map, counter_faces)], plane, window_map, numbers, overview),
        "source_sha256": measured_map.attrs.get("source_sha256", ""),
    }
    del measured_map, plane  # large maps leave no room for them beside the solution
    fields = _fields(files["contact"], window_map, numbers, dict(zip(indices, order[indices], strict=True)))
    contents = {
        "measured heights": files["height"],
        "levelled": files["levelled"],
        "solved window": files["window"],
        "pressure and gap" if fields else "solution without maps": files["contact"],
        "all numbers": files["statistics"],
    }
    rough = float(numbers["rms_gradient"]) > 0  # a flat map has neither waves nor charts
    html = template("panel.html").render(
        summary | values_shown,
        verdict_words=outcome.VERDICTS[verdict],
        doubts=doubts,
        checks=all_checks,
        concerns=outcome.concerns,
        profile=dimensions(window_map.shape) == 1,
        fields=fields,
        drawn=indices,
        loads=json.dumps(each_load(numbers, indices if fields else []), ensure_ascii=False),
        waves=texture_plots.pictures(window_map, facts.spectrum_caption(window_map, numbers))
        if rough
        else [],
        charts=_charts(numbers, window_map, indices) if rough else {},
        bars=partial(load_plots.bars_in_words, numbers),
        theories=load_plots.has_theories(numbers),
        budget=shown_budget(numbers, indices),
        tables=tables.number_tables(numbers, checks.load_flags(numbers, window_map.size)),
        outcomes=[glance.outcome_of(numbers, index) for index in range(numbers.sizes["load"])],
        creep=tables.creep_table(numbers, indices),
        files=relative_links(path, contents) if linked else [],
        methods=methods_paragraph(numbers) if "level" in json_attribute(numbers.attrs, "settings") else "",
        settings=json.dumps(settings, indent=1, sort_keys=True),
        versions=json_attribute(numbers.attrs, "versions"),
    )
    write_text(html, path)
    write_summary(summary, path)


def _read_map(path: str | Path) -> xr.DataArray:
    """Return the height map of a result file, attributes of the file included."""
    with opened_dataset(path) as dataset:  # without what levelling has rejected, which is as large
        height = dataset["height"].drop_vars("rejected_height", errors="ignore").load()
        return height.assign_attrs(dataset.attrs | height.attrs)


def _frame(window: xr.DataArray) -> map_plots.Frame:
    """Return (x, y, length x, length y) of the part of the map that the window shows, m."""
    x, y = (window.attrs.get(f"window_offset_{axis}", 0.0) for axis in ("x", "y"))
    images = 2 if window.attrs.get("periodisation") == "mirror" else 1  # the part and its mirror image
    ly, lx = side_lengths(window)
    return x, y, lx / images, ly / images


def _maps(
    measured: Sequence[xr.DataArray],
    levelled: xr.DataArray,
    window: xr.DataArray,
    numbers: xr.Dataset,
    overview: str | Path | None,
) -> list[tuple[str, str, str]]:
    """Return (title, image, caption) of the heights after each stage, and of overviews with the map in them.

    `measured` has the faces of a pair, or the one.
    """
    *titles, title_of_levelled = _TITLES[len(measured)]
    titled_maps = zip(titles, measured, strict=True)
    faces: list[tuple] = [(title, face, facts.measured_caption(face), None) for title, face in titled_maps]
    faces.append((title_of_levelled, levelled, facts.levelled_caption(levelled), _frame(window)))
    faces.append(("Solved window", window, window.attrs.get("window_reason", ""), None))
    for coarser in separate_overviews(read_dataset(overview)) if overview is not None else ():
        frame = frame_of_place(coarser, levelled)
        title = "Overview, the map in it" if frame else "Overview"
        faces.append((title, coarser, place_in_words(coarser), frame))
    along = unit_of(numbers, "m along")
    return [
        (title, map_plots.height_map(height, rectangle=frame, along=along).source(), caption)
        for title, height, caption, frame in faces
    ]


def _fields(
    path: str | Path, window: xr.DataArray, numbers: xr.Dataset, loads: Mapping[int, int]
) -> list[tuple[str, str, str]]:
    """Return (caption, pressure map, gap map) of a few loads, an empty list where no maps were kept.

    `loads` has the place in the solution of some loads of `numbers`. The maps of all of them have the colours
    of one scale.
    """
    with opened_dataset(path) as contact:
        if "pressure" not in contact or "gap" not in contact:
            return []

        # read twice, so that the maps of one load at a time are in memory
        def maps(load: int) -> map_plots.Fields:
            result = contact[["pressure", "gap"]].isel(load=load)
            return result["pressure"].values, result["gap"].values

        highest, widest = map_plots.common_limits(map(maps, loads.values()))
        unit, fields, texts = unit_of(numbers, "Pa"), [], stated_loads(numbers).texts
        for index, place in loads.items():
            pressure, gap = maps(place)
            area = percent(np.count_nonzero(pressure > 0) / pressure.size)
            smooth = hertz_contact(window, numbers, index)
            chart = map_plots.pressure_map(window, pressure, highest=highest, unit=unit, ellipse=smooth)
            gap_chart = map_plots.gap_map(window, gap, pressure, widest=widest)
            outline = "; red: the contact of the smooth bodies (Hertz)" if smooth else ""
            caption = f"{texts[index]}: {area} of the pixels touch{outline}"
            fields.append((caption, chart.source(), gap_chart.source()))
            del pressure, gap  # before the next ones are read
    return fields


def each_load(numbers: xr.Dataset, with_maps: Sequence[int]) -> list[tuple[str, str, int, float]]:
    """Return for each load its name, what is asked in words, the place of the maps, its value in a chart.

    The maps are those of the load itself or, as the words say, of the nearest of those `with_maps`.
    """
    stated, result = stated_loads(numbers), []
    loads = stated.values
    for index, cells in enumerate(glance.glance_rows(numbers, indices=range(loads.size))):
        nearest = int(np.argmin(np.abs(np.log(loads[list(with_maps)] / loads[index])))) if with_maps else 0
        answer, verdict = glance.answer_line(numbers, index, cells, alone=True), cells[glance.LOAD].outcome
        text = sentence("at_load", answer, outcome.VERDICTS.get(verdict), index in with_maps, with_maps)
        name = f"{stated.texts[index]} ({index + 1} of {loads.size})"
        result.append((name, text, nearest, float(f"{loads[index]:.6g}")))
    return result


def _charts(numbers: xr.Dataset, window: xr.DataArray, indices: Sequence[int]) -> dict[str, str]:
    """Return {name: image} of the charts of a window that is not flat."""
    charts = {
        "area": load_plots.area_against_load(numbers, window),
        "pressure": load_plots.pressure_against_load(numbers),
        "pressures": load_plots.pressure_distribution(numbers, indices),
    }
    if not facts_of_numbers(numbers).form_is_meant:  # of which the mean gap would be
        charts["gap"] = load_plots.gap_against_load(numbers)
    return {name: chart.source() for name, chart in charts.items()}
