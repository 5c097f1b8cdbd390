"""The answers of `roughcontact solve` on the screen: the cells and sentences of the page, as text."""

import io
from collections.abc import Iterable, Mapping, Sequence
from itertools import compress
from typing import Any

import xarray as xr

from roughcontact.arguments.answers import AREA, TABLES
from roughcontact.arguments.choices import PERIODIC_BY
from roughcontact.arguments.kinds import facts_of
from roughcontact.arguments.quantities import percent, quantity
from roughcontact.arguments.variables import names_asked
from roughcontact.interface.command_line.describe import labelled_line, points_in_words
from roughcontact.report import facts, glance
from roughcontact.report.asked import bodies_in_words
from roughcontact.report.budget_plots import beyond_in_words, largest_parts
from roughcontact.report.groups import group_cells, group_headings
from roughcontact.report.methods import interval_measurand
from roughcontact.report.tables import creep_table, number_tables
from roughcontact.uncertainty.groups import is_range

_TABLE_WIDTH = 130
_ABOUT_GROUPS = "95 %: ± of the mean of the finish, and of one more map"


def solution(result: Mapping[str, Any], statistics: xr.Dataset) -> str:
    """Return the answers of a result of `solve_file`, as the page has them, and checks that did not pass."""
    window, settings = result["window"], result["settings"]
    flags = [load["flags"] for load in result["loads"]]
    order = statistics["mean_pressure"].argsort().values.tolist()
    numbers, flags = statistics.isel(load=order), [flags[index] for index in order]
    lengths = [
        quantity(result["surface"][f"window_length_{axis}"], "m") for axis in "xy" if window[f"n{axis}"] > 1
    ]
    size = f"{points_in_words(window)}, {' × '.join(lengths)}"
    body = facts_of(settings["contact"]).noun or _periodic_by(window["periodisation"])
    lines = [
        ("levelled", result["levelled"]["removed_and_filled"]),
        ("window", f"{size}, {percent(window['share'])} of the map, {body}"),
        ("bodies", bodies_in_words(settings["contact"])),
        *facts.number_facts(numbers).items(),
        *_bodies_at_loads(numbers),
    ]
    shortest, corrected = window.get("shortest_wavelength"), window.get("corrected_for")
    measurand = interval_measurand(numbers, settings["uncertainty"])
    remarks = [
        ("wavelengths", f"above {quantity(shortest, 'm')}" if shortest else ""),
        ("corrected", f"for {corrected}" if corrected else ""),
        ("±", f"for {measurand}" if measurand else ""),
        *beyond_in_words(numbers).items(),
        ("verdict", _verdict(result)),
        ("with overview", result["overview"]),
        ("largest source of ±", largest_parts(numbers)),
        ("to halve the ±", f"of the {result['halved']}: {result['halve']}" if result["halve"] else ""),
        ("for ± 10 %", result["places"]),
        *((check["name"], check["sentence"]) for check in result["checks"] if check["outcome"] != "passed"),
    ]
    rows = glance.glance_rows(numbers, indices=range(len(flags)))
    return "\n".join(
        [
            str(result["file"]),
            *_lines([("answer", glance.answer_line(numbers, len(flags) - 1, rows[-1])), *lines]),
            "",
            *answers(numbers, rows, flags),
            *_crept(numbers),
            "",
            *_lines(remarks),
        ]
    )


def _periodic_by(method: str) -> str:
    """Return how a window was made periodic."""
    unchanged = {"none": "periodic as measured", "raw": "its edges left as they are"}
    return unchanged.get(method) or f"made periodic by {PERIODIC_BY[method]}"


def answers(
    numbers: xr.Dataset, cells_of_loads: Sequence[Mapping[str, glance.Cell]], flags: Sequence[Sequence[str]]
) -> list[str]:
    """Return the lines of the table of what is asked for at all loads, and one of what is judged at none."""
    columns = glance.asked_columns([numbers])
    headings = glance.headings_of(columns, [numbers])
    rows = [[cells[name] for name in (glance.LOAD, *columns)] for cells in cells_of_loads]
    judged = [any(cell.text != glance.NOT_JUDGED for cell in column) for column in zip(*rows, strict=True)]
    unanswered = [
        ", ".join(filter(None, (heading, cell.details)))
        for heading, cell, is_judged in zip(headings, rows[0], judged, strict=True)
        if not is_judged
    ]
    table = _table([*compress(headings, judged)], [[*compress(row, judged)] for row in rows], flags)
    return [*table, *_lines([(glance.NOT_JUDGED, "; ".join(unanswered))])]


