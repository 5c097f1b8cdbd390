"""The panel of a surface: its section of the report, with checks, pictures and numbers."""

import json
from collections.abc import Sequence
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
import xarray as xr

from roughcontact.bodies import have_layers
from roughcontact.maps import side_lengths
from roughcontact.profiles.surface import is_drawn
from roughcontact.quantities import percent
from roughcontact.report import captions, facts, load_plots, map_plots, tables, texture_plots
from roughcontact.report.budget_plots import shown_budget
from roughcontact.report.colours import POINTS
from roughcontact.report.files import relative_links
from roughcontact.report.glance import HEADINGS, glance_rows, outcome_of, usable_loads
from roughcontact.report.methods import methods_paragraph
from roughcontact.report.stack import stack_of_layers
from roughcontact.report.summary import write_summary
from roughcontact.report.template import template
from roughcontact.report.units import unit_of
from roughcontact.results.storage import opened_dataset, read_dataset, write_text
from roughcontact.statistics import checks
from roughcontact.statistics.finite_body import hertz_contact
from roughcontact.statistics.outcome import (
    VERDICTS,
    by_importance,
    concerns,
    not_passed,
    reason_text,
    verdict_of,
)

_LINE = 150  # letters of a reason; a line of a wide page has some 170


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
    counter_face: str | Path | None = None,
    linked: bool = True,
) -> None:
    """Write one surface's part of the report: an HTML fragment, and its summary (`.json`), from its files.

    Where `contact` keeps no maps the part says so; `linked` puts links to the files, `counter_face` is the
    other file of a pair.
    """
    measured, plane, solved = (_read_map(file) for file in (height, levelled, window))
    numbers = read_dataset(statistics)
    order = np.argsort(numbers["mean_pressure"].values, kind="stable")
    numbers = numbers.isel(load=order)
    displayed = usable_loads(numbers)
    checks_of = partial(
        checks.surface_checks,
        height=plane.attrs if counter_face else measured.attrs,  # of both faces together
        levelled=plane.attrs,
        window=solved.attrs,
        points=solved.size,
    )
    outcome = checks_of(numbers)
    name = surface if case is None else f"{surface} · {case}"
    identifier = surface if case is None else f"{case}--{surface}"
    # of loads that nobody stated those are judged that are shown
    judged = checks_of(numbers.isel(load=displayed)) if numbers.attrs.get("loads") == "found" else outcome
    verdict = verdict_of(judged)
    doubts = by_importance(not_passed(outcome))
    bodies = settings["contact"].get("bodies")
    available = facts.surface_facts(measured, plane, solved, numbers)
    maps = _maps(measured, plane, solved, numbers, counter_face)
    source, date = measured.attrs.get("source_sha256", ""), facts.date_of(measured)
    del measured, plane  # large maps leave no room for them beside the solution
    fields = _fields(contact, solved, numbers, order[displayed])
    files = {"measured heights": height, "levelled": levelled, "solved window": window}
    files |= {"pressure and gap" if fields else "solution without maps": contact, "all numbers": statistics}
    recorded = json.loads(numbers.attrs.get("settings", "{}"))
    rough = float(numbers["rms_gradient"]) > 0  # a flat map has neither waves nor charts
    html = template("panel.html").render(
        identifier=identifier,
        name=name,
        verdict=verdict,
        verdict_words=VERDICTS[verdict],
        doubts=doubts,
        checks=outcome,
        facts=available,
        stack=stack_of_layers(bodies, solved) if have_layers(bodies) else None,
        maps=maps,
        concerns=concerns,
        profile=1 in solved.shape,
        fields=fields,
        drawn=displayed,
        loads=json.dumps(_each_load(numbers, displayed if fields else []), ensure_ascii=False),
        waves=_waves(solved, numbers) if rough else [],
        charts=_charts(numbers, solved, displayed) if rough else {},
        bars=partial(captions.reading_of, numbers),
        theories=load_plots.has_theories(numbers),
        budget=shown_budget(numbers, displayed, extent=settings["uncertainty"]["extent"]),
        tables=tables.number_tables(numbers, checks.load_flags(numbers, solved.size)),
        outcomes=[outcome_of(numbers, index) for index in range(numbers.sizes["load"])],
        material=tables.material_table(numbers, displayed),
        files=relative_links(path, files) if linked else [],
        methods=methods_paragraph(numbers) if "level" in recorded else "",
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
            "verdict": verdict,
            "reasons": [reason_text(check) for check in doubts],
            "doubts": [str(check.name) for check in doubts],
            "main_reason": reason_text(doubts[0], letters=_LINE) if doubts else "",
            "halve": str(numbers.attrs.get("halve", "")),
            "loads": displayed,
            "measured": date,
            "waves": facts.waves_in_words(solved),
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
    measured: xr.DataArray,
    levelled: xr.DataArray,
    window: xr.DataArray,
    numbers: xr.Dataset,
    counter_face: str | Path | None,
) -> list[tuple[str, str, str]]:
    """Return (title, image, caption) of the heights after each stage; of a pair, both measured faces."""
    faces = [("Face, as measured" if counter_face else "As measured", measured)]
    if counter_face:
        faces.append(("Counter-face, as measured", _read_map(counter_face)))
    drawn = partial(map_plots.height_map, unit=unit_of(numbers, "m"), along=unit_of(numbers, "m along"))
    return [
        *((title, drawn(face).source(), facts.measured_caption(face)) for title, face in faces),
        (
            "Sum of both, levelled" if counter_face else "Levelled",
            drawn(levelled, rectangle=_frame(window)).source(),
            facts.levelled_caption(levelled),
        ),
        ("Solved window", drawn(window).source(), window.attrs.get("window_reason", "")),
    ]


