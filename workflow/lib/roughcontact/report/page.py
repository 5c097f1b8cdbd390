"""The page of a run: verdicts, comparison and the panel of every surface in one self-contained HTML file."""

import base64
import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact import __version__
from roughcontact.arguments.answers import ANSWERS, AREA
from roughcontact.arguments.quantities import Unit, number
from roughcontact.report import ONE_PAGE, glance
from roughcontact.report.asked import describe_problem, measured_in_words, same_loads
from roughcontact.report.cases import case_medians, case_table
from roughcontact.report.courses import answer_with_courses, course_sections
from roughcontact.report.files import from_page
from roughcontact.report.groups import HEADINGS as GROUP_HEADINGS
from roughcontact.report.groups import (
    comparison_rows,
    differences_in_words,
    group_picture,
    group_rows,
    groups_in_words,
    shown_comparisons,
    surfaces_in_words,
)
from roughcontact.report.load_plots import compare_areas, line_sample
from roughcontact.report.summary import read_summary
from roughcontact.report.template import template
from roughcontact.report.units import interval_values, unit_of
from roughcontact.results.collect import Entry, Failure, file_of, solved_results
from roughcontact.results.storage import write_text
from roughcontact.statistics.decisions import OPEN_BELOW, OPEN_PARTS
from roughcontact.statistics.kinds import facts_of_numbers
from roughcontact.statistics.outcome import VERDICTS
from roughcontact.uncertainty.group_tables import NamedGroup

# columns of the index of many surfaces: load and all answers but the last; and the variables that sort them
_HEADINGS = ("rms height", "rms gradient\N{NO-BREAK SPACE}g")  # of the index, before load and answers
_SORTED_BY = ("mean_pressure", *(answer.quantity for answer in [*ANSWERS.values()][:-1]))

Key = tuple[str, str | None]  # surface and case


