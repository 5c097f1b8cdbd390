"""The page of a run: verdicts, comparison and the panel of every surface in one self-contained HTML file."""

import base64
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from roughcontact import __version__
from roughcontact.arguments.answers import ANSWERS
from roughcontact.report import ONE_PAGE, glance
from roughcontact.report import groups as group_section
from roughcontact.report.allowed import DECISIONS
from roughcontact.report.asked import describe_problem, measured_in_words, same_loads
from roughcontact.report.charts import series_style
from roughcontact.report.courses import answer_with_courses, course_sections
from roughcontact.report.differences import Row, case_rows, comparison_rows
from roughcontact.report.groups import Key, name_under
from roughcontact.report.load_plots import compare_areas
from roughcontact.report.summary import from_page, read_summary
from roughcontact.report.template import template
from roughcontact.results.collect import Entry, Failure, file_of, solved_results
from roughcontact.results.storage import write_text
from roughcontact.statistics.decisions import OPEN_BELOW
from roughcontact.statistics.outcome import VERDICTS
from roughcontact.uncertainty.group_tables import NamedGroup


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
    folder, has_index = Path(path).parent, len(finished) + len(failures) > ONE_PAGE
    series = _series(statistics)
    results = list(series.values())
    by_surface: dict[str, dict[str, xr.Dataset]] = {}
    for (surface, case), data in series.items():
        by_surface.setdefault(surface, {})[case or ""] = data
    # a placement stands with its pair, which comes last
    group_of_surface = {str(name): group.name for group in groups for name in group.answer["map"].values}
    surfaces, cases_solved = [*by_surface], list(dict.fromkeys(case for _, case in series))
    styles = {key: series_style(surfaces.index(key[0]), cases_solved.index(key[1])) for key in series}
    ungrouped = {key: data for key, data in series.items() if key[0] not in group_of_surface}
    equal_loads = same_loads(settings)
    shared = glance.shared_loads(results, "place" if equal_loads else glance.LOAD)
    loads_at_glance = dict(zip(series, shared, strict=bool(shared)))
    units = dict(zip(series, glance.glance_units(results), strict=True))
    last: dict[Key, int] = {}
    asked = glance.asked_columns(results)
    further = [name for name in ANSWERS if name not in asked]
    rows: list[Row] = []
    for entry in finished:
        key, panel = (entry["surface"], entry["case"]), file_of(entry, "panel.html")
        of_panel = read_summary(panel)
        loads = loads_at_glance.get(key, of_panel["loads"])
        numbers, cells = series[key], glance.glance_rows(series[key], units[key], loads)
        asked_cells = [cells[-1][name] for name in asked]
        alone = len(cells) == len(finished) == 1  # then no table of loads repeats it
        is_row = len(cells) == 1 and not alone  # which is the answer
        answer = [] if is_row else glance.answer_sentences(numbers, loads[-1], cells[-1], alone=alone)
        courses = course_sections(of_panel["name"], numbers, panel.parent, folder)
        sentences = answer_with_courses(answer, courses)
        row: Row = {
            **entry,
            **of_panel,
            "panel": panel,
            "courses": courses,
            "sentences": sentences,
            "answer": " ".join(map(str, sentences)),
            "said": {remark for cell in asked_cells for remark in cell.remarks if not is_row},
            "glance": [[at_load[name] for name in (glance.LOAD, *asked)] for at_load in cells],
            "further": [[at_load[name] for name in (glance.LOAD, *further)] for at_load in cells],
            "complete": len(cells) == numbers.sizes["load"],
            "keys": [_sorted_by(numbers, name, loads[-1]) for name in (glance.LOAD, *asked)],
            "sample": styles[key],
            "group": group_of_surface.get(entry["surface"], ""),
            "rank": len(VERDICTS) - list(VERDICTS).index(of_panel["verdict"]),
        }
        rows.append(row)
        last[key] = loads[-1]
    cases_of_run = dict.fromkeys([*cases_solved, *(failure["case"] for failure in failures)])
    causes: dict[tuple[str, str], list[str | None]] = {}
    for failure in failures:
        causes.setdefault((failure["surface"], failure["reason"]), []).append(failure["case"])
    failure_rows = [
        {"surface": name, "reason": reason, "cases": cases, "name": name_under(name, *cases)}
        for (name, reason), cases in causes.items()
    ]
    by_name = {name_under(*key): data for key, data in series.items()}
    differences = comparison_rows(compared or {}, groups, by_name)
    several = group_section.answer_of_several(groups, differences, series, last)
    cases: list[Row] = []
    for name, of_cases in by_surface.items():
        cases += case_rows(of_cases, surface=name, equal_loads=equal_loads)
    verdicts = {(row["surface"], row["case"]): VERDICTS[row["verdict"]] for row in rows}
    head = {
        "title": title,
        "version": __version__,
        "words": VERDICTS,
        "decisions": DECISIONS,
        "single": len(rows) == 1,
        "answer": rows[0]["answer"] if len(rows) == 1 else several,
        "asked": glance.headings_of(asked, results),
        "further": glance.headings_of(further, results),
        "in_words": glance.IN_WORDS,
        "asked_of_run": describe_problem(settings, changed),
    }
    if has_index:
        _write_pages(folder / "pages", rows, failure_rows, cases, head)
    html = template("report.html").render(
        head,
        rows=rows,
        download="" if has_index else base64.b64encode(summary.encode()).decode(),
        linked=linked,
        counts=Counter(row["verdict"] for row in rows),
        many=has_index,
        doubts=Counter(doubt for row in rows for doubt in row["doubts"]).most_common(),
        cases_of_run=[*filter(None, cases_of_run)],
        are_shared=bool(shared),
        # of so many that an index stands for them, lines over one another tell nothing; groups have their own
        comparison="" if has_index else _comparison(ungrouped, styles),
        cases=[] if has_index else cases,
        parts=[] if has_index else _parts(rows, folder),
        failures=failure_rows,
        groups=group_section.group_rows(groups, verdicts, asked),
        group_headings=[*group_section.group_headings(asked).values()],
        group_picture=group_section.group_picture(groups) if groups else None,
        left_out=omissions,
        compared=differences,
        measured=measured_in_words({row["surface"]: row["measured"] for row in rows}),
        open_below=OPEN_BELOW,
        settings=json.dumps(settings, indent=1, sort_keys=True),
    )
    write_text(html, path)