def _fields(
    path: str | Path, window: xr.DataArray, numbers: xr.Dataset, loads: np.ndarray
) -> list[tuple[str, str, str]]:
    """Return (caption, pressure map, gap map) of a few loads, an empty list where no maps were kept.

    The maps of all loads have the colours of one scale.
    """
    with opened_dataset(path) as contact:
        if "pressure" not in contact or "gap" not in contact:
            return []

        # maps of which every point is drawn are read once, finer ones twice: a load at a time is in memory
        @lru_cache(loads.size if window.size <= POINTS else 0)
        def maps(load: int) -> map_plots.Fields:
            result = contact[["pressure", "gap"]].isel(load=load)
            return result["pressure"].values, result["gap"].values

        highest, widest = map_plots.common_limits(window, map(maps, loads))
        of_pressure, of_gap = unit_of(numbers, "Pa"), unit_of(numbers, "m")
        fields = []
        for load in loads:
            pressure, gap = maps(load)
            area = percent(np.count_nonzero(pressure > 0) / pressure.size)
            hertz = hertz_contact(window, numbers, load)
            shown = map_plots.pressure_map(window, pressure, highest=highest, unit=of_pressure, ellipse=hertz)
            gap_chart = map_plots.gap_map(window, gap, pressure, widest=widest, unit=of_gap)
            mean = of_pressure.text(float(contact["mean_pressure"][load]))
            outlined = "; red: the contact of the smooth bodies (Hertz)" if hertz else ""
            caption = f"p̄ = {mean}: {area} of the pixels touch{outlined}"
            fields.append((caption, shown.source(), gap_chart.source()))
            del pressure, gap  # before the next ones are read
    return fields


def _each_load(numbers: xr.Dataset, drawn: Sequence[int]) -> list[tuple[str, str, int, float]]:
    """Return for each load its name, its answers in words, the place of the maps, and its value in a chart.

    The maps are those of the load itself or, as the words say, of the nearest of those that are `drawn`.
    """
    pressure, loads = unit_of(numbers, "Pa"), numbers["mean_pressure"].values
    result = []
    for index, (_, *cells) in enumerate(glance_rows(numbers, indices=range(loads.size))):
        text = [
            ", ".join(filter(None, (f"{title} {cell.text}", cell.details, cell.precision)))
            + (f" ({VERDICTS[cell.outcome]})" if cell.outcome else "")
            for title, cell in zip(HEADINGS[1:], cells, strict=True)
        ]
        nearest = int(np.argmin(np.abs(np.log(loads[list(drawn)] / loads[index])))) if drawn else 0
        if index not in drawn:
            text.append(
                "maps of this load are not drawn" + ("; below those of the nearest load" if drawn else "")
            )
        name = f"p̄ = {pressure.text(float(loads[index]))} ({index + 1} of {loads.size})"
        result.append((name, "; ".join(text), nearest, float(f"{loads[index] * pressure.factor:.6g}")))
    return result


def _waves(window: xr.DataArray, numbers: xr.Dataset) -> list[tuple[str, str, str]]:
    """Return (title, image, caption) of the waves of a window that is not flat."""
    profile = 1 in window.shape
    pictures = [("Power spectrum", texture_plots.spectrum(window), facts.spectrum_caption(window, numbers))]
    if is_drawn(window):
        caption = "Of the profiles, and of such profiles of the surface that was fitted to them."
        pictures.insert(0, ("Spectrum of the profiles", texture_plots.fitted_spectrum(window), caption))
    if not profile:
        directions = texture_plots.directional_spectrum(window)
        pictures.append(("Waves by direction", directions, facts.lay_caption(numbers)))
    caption = facts.autocorrelation_caption(numbers, profile=profile)
    pictures.append(("Autocorrelation", texture_plots.autocorrelation_map(window), caption))
    return pictures


def _charts(
    numbers: xr.Dataset, window: xr.DataArray, displayed: Sequence[int]
) -> dict[str, tuple[str, str]]:
    """Return {name: (image, caption)} of the charts of a window that is not flat."""
    charts = {
        "area": (load_plots.area_against_load(numbers, window), captions.area_caption),
        "pressure": (load_plots.pressure_against_load(numbers), captions.pressure_caption),
        "gap": (load_plots.gap_against_load(numbers), captions.gap_caption),
        "pressures": (load_plots.pressure_distribution(numbers, displayed), captions.distribution_caption),
        "gaps": (load_plots.gap_distribution(numbers, displayed), captions.open_caption),
    }
    if 1 not in window.shape:  # the patches of a profile have no area
        charts["patches"] = load_plots.patch_distribution(numbers, displayed), captions.patch_caption
    return {name: (chart.source(), caption(numbers)) for name, (chart, caption) in charts.items()}
