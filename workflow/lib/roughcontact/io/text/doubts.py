"""Doubts about the table of a text: a row above it, thousands separators, row numbers among the heights."""

import re
from itertools import islice
from pathlib import Path

from roughcontact.errors import InputFileError
from roughcontact.io.text.header import LENGTHS, Stated, statements
from roughcontact.io.text.missing import is_missing
from roughcontact.io.text.table import COMMENT_SIGNS, Dialect, Rows, word_in_row

_MIN_CELLS = 10  # cells with three digits behind the mark, of which fewer say nothing
_LAST_LINES = 50  # lines whose last numbers are compared with that at the end of a file
_MIN_PEERS = 3
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
    nonempty = filter(None, map(str.strip, body[-_LAST_LINES:]))
    *cells, last = (line.split(delimiter)[-1].strip() for line in nonempty)
    peers = [cell for cell in cells if cell and not is_missing(cell)]
    if len(peers) < _MIN_PEERS or (is_missing(last) and last != "-"):
        return []
    forms = [tuple(map(len, re.split("[.,]|[eEdD][-+]?", cell)[1:])) for cell in (*peers, last)]
    wrong = f"line {last_line} ends the file in {last!r}, without the end of a line"
    if len({*forms[:-1]}) == 1 and forms[0] and forms[-1] != forms[0]:
        raise InputFileError(f"{wrong} and all digits of the others: it was cut off; complete it")
    *digits, last_digits = (len(re.sub(r"\D", "", cell)) for cell in (*peers, last))
    return [f"{wrong}: if the file was cut off, complete that number"] if last_digits < min(digits) else []


def thousands(by_meaning: Stated, body: list[str], dialect: Dialect) -> list[str]:
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
    ungrouped_examples: dict[int, str] = {}  # an example in each column
    grouped_examples: dict[int, str] = {}
    cells = (cell for line in body for cell in enumerate(line.strip().split(dialect.delimiter)))
    count = 0
    for column, cell in islice(cells, _MAX_CELLS):
        text = cell.strip()
        if match := number.fullmatch(text):
            (grouped_examples if match[1] else ungrouped_examples).setdefault(column, text)
            count += bool(match[1])
        elif text != "0" and not is_missing(text):
            return []
    lengths = [statement.text for meaning in LENGTHS for statement in by_meaning.get(meaning, [])]
    if count < _MIN_CELLS or any(re.search(rf"\d{re.escape(sign)}\d{{1,2}}(?!\d)", text) for text in lengths):
        return []
    example = next(iter(grouped_examples.values()))
    way_out = "write the numbers without separators of thousands"
    if conflict := grouped_examples.keys() & ungrouped_examples.keys():
        raise InputFileError(
            f"{example!r} and {ungrouped_examples[min(conflict)]!r} in one table, with three digits behind "
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
