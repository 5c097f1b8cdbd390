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
from roughcontact.quantities import Unit, number
from roughcontact.report import ONE_PAGE
from roughcontact.report.asked import describe_problem, measured_in_words, planned_in_words, same_loads
from roughcontact.report.captions import comparison_caption
from roughcontact.report.cases import case_medians, case_table
from roughcontact.report.files import from_page
from roughcontact.report.glance import HEADINGS, IN_WORDS, Cell, glance_rows, glance_units, loads_to_compare
from roughcontact.report.groups import HEADINGS as GROUP_HEADINGS
from roughcontact.report.groups import comparison_rows, group_pictures, group_rows
from roughcontact.report.load_plots import compare_areas, sample_of, spread_of_areas
from roughcontact.report.summary import read_summary
from roughcontact.report.tables import is_finite_body
from roughcontact.report.template import template
from roughcontact.report.units import interval_of, unit_of
from roughcontact.report.unloading import unloading_of
from roughcontact.results.collect import Entry, Failure, file_of, solved_results
from roughcontact.results.storage import write_text
from roughcontact.statistics.outcome import VERDICTS
from roughcontact.uncertainty.group_tables import NamedGroup

# columns of the index of many surfaces: of `HEADINGS` all but the last; and the variables that sort them
_HEADINGS = ("rms height", "rms gradient\N{NO-BREAK SPACE}g", *HEADINGS[:-1])
_AREA = "relative_contact_area"
_SORTED_BY = ("mean_pressure", _AREA, "mean_contact_pressure", "mean_gap", "", "", "max_pressure")

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
    folder: str | Path | None = None,
) -> None:
    """Write the page of a run: verdicts, comparison, and the part of every surface (`write_panel`).

    Up to `ONE_PAGE` results stand on one self-contained page; of more there is an index, and beside it the
    folder `pages`. `summary` is the text of `summary.csv`, `changed` the settings in words by case,
    `omissions` why groups have no answer, `folder` where the page will be moved to, for its links.
    """
    indexed = len(finished) + len(failures) > ONE_PAGE
    folder = Path(path).parent if folder is None else Path(folder)
    series = _series(statistics)
    by_surface: dict[str, dict[str, xr.Dataset]] = {}
    for (surface, case), data in series.items():
        by_surface.setdefault(surface, {})[case or ""] = data
    # a placement stands with its pair, which comes last
    grouped = {str(name): group.name for group in groups for name in group.answer["map"].values}
    results = list(series.values())
    styles, indices = _line_styles(series, grouped), loads_to_compare(results)
    units = dict(zip(series, glance_units(results), strict=True))
    compared_at = dict(zip(series, indices, strict=True))
    rows: list[dict[str, Any]] = []
    for entry in finished:
        key, path_of_panel = (entry["surface"], entry["case"]), file_of(entry, "panel.html")
        panel = read_summary(path_of_panel)
        rows.append(
            {
                **entry,
                **panel,
                "panel": path_of_panel,
                "residual": file_of(entry, "residual.nc"),
                "glance": glance_rows(series[key], units[key], panel["loads"]),
                "numbers": _compared(series[key], units[key], compared_at[key]) if indexed else [],
                "sample": sample_of(*styles[key]),
                "group": grouped.get(entry["surface"], ""),
                "rank": len(VERDICTS) - list(VERDICTS).index(panel["verdict"]),
            }
        )
    causes: dict[tuple[str, str], list[str | None]] = {}
    for failure in failures:
        causes.setdefault((failure["surface"], failure["reason"]), []).append(failure["case"])
    named = [
        {"surface": name, "reason": reason, "cases": cases, "name": _name(name, _listed(cases))}
        for (name, reason), cases in causes.items()
    ]
    cases = [*(case for _, case in series), *(failure["case"] for failure in failures)]
    head: dict[str, Any] = {"title": title, "version": __version__, "words": VERDICTS}
    head |= {"asked": HEADINGS, "in_words": IN_WORDS, "asked_of_run": describe_problem(settings, changed)}
    equal = same_loads(settings)
    if indexed:
        written_to, place = Path(path).parent / "pages", folder / "pages"
        _write_pages(written_to, rows, by_surface, named, equal_loads=equal, head=head, folder=place)
    html = template("report.html").render(
        rows=rows,
        headings=_HEADINGS,
        download=None if indexed else _as_download(summary),
        counts={outcome: sum(row["verdict"] == outcome for row in rows) for outcome in VERDICTS},
        many=indexed,
        doubts=Counter(doubt for row in rows for doubt in row["doubts"]).most_common(),
        surfaces=len(by_surface),
        cases_of_run=[*filter(None, dict.fromkeys(cases))],
        light=planned_in_words(
            settings,
            {(name, case or ""): float(data["mean_pressure"][0]) for (name, case), data in series.items()},
        ),
        which_load=_which_load(indices, results),
        comparisons=_comparisons(series, styles, bool(grouped), many=indexed),
        cases=_cases(by_surface, many=indexed, equal_loads=equal),
        unloadings=[
            unloading_of(row["name"], series[row["surface"], row["case"]], residual, folder)
            for row in rows
            if (residual := row["residual"]).is_file()
        ],
        parts=[] if indexed else [_panel_html(row, folder) for row in rows],
        failures=named,
        groups=group_rows(groups, {(row["surface"], row["case"]): VERDICTS[row["verdict"]] for row in rows}),
        group_headings=GROUP_HEADINGS,
        group_pictures=group_pictures(groups) if groups else [],
        left_out=omissions,
        compared=comparison_rows(compared or {}, groups, {_name(*key): data for key, data in series.items()}),
        folded=bool(grouped) and by_surface.keys() <= grouped.keys(),
        **head,
        measured=measured_in_words({row["surface"]: row["measured"] for row in rows}),
        settings=json.dumps(settings, indent=1, sort_keys=True),
    )
    write_text(html, path)