def write_report(
    path: str | Path,
    *,
    finished: Sequence[Entry],
    statistics: xr.Dataset,
    summary: str,
    title: str,
    settings: dict,
    changed: Mapping[str, Sequence[str]] | None = None,
    groups: Sequence[NamedGroup] = (),
    compared: Mapping[tuple[str, str], xr.Dataset] | None = None,
    omissions: Sequence[str] = (),
    failures: Sequence[Failure] = (),
    linked: bool = True,
) -> None:
    """Write the page of a run: verdicts, comparison, and the part of every surface (`write_panel`).

    Up to `ONE_PAGE` results stand on one self-contained page; of more there is an index, and beside it the
    folder `pages`. `summary` is the text of `summary.csv`, `changed` the settings in words by case,
    `omissions` why groups have no answer; the page is `linked` to the tables of the run.
    """
    has_index = len(finished) + len(failures) > ONE_PAGE
    folder = Path(path).parent
    series = _series(statistics)
    by_surface: dict[str, dict[str, xr.Dataset]] = {}
    for (surface, case), data in series.items():
        by_surface.setdefault(surface, {})[case or ""] = data
    # a placement stands with its pair, which comes last
    group_of_surface = {str(name): group.name for group in groups for name in group.answer["map"].values}
    results = list(series.values())
    styles, indices = _line_styles(series, group_of_surface), glance.loads_to_compare(results)
    units = dict(zip(series, glance.glance_units(results), strict=True))
    compared_at = dict(zip(series, indices, strict=True))
    columns_asked = glance.asked_columns(results)
    further = [0, *(column for column in range(1, len(ANSWERS) + 1) if column not in columns_asked)]
    rows: list[dict[str, Any]] = []
    for entry in finished:
        key, path_of_panel = (entry["surface"], entry["case"]), file_of(entry, "panel.html")
        panel = read_summary(path_of_panel)
        numbers, cells = series[key], glance.glance_rows(series[key], units[key], panel["loads"])
        alone = len(cells) == len(finished) == 1  # then no table of loads repeats it
        if alone or len(cells) > 1:
            line = glance.answer_line(numbers, panel["loads"][-1], cells[-1], alone=alone)
        else:  # the row is the answer
            line = glance.exact_remarks([cells[0][column] for column in columns_asked])
        courses = course_sections(panel["name"], numbers, path_of_panel.parent, folder)
        rows.append(
            {
                **entry,
                **panel,
                "panel": path_of_panel,
                "courses": courses,
                "answer": answer_with_courses(line, courses),
                "glance": [[cells_of_load[column] for column in columns_asked] for cells_of_load in cells],
                "further": [[cells_of_load[column] for column in further] for cells_of_load in cells],
                "numbers": _compared(numbers, units[key], compared_at[key]) if has_index else [],
                "sample": line_sample(*styles[key]),
                "group": group_of_surface.get(entry["surface"], ""),
                "rank": len(VERDICTS) - list(VERDICTS).index(panel["verdict"]),
            }
        )
    causes: dict[tuple[str, str], list[str | None]] = {}
    for failure in failures:
        causes.setdefault((failure["surface"], failure["reason"]), []).append(failure["case"])
    failure_rows = [
        {"surface": name, "reason": reason, "cases": cases, "name": _name(name, *cases)}
        for (name, reason), cases in causes.items()
    ]
    cases = [*(case for _, case in series), *(failure["case"] for failure in failures)]
    head: dict[str, Any] = {"title": title, "version": __version__, "words": VERDICTS}
    head |= {
        "asked": [glance.load_heading(results), *(glance.HEADINGS[column] for column in columns_asked[1:])],
        "further": [glance.load_heading(results), *(glance.HEADINGS[column] for column in further[1:])],
    }
    head |= {"single": len(rows) == 1, "open_below": OPEN_BELOW, "open_parts": OPEN_PARTS}
    # members of a group that is compared with no other: nobody asked for that
    uncompared = {
        _name(str(name), group.case)
        for group in groups
        if not group.members.is_compared
        for name in group.answer["map"].values
    }
    maps = {_name(*key): data for key, data in series.items()}
    compared = shown_comparisons(compared or {}, maps | {group.label: group.answer for group in groups})
    asked = {labels: table for labels, table in compared.items() if not uncompared & {*labels}}
    several = differences_in_words(asked) or groups_in_words(groups, series)
    if results and not (several or groups):  # at the last load that the table below shows of each
        last = compared_at if has_index else {(row["surface"], row["case"]): row["loads"][-1] for row in rows}
        several = surfaces_in_words({_name(*key): (data, last[key]) for key, data in series.items()})
    head["answer"] = rows[0]["answer"] if len(rows) == 1 else several
    head |= {"in_words": glance.IN_WORDS, "asked_of_run": describe_problem(settings, changed)}
    equal = same_loads(settings)
    if has_index:
        _write_pages(folder / "pages", rows, by_surface, failure_rows, equal_loads=equal, head=head)
    html = template("report.html").render(
        rows=rows,
        headings=(*_HEADINGS, glance.load_heading(results), *glance.HEADINGS[1 : len(ANSWERS)]),
        download=None if has_index else _as_download(summary),
        linked=linked,
        counts={outcome: sum(row["verdict"] == outcome for row in rows) for outcome in VERDICTS},
        many=has_index,
        doubts=Counter(doubt for row in rows for doubt in row["doubts"]).most_common(),
        surfaces=len(by_surface),
        cases_of_run=[*filter(None, dict.fromkeys(cases))],
        which_load=_which_load(indices, results),
        # of so many that an index stands for them, lines over one another tell nothing
        comparisons=[] if has_index else _comparisons(series, styles, bool(group_of_surface)),
        cases=_cases(by_surface, large=has_index, equal_loads=equal),
        courses=[row["courses"] for row in rows],
        parts=[]
        if has_index
        else [from_page(row["panel"].read_text(encoding="utf-8"), row["panel"], folder) for row in rows],
        failures=failure_rows,
        groups=group_rows(groups, {(row["surface"], row["case"]): VERDICTS[row["verdict"]] for row in rows}),
        group_headings=GROUP_HEADINGS,
        group_picture=group_picture(groups) if groups else None,
        left_out=omissions,
        compared=comparison_rows(compared, groups, maps),
        folded=bool(group_of_surface) and by_surface.keys() <= group_of_surface.keys(),
        **head,
        measured=measured_in_words({row["surface"]: row["measured"] for row in rows}),
        settings=json.dumps(settings, indent=1, sort_keys=True),
    )
    write_text(html, path)


def _write_pages(
    folder: Path,
    rows: Sequence[Mapping[str, Any]],
    by_surface: Mapping[str, Mapping[str, xr.Dataset]],
    failures: Sequence[Mapping[str, Any]],
    *,
    equal_loads: bool,
    head: Mapping[str, Any],
) -> None:
    """Write the page of each surface, with all its cases and the same `head`.

    `equal_loads` is as of `case_table`.
    """
    names = list(dict.fromkeys(row["surface"] for row in rows))
    for previous, name, following in zip([None, *names], names, [*names[1:], None], strict=False):
        rows_of_surface = [row for row in rows if row["surface"] == name]
        html = template("surface.html").render(
            head,
            measured=measured_in_words({name: rows_of_surface[0]["measured"]}),
            name=name,
            before=previous,
            after=following,
            cases=case_table(by_surface[name], equal_loads=equal_loads),
            rows=rows_of_surface,
            failures=[failure for failure in failures if failure["surface"] == name],
            parts=[
                from_page(row["panel"].read_text(encoding="utf-8"), row["panel"], folder)
                for row in rows_of_surface
            ],
        )
        write_text(html, folder / f"{name}.html")


def _as_download(text: str) -> str:
    """Return a table as a data URI, so that the page offers it as a download without another file."""
    return "data:text/csv;charset=utf-8;base64," + base64.b64encode(text.encode()).decode()


