"""The page of a run: verdicts, comparison and the panel of every surface in one self-contained HTML file."""

import base64
import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact import materials
from roughcontact.quantities import Unit, number, percent
from roughcontact.report import ONE_PAGE
from roughcontact.report.captions import comparison_caption
from roughcontact.report.cases import case_medians, case_table
from roughcontact.report.files import from_page
from roughcontact.report.glance import HEADINGS, glance_rows, glance_units
from roughcontact.report.load_plots import compare_areas, spread_of_areas
from roughcontact.report.summary import Summary, summary_of
from roughcontact.report.tables import pair_table
from roughcontact.report.template import template
from roughcontact.report.units import unit_of
from roughcontact.results.collect import Failure, summary_table
from roughcontact.results.storage import read_dataset, write_text
from roughcontact.statistics import checks

# the numbers of a surface in the index of many, as `_headline` gives them
_HEADINGS = ("rms height", "rms gradient g", "mean pressure p̄", "contact area A/A₀", "largest pressure")


def write_report(
    path: str | Path,
    *,
    panels: Sequence[str | Path],
    statistics: str | Path,
    title: str,
    settings: dict,
    pairs: str | Path | None = None,
    failures: Sequence[Failure] = (),
    folder: str | Path | None = None,
) -> None:
    """Write the page of a run: verdicts, comparison, and the part of every surface.

    Up to `report.ONE_PAGE` results stand on one self-contained page. Of more there is an index, and beside it
    the folder `pages` with a page for each surface; nothing is fetched from elsewhere either.

    Parameters
    ----------
    path : path
        where to write.
    panels : sequence of paths
        what `write_panel` wrote, in the order they shall appear.
    statistics : path
        what `collect_statistics` put together.
    title : str
        of the page.
    settings : dict
        the settings of the run (of each case, where there are cases).
    pairs : path or None
        the table of pairs of faces (`collect.pairs_table`), where there are any.
    failures : sequence of dict
        surfaces (and cases) without results, with the reason.
    folder : path or None
        where the page will be moved to; None where it stays. Its links to files are those from there.

    Raises
    ------
    InputFileError
        for a file that is not readable, or is no panel.
    """
    many = len(panels) + len(failures) > ONE_PAGE
    folder = Path(path).parent if folder is None else Path(folder)
    collected = read_dataset(statistics)
    series = _series(collected)
    by_surface: dict[str, dict[str, xr.Dataset]] = {}
    for (surface, case), data in series.items():
        by_surface.setdefault(surface, {})[case or ""] = data
    known = {_name(*key): data for key, data in series.items()}
    read = partial(Path.read_text, encoding="utf-8")
    summaries = [summary_of(read(Path(panel)), panel) for panel in panels]
    units = glance_units(list(known.values()))
    rows = [
        {
            **summary,
            **_glance(summary, known[summary["name"]], units),
            "numbers": _headline(known[summary["name"]]),
            "doubts": ", ".join(reason.partition(":")[0] for reason in summary["reasons"]),
            "sort_by": _sort_keys(known[summary["name"]]),
            "link": f"pages/{summary['surface']}.html#surface-{summary['identifier']}",
        }
        for summary in summaries
    ]
    if many:
        shown_in = folder / "pages"
        _write_pages(Path(path).parent / "pages", rows, panels, by_surface, title=title, folder=shown_in)
    html = template("report.html").render(
        title=title,
        rows=rows,
        headings=_HEADINGS,
        asked=HEADINGS,
        download=None if many else _as_download(summary_table(collected).to_csv(index=False)),
        words=checks.VERDICTS,
        counts={outcome: sum(row["verdict"] == outcome for row in rows) for outcome in checks.VERDICTS},
        many=many,
        comparisons=_comparisons(series, many=many),
        cases=_cases(by_surface, many=many),
        parts=[] if many else [from_page(read(Path(panel)), panel, folder) for panel in panels],
        failures=[
            {"name": _name(failure["surface"], failure["case"]), "reason": failure["reason"]}
            for failure in failures
        ],
        pairs=pair_table(pairs) if pairs else None,
        settings=json.dumps(settings, indent=1, sort_keys=True),
        limits={
            "points": checks.CONTACT_POINTS,
            "overcount": f"{100 * checks.OVERCOUNT:g} %",
            "filled": [f"{100 * share:g} %" for share in checks.FILLED_IN_CONTACT],
            "rejected": f"{100 * checks.REJECTED_LOAD:g} %",
            "jitter": f"{100 * checks.ROW_JITTER:g} %",
            "gradient": f"{100 * checks.GRADIENT_CHANGE:g} %",
            "heights": f"{100 * checks.HEIGHT_CHANGE:g} %",
            "form": f"{100 * checks.FORM:g} %",
            "window": f"{100 * checks.WINDOW_SHARE:g} %",
            "lengths": checks.LENGTHS,
            "steep": number(checks.STEEP, digits=1),
            "places": f"{100 * checks.STEEP_PLACES:g} %",
            "too_steep": number(checks.TOO_STEEP, digits=1),
            "metals": [number(limit, digits=1) for limit in materials.METALS],
            "hardest": number(materials.HARDEST, digits=1),
        },
    )
    write_text(html, path)