def _write_pages(
    folder: Path, rows: Sequence[Row], failures: Sequence[Row], cases: Sequence[Row], head: Row
) -> None:
    """Write the page of each surface, with its rows of `cases` and the same `head`."""
    names = list(dict.fromkeys(row["surface"] for row in rows))
    for previous, name, following in zip([None, *names], names, [*names[1:], None], strict=False):
        rows_of_surface = [row for row in rows if row["surface"] == name]
        html = template("surface.html").render(
            head,
            measured=measured_in_words({name: rows_of_surface[0]["measured"]}),
            name=name,
            before=previous,
            after=following,
            cases=[pair for pair in cases if pair["surface"] == name],
            rows=rows_of_surface,
            failures=[failure for failure in failures if failure["surface"] == name],
            parts=_parts(rows_of_surface, folder),
        )
        write_text(html, folder / f"{name}.html")


def _parts(rows: Sequence[Row], folder: Path) -> list[str]:
    """Return the panels of results, with their links as seen from a page in `folder`."""
    return [from_page(row["panel"].read_text(encoding="utf-8"), row["panel"], folder) for row in rows]


def _comparison(series: Mapping[Key, xr.Dataset], styles: Mapping[Key, Row]) -> str:
    """Return the image of area against load of the rough ones of several surfaces; empty for one."""
    rough = {key: data for key, data in series.items() if np.isfinite(data["relative_pressure"]).all()}
    if len(rough) < 2:  # the panel of a single surface has the same
        return ""
    by_name = {name_under(*key): data for key, data in rough.items()}
    return compare_areas(by_name, {name_under(*key): styles[key] for key in rough})


def _series(statistics: xr.Dataset) -> dict[Key, xr.Dataset]:
    """Return {(surface, case): statistics}, loads rising, without padding and failed surfaces.

    `place` (load) is that of a load among the stated ones and targets.
    """
    series = {}
    for labels, result in solved_results(statistics):
        result_with_place = result.assign_coords(place=("load", np.arange(result.sizes["load"])))
        series[labels["surface"], labels.get("case")] = result_with_place.sortby("mean_pressure")
    return series


def _sorted_by(data: xr.Dataset, name: str, index: int) -> float | str | None:
    """Return by what the index sorts a surface in a column; None for words, empty for an unknown number."""
    quantity = ANSWERS[name].quantity if name in ANSWERS else name
    if not quantity:
        return None
    value = float(data[quantity][index]) if quantity in data else np.nan
    return value if np.isfinite(value) else ""
