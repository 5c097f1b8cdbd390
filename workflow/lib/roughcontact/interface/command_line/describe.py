"""Output of the program, for people and for machines."""

import json
import math
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from roughcontact.arguments.quantities import counted_noun, number, percent, quantity
from roughcontact.io.metadata import labelled
from roughcontact.io.sources import in_words

_WIDTH = 100
_POINTS = " points (x, y)"  # where x and y need to be told apart


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
    lines.append(("sources", in_words(content["sources"])))
    lines += [("not used", line) for line in content["sources"].get("not used", [])]
    lines += labelled(content["instrument"])
    if content["problem"]:
        lines.append(("to be given", content["problem"].removeprefix(f"{file}: ")))
    if content["map"]:
        lines += [("suspicion", warning) for warning in content["warnings"]] or [("suspicion", "none")]
    return "\n".join([str(file), *(labelled_line(label, text) for label, text in lines if text)])


def overview(contents: Sequence[Mapping[str, Any]], folder: str) -> str:
    """Return a line for each file of a folder, by `inspect_file`: format, points, field, Sq, problem."""
    cells = [("file", "format", "points", "field", "Sq", "to be given, or suspected")]
    for content in contents:
        size = dict(_map_lines(content["map"]) if content["map"] else _silent_lines(content))
        shape = content["map"] or _chosen_channel(content)
        problem = str(content["problem"] or "").removeprefix(f"{Path(folder, content['file'])}: ")
        warnings = content["warnings"] if content["map"] else []
        count = len(content.get("channels", []))
        number_more = f" (and {len(warnings) - 1} more)" if len(warnings) > 1 else ""
        cells.append(
            (
                content["file"],
                content["format"] or "–",
                (points_in_words(shape, noun="") if shape else "–")
                + (f", 1 of {count}" if count > 1 else ""),
                size.get("field", "–"),
                quantity(content["map"]["rms_height"], "m") if content["map"] else "–",
                problem or (warnings[0] + number_more if warnings else "nothing"),
            )
        )
    return "\n".join([str(folder), *_aligned(cells)])


def labelled_line(label: str, text: str) -> str:
    """Return a label and its text, long texts wrapped beside the label."""
    return textwrap.fill(
        text,
        _WIDTH,
        initial_indent=f"  {label:<16}  ",
        subsequent_indent=" " * 20,
        break_long_words=False,
        break_on_hyphens=False,
    )


def _map_lines(content: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the properties of a map that can be read."""
    pitch = " × ".join(dict.fromkeys(quantity(content[step], "m", digits=4) for step in ("dx", "dy")))
    step = content["quantisation_step"]
    heights = f"{quantity(content['lowest'], 'm')} to {quantity(content['highest'], 'm')}"
    if step:
        heights += f", multiples of {quantity(step, 'm')}"
    rms = f"rms height {quantity(content['rms_height'], 'm')}, rms gradient {number(content['rms_gradient'])}"
    return [
        ("size", points_in_words(content, noun=_POINTS)),
        ("field", field_in_words(content)),
        ("spacing", pitch),
        ("missing", f"{percent(content['missing_share'])}, {content['missing_points']} points"),
        ("heights", heights),
        ("off mean plane", f"{rms} (between neighbours)"),
    ]


def field_in_words(content: Mapping[str, Any]) -> str:
    """Return the sides of a map, x first, or the length of a profile."""
    sides = ("size_x",) if content["ny"] == 1 else ("size_x", "size_y")
    return " × ".join(quantity(content[side], "m", digits=4) for side in sides)


def points_in_words(content: Mapping[str, Any], *, noun: str = " points") -> str:
    """Return the numbers of points of a map, x first, and the noun, or of a profile."""
    ny, nx = content["ny"], content["nx"]
    return f"profile of {nx} points" if ny == 1 else f"{nx} × {ny}{noun}"


def _chosen_channel(content: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Return the channel of a file that would be read, None where there is none."""
    channels = content.get("channels", [])
    return next((entry for entry in channels if entry["name"] == content["channel"]), None)


def _silent_lines(content: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the properties of a map whose size or unit is not in the file."""
    channel = _chosen_channel(content)
    if channel is None:
        return []
    lines = [("size", points_in_words(channel, noun=_POINTS))]
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
    return f"{channel['name']!r}: {points_in_words(channel)}, {text}"


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return rows of cells as indented lines, those of a column below one another."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [f"  {'  '.join(map(str.ljust, row, widths))}".rstrip() for row in rows]


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
    lines = [line.strip() for line in _aligned(cells)]
    unpaired = sum(row["quantity"] == "mean_pressure" for row in rows)  # a load of one run, no number
    count = len(cells) - unpaired
    verb, pronoun = ("differs", "its") if count == 1 else ("differ", "their")
    tolerance_text = f"{pronoun} ±" if share is None else percent(share)
    remark = f"; {counted_noun(unpaired, 'load')} of one run only" if unpaired else ""
    return "\n".join(
        [*lines, f"{count} of {len(rows) - unpaired} numbers {verb} by more than {tolerance_text}{remark}"]
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