def _write_pages(
    written_to: Path,
    summaries: Sequence[Mapping[str, Any]],
    panels: Sequence[str | Path],
    by_surface: Mapping[str, Mapping[str, xr.Dataset]],
    *,
    title: str,
    folder: Path,
) -> None:
    """Write the page of each surface, with all its cases; `folder` is where the pages come to lie."""
    names = list(dict.fromkeys(summary["surface"] for summary in summaries))
    for place, name in enumerate(names):
        own = [index for index, summary in enumerate(summaries) if summary["surface"] == name]
        html = template("surface.html").render(
            title=title,
            name=name,
            before=names[place - 1] if place else None,
            after=names[place + 1] if place + 1 < len(names) else None,
            cases=case_table(by_surface[name]),
            rows=[summaries[index] for index in own],
            asked=HEADINGS,
            words=checks.VERDICTS,
            failures=(),
            parts=[
                from_page(Path(panels[index]).read_text(encoding="utf-8"), panels[index], folder)
                for index in own
            ],
        )
        write_text(html, written_to / f"{name}.html")


def _glance(summary: Summary, numbers: xr.Dataset, units: Mapping[str, Unit]) -> dict[str, Any]:
    """Return the cells of a surface at two or three loads, the one reason that matters, how many others."""
    reasons = summary["reasons"]
    return {
        "glance": glance_rows(numbers, units),
        "loads": numbers.sizes["load"],
        "reason": next(iter(reasons), ""),
        "others": max(len(reasons) - 1, 0),
    }


def _as_download(text: str) -> str:
    """Return a table as a link to itself, so that the page needs no other file to hand it out."""
    return "data:text/csv;charset=utf-8;base64," + base64.b64encode(text.encode()).decode()


