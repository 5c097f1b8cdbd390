"""Output of the program, for people and for machines."""

import json
import math
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from roughcontact.io.metadata import labelled
from roughcontact.quantities import Unit, counted_noun, number, percent, prefix, quantity, with_interval
from roughcontact.report.asked import bodies_in_words
from roughcontact.statistics.precision import precision_in_words
from roughcontact.uncertainty.measurands import beyond_the_map, measurand_in_words

_WIDTH = 100
# headline numbers of a load: name, heading, unit for people
_COLUMNS = (
    ("mean_pressure", "mean pressure", "Pa"),
    ("relative_contact_area", "A/A0", "%"),
    ("relative_contact_area_pixels", "counted", "%"),
    ("mean_contact_pressure", "in contact", "Pa"),
    ("max_pressure", "largest", "Pa"),
    ("mean_gap", "mean gap", "m"),
    ("error_bound", "error bound", "1"),
)
# those of them that a group of maps has
_OF_GROUPS = ("mean_pressure", "relative_contact_area", "mean_contact_pressure", "max_pressure", "mean_gap")
_ABOUT_GROUPS = "95 %: ± of the mean of the finish, and of one more map"

# of a contact wider than its map
_WHOLE = (
    ("local_mean_contact_pressure", "in contact", "Pa"),
    ("local_mean_gap", "mean gap", "m"),
    ("local_thermal_resistance", "heat", "K/W"),
    ("local_electrical_resistance", "current", "Ω"),
)


def as_json(value: object) -> str:
    """Return JSON of plain values; infinities and NaN become null, which every reader accepts.

    Examples
    --------
    >>> print(as_json({"mean_gap": float("inf")}))
    {
     "mean_gap": null
    }
    """
    return json.dumps(_finite(value), indent=1, ensure_ascii=False, allow_nan=False)


def _finite(value: object) -> object:
    """Return plain values with null for infinities and NaN."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def inspection(content: Mapping[str, Any], file: str) -> str:
    """Return a description of the result of `inspect_file`: the path, and a line for each known property."""
    lines = [
        ("format", f"{content['format']}, {content['bytes']} bytes"),
        ("channel", content["channel_choice"] or content["channel"] or "none that holds heights"),
    ]
    if len(content["channels"]) > 1:
        lines += [("", _channel(channel)) for channel in content["channels"]]
    lines += _map_lines(content["map"]) if content["map"] else _silent_lines(content)
    if not (content["map"] and content["map"]["ny"] == 1):
        source = (
            "assumed: give first_row where that is wrong" if content["first_row_assumed"] else "by its format"
        )
        lines.append(("first row", f"at the {content['first_row']} of the picture ({source})"))
    lines += labelled(content["instrument"])
    if content["problem"]:
        lines.append(("to be given", content["problem"].removeprefix(f"{file}: ")))
    if content["map"]:
        lines += [("suspicion", warning) for warning in content["warnings"]] or [("suspicion", "none")]
    return "\n".join([str(file), *(_line(label, text) for label, text in lines)])


def overview(contents: Sequence[Mapping[str, Any]], folder: str) -> str:
    """Return a line for each file of a folder, by `inspect_file`: format, points, field, Sq, problem."""
    cells = [("file", "format", "points", "field", "Sq", "to be given, or suspected")]
    for content in contents:
        size = dict(_map_lines(content["map"]) if content["map"] else _silent_lines(content))
        problem = str(content["problem"] or "").removeprefix(f"{Path(folder, content['file'])}: ")
        warnings = content["warnings"] if content["map"] else []
        count = len(content.get("channels", []))
        number_more = f" (and {len(warnings) - 1} more)" if len(warnings) > 1 else ""
        cells.append(
            (
                content["file"],
                content["format"] or "–",
                size.get("size", "–").removesuffix(" points (x, y)")
                + (f", 1 of {count}" if count > 1 else ""),
                size.get("field", "–"),
                quantity(content["map"]["rms_height"], "m") if content["map"] else "–",
                problem or (warnings[0] + number_more if warnings else "nothing"),
            )
        )
    return "\n".join([str(folder), *_aligned(cells, str.ljust)])


def _line(label: str, text: str) -> str:
    """Return a label and its text, long texts wrapped beside the label."""
    return textwrap.fill(
        text,
        _WIDTH,
        initial_indent=f"  {label:<17} ",
        subsequent_indent=" " * 20,
        break_long_words=False,
        break_on_hyphens=False,
    )


def _map_lines(content: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the properties of a map that can be read."""
    pitch = " × ".join(dict.fromkeys(quantity(content[step], "m", digits=4) for step in ("dx", "dy")))
    sides = ("size_x",) if content["ny"] == 1 else ("size_x", "size_y")
    field = " × ".join(quantity(content[side], "m", digits=4) for side in sides)
    step = content["quantisation_step"]
    heights = f"{quantity(content['lowest'], 'm')} to {quantity(content['highest'], 'm')}"
    if step:
        heights += f", multiples of {quantity(step, 'm')}"
    rms = f"rms height {quantity(content['rms_height'], 'm')}, rms gradient {number(content['rms_gradient'])}"
    return [
        ("size", _points(content)),
        ("field", field),
        ("spacing", pitch),
        ("missing", f"{percent(content['missing_share'])}, {content['missing_points']} points"),
        ("heights", heights),
        ("off mean plane", f"{rms} (between neighbours)"),
    ]


