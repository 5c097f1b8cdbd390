"""Instrument, lens, date and serial number of a file, with the same keys (`LABELS`) for all formats.

A key exists only where the file states its value, `acquisition_time` in ISO 8601 where known. Names of
persons are left out.
"""

import datetime
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from roughcontact.arguments.quantities import number
from roughcontact.io.vocabulary import meanings, words

# key -> label, in the order of display
LABELS = {key: labels[0] for key, labels in words("label").items()}

# spellings in headers of each key, of which, where a header has several, the first counts
_SPELLINGS, _MEANING = words("instrument"), meanings("instrument")
_SILENT = {"", "0", "-", "none", "(none)", "null", "unknown", "not available", "n/a", "na", "default"}
_LONGEST = 200  # characters of a name


def instrument_metadata(facts: Mapping[str, Any], header: Mapping | None = None) -> dict[str, Any]:
    """Return the known metadata of the instrument, as plain JSON values in the order of `LABELS`.

    `facts` wins over the file's `header`, searched two levels deep for the usual spellings, but for sections
    on software, whose serial number is that of a licence.

    Examples
    --------
    >>> instrument_metadata({"vendor": "Zygo"}, {"Objective": "20X Mirau", "Serial Number": 594, "date": "-"})
    {'vendor': 'Zygo', 'serial': 594, 'lens': '20X Mirau'}
    """
    ranked = sorted(_entries(header), key=lambda each: each[0])
    best = {entry: value for _, entry, value in ranked[::-1]}
    best |= {entry: plain for entry, value in facts.items() if (plain := _plain(value)) is not None}
    aperture = best.get("numerical_aperture")
    if aperture is not None and not (isinstance(aperture, float | int) and 0 < aperture < 2):
        del best["numerical_aperture"]
    # the zero of a computer's clock is no date
    for entry in ("acquisition_time", "calibration_time"):
        if str(best.get(entry, "")).startswith(("1970-01-01", "1969-12-31", "1601-01-01", "0001-01-01")):
            del best[entry]
    return {entry: best.pop(entry) for entry in LABELS if entry in best} | best


def _entries(header: Any, depth: int = 0) -> Iterator[tuple[int, str, str | float]]:
    """Yield the known entries of a header: the rank of the spelling, the key, and the value."""
    for key, value in header.items() if hasattr(header, "items") else ():
        name = re.sub(r"[^a-z0-9]", "", str(key).lower())
        if hasattr(value, "items"):
            # deeper lie settings of parts of the instrument, under the same names
            if depth < 2 and name != "software":
                yield from _entries(value, depth + 1)
        elif name in _MEANING and (plain := _plain(value)) is not None:
            yield _SPELLINGS[_MEANING[name]].index(name), _MEANING[name], plain


def _plain(value: Any) -> str | float | None:
    """Return a value as text or number on one line, None for an empty or meaningless one."""
    if isinstance(value, bytes):
        value = value.decode("latin-1")
    if isinstance(value, datetime.datetime | datetime.date):
        value = value.isoformat()
    if isinstance(value, str):
        value = " ".join(value.replace("\0", " ").split())
        return None if value.lower() in _SILENT or len(value) > _LONGEST else value
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return value if is_number and value != 0 and math.isfinite(value) else None


def labelled(instrument: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the metadata from `instrument_metadata` for people, as labels and texts."""
    texts = {key: number(fact) if isinstance(fact, float) else str(fact) for key, fact in instrument.items()}
    return [(LABELS.get(key, key.replace("_", " ")), text) for key, text in texts.items()]
