"""The panel of a surface: its section of the report, with checks, pictures and numbers."""

import json
from collections.abc import Mapping, Sequence
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, GAP, PEAK, PRESSURE
from roughcontact.arguments.maps import dimensions, side_lengths
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.quantities import percent
from roughcontact.report import captions, facts, load_plots, map_plots, tables, texture_plots
from roughcontact.report.budget_plots import shown_budget
from roughcontact.report.colours import POINTS
from roughcontact.report.files import relative_links
from roughcontact.report.glance import (
    HEADINGS,
    NOT_JUDGED,
    answer_line,
    glance_rows,
    main_doubt,
    outcome_of,
    usable_loads,
    verdict_on_asked,
)
from roughcontact.report.methods import methods_paragraph
from roughcontact.report.summary import write_summary
from roughcontact.report.template import template
from roughcontact.report.units import stated_loads, unit_of
from roughcontact.results.storage import opened_dataset, read_dataset, write_text
from roughcontact.statistics import checks, outcome
from roughcontact.statistics.kinds import numbers_of_kind
from roughcontact.surface.faces.placing import frame_of_place, place_in_words, separate_overviews

_TITLES = {  # of the maps by the number of measured faces
    1: ("As measured", "Levelled"),
    2: ("Face, as measured", "Counter-face, as measured", "Sum of both, levelled"),
}
_LINE = 180  # letters of a reason; a line of a wide page has some 185