def _points(content: Mapping[str, Any]) -> str:
    """Return the numbers of points of a map or a profile."""
    ny, nx = content["ny"], content["nx"]
    return f"profile of {nx} points" if ny == 1 else f"{nx} × {ny} points (x, y)"


def _silent_lines(content: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the properties of a map whose size or unit is not in the file."""
    channels = content.get("channels", [])
    channel = next((entry for entry in channels if entry["name"] == content["channel"]), None)
    if channel is None:
        return []
    lines = [("size", _points(channel))]
    for label, unit, names in (
        ("spacing", "lateral_unit", ("dx", "dy")),
        ("heights", "height_unit", ("lowest", "highest")),
    ):
        texts = [number(channel[name], digits=4) for name in names if channel.get(name) is not None]
        text = (" to " if label == "heights" else " × ").join(texts) or "not said"
        lines.append((label, f"{text}, in {channel[unit]}" if channel[unit] else f"{text}, unit not said"))
    if "missing_share" in channel:
        lines.append(("missing", f"{percent(channel['missing_share'])}, {channel['missing_points']} points"))
    return lines


def _channel(channel: Mapping[str, Any]) -> str:
    """Return name, size and unit of a channel, or the reason why it holds no heights."""
    text = f"in {channel['height_unit'] or 'a unit not said'}" if channel["is_height"] else channel["reason"]
    return f"{channel['name']!r}: {_points(channel).removesuffix(' (x, y)')}, {text}"


def solution(result: Mapping[str, Any]) -> str:
    """Return the headline numbers of a result of `solve_file` as a table, and checks that did not pass."""
    surface, window, contact = result["surface"], result["window"], result["settings"]["contact"]
    rising = sorted(result["loads"], key=lambda load: load["mean_pressure"])
    lengths = [quantity(surface[f"window_length_{axis}"], "m") for axis in ("x", "y")]
    size = f"{window['nx']} × {window['ny']} points, {' × '.join(lengths)}"
    if 1 in (window["nx"], window["ny"]):
        size = f"profile of {max(window['nx'], window['ny'])} points, {lengths[window['nx'] == 1]}"
    body = f"made periodic: {window['periodisation']}"
    if result["settings"]["contact"]["boundary"] == "free":
        body = "a body of finite size"
    lines = [
        str(result["file"]),
        _line("levelled", result["levelled"]["removed_and_filled"]),
        _line("window", f"{size}, {percent(window['share'])} of the map, {body}"),
        _line("rms height", quantity(surface["rms_height"], "m")),
        _line("rms gradient", number(surface["rms_gradient"])),
        *([_line("bodies", bodies_in_words(contact))] if contact["bodies"] else []),
        _line("contact modulus", quantity(surface["contact_modulus"], "Pa")),
        *_lines_of_hardness(surface),
        *_lines_of_finite_body(rising),
        "",
        *_table(rising),
        *_precision(rising),
        *_about(result, rising),
        "",
        _line("verdict", _verdict(result)),
        *([_line("to halve the ±", result["halve"])] if result["halve"] else []),
    ]
    lines += [
        _line(check["name"], check["sentence"]) for check in result["checks"] if check["outcome"] != "passed"
    ]
    return "\n".join(lines)


def _verdict(result: Mapping[str, Any]) -> str:
    """Return the verdict on a map, and the answers that have another one."""
    answers: dict[str, list[str]] = {}
    for answer, verdict in result["verdicts"].items():
        if verdict != result["verdict"]:
            answers.setdefault(verdict, []).append(answer)
    return "; ".join(
        [result["verdict"], *(f"{verdict}: {', '.join(names)}" for verdict, names in answers.items())]
    )


def group(result: Mapping[str, Any]) -> str:
    """Return the numbers of several maps together, by `solve_files`, and a line about each map."""
    answer = result["group"]
    lines = [f"{answer['maps']} maps together", ""]
    lines += [_line("no group", answer["none"])] if "none" in answer else _table_of_group(answer)
    for entry in result["maps"]:
        areas = ", ".join(percent(load["relative_contact_area"]) for load in entry["loads"])
        lines += ["", str(entry["file"]), _line("A/A0", areas), _line("verdict", _verdict(entry))]
    return "\n".join(lines)


def _table_of_group(answer: Mapping[str, Any]) -> list[str]:
    """Return the lines of the numbers of a group, and what its intervals mean."""
    columns = [column for column in _COLUMNS if column[0] in _OF_GROUPS]
    show = _ends if answer["range"] else _cell
    rows = [[columns[0][1], columns[1][1], "next map", *(heading for _, heading, _ in columns[2:])]]
    for load in answer["loads"]:
        first, area, *cells = (show(load, name, unit) for name, _, unit in columns)
        rows.append([first, area, _ends(load, "relative_contact_area_next", "%"), *cells])
    of_two = "range, from the lowest to the highest of the maps, and what these share"
    about = of_two if answer["range"] else _ABOUT_GROUPS
    remarks = [_line("remark", text) for text in answer["remarks"]]
    return [*_aligned(rows), "", _line("intervals", about), *remarks]


def _ends(load: Mapping[str, Any], name: str, unit: str) -> str:
    """Return an interval of a load by its ends; the number itself where it has none."""
    _, low, high = _interval(load, name)
    if math.isnan(low):
        return _cell(load, name, unit) if name in load else "–"
    factor, symbol = (100.0, "%") if unit == "%" else prefix(low or high, unit)
    return f"{with_interval(math.nan, low * factor, high * factor)} {symbol}"


def _lines_of_finite_body(loads: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return the contact of a body of finite size at each load, and Hertz's of the smooth body beside it."""
    lines = []
    for load in loads:
        if "local_contact_area" in load:
            radius = quantity(load["hertz_radius"], "m")
            numbers = [f"{text} {_cell(load, name, unit)}" for name, text, unit in _WHOLE if name in load]
            lines.append(
                _line(f"at {quantity(load['force'], 'N')}", ", ".join([f"radius {radius}", *numbers]))
            )
        if "contact_radius" not in load:
            continue
        text = f"radius {quantity(load['contact_radius'], 'm')}, approach {quantity(-load['approach'], 'm')}"
        lines.append(_line(f"at {quantity(load['force'], 'N')}", f"{text} of the mean plane"))
        if "hertz_radius" in load:
            radius, approach = (quantity(load[f"hertz_{name}"], "m") for name in ("radius", "approach"))
            peak = quantity(load["hertz_max_pressure"], "Pa")
            lines.append(
                _line("smooth (Hertz)", f"radius {radius}, approach {approach}, largest pressure {peak}")
            )
    return lines


def _lines_of_hardness(surface: Mapping[str, Any]) -> list[str]:
    """Return hardness and first yield, if a hardness is given."""
    lines = []
    if "hardness" in surface:
        lines.append(_line("hardness", quantity(surface["hardness"], "Pa")))
    if "first_yield_pressure" in surface:
        lines.append(_line("first yield", f"mean pressure {quantity(surface['first_yield_pressure'], 'Pa')}"))
    return lines


def _precision(loads: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return a line for each number with an interval, how well it is known at the loads, which rise."""
    lines = []
    for name, heading, unit in _COLUMNS[1:]:
        percent = Unit(100.0, "%") if unit == "%" else None
        sentences = []
        for load in loads:
            value, lower, upper = _interval(load, name)
            unit_shown = percent or Unit(*prefix(upper if upper > 0 else value, unit))
            sentences.append(precision_in_words(value, lower, upper, unit_shown))
        if any(sentences):
            lines.append(_line(f"{heading} known", "; ".join(text or "–" for text in sentences)))
    return ["", *lines] if lines else []


def _about(result: Mapping[str, Any], loads: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return the lines with the waves that the numbers hold for, and the range of validity of the ±."""
    lines = [""]
    if shortest := result["window"].get("shortest_wavelength"):
        lines.append(_line("waves", f"longer than {quantity(shortest, 'm')}"))
    if corrected := result["window"].get("corrected_for"):
        lines.append(_line("corrected", f"for {corrected}"))
    uncertainty = result["settings"]["uncertainty"]
    sampled = "window" in uncertainty["sources"]
    if result["settings"]["contact"]["boundary"] == "free":
        elsewhere = ", elsewhere on the roughness too where the map is large enough" if sampled else ""
        lines += [_line("±", f"for this body{elsewhere}")] if uncertainty["sources"] else []
    elif sampled:
        extent, longer = uncertainty["extent"], uncertainty["measurand"] == "longer"
        lines.append(_line("±", f"for {measurand_in_words(extent if longer else None)}"))
        lines += _wider_intervals(loads, extent)
    return lines if lines[1:] else []


def _wider_intervals(loads: Iterable[Mapping[str, Any]], extent: float) -> list[str]:
    """Return the intervals of the area for what lies beyond band or map: a line each, loads rising."""
    lines = []
    for key, text in beyond_the_map(extent).items():
        name = f"relative_contact_area_{key}"
        if any(math.isfinite(load.get(f"{name}_lower", math.nan)) for load in loads):
            lines.append(_line("A/A0", f"{', '.join(_ends(load, name, '%') for load in loads)} {text}"))
    return lines


def _interval(load: Mapping[str, Any], name: str) -> list[float]:
    """Return a number of a load and both ends of its interval, NaN where it has none."""
    return [load.get(f"{name}{end}", math.nan) for end in ("", "_lower", "_upper")]


def _cell(load: Mapping[str, Any], name: str, unit: str) -> str:
    """Return a number of a load with its unit, and with its interval if it has one."""
    value, *ends = _interval(load, name)
    if ends[0] == ends[1] or math.isnan(ends[0]):
        return percent(value) if unit == "%" else quantity(value, unit, digits=4 if unit == "Pa" else 3)
    factor, symbol = (100.0, "%") if unit == "%" else prefix(value or ends[1], unit)
    return f"{with_interval(value * factor, *(end * factor for end in ends))} {symbol}"


def _table(loads: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return the lines of the table of numbers, loads rising."""
    rows = [[heading for _, heading, _ in _COLUMNS]]
    rows += [[_cell(load, name, unit) for name, _, unit in _COLUMNS] for load in loads]
    flags = ["", *(", ".join(load["flags"]) for load in loads)]
    lines = zip(_aligned(rows), flags, strict=True)
    return [f"{numbers}  {text}".rstrip() for numbers, text in lines]


def _aligned(rows: Sequence[Sequence[str]], justified: Callable[[str, int], str] = str.rjust) -> list[str]:
    """Return rows of cells as indented lines, the cells of each column to the right unless `justified`."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [f"  {'  '.join(map(justified, row, widths))}".rstrip() for row in rows]


def comparison(rows: Sequence[Mapping[str, Any]], *, share: float | None = None) -> str:
    """Return the numbers that differ between two runs, a line each, and their count.

    `rows` are those of `compare_statistics`, `share` is the allowed change if that is not the ±.

    Examples
    --------
    >>> gap = {"surface": "ground", "mean_pressure": 1e6, "quantity": "mean_gap", "unit": "m"}
    >>> print(comparison([gap | {"before": 2e-7, "after": 3e-7, "allowed": 5e-8, "differs": True}]))
    ground at 1.00 MPa  mean_gap  200 nm → 300 nm  +50 %, 50.0 nm allowed
    1 of 1 numbers differs by more than its ±
    """
    cells = [_difference(row) for row in rows if row["differs"]]
    lines = [line.strip() for line in _aligned(cells, str.ljust)]
    unmatched = sum(row["quantity"] == "mean_pressure" for row in rows)  # a load of one run, no number
    count = len(cells) - unmatched
    verb, pronoun = ("differs", "its") if count == 1 else ("differ", "their")
    allowed = f"{pronoun} ±" if share is None else percent(share)
    more = f"; {counted_noun(unmatched, 'load')} of one run only" if unmatched else ""
    return "\n".join(
        [*lines, f"{count} of {len(rows) - unmatched} numbers {verb} by more than {allowed}{more}"]
    )


def _difference(row: Mapping[str, Any]) -> list[str]:
    """Return the cells of a number that differs."""
    label = " ".join(str(row[name]) for name in ("case", "surface") if name in row)
    where = f"{label} at {quantity(row['mean_pressure'], 'Pa')}".strip()
    unit = row["unit"] or "1"
    if row["quantity"] == "mean_pressure":
        return [where, "", "", "only in the first" if math.isnan(row["after"]) else "only in the second"]
    sides = [row[side] for side in ("before", "after")]
    values = " → ".join("nothing" if math.isnan(value) else quantity(value, unit) for value in sides)
    change = sides[1] - sides[0]
    if not math.isfinite(change):
        return [where, row["quantity"], values, ""]
    sign = "+" if change > 0 else "−"
    relative = f"{sign}{number(100 * abs(change / sides[0]), digits=2)} %, " if sides[0] else ""
    return [where, row["quantity"], values, f"{relative}{quantity(row['allowed'], unit)} allowed"]