def _write_pages(
    written_to: Path,
    rows: Sequence[Mapping[str, Any]],
    by_surface: Mapping[str, Mapping[str, xr.Dataset]],
    failures: Sequence[Mapping[str, Any]],
    *,
    equal_loads: bool,
    head: Mapping[str, Any],
    folder: Path,
) -> None:
    """Write the page of each surface, with all its cases and the same `head`; `folder` is their place.

    `equal_loads` is as of `case_table`.
    """
    names = list(dict.fromkeys(row["surface"] for row in rows))
    for before, name, after in zip([None, *names], names, [*names[1:], None], strict=False):
        selected = [row for row in rows if row["surface"] == name]
        html = template("surface.html").render(
            head,
            measured=measured_in_words({name: selected[0]["measured"]}),
            name=name,
            before=before,
            after=after,
            cases=case_table(by_surface[name], equal_loads=equal_loads),
            rows=selected,
            failures=[failure for failure in failures if failure["surface"] == name],
            parts=[_panel_html(row, folder) for row in selected],
        )
        write_text(html, written_to / f"{name}.html")


def _panel_html(row: Mapping[str, Any], folder: Path) -> str:
    """Return the part of a surface as it stands on a page of `folder`."""
    return from_page(Path(row["panel"]).read_text(encoding="utf-8"), row["panel"], folder)


def _as_download(text: str) -> str:
    """Return a table as a data URI, so that the page offers it as a download without another file."""
    return "data:text/csv;charset=utf-8;base64," + base64.b64encode(text.encode()).decode()


def _comparisons(
    series: Mapping[Key, xr.Dataset], styles: Mapping[Key, tuple[int, int]], grouped: bool, *, many: bool
) -> list[tuple[str, str]]:
    """Return (image, caption) of area against load of all rough surfaces: in Pa, and relative to E* g.

    `styles` is of `_line_styles`, `grouped` whether there are groups of maps.
    """
    rough = {key: data for key, data in series.items() if np.isfinite(data["relative_pressure"]).all()}
    half_spaces = {key: data for key, data in rough.items() if not is_finite_body(data)}
    # the panel of a single surface has the same
    if len(rough) < 2 or (many and not half_spaces):
        return []
    in_these_units = (
        "Over the pressure relative to E* times the rms gradient rough surfaces fall close together; the "
        "dark lines without marks are theories, in which the rms gradient alone stands for the surface."
    )
    if many:
        groups: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
        for (_, case), data in half_spaces.items():
            line = data["relative_pressure"].values, data[_AREA].values
            groups.setdefault(case or "", []).append(line)
        statements = f"Each surface is a faint line. {in_these_units}"
        return [
            (image, f"The same under {case}." if index else statements)
            for index, (case, image) in enumerate(spread_of_areas(groups).items())
        ]
    # that of the stiffest, where the cases differ in it
    pressure = min((unit_of(data, "Pa") for data in rough.values()), key=lambda unit: unit.factor)
    available = all(f"{_AREA}_lower" in data for data in rough.values())
    remarks = ["Bars: the ±."] if available else []
    remarks += ["Surfaces are colours, cases are line styles."] if any(case for _, case in rough) else []
    remarks += ["The maps of a group have one colour."] if grouped else []
    charts = []
    for drawn, load, unit, text in (
        (rough, "mean_pressure", pressure, " ".join(remarks)),
        (half_spaces, "relative_pressure", None, in_these_units),
    ):
        if len(drawn) < 2:
            continue
        lines = [(_name(*key), data[load].values, data[_AREA].values) for key, data in drawn.items()]
        ends = [interval_of(data, _AREA)[1:] for data in drawn.values() if available]
        image = compare_areas(lines, intervals=ends, pressure=unit, styles=[styles[key] for key in drawn])
        charts.append((image, f"{comparison_caption(lines, unit)} {text}".strip()))
    return charts