def _comparisons(
    series: Mapping[Key, xr.Dataset], styles: Mapping[Key, tuple[int, int]], has_groups: bool
) -> list[tuple[str, str]]:
    """Return (image, caption) of area against load of all rough surfaces: in Pa, and relative to E* g.

    `styles` is of `_line_styles`, `has_groups` whether there are groups of maps.
    """
    rough = {key: data for key, data in series.items() if np.isfinite(data["relative_pressure"]).all()}
    # the panel of a single surface has the same
    if len(rough) < 2:
        return []
    half_spaces = {key: data for key, data in rough.items() if facts_of_numbers(data).scaled_columns}
    in_these_units = (
        "Over the pressure relative to E* times the rms gradient rough surfaces fall close together; the "
        "dark lines without marks are theories, in which the rms gradient alone stands for the surface."
    )
    # that of the stiffest, where the cases differ in it
    pressure = min((unit_of(data, "Pa") for data in rough.values()), key=lambda unit: unit.factor)
    available = all(f"{AREA}_lower" in data for data in rough.values())
    remarks = ["Bars: the ±."] if available else []
    remarks += ["Surfaces are colours, cases are line styles."] if any(case for _, case in rough) else []
    remarks += ["The maps of a group have one colour."] if has_groups else []
    charts = []
    for compared, load, unit, text in (
        (rough, "mean_pressure", pressure, " ".join(remarks)),
        (half_spaces, "relative_pressure", None, in_these_units),
    ):
        if len(compared) < 2:
            continue
        lines = [(_name(*key), data[load].values, data[AREA].values) for key, data in compared.items()]
        bounds = [interval_values(data, AREA)[1:] for data in compared.values() if available]
        styles_shown = [styles[key] for key in compared]
        charts.append((compare_areas(lines, intervals=bounds, pressure=unit, styles=styles_shown), text))
    return charts


def _cases(
    by_surface: Mapping[str, Mapping[str, xr.Dataset]], *, large: bool, equal_loads: bool
) -> list[tuple[str, dict[str, Any]]]:
    """Return (title, table) of the cases side by side: of each surface, or of all where there are many."""
    if large:
        medians = case_medians(list(by_surface.values()), equal_loads=equal_loads)
        return [("", medians)] if medians else []
    tables = [(name, case_table(cases, equal_loads=equal_loads)) for name, cases in by_surface.items()]
    return [(name, table) for name, table in tables if table]


def _line_styles(series: Iterable[Key], groups_by_surface: Mapping[str, str]) -> dict[Key, tuple[int, int]]:
    """Return the indices of colour and line style of all results.

    The maps of a group (name of a map -> of its group) have one colour, cases have line styles.
    """
    colours = list(dict.fromkeys(groups_by_surface.get(surface, surface) for surface, _ in series))
    cases = list(dict.fromkeys(case for _, case in series))
    return {
        (surface, case): (colours.index(groups_by_surface.get(surface, surface)), cases.index(case))
        for surface, case in series
    }


def _series(statistics: xr.Dataset) -> dict[Key, xr.Dataset]:
    """Return {(surface, case): statistics}, loads rising, without padding and failed surfaces.

    `place` (load) is that of a load among the stated ones and targets.
    """
    series = {}
    for labels, result in solved_results(statistics):
        result_with_place = result.assign_coords(place=("load", np.arange(result.sizes["load"])))
        series[labels["surface"], labels.get("case")] = result_with_place.sortby("mean_pressure")
    return series


def _name(surface: str, *cases: str | None) -> str:
    """Return the name of a surface, under a case or several, on the page."""
    return " · ".join(filter(None, [str(surface), ", ".join(filter(None, cases))]))


def _compared(data: xr.Dataset, units: Mapping[str, Unit], index: int) -> list[dict[str, Any]]:
    """Return the cells of a surface in the index, below `_HEADINGS`, with their sorting keys."""
    rms, slope = (float(data[name]) for name in ("rms_height", "rms_gradient"))
    answers = glance.glance_rows(data, units, [index])[0]
    cells = [glance.Cell(units["mean_gap"].text(rms)), glance.Cell(number(slope)), *answers]
    keys = [rms, slope, *(float(data[name][index]) if name else None for name in _SORTED_BY)]
    return [
        cell._asdict()
        | ({"details": "", "key": None} if key is None else {"key": key if np.isfinite(key) else ""})
        for cell, key in zip(cells, keys, strict=False)  # all but the last
    ]


def _which_load(indices: Sequence[int], results: Sequence[xr.Dataset]) -> str:
    """Return the load at which the surfaces of the index are compared, in words."""
    if len({(index, data.sizes["load"]) for index, data in zip(indices, results, strict=True)}) == 1:
        return (
            f"at load {indices[0] + 1} of {results[0].sizes['load']}, at which the contact of most is nearest"
        )
    return "at that load at which its contact is nearest"
