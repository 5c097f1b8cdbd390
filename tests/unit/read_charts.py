"""Charts of the report, read back as a reader does: by the numbers that are written at their axes."""

import re
from dataclasses import dataclass
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np

_SVG = "{http://www.w3.org/2000/svg}"
_DIGITS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")


@dataclass(frozen=True)
class Line:
    """One line of a chart, or a row of marks, in the values of the axes."""

    colour: str
    dash: str
    x: np.ndarray
    y: np.ndarray


@dataclass(frozen=True)
class Drawn:
    """All texts of a chart, its lines and its marks, in the order in which they are drawn."""

    texts: list[str]
    lines: list[Line]
    marks: list[Line]


def read_chart(source, *, log=""):
    """Return what a chart shows; `log` names its logarithmic axes, as in "xy"."""
    kind, _, text = source.partition(",")
    assert kind == "data:image/svg+xml"
    root = ElementTree.fromstring(unquote(text))
    area = root.find(f"{_SVG}svg")
    left, top, height = (float(area.get(name)) for name in ("x", "y", "height"))
    texts = [(each, each.text) for each in root.iter(f"{_SVG}text") if each.text]
    below = [
        (float(each.get("x")) - left, _value(words))
        for each, words in texts
        if each.get("text-anchor") == "middle" and float(each.get("y", 0)) == round(top + height + 18, 1)
    ]
    beside = [
        (float(each.get("y")) - 4 - top, _value(words))
        for each, words in texts
        if each.get("text-anchor") == "end"
    ]
    to_x, to_y = _scale(below, "x" in log), _scale(beside, "y" in log)
    lines, marks = [], {}
    for path in area.iter(f"{_SVG}path"):
        if place := re.match(r"translate\(([-\d.]+) ([-\d.]+)\)", path.get("transform", "")):
            marks.setdefault(path.get("stroke"), []).append([float(value) for value in place.groups()])
        elif path.get("fill") == "none":
            points = np.array(
                re.findall(r"(-?[\d.]+(?:e-?\d+)?) (-?[\d.]+(?:e-?\d+)?)", path.get("d")), float
            )
            points = points.reshape(-1, 2)
            dash = path.get("stroke-dasharray", "")
            lines.append(Line(path.get("stroke"), dash, to_x(points[:, 0]), to_y(points[:, 1])))
    places = {colour: np.array(points) for colour, points in marks.items()}
    return Drawn(
        [words for _, words in texts],
        lines,
        [Line(colour, "", to_x(points[:, 0]), to_y(points[:, 1])) for colour, points in places.items()],
    )


def _value(words):
    """Return the number that is written at a tick, as 0.5, 10⁻⁵ or 2×10⁻⁷."""
    digits, _, power = words.translate(_DIGITS).rpartition("×")
    if re.fullmatch(r"10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+", words.rpartition("×")[2]):
        return float(digits or 1) * 10.0 ** int(power.removeprefix("10"))
    return float(words.translate(_DIGITS))


def _scale(ticks, log):
    """Return the function from places (pixels) to values that goes through all ticks."""
    places, values = np.array(ticks).T
    values = np.log10(values) if log else values
    slope, offset = np.polyfit(places, values, 1)
    assert np.abs(offset + slope * places - values).max() < 0.01 * np.ptp(values), ticks
    return lambda place: 10 ** (offset + slope * place) if log else offset + slope * place
