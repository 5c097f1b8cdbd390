"""Doubts about the numbers of a table: marks that may be decimal signs or separate thousands."""

import re
from itertools import islice

from roughcontact.errors import InputFileError
from roughcontact.io.text.header import LENGTHS, Stated
from roughcontact.io.text.table import WITHOUT_THOUSANDS, Dialect, is_missing

_MIN_CELLS = 10  # cells with three digits behind the mark, of which fewer say nothing
_MAX_CELLS = 200_000  # cells that are compared column by column


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
    examples: dict[bool, dict[int, str]] = {True: {}, False: {}}  # grouped or not, in each column
    cells = (cell for line in body for cell in enumerate(line.strip().split(dialect.delimiter)))
    count = 0
    # one number below one, or with other digits, settles the sign: no more is read
    for column, cell in islice(cells, _MAX_CELLS):
        text = cell.strip()
        if match := number.fullmatch(text):
            examples[bool(match[1])].setdefault(column, text)
            count += bool(match[1])
        elif text != "0" and not is_missing(text):
            return []
    lengths = [statement.text for meaning in LENGTHS for statement in by_meaning.get(meaning, [])]
    if count < _MIN_CELLS or any(re.search(rf"\d{re.escape(sign)}\d{{1,2}}(?!\d)", text) for text in lengths):
        return []
    example = next(iter(examples[True].values()))
    if conflict := examples[True].keys() & examples[False].keys():
        both = f"{example!r} and {examples[False][min(conflict)]!r} in one table"
        wrong = f"with three digits behind every {sign!r}: it separates thousands or decimals"
        raise InputFileError(f"{both}, {wrong}; {WITHOUT_THOUSANDS}, or with four decimals")
    doubt = f"every number has three digits behind its {sign!r}, as in {example!r}: it is read as the decimal"
    return [f"{doubt} sign; if it separates thousands, {WITHOUT_THOUSANDS}"]


def _refuse_both_marks(body: list[str]) -> None:
    """Refuse points as separators of thousands, or decimals, in a table with decimal commas."""
    number = re.compile(r"(?<![\d.,])\d+([.,])(\d+)(?![\d.,eE])")
    if not any("." in line and number.search(line) for line in body):
        return
    matches = [match for line in body for match in number.finditer(line)]
    first = {match[1]: match[0] for match in reversed(matches)}
    lengths = {mark: {len(match[2]) for match in matches if match[1] == mark} for mark in ".,"}
    if len(first) == 2 and {3} in lengths.values():
        both = f"{first[',']!r} and {first['.']!r} in one table"
        wrong = "either mark may be the decimal sign or separate thousands"
        raise InputFileError(f"{both}: {wrong}; {WITHOUT_THOUSANDS}")