def _crept(numbers: xr.Dataset) -> list[str]:
    """Return the lines of the table of what the contact has become, where a body creeps."""
    if not (crept := creep_table(numbers, range(numbers.sizes["load"]))):
        return []
    return ["", *_table(crept["header"], [[glance.Cell(text) for text in row] for row in crept["rows"]])]


def _lines(named: Iterable[tuple[str, str]]) -> list[str]:
    """Return a line for each label with a text."""
    return [labelled_line(label, text) for label, text in named if text]


def _verdict(result: Mapping[str, Any]) -> str:
    """Return the verdict on a map, and the answers that have another one."""
    answers: dict[str, list[str]] = {}
    for answer, verdict in result["verdicts"].items():
        if verdict != result["verdict"]:
            answers.setdefault(verdict, []).append(answer)
    return "; ".join(
        [result["verdict"], *(f"{verdict}: {', '.join(names)}" for verdict, names in answers.items())]
    )


def group(result: Mapping[str, Any], answer: xr.Dataset | None) -> str:
    """Return the numbers of several maps together, by `solve_files`, and a line about each map."""
    lines = [f"{result['group']['maps']} maps together", ""]
    if answer is None:
        lines.append(labelled_line("no group", result["group"]["none"]))
    else:
        (units,), columns = glance.glance_units([answer]), names_asked(result["maps"][0]["loads"][0])
        rows = [group_cells(answer, units, index, columns) for index in range(answer.sizes["load"])]
        lines += [*_table([*group_headings(columns).values()], rows), ""]
        lines += [] if is_range(answer) else [labelled_line("intervals", _ABOUT_GROUPS)]
        lines += [labelled_line("remark", text) for text in result["group"]["remarks"]]
    for entry in result["maps"]:
        areas = ", ".join(percent(load[AREA]) for load in entry["loads"])
        lines += ["", str(entry["file"]), *_lines([("contact area", areas), ("verdict", _verdict(entry))])]
    return "\n".join(lines)


def _bodies_at_loads(numbers: xr.Dataset) -> list[tuple[str, str]]:
    """Return the contact of a body of finite size at the last load, or at each of one wider than its map."""
    loads = range(numbers.sizes["load"])
    size = facts.size_of_contact(numbers, loads[-1])
    lines = [("body", size)] if size else []
    tables = {table["title"]: table for table in number_tables(numbers, [""] * len(loads))}
    if wider := tables.get(TABLES["local_contact_area"]):
        for index, row in enumerate(wider["rows"]):
            force, radius = (float(numbers[name][index]) for name in ("force", "hertz_radius"))
            cells = zip(wider["header"][1:], row["cells"][1:], strict=True)
            texts = [f"{title} {text} {unit}" for (title, unit, _), text in cells]
            lines.append(
                (f"at {quantity(force, 'N')}", ", ".join([f"radius {quantity(radius, 'm')}", *texts]))
            )
    return lines


def _table(
    headings: Sequence[str], rows: Iterable[Sequence[glance.Cell]], flags: Sequence[Sequence[str]] = ()
) -> list[str]:
    """Return the lines of a table: below each number with its interval how well it is known, then `flags`."""
    from rich.console import Console
    from rich.table import Table

    remarks = ["remarks"] if any(flags) else []
    table = Table(*headings, *remarks, box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="")
    for index, cells in enumerate(rows):
        texts = ["\n".join(filter(None, (cell.text, cell.all_details, cell.known))) for cell in cells]
        table.add_row(*texts, *([", ".join(flags[index])] if remarks else []))
    page = io.StringIO()
    Console(
        file=page, width=_TABLE_WIDTH, color_system=None, markup=False, emoji=False, highlight=False
    ).print(table)
    return [f"  {line}".rstrip() for line in page.getvalue().splitlines()]
