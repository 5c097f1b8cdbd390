"""Doubts about the table of a text: a row above it, thousands separators, row numbers among the heights."""

import re
from itertools import islice
from pathlib import Path

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import NO_TOPOGRAPHY
from roughcontact.io.text.header import LENGTHS, Stated, statements
from roughcontact.io.text.missing import is_missing
from roughcontact.io.text.table import COMMENT_SIGNS, Dialect, Rows, word_in_row
from roughcontact.io.vocabulary import words
from roughcontact.quantities import counted_noun

_MAX_LINES = 1000  # lines above a table that are searched for other statements
_LONGEST_LINE = 200  # characters of such a line
_MIN_CELLS = 10  # cells with three digits behind the mark, of which fewer say nothing
# statements of a header that may change the heights, beyond those that are understood
_FACTOR, _MARKER, _TURNED, _PIXELS = (
    re.compile("|".join(words("aside")[matter]), re.IGNORECASE)
    for matter in ("factor", "marker", "turned", "pixels")
)
_NO_HEIGHTS = re.compile(
    rf"(?:data|signal|type|image|quantity)\W*[:=]\W*(?:{NO_TOPOGRAPHY.pattern})", re.IGNORECASE
)
_NEGATIVE = re.compile(r"\b(?:no|none|false|off|nein|non|0)\W*$", re.IGNORECASE)
_LAST_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?=\D*$)")
_LAST_LINES = 50  # lines whose last numbers are compared with that at the end of a file
_LEAST_OTHERS = 3
_MAX_CELLS = 200_000  # cells that are compared column by column


def refuse_lost_row(rows: Rows, width: int, dialect: Dialect) -> None:
    """Refuse a table of `width` columns below a line that is one of its rows except for a word."""
    number, line = rows.filled[-1] if rows.filled else (0, "")
    stray_word = word_in_row(line, width, dialect) if line else None
    if stray_word is None or re.search(r"[^\W\d]\s*[:=]", line) or statements([line]):
        return
    if width <= 3 and (line.strip()[0].isalpha() or line.strip()[0] in COMMENT_SIGNS):
        return
    raise InputFileError(
        f"line {number} has as many cells as the rows of the table below it, and "
        f"{stray_word[:40]!r} in place of a number: correct it, write NaN for a missing point, or delete the "
        "line if it is no row of the map"
    )


def cut_number(body: list[str], delimiter: str | None, path: Path, last_line: int) -> list[str]:
    """Return a note where a file ends in a number shorter than all others, without the end of a line.

    It is refused where all others have as many decimals and digits of the exponent.
    """
    with path.open("rb") as stream:
        stream.seek(max(0, path.stat().st_size - 2))
        if set(stream.read()) & set(b"\n\r"):
            return []
    *cells, last = (line.strip().split(delimiter)[-1].strip() for line in body[-_LAST_LINES:])
    others = [cell for cell in cells if cell and not is_missing(cell)]
    if len(others) < _LEAST_OTHERS or (is_missing(last) and last != "-"):
        return []
    forms = [tuple(map(len, re.split("[.,]|[eEdD][-+]?", cell)[1:])) for cell in (*others, last)]
    wrong = f"line {last_line} ends the file in {last!r}, without the end of a line"
    if len({*forms[:-1]}) == 1 and forms[0] and forms[-1] != forms[0]:
        raise InputFileError(f"{wrong} and all digits of the others: it was cut off; complete it")
    *digits, last_digits = (len(re.sub(r"\D", "", cell)) for cell in (*others, last))
    return [f"{wrong}: if the file was cut off, complete that number"] if last_digits < min(digits) else []