def write_panel(
    path: str | Path,
    *,
    surface: str,
    case: str | None = None,
    height: str | Path,
    levelled: str | Path,
    window: str | Path,
    contact: str | Path,
    statistics: str | Path,
    settings: dict,
    counter_faces: Sequence[str | Path] = (),
    overview: str | Path | None = None,
    linked: bool = True,
) -> None:
    """Write one surface's part of the report: an HTML fragment, and its summary (`.json`), from its files.

    Where `contact` keeps no maps the part says so; `linked` puts links to the files, `counter_faces` has
    the other file of a pair, `overview` that of the coarser maps around this one.
    """
    measured_map, plane, window_map = (_read_map(file) for file in (height, levelled, window))
    numbers = read_dataset(statistics)
    order = np.argsort(numbers["mean_pressure"].values, kind="stable")
    numbers = numbers.isel(load=order)
    indices = usable_loads(numbers)
    checks_of = partial(
        checks.surface_checks,
        height=plane.attrs if counter_faces else measured_map.attrs,  # of both faces together
        levelled=plane.attrs,
        window=window_map.attrs,
        points=window_map.size,
    )
    all_checks = checks_of(numbers)
    name = surface if case is None else f"{surface} · {case}"
    identifier = surface if case is None else f"{case}--{surface}"
    # of loads that nobody stated those are judged that are shown
    are_planned = numbers.attrs.get("loads") == "planned"
    verdict = outcome.worst_result(checks_of(numbers.isel(load=indices)) if are_planned else all_checks)
    verdict = verdict_on_asked(numbers, indices, verdict)
    doubts = outcome.sort_by_importance(outcome.not_passed(all_checks))
    reason = main_doubt(numbers, doubts)
    available = facts.surface_facts(measured_map, plane, window_map, numbers)
    maps = _maps(measured_map, plane, window_map, numbers, counter_faces)
    if overview is not None:
        coarser = separate_overviews(read_dataset(overview))
        maps += [_overview(field, plane, numbers) for field in coarser]
    source, date = measured_map.attrs.get("source_sha256", ""), facts.date_text(measured_map)
    del measured_map, plane  # large maps leave no room for them beside the solution
    fields = _fields(contact, window_map, numbers, dict(zip(indices, order[indices], strict=True)))
    files = {"measured heights": height, "levelled": levelled, "solved window": window}
    files |= {"pressure and gap" if fields else "solution without maps": contact, "all numbers": statistics}
    recorded_settings = json_attribute(numbers.attrs, "settings")
    rough = float(numbers["rms_gradient"]) > 0  # a flat map has neither waves nor charts
    html = template("panel.html").render(
        identifier=identifier,
        name=name,
        verdict=verdict,
        verdict_words=outcome.VERDICTS[verdict],
        doubts=doubts,
        checks=all_checks,
        facts=available,
        maps=maps,
        concerns=outcome.concerns,
        profile=dimensions(window_map.shape) == 1,
        fields=fields,
        drawn=indices,
        loads=json.dumps(each_load(numbers, indices if fields else []), ensure_ascii=False),
        waves=_waves(window_map, numbers) if rough else [],
        charts=_charts(numbers, window_map, indices) if rough else {},
        bars=partial(captions.bars_in_words, numbers),
        theories=load_plots.has_theories(numbers),
        budget=shown_budget(numbers, indices),
        tables=tables.number_tables(numbers, checks.load_flags(numbers, window_map.size)),
        outcomes=[outcome_of(numbers, index) for index in range(numbers.sizes["load"])],
        material=tables.material_table(numbers, indices),
        creep=tables.creep_table(numbers, indices),
        files=relative_links(path, files) if linked else [],
        methods=methods_paragraph(numbers) if "level" in recorded_settings else "",
        settings=json.dumps(settings, indent=1, sort_keys=True),
        versions=facts.versions(numbers),
        source_sha256=source,
    )
    write_text(html, path)
    write_summary(
        {
            "identifier": identifier,
            "name": name,
            "surface": surface,
            "answer": answer_line(numbers, indices[-1], glance_rows(numbers, indices=indices[-1:])[0]),
            "verdict": verdict,
            "reasons": [outcome.reason_text(check) for check in doubts],
            "doubts": [str(check.name) for check in doubts],
            "main_reason": outcome.reason_text(reason, letters=_LINE) if reason else "",
            "halve": str(numbers.attrs.get("halve", "")),
            "halved": str(numbers.attrs.get("halved", "")),
            "places": str(numbers.attrs.get("places", "")),
            "overview": str(numbers.attrs.get("overview", "")),
            "loads": indices,
            "measured": date,
            "waves": facts.waves_in_words(window_map),
        },
        path,
    )


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
    measured_map: xr.DataArray,
    levelled_map: xr.DataArray,
    window: xr.DataArray,
    numbers: xr.Dataset,
    counter_faces: Sequence[str | Path],
) -> list[tuple[str, str, str]]:
    """Return (title, image, caption) of the heights after each stage; of a pair, both measured faces."""
    measured = [measured_map, *map(_read_map, counter_faces)]
    *titles, title_of_levelled = _TITLES[len(measured)]
    chart = partial(map_plots.height_map, along=unit_of(numbers, "m along"))
    levelled_chart = chart(levelled_map, rectangle=_frame(window))
    return [
        *(
            (title, chart(face).source(), facts.measured_caption(face))
            for title, face in zip(titles, measured, strict=True)
        ),
        (title_of_levelled, levelled_chart.source(), facts.levelled_caption(levelled_map)),
        ("Solved window", chart(window).source(), window.attrs.get("window_reason", "")),
    ]


