"""The page of the validation, its table, and the sentence that lists what does not hold."""

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import asdict
from itertools import groupby
from pathlib import Path
from typing import Any

from roughcontact.arguments.quantities import number
from roughcontact.errors import RoughContactError
from roughcontact.report.template import template
from roughcontact.results.storage import provenance, write_text
from validation.lines import Line, Section

MEASURES = {
    "relative": "relative",
    "absolute": "absolute",
    "largest": "largest, of the largest value",
    "rms": "rms, of the rms value",
}
_TEMPLATES = Path(__file__).with_name("templates")


class DeviationError(RoughContactError, RuntimeError):
    """A line of the validation whose deviation is beyond its tolerance."""


def write_page(path: str | Path, sections: Sequence[Section]) -> None:
    """Write the page for people, one self-contained HTML file; what does not hold is marked and listed."""
    lines = [line for section in sections for line in section.lines]
    html = template("validation.html", folder=_TEMPLATES).render(
        sections=[_for_template(section) for section in sections],
        count=len(lines),
        failures=[
            {"id": section.name, "text": _sentence(line)}
            for section in sections
            for line in section.lines
            if not line.holds
        ],
        versions=_versions(),
    )
    write_text(html, path)


def write_table(path: str | Path, sections: Sequence[Section]) -> None:
    """Write all lines as CSV, one row each, every digit kept."""
    rows = [_record(section, line) for section in sections for line in section.lines]
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(buffer.getvalue(), path)


def check(sections: Sequence[Section], page: str | Path) -> int:
    """Return how many lines there are, all of which hold.

    Raises
    ------
    DeviationError
        where a line does not hold: each with its numbers, and `page`, where a reader sees them.

    Examples
    --------
    >>> check([Section("sums", "Sums", "Of small numbers.", [])], "validation.html")
    0
    """
    lines = [line for section in sections for line in section.lines]
    failures = [_sentence(line) for line in lines if not line.holds]
    if failures:
        listed = "\n".join(f"  {sentence}" for sentence in failures)
        raise DeviationError(
            f"{len(failures)} of {len(lines)} lines of the validation do not hold:\n{listed}\n"
            f"{page} has them marked, with formula, source and test."
        )
    return len(lines)


def _record(section: Section, line: Line) -> dict[str, str]:
    """Return a line as a row of the table."""
    numbers = {name: repr(float(getattr(line, name))) for name in ("reference", "value", "deviation")}
    return (
        {"section": section.name, "what": line.what, **numbers, "measure": line.measure}
        | {"tolerance": repr(line.tolerance), "reason": line.reason, "holds": "yes" if line.holds else "no"}
        | asdict(line.evidence)
    )


def _sentence(line: Line) -> str:
    """Return what a line says, in words."""
    return (
        f"{line.what}: {_value(line.value)} instead of {_value(line.reference)}, deviation "
        f"{number(line.deviation, digits=2)} ({MEASURES[line.measure]}), tolerance "
        f"{number(line.tolerance, digits=2)}"
    )


def _for_template(section: Section) -> dict[str, Any]:
    """Return a section as the template wants it: lines with the same evidence together, numbers as text."""
    evidences = list(dict.fromkeys(line.evidence for line in section.lines))
    ordered = sorted(section.lines, key=lambda line: evidences.index(line.evidence))
    groups = [
        {"evidence": evidence, "lines": [cells(line) for line in lines]}
        for evidence, lines in groupby(ordered, key=lambda line: line.evidence)
    ]
    return {
        "name": section.name,
        "title": section.title,
        "text": section.text,
        "holding": sum(line.holds for line in section.lines),
        "count": len(section.lines),
        "groups": groups,
        "figures": section.figures,
        "tables": section.tables,
    }


def cells(line: Line) -> dict[str, str | bool]:
    """Return what the page shows of a line, numbers as text.

    Examples
    --------
    >>> from validation.lines import Evidence
    >>> one = Evidence("1 + 1 = 2", "Peano (1889)", "validation.closed_forms.hertz", "tests/a.py::test")
    >>> shown = cells(Line("a sum", 2.0, 1.98, 0.01, "relative", 0.02, "two digits", one))
    >>> shown["reference"], shown["value"], shown["deviation"]
    ('2', '1.98000', '0.010')
    """
    return {
        "what": line.what,
        "reference": _value(line.reference),
        "value": _value(line.value),
        "deviation": number(line.deviation, digits=2),
        "measure": MEASURES[line.measure],
        "tolerance": number(line.tolerance, digits=2),
        "reason": line.reason,
        "holds": line.holds,
    }


def _value(value: float) -> str:
    """Return a number with six digits, a whole one without decimals."""
    if value == round(value) and abs(value) < 1e6:
        return f"{value:.0f}".replace("-", "−")
    return number(value, digits=6)


def _versions() -> str:
    """Return the versions behind the numbers."""
    versions = json.loads(provenance({})["versions"])
    return ", ".join(f"{name} {version}" for name, version in versions.items())