def _cases(
    by_surface: Mapping[str, Mapping[str, xr.Dataset]], *, many: bool, equal_loads: bool
) -> list[tuple[str, dict[str, Any]]]:
    """Return (title, table) of the cases side by side: of each surface, or of all where there are many."""
    if many:
        medians = case_medians(list(by_surface.values()), equal_loads=equal_loads)
        return [("", medians)] if medians else []
    tables = [(name, case_table(cases, equal_loads=equal_loads)) for name, cases in by_surface.items()]
    return [(name, table) for name, table in tables if table]


def _line_styles(series: Iterable[Key], grouped: Mapping[str, str]) -> dict[Key, tuple[int, int]]:
    """Return the indices of colour and line style of all results.

    The maps of a group (name of a map -> of its group) have one colour, cases have line styles.
    """
    colours = list(dict.fromkeys(grouped.get(surface, surface) for surface, _ in series))
    cases = list(dict.fromkeys(case for _, case in series))
    return {
        (surface, case): (colours.index(grouped.get(surface, surface)), cases.index(case))
        for surface, case in series
    }


def _series(statistics: xr.Dataset) -> dict[Key, xr.Dataset]:
    """Return {(surface, case): statistics}, loads rising, without padding and failed surfaces.

    `place` (load) is that of a load among the stated ones and targets.
    """
    series = {}
    for labels, result in solved_results(statistics):
        placed = result.assign_coords(place=("load", np.arange(result.sizes["load"])))
        series[labels["surface"], labels.get("case")] = placed.sortby("mean_pressure")
    return series


def _name(surface: str, case: str | None) -> str:
    """Return the name of a surface, under a case, on the page."""
    return str(surface) if case is None else f"{surface} · {case}"


def _listed(cases: Sequence[str | None]) -> str | None:
    """Return the names of some cases; None in a run without cases."""
    return ", ".join(case for case in cases if case is not None) or None


def _compared(data: xr.Dataset, units: Mapping[str, Unit], index: int) -> list[dict[str, Any]]:
    """Return the cells of a surface in the index, below `_HEADINGS`, with their sorting keys."""
    answers = glance_rows(data, units, [index])[0]
    keys = [_sorted(float(data[name][index])) if name else None for name in _SORTED_BY]
    return [
        Cell(units["mean_gap"].text(rms := float(data["rms_height"])))._asdict() | {"key": _sorted(rms)},
        Cell(number(slope := float(data["rms_gradient"])))._asdict() | {"key": _sorted(slope)},
        *(
            cell._replace(details="" if key is None else cell.details)._asdict() | {"key": key}
            for cell, key in zip(answers[: len(keys)], keys, strict=True)
        ),
    ]


def _sorted(value: float) -> float | str:
    """Return the sorting key of a cell: its number, or an empty text where it has none."""
    return value if np.isfinite(value) else ""


def _which_load(indices: Sequence[int], results: Sequence[xr.Dataset]) -> str:
    """Return the load at which the surfaces of the index are compared, in words."""
    if len({(index, data.sizes["load"]) for index, data in zip(indices, results, strict=True)}) == 1:
        return (
            f"at load {indices[0] + 1} of {results[0].sizes['load']}, at which the contact of most is nearest"
        )
    return "at that load at which its contact is nearest"
