"""One line of the validation: two numbers, how far they are apart, and how far they may be."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import SupportsFloat

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Evidence:
    """Where a reader who doubts a line finds its formula, its source and the test of the reference itself.

    Attributes
    ----------
    formula : str
    source : str
        literature, or the code that gave the number.
    code : str
        the function that gives the reference, as module.function of this package; or several.
    test : str
        file::function, from the root of the project.
    """

    formula: str
    source: str
    code: str
    test: str


@dataclass(frozen=True)
class Line:
    """One comparison. It holds where deviation <= tolerance; a deviation that is no number never does.

    Attributes
    ----------
    what : str
        what is compared, in words.
    reference, value : float
        what is known from elsewhere, and what this program computes; of a field the two at the point that is
        farthest off, or both rms.
    deviation : float
    measure : str
        what the deviation is: ``relative`` |value - reference|/|reference|, ``absolute`` |value -
        reference|, ``largest`` and ``rms`` over all points of a field, relative to the largest and to the rms
        of the reference.
    tolerance : float
    reason : str
        where the tolerance comes from.
    evidence : Evidence
    """

    what: str
    reference: float
    value: float
    deviation: float
    measure: str
    tolerance: float
    reason: str
    evidence: Evidence

    @property
    def holds(self) -> bool:
        """Whether the deviation is within the tolerance."""
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


def compare(
    what: str,
    value: SupportsFloat,
    reference: SupportsFloat,
    *,
    tolerance: SupportsFloat,
    reason: str,
    evidence: Evidence,
    measure: str = "relative",
) -> Line:
    """Return the line of a single number.

    Parameters
    ----------
    what : str
        what is compared, in words.
    value : float
        what this program computes.
    reference : float
        what is known from elsewhere.
    tolerance : float
        largest deviation that holds.
    reason : str
        where the tolerance comes from.
    evidence : Evidence
        formula, source, function and test.
    measure : str
        of the deviation, ``relative`` or ``absolute``.

    Returns
    -------
    Line

    Examples
    --------
    >>> one = Evidence("1 + 1 = 2", "Peano (1889)", "references.closed_forms.hertz", "tests/a.py::test")
    >>> line = compare("a sum", 1.98, 2.0, tolerance=0.02, reason="two digits", evidence=one)
    >>> round(line.deviation, 6), line.holds
    (0.01, True)
    """
    found, known = float(value), float(reference)
    deviation = abs(found - known) / (abs(known) if measure == "relative" else 1.0)
    return Line(what, known, found, deviation, measure, float(tolerance), reason, evidence)


def compare_largest(
    what: str,
    values: ArrayLike,
    reference: ArrayLike,
    *,
    tolerance: SupportsFloat,
    reason: str,
    evidence: Evidence,
) -> Line:
    """Return the line of a field: the largest difference at any point, relative to the largest value.

    Parameters
    ----------
    what : str
        what is compared, in words.
    values : array
        what this program computes.
    reference : array, of the same shape
        what is known from elsewhere.
    tolerance : float
        largest deviation that holds.
    reason : str
        where the tolerance comes from.
    evidence : Evidence
        formula, source, function and test.

    Returns
    -------
    Line

    Examples
    --------
    >>> one = Evidence("1 + 1 = 2", "Peano (1889)", "references.closed_forms.hertz", "tests/a.py::test")
    >>> line = compare_largest("two", [4.0, 5.1], [4, 5], tolerance=0.03, reason="two digits", evidence=one)
    >>> line.reference, line.value, round(line.deviation, 6)
    (5.0, 5.1, 0.02)
    """
    found, known = (np.asarray(field, float).ravel() for field in (values, reference))
    difference = np.abs(found - known)
    worst = int(difference.argmax())  # a NaN counts as the largest
    deviation = float(difference[worst] / np.abs(known).max())
    at_worst = (float(known[worst]), float(found[worst]))
    return Line(what, *at_worst, deviation, "largest", float(tolerance), reason, evidence)


def compare_rms(
    what: str,
    values: ArrayLike,
    reference: ArrayLike,
    *,
    tolerance: SupportsFloat,
    reason: str,
    evidence: Evidence,
) -> Line:
    """Return the line of a field: the rms of the difference, relative to the rms of the reference.

    Parameters
    ----------
    what : str
        what is compared, in words.
    values : array
        what this program computes.
    reference : array, of the same shape
        what is known from elsewhere.
    tolerance : float
        largest deviation that holds.
    reason : str
        where the tolerance comes from.
    evidence : Evidence
        formula, source, function and test.

    Returns
    -------
    Line

    Examples
    --------
    >>> one = Evidence("1 + 1 = 2", "Peano (1889)", "references.closed_forms.hertz", "tests/a.py::test")
    >>> line = compare_rms("two", [4.0, 3.1], [4, 3], tolerance=0.03, reason="two digits", evidence=one)
    >>> round(line.deviation, 6)
    0.02
    """
    found, known = (np.asarray(field, float) for field in (values, reference))
    rms = [float(np.sqrt(np.mean(field**2))) for field in (known, found, found - known)]
    return Line(what, rms[0], rms[1], rms[2] / rms[0], "rms", float(tolerance), reason, evidence)


def to_json(part: Part) -> str:
    """Return a part as JSON, the same text for the same part.

    Parameters
    ----------
    part : Part

    Returns
    -------
    str

    Examples
    --------
    >>> part = Part("sums", "Sums", "Of small numbers.", [])
    >>> from_json(to_json(part)).title
    'Sums'
    """
    return json.dumps(asdict(part), indent=1, ensure_ascii=False) + "\n"


def from_json(text: str) -> Part:
    """Return the part that `to_json` has written.

    Parameters
    ----------
    text : str

    Returns
    -------
    Part
    """
    data = json.loads(text)
    lines = [Line(**line | {"evidence": Evidence(**line["evidence"])}) for line in data["lines"]]
    figures = [Figure(**figure) for figure in data["figures"]]
    tables = [Table(**table) for table in data["tables"]]
    return Part(**data | {"lines": lines, "figures": figures, "tables": tables})
