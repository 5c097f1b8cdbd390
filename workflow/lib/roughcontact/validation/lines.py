"""One line of the validation: two numbers, how far they are apart, and how far they may be."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field

import numpy as np


@dataclass(frozen=True)
class Evidence:
    """Where a reader who doubts a line finds its formula, its source and the test of the reference itself."""

    formula: str
    source: str
    code: str  # the function of this package that gives the reference
    test: str  # file::function, from the root of the project


@dataclass(frozen=True)
class Line:
    """One comparison. It holds where deviation <= tolerance; a deviation that is no number never does.

    `measure` says what the deviation is: ``relative`` |value - reference|/|reference|, ``absolute``
    |value - reference|, ``largest`` and ``rms`` over all points of a field, relative to the largest and to
    the rms of the reference; a field shows the values at the point that is farthest off, or both rms.
    """

    what: str
    reference: float
    value: float
    deviation: float
    measure: str
    tolerance: float
    reason: str  # where the tolerance comes from
    evidence: Evidence

    @property
    def holds(self) -> bool:
        return bool(self.deviation <= self.tolerance)


@dataclass(frozen=True)
class Figure:
    """A picture (data URI) and what it shows."""

    title: str
    image: str
    caption: str


@dataclass(frozen=True)
class Table:
    """Numbers that stand beside the lines for comparison; nothing in them can fail."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str


@dataclass(frozen=True)
class Part:
    """A section of the page: lines that belong together, with figures."""

    name: str
    title: str
    text: str
    lines: Sequence[Line]
    figures: Sequence[Figure] = field(default=())
    tables: Sequence[Table] = field(default=())


def compare(what, value, reference, *, tolerance, reason, evidence, measure="relative") -> Line:
    """Return the line of a single number, its deviation ``relative`` or ``absolute``."""
    value, reference = float(value), float(reference)
    deviation = abs(value - reference) / (abs(reference) if measure == "relative" else 1.0)
    return Line(what, reference, value, deviation, measure, float(tolerance), reason, evidence)


def compare_largest(what, values, reference, *, tolerance, reason, evidence) -> Line:
    """Return the line of a field: the largest difference at any point, relative to the largest value."""
    values, reference = (np.asarray(field, float).ravel() for field in (values, reference))
    difference = np.abs(values - reference)
    worst = int(difference.argmax())  # a NaN counts as the largest
    deviation = float(difference[worst] / np.abs(reference).max())
    at_worst = (float(reference[worst]), float(values[worst]))
    return Line(what, *at_worst, deviation, "largest", float(tolerance), reason, evidence)


def compare_rms(what, values, reference, *, tolerance, reason, evidence) -> Line:
    """Return the line of a field: the rms of the difference, relative to the rms of the reference."""
    values, reference = (np.asarray(field, float) for field in (values, reference))
    rms = [float(np.sqrt(np.mean(field**2))) for field in (reference, values, values - reference)]
    return Line(what, rms[0], rms[1], rms[2] / rms[0], "rms", float(tolerance), reason, evidence)


def to_json(part: Part) -> str:
    """Return a part as text, the same text for the same part."""
    return json.dumps(asdict(part), indent=1, ensure_ascii=False) + "\n"


def from_json(text: str) -> Part:
    """Return the part that `to_json` has written."""
    data = json.loads(text)
    lines = [Line(**line | {"evidence": Evidence(**line["evidence"])}) for line in data["lines"]]
    figures = [Figure(**figure) for figure in data["figures"]]
    tables = [Table(**table) for table in data["tables"]]
    return Part(**data | {"lines": lines, "figures": figures, "tables": tables})
