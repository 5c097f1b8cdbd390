"""Doubts about the table of a text: a row above it, thousands separators, row numbers among the heights."""

import re
from collections import defaultdict
from itertools import chain, islice
from pathlib import Path

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.text.header import statements
from roughcontact.io.text.table import COMMENT_SIGNS, text_chunks, word_in_row

_LENGTHS = {"length_x", "length_y", "dx", "dy", "step"}  # entries of a header with a decimal sign
_MIN_CELLS = 10  # cells with three digits behind the mark, of which fewer say nothing
_MAX_CELLS = 200_000  # cells that are compared column by column
_MIN_COUNTED = 5  # rows or columns; fewer count 1, 2, 3, or have as many decimals, by chance
_MAX_ENDS = 50  # rows whose decimals are compared with those of the last one


def refuse_lost_row(
    header: list[str], width: int, delimiter: str | None, decimal_comma: bool, path: Path, first: int = 1
) -> None:
    """Refuse a table of `width` columns below a line that is one of its rows except for a word."""
    number = next((index for index in reversed(range(len(header))) if header[index].strip()), None)
    if number is None:
        return
    line = header[number]
    stray_word = word_in_row(line, width, delimiter, decimal_comma)
    if stray_word is None or re.search(r"[^\W\d]\s*[:=]", line) or statements([line]):
        return
    if width <= 3 and (line.strip()[0].isalpha() or line.strip()[0] in COMMENT_SIGNS):
        return
    raise InputFileError(
        f"{path}: line {first + number} has as many cells as the rows of the table below it, and "
        f"{stray_word[:40]!r} in place of a number: correct it, write NaN for a missing point, or delete "
        f"the line "
        "if it is no row of the map"
    )


def thousands(
    header: list[str],
    body: list[str],
    values: np.ndarray,
    delimiter: str | None,
    decimal_comma: bool,
    path: Path,
) -> list[str]:
    """Return a warning where all numbers have three digits behind a mark that may separate thousands.

    A number below one, one with four digits in a row or another number of decimals, also in a length of the
    header, shows that the mark is a decimal sign. `values` are the numbers of the whole table; their text is
    compared in the first cells.

    Examples
    --------
    >>> thousands([], ["1.250 2.500"] * 5, np.array([[1.25, 2.5]] * 5), None, False, Path("map.txt"))[0][:60]
    "every number has three digits behind its '.', as in '1.250':"
    >>> thousands([], ["0.250 2.500"] * 5, np.array([[0.25, 2.5]] * 5), None, False, Path("map.txt"))
    []
    """
    if decimal_comma:
        _refuse_both_marks(body, path)
    if not _in_thousandths(values):
        return []
    sign = "," if decimal_comma else "."
    mark = re.escape(sign)
    decimal = re.compile(rf"(?<!\d)0+{mark}|(?<!\d){mark}\d|\d{{4}}|\d[eEdD][-+]?\d|\d{mark}\d{{0,2}}(?!\d)")
    body = [_first_cells(line, delimiter) for line in body[: 1 + _MAX_CELLS // values.shape[1]]]
    lengths = (line for line in header if decimal.search(line) and _LENGTHS & set(statements([line])))
    if any(map(decimal.search, body)) or any(lengths):
        return []
    grouped = re.compile(rf"[-+]?[1-9]\d{{0,2}}{mark}\d{{3}}")
    marked: dict[int, int] = defaultdict(int)
    integer_parts: dict[int, str] = {}
    below_thousand = re.compile(r"[-+]?[1-9]\d{0,2}")
    example = ""
    rows = (chain.from_iterable(text_chunks(line.strip(), delimiter)) for line in body)
    for column, cell in islice((cell for row in rows for cell in enumerate(row)), _MAX_CELLS):
        text = cell.strip()
        if grouped.fullmatch(text):
            marked[column] += 1
            example = example or text
        elif below_thousand.fullmatch(text):
            integer_parts.setdefault(column, text)
    if sum(marked.values()) < _MIN_CELLS:
        return []
    way_out = "write the numbers without separators of thousands"
    if mixed := marked.keys() & integer_parts.keys():
        raise InputFileError(
            f"{path}: {example!r} and {integer_parts[min(mixed)]!r} in one table, with three digits behind "
            f"every "
            f"{sign!r}: it separates thousands or decimals; {way_out}, or with four decimals"
        )
    return [
        (
            f"every number has three digits behind its {sign!r}, as in {example!r}: it is read as the "
            f"decimal sign; if it separates thousands, {way_out}"
        )
    ]


def _first_cells(line: str, delimiter: str | None) -> str:
    """Return a line up to the last cell that is compared: there are lines of 40 MB."""
    cells = line.split(delimiter, _MAX_CELLS)
    return line if len(cells) <= _MAX_CELLS else line[: -len(cells[-1])]


def _in_thousandths(values: np.ndarray) -> bool:
    """Return whether all numbers are 0 or, without their sign, thousandths between 1 and 1000."""
    numbers = np.abs(values[np.isfinite(values) & (values != 0)])
    within = numbers.size > 0 and numbers.min() >= 1 and numbers.max() < 1000
    return bool(within and np.all(np.abs(1000 * numbers - np.rint(1000 * numbers)) < 1e-6))


def _refuse_both_marks(body: list[str], path: Path) -> None:
    """Refuse points as separators of thousands, or decimals, in a table with decimal commas."""
    number = re.compile(r"(?<![\d.,])\d+([.,])(\d+)(?![\d.,])")
    if not any("." in line and number.search(line) for line in body):
        return
    digits_behind: dict[str, set[int]] = {".": set(), ",": set()}
    examples: dict[str, str] = {}
    for match in (match for line in body for match in number.finditer(line)):
        digits_behind[match[1]].add(len(match[2]))
        examples.setdefault(match[1], match[0])
    if len(examples) == 2 and {3} in digits_behind.values():
        raise InputFileError(
            f"{path}: {examples[',']!r} and {examples['.']!r} in one table: either mark may be the "
            "decimal sign or separate thousands; write the numbers without separators of thousands"
        )


def cut_number(rows: list[str], delimiter: str | None, path: Path) -> list[str]:
    r"""Return a warning where a text ends, without a line end, in a number shorter than all above it."""
    ends = [
        cells[-1].strip() for line in rows[-_MAX_ENDS:] if (cells := [*chain(*text_chunks(line, delimiter))])
    ]
    marked = [re.fullmatch(r"[-+]?\d+[.,](\d*)", end) for end in ends]
    decimals = {len(match[1]) for match in marked[:-1] if match}
    if len(marked) <= _MIN_COUNTED or not all(marked[:-1]) or len(decimals) > 1:
        return []
    if not re.fullmatch(r"[-+]?\d*[.,]?\d*", ends[-1]):
        return []  # a word for a missing point
    (usual,) = decimals
    last = len(ends[-1].replace(",", ".").partition(".")[2])
    with path.open("rb") as stream:
        stream.seek(-2, 2)
        if last >= usual or set(stream.read()) & set(b"\r\n"):
            return []
    return [
        (
            f"the text ends in {ends[-1]!r}, where the numbers above have {usual} decimals: it seems "
            "to be cut off; export the map again"
        )
    ]