def _comparisons(series: Mapping[tuple[str, str | None], xr.Dataset], *, many: bool) -> list[tuple[str, str]]:
    """Return (image, caption) of area against load of all surfaces: in pascals, and relative to E* g.

    Of very many there is the latter alone, of flat surfaces nothing, and of one surface neither: its own part
    has the same.
    """
    rough = {
        key: data.sortby("mean_pressure")
        for key, data in series.items()
        if np.isfinite(data["relative_pressure"]).all()
    }
    if len(rough) < 2:
        return []
    relative = {
        key: (data["relative_pressure"].values, data["relative_contact_area"].values)
        for key, data in rough.items()
    }
    in_these_units = (
        "Over the pressure relative to E* times the rms gradient rough surfaces fall close together; the "
        "dark lines without marks are theories that know nothing of a surface but its rms gradient."
    )
    if many:
        groups: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
        for (_, case), line in relative.items():
            groups.setdefault(case or "", []).append(line)
        return [(spread_of_areas(groups), f"Each surface is a faint line. {in_these_units}")]
    names = [_name(*key) for key in rough]
    lines = [(name, *relative[key]) for name, key in zip(names, rough, strict=True)]
    pascal = [
        (name, data["mean_pressure"].values, data["relative_contact_area"].values)
        for name, data in zip(names, rough.values(), strict=True)
    ]
    known = all("relative_contact_area_lower" in data for data in rough.values())
    ends = [
        (data["relative_contact_area_lower"].values, data["relative_contact_area_upper"].values)
        for data in rough.values()
        if known
    ]
    # that of the stiffest, where the cases differ in it
    pressure = min((unit_of(data, "Pa") for data in rough.values()), key=lambda unit: unit.factor)
    bars = "Bars: the ±." if known else ""
    return [
        (
            compare_areas(pascal, ends=ends, pressure=pressure),
            f"{comparison_caption(pascal, pressure)} {bars}".strip(),
        ),
        (compare_areas(lines, ends=ends), f"{comparison_caption(lines)} {in_these_units}".strip()),
    ]


def _cases(
    by_surface: Mapping[str, Mapping[str, xr.Dataset]], *, many: bool
) -> list[tuple[str, dict[str, Any]]]:
    """Return (title, table) of the cases side by side: of each surface, or of all where there are many."""
    if many:
        medians = case_medians(list(by_surface.values()))
        return [("", medians)] if medians else []
    tables = [(name, case_table(cases)) for name, cases in by_surface.items()]
    return [(name, table) for name, table in tables if table]


def _series(statistics: xr.Dataset) -> dict[tuple[str, str | None], xr.Dataset]:
    """Return {(surface, case): statistics}, loads rising; padding and what has failed are left out."""
    series = {}
    cases = statistics["case_name"].values if "case" in statistics.dims else [None]
    for place, case in enumerate(cases):
        of_case = statistics if case is None else statistics.isel(case=place)
        for index, surface in enumerate(statistics["surface_name"].values):
            one = of_case.isel(surface=index)
            one = one.isel(load=np.isfinite(one["mean_pressure"].values))
            if one.sizes["load"]:
                order = np.argsort(one["mean_pressure"].values)
                series[str(surface), None if case is None else str(case)] = one.isel(load=order)
    return series


def _sort_keys(data: xr.Dataset) -> list[float]:
    """Return the numbers by which the rows of the index are sorted, for each of the headings."""
    return [
        float(data["rms_height"]),
        float(data["rms_gradient"]),
        float(data["mean_pressure"].max()),
        float(data["relative_contact_area"].max()),
        float(data["max_pressure"].max()),
    ]


def _name(surface: str, case: str | None) -> str:
    """Return what a surface, under a case, is called on the page."""
    return str(surface) if case is None else f"{surface} · {case}"


def _headline(data: xr.Dataset) -> list[str]:
    """Return the few numbers of a surface that stand at the top of the page."""
    return [
        unit_of(data, "m").text(float(data["rms_height"])),
        number(float(data["rms_gradient"])),
        _span(data["mean_pressure"].values, unit_of(data, "Pa").text),
        _span(data["relative_contact_area"].values, percent),
        _largest_pressure(data),
    ]


def _largest_pressure(data: xr.Dataset) -> str:
    """Return the largest pressure and the lowest load at which it acts."""
    place = int(data["max_pressure"].values.argmax())
    peak, load = (float(data[name][place]) for name in ("max_pressure", "mean_pressure"))
    show = unit_of(data, "Pa").text
    return f"{show(peak)} at {show(load)}"


def _span(values: np.ndarray, show: Callable[[float], str]) -> str:
    """Return the least and the largest of some values in words."""
    low, high = (show(float(f(values))) for f in (np.min, np.max))
    return low if low == high else f"{low} to {high}"