def _overview(overview: xr.DataArray, levelled: xr.DataArray, numbers: xr.Dataset) -> tuple[str, str, str]:
    """Return title, image and caption of an overview with the map in it."""
    frame = frame_of_place(overview, levelled)
    image = map_plots.height_map(overview, rectangle=frame, along=unit_of(numbers, "m along")).source()
    return f"Overview{', the map in it' if frame else ''}", image, place_in_words(overview)


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

        # maps of which every point is drawn are read once, finer ones twice: a load at a time is in memory
        @lru_cache(len(loads) if window.size <= POINTS else 0)
        def maps(load: int) -> map_plots.Fields:
            result = contact[["pressure", "gap"]].isel(load=load)
            return result["pressure"].values, result["gap"].values

        highest, widest = map_plots.common_limits(map(maps, loads.values()))
        of_pressure, fields, texts = unit_of(numbers, "Pa"), [], stated_loads(numbers).texts
        for index, place in loads.items():
            pressure, gap = maps(place)
            area = percent(np.count_nonzero(pressure > 0) / pressure.size)
            smooth = numbers_of_kind(window.attrs).smooth_contact(window, numbers, index)
            chart = map_plots.pressure_map(
                window, pressure, highest=highest, unit=of_pressure, ellipse=smooth
            )
            gap_chart = map_plots.gap_map(window, gap, pressure, widest=widest)
            outline = "; red: the contact of the smooth bodies (Hertz)" if smooth else ""
            caption = f"{texts[index]}: {area} of the pixels touch{outline}"
            fields.append((caption, chart.source(), gap_chart.source()))
            del pressure, gap  # before the next ones are read
    return fields


def each_load(numbers: xr.Dataset, with_maps: Sequence[int]) -> list[tuple[str, str, int, float]]:
    """Return for each load its name, its answers in words, the place of the maps, and its value in a chart.

    The maps are those of the load itself or, as the words say, of the nearest of those `with_maps`.
    """
    stated = stated_loads(numbers)
    loads, result = stated.values, []
    for index, (_, *cells) in enumerate(glance_rows(numbers, indices=range(loads.size))):
        text = [
            ", ".join(filter(None, (f"{title} {cell.text}", cell.details, cell.known)))
            + (f" ({outcome.VERDICTS[cell.outcome]})" if cell.outcome else "")
            for title, cell in zip(HEADINGS[1:], cells, strict=True)
            if cell.text != NOT_JUDGED
        ]
        nearest = int(np.argmin(np.abs(np.log(loads[list(with_maps)] / loads[index])))) if with_maps else 0
        if index not in with_maps:
            remark = "; below those of the nearest load" if with_maps else ""
            text.append(f"maps of this load are not drawn{remark}")
        name = f"{stated.texts[index]} ({index + 1} of {loads.size})"
        result.append((name, "; ".join(text), nearest, float(f"{loads[index]:.6g}")))
    return result


def _waves(window: xr.DataArray, numbers: xr.Dataset) -> list[tuple[str, str, str]]:
    """Return (title, image, caption) of the waves of a window that is not flat."""
    pictures = [("Power spectrum", texture_plots.spectrum(window), facts.spectrum_caption(window, numbers))]
    if "profile_spectra" in window.attrs:
        caption = "Of the profiles, and of such profiles of the surface that was fitted to them."
        pictures.insert(0, ("Spectrum of the profiles", texture_plots.fitted_spectrum(window), caption))
    if dimensions(window.shape) == 2:
        directions = texture_plots.directional_spectrum(window)
        pictures.append(("Waves by direction", directions, facts.lay_caption(numbers)))
    return pictures


def _charts(numbers: xr.Dataset, window: xr.DataArray, indices: Sequence[int]) -> dict[str, tuple[str, str]]:
    """Return {name: (image, caption)} of the charts of a window that is not flat."""
    charts = {
        "area": (load_plots.area_against_load(numbers, window), [AREA]),
        "pressure": (load_plots.pressure_against_load(numbers), [PRESSURE, PEAK]),
        "gap": (load_plots.gap_against_load(numbers), [GAP]),
        "pressures": (
            load_plots.pressure_distribution(numbers, indices),
            ["pressure_std", "area_share_above_hardness"],
        ),
        "gaps": (load_plots.gap_distribution(numbers, indices), [GAP]),
    }
    if dimensions(window.shape) == 2:  # the patches of a profile have no area
        patches = load_plots.patch_distribution(numbers, indices)
        charts["patches"] = patches, ["contact_clusters", "largest_patch_area"]
    return {
        name: (chart.source(), captions.answers_caption(numbers, *quantities))
        for name, (chart, quantities) in charts.items()
    }
