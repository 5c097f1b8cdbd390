"""Charts of the report, read back as a reader does: by the numbers that are written at their axes."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np

from roughcontact.report.charts import Chart

_SVG = "{http://www.w3.org/2000/svg}"
_NUMBER = r"(-?[\d.]+(?:e-?\d+)?)"
_DIGITS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")


@dataclass(frozen=True)
class Points:
    """A line of a chart, or marks of one kind, in the values of the axes; `y` of error bars is the lower end.

    `style` holds the dashes of a line, or the fill of marks ("none" where they are hollow).
    """

    colour: str
    style: str
    x: np.ndarray
    y: np.ndarray
    upper: np.ndarray | None = None


@dataclass(frozen=True)
class Drawn:
    """What a chart shows, everything in the order in which it is drawn.

    `x_ends` and `y_ends` are the values at the left and the right edge, and at the lower and the upper one;
    `top` gives for a value of x what the axis above says, `legend` the colour and style of each label.
    """

    texts: list[str]
    x_ends: np.ndarray
    y_ends: np.ndarray
    lines: list[Points]
    marks: list[Points]
    bars: list[Points]
    bands: list[tuple[float, float]]
    legend: dict[str, tuple[str, str]]
    top: Callable | None

    def labelled(self, label: str) -> Points:
        """Return the line or the marks that the legend calls so."""
        colour, style = self.legend[label]
        (match,) = [
            candidate
            for candidate in (self.marks if any(m.colour == colour for m in self.marks) else self.lines)
            if candidate.colour == colour and candidate.style == style
        ]
        return match


def read_chart(chart: Chart | str, *, log: str = "") -> Drawn:
    """Return what a chart, or its data URI, shows; `log` names its logarithmic axes, as in "xy"."""
    kind, _, text = (chart if isinstance(chart, str) else chart.source()).partition(",")
    assert kind == "data:image/svg+xml"
    root = ElementTree.fromstring(unquote(text))
    area = root.find(f"{_SVG}svg")
    left_edge, upper_edge, width, height = (float(area.get(name)) for name in ("x", "y", "width", "height"))
    ticks = {"below": [], "above": [], "beside": []}
    letters = float(root.get("font-size"))
    edges = {round(upper_edge + height + 6 + letters, 1): "below", round(upper_edge - 9, 1): "above"}
    for element in root.iter(f"{_SVG}text"):
        match = (
            float(element.get("x", "nan")) - left_edge,
            float(element.get("y", "nan")) - letters / 3 - upper_edge,
        )
        if element.get("text-anchor") == "end":
            ticks["beside"].append((match[1], _value(element.text)))
        elif element.get("text-anchor") == "middle" and float(element.get("y", "nan")) in edges:
            ticks[edges[float(element.get("y"))]].append((match[0], _value(element.text)))
    to_x, to_y = _scale(ticks["below"], log="x" in log), _scale(ticks["beside"], log="y" in log)
    to_top, from_x = (_scale(ticks["above"], log="x" in log), _inverse(ticks["below"], log="x" in log))
    lines, marks, bars, bands = [], {}, [], []
    for path in area.iter(f"{_SVG}path"):
        words, colour = path.get("d"), path.get("stroke")
        if match := re.match(rf"translate\({_NUMBER} {_NUMBER}\)", path.get("transform", "")):
            marks.setdefault((colour, path.get("fill")), []).append([float(v) for v in match.groups()])
        elif band := re.fullmatch(rf"M{_NUMBER} 0H{_NUMBER}V.*z", words):
            bands.append(tuple(float(to_x(float(position))) for position in band.groups()))
        elif "V" in words:
            bar_ends = np.array(re.findall(rf"M{_NUMBER} {_NUMBER}V{_NUMBER}", words), float).reshape(-1, 3)
            bars.append(Points(colour, "", to_x(bar_ends[:, 0]), to_y(bar_ends[:, 1]), to_y(bar_ends[:, 2])))
        else:
            points = np.array(re.findall(f"{_NUMBER} {_NUMBER}", words), float).reshape(-1, 2)
            style = path.get("stroke-dasharray", "")
            lines.append(Points(colour, style, to_x(points[:, 0]), to_y(points[:, 1])))
    kinds = [(kind, np.array(points_by_style)) for kind, points_by_style in marks.items()]
    return Drawn(
        [element.text for element in root.iter(f"{_SVG}text")],
        to_x(np.array([0.0, width])),
        to_y(np.array([height, 0.0])),
        lines,
        [
            Points(*kind, to_x(points_by_style[:, 0]), to_y(points_by_style[:, 1]))
            for kind, points_by_style in kinds
        ],
        bars,
        bands,
        _legend(root),
        None if to_top is None else lambda x: to_top(from_x(x)),
    )


def _legend(root: ElementTree.Element) -> dict[str, tuple[str, str]]:
    """Return colour and style of the sample that is drawn right before each text of the legend."""
    labels, sample = {}, None
    for element in root.find(f"{_SVG}g[@id='legend']"):
        if element.tag == f"{_SVG}path" and element.get("stroke"):
            filled = element.get("transform") is not None
            sample = (
                element.get("stroke"),
                element.get("fill") if filled else element.get("stroke-dasharray", ""),
            )
        elif element.tag == f"{_SVG}text":
            labels[element.text] = sample
    return labels


def _value(words: str) -> float:
    """Return the number that is written at a tick, as 0.5, 10⁻⁵ or 2×10⁻⁷."""
    digits, _, power = words.rpartition("×")
    if re.fullmatch(r"10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+", power):
        return float(digits or 1) * 10.0 ** int(power.removeprefix("10").translate(_DIGITS))
    return float(words.translate(_DIGITS))


def _fit(ticks: list, *, log: bool) -> tuple[float, float]:
    """Return slope and offset of the values, or of their logarithms, over the places of all ticks."""
    positions, values = np.array(ticks).T
    values = np.log10(values) if log else values
    slope, offset = np.polyfit(positions, values, 1)
    assert np.abs(offset + slope * positions - values).max() < 0.01 * np.ptp(values), ticks
    return slope, offset


def _scale(ticks: list, *, log: bool) -> Callable | None:
    """Return the function from places (pixels) to values that goes through all ticks."""
    if not ticks:
        return None
    slope, offset = _fit(ticks, log=log)
    return lambda position: 10 ** (offset + slope * position) if log else offset + slope * position


def _inverse(ticks: list, *, log: bool) -> Callable:
    """Return the function from values to places that goes through all ticks."""
    slope, offset = _fit(ticks, log=log)
    return lambda value: ((np.log10(value) if log else value) - offset) / slope
