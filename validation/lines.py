"""Lines of the validation: two numbers, their deviation, and how large it may be.

The words stand in tables: `sections.tsv` has title and text of each section, `evidence.tsv` formula, source,
function and test, `lines.tsv` the name and the text of each line, how it measures its deviation, and the
reason of its tolerance.
"""

import csv
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import SupportsFloat

import numpy as np
from numpy.typing import ArrayLike

_TABLES = Path(__file__).with_name("tables")


@dataclass(frozen=True)
class Evidence:
    """Where a reader who doubts a line finds its formula, its source and the test of the reference itself.

    Attributes
    ----------
    formula : str
    source : str
        literature, or the code that gave the number.
    code : str
        the functions that give the reference, as module.function of roughcontact, or of `validation`.
    test : str
        file::function, from the root of the project.
    """

    formula: str
    source: str
    code: str
    test: str


@dataclass(frozen=True)
class LineText:
    """The words of a line; `what` and `reason` may have names in braces, for numbers of the single case.

    Attributes
    ----------
    what : str
        what is compared.
    measure : str
        what the deviation is: ``relative`` |value - reference|/|reference|, ``absolute`` |value -
        reference|, ``largest`` and ``rms`` over all points of a field, relative to the largest and to the rms
        of the reference.
    reason : str
        where the tolerance comes from.
    evidence : Evidence
    """

    what: str
    measure: str
    reason: str
    evidence: Evidence


@dataclass(frozen=True)
class Line:
    """One comparison. It holds where deviation <= tolerance; a deviation that is no number never does.

    Attributes
    ----------
    what, measure, reason, evidence
        as those of `LineText`, with the numbers of this case.
    reference, value : float
        what is known from elsewhere, and what this program computes; of a field the two at the point that is
        farthest off, or both rms.
    deviation, tolerance : float
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
class Section:
    """A section of the page: lines that belong together, with figures; its module adds them one by one."""

    name: str
    title: str
    text: str
    lines: list[Line] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)

    def compare(
        self, name: str, value: ArrayLike, reference: ArrayLike, tolerance: SupportsFloat, **fields: object
    ) -> Line:
        """Add the line of this name in the table, and return it; the rest is that of `compare`."""
        line = compare(_line_texts(self.name)[name], value, reference, tolerance, **fields)
        self.lines.append(line)
        return line


def compare(
    line_text: LineText, value: ArrayLike, reference: ArrayLike, tolerance: SupportsFloat, **fields: object
) -> Line:
    """Return the line that compares two numbers or two fields.

    Parameters
    ----------
    line_text : LineText
    value : float or array
        what this program computes.
    reference : float or array of the same shape
        what is known from elsewhere.
    tolerance : float
        largest deviation that holds.
    **fields
        what stands in place of the names in braces.

    Returns
    -------
    Line

    Examples
    --------
    >>> sums = Evidence("1 + 1 = 2", "Peano (1889)", "validation.closed_forms.hertz", "tests/a.py::test")
    >>> line = compare(LineText("{n} digits", "relative", "rounding", sums), 1.98, 2.0, 0.02, n=2)
    >>> line.what, round(line.deviation, 6), line.holds
    ('2 digits', 0.01, True)
    >>> line = compare(LineText("two", "largest", "rounding", sums), [4.0, 5.1], [4, 5], 0.03)
    >>> line.reference, line.value, round(line.deviation, 6)
    (5.0, 5.1, 0.02)
    """
    computed, expected = (np.asarray(numbers, float).ravel() for numbers in (value, reference))
    difference = np.abs(computed - expected)
    if line_text.measure == "rms":
        expected, computed, difference = (
            np.sqrt(np.mean(numbers**2, keepdims=True)) for numbers in (expected, computed, difference)
        )
    worst = int(difference.argmax())  # a NaN counts as the largest
    scale = 1.0 if line_text.measure == "absolute" else np.abs(expected).max()
    return Line(
        what=line_text.what.format(**fields),
        reference=float(expected[worst]),
        value=float(computed[worst]),
        deviation=float(difference[worst] / scale),
        measure=line_text.measure,
        tolerance=float(tolerance),
        reason=line_text.reason.format(**fields),
        evidence=line_text.evidence,
    )


def empty_section(name: str) -> Section:
    """Return a section with its title and text, to which its module adds the lines."""
    (fields,) = (row for row in _rows("sections") if row["section"] == name)
    return Section(name, fields["title"], fields["text"])


@cache
def _line_texts(section: str) -> dict[str, LineText]:
    """Return the words of the lines of a section by name."""
    evidence = {
        row["evidence"]: Evidence(row["formula"], row["source"], row["code"], row["test"])
        for row in _rows("evidence")
        if row["section"] == section
    }
    return {
        row["name"]: LineText(row["what"], row["measure"], row["reason"], evidence[row["evidence"]])
        for row in _rows("lines")
        if row["section"] == section
    }


@cache
def _rows(table: str) -> list[dict[str, str]]:
    """Return the rows of a table of words; its cells are separated by tabs, and nothing is quoted."""
    with (_TABLES / f"{table}.tsv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