def not_understood(rows: Rows, stated: Stated, heights: np.ndarray) -> list[str]:
    """Return notes on lines above a table that may concern heights; refuse a factor above whole numbers."""
    notes = []
    understood = {statement.line for repeated in stated.values() for statement in repeated}
    measured = heights[np.isfinite(heights)]
    for number, line in enumerate(rows.heading[:_MAX_LINES], rows.first):
        if number in understood or len(line) > _LONGEST_LINE or not re.search(r"[:=\t;,]|\s[-+\d]", line):
            continue
        where = f"line {number} says {line.strip()[:60]!r}"
        value = _LAST_NUMBER.search(line.replace(",", "."))
        factor = value and "z_factor" not in stated and _FACTOR.search(line) and float(value[0]) not in (0, 1)
        if factor and measured.size and np.all(measured == np.rint(measured)):
            raise InputFileError(
                f"{where}, and all heights are whole numbers, as counts are: state it as 'Z factor', "
                "with the unit of the products, or delete that line if they are lengths"
            )
        if value and _MARKER.search(line) and (count := int(np.sum(measured == float(value[0])))):
            points = f"{counted_noun(count, 'point')} with that height"
            notes.append(
                f"{where}, and there {'is' if count == 1 else 'are'} {points}: if missing, give missing_value"
            )
        elif (_TURNED.search(line) or _NO_HEIGHTS.search(line)) and not _NEGATIVE.search(line):
            notes.append(
                f"{where}, which is not followed: check first_row, the sign, and whether these are heights"
            )
        elif _PIXELS.search(line) and any(float(n) != 1 for n in re.findall(r"\d+\.?\d*", line)):
            notes.append(f"{where}, which is not followed: check the steps dx and dy")
    return notes


def thousands(stated: Stated, body: list[str], dialect: Dialect) -> list[str]:
    """Return a warning where all numbers have three digits behind a mark that may separate thousands.

    A number below one, with four digits in a row or other decimals, also in a length of the header, shows a
    decimal sign.

    Examples
    --------
    >>> thousands({}, ["1.250 2.500"] * 5, Dialect(None, False))[0][:60]
    "every number has three digits behind its '.', as in '1.250':"
    >>> thousands({}, ["0.250 2.500"] * 5, Dialect(None, False))
    []
    """
    if dialect.decimal_comma:
        _refuse_both_marks(body)
    sign = "," if dialect.decimal_comma else "."
    number = re.compile(rf"[-+]?[1-9]\d{{0,2}}({re.escape(sign)}\d{{3}})?")
    whole: dict[int, str] = {}  # an example in each column
    grouped: dict[int, str] = {}
    cells = (cell for line in body for cell in enumerate(line.strip().split(dialect.delimiter)))
    count = 0
    for column, cell in islice(cells, _MAX_CELLS):
        text = cell.strip()
        if match := number.fullmatch(text):
            (grouped if match[1] else whole).setdefault(column, text)
            count += bool(match[1])
        elif text != "0" and not is_missing(text):
            return []
    lengths = [statement.text for meaning in LENGTHS for statement in stated.get(meaning, [])]
    if count < _MIN_CELLS or any(re.search(rf"\d{re.escape(sign)}\d{{1,2}}(?!\d)", text) for text in lengths):
        return []
    example = next(iter(grouped.values()))
    way_out = "write the numbers without separators of thousands"
    if mixed := grouped.keys() & whole.keys():
        raise InputFileError(
            f"{example!r} and {whole[min(mixed)]!r} in one table, with three digits behind "
            f"every {sign!r}: it separates thousands or decimals; {way_out}, or with four decimals"
        )
    doubt = f"every number has three digits behind its {sign!r}, as in {example!r}: it is read as the decimal"
    return [f"{doubt} sign; if it separates thousands, {way_out}"]


def _refuse_both_marks(body: list[str]) -> None:
    """Refuse points as separators of thousands, or decimals, in a table with decimal commas."""
    number = re.compile(r"(?<![\d.,])\d+([.,])(\d+)(?![\d.,eE])")
    if not any("." in line and number.search(line) for line in body):
        return
    matches: dict[str, list[re.Match[str]]] = {mark: [] for mark in ".,"}
    for match in (match for line in body for match in number.finditer(line)):
        matches[match[1]].append(match)
    if all(matches.values()) and any({len(match[2]) for match in matches[mark]} == {3} for mark in ".,"):
        raise InputFileError(
            f"{matches[','][0][0]!r} and {matches['.'][0][0]!r} in one table: either mark may be the "
            "decimal sign or separate thousands; write the numbers without separators of thousands"
        )
