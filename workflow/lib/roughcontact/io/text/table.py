"""The table of numbers of a text file: its first line, delimiters and tokens."""

import csv
import re
from array import array
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from typing import NamedTuple

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.guards import brief, check_points
from roughcontact.io.text.columns import is_heading
from roughcontact.io.text.header import statements
from roughcontact.io.text.missing import is_missing, is_spoken, joined
from roughcontact.quantities import counted_noun

COMMENT_SIGNS = "#%;!\\*/"  # at the beginning of a line
_FORTRAN = re.compile(r"^([-+]?(?:\d+\.?\d*|\.\d+))[dD]([-+]?\d+)$")  # double precision, 1.5D-03
_MAX_HEADER_LINES = 100_000  # without empty lines
_MAX_PREFIX = 2**16  # characters of a line that decide whether it contains numbers
_WIDE_TABLE = 8  # columns; the headings of so many differ from one another
_MAX_CELL = 64  # characters of a cell, on the average
_PLAIN = re.compile(r'[-+\d.,;\s"eEdD]*\Z')  # of a row without words
_CELL_SEPARATORS = ' \t;,"\r\n\f'  # what may stand between cells
_UNEVEN = 0.1  # of a step, between positions that are rounded
_FEW_ROWS = 3  # that show what a first row with one cell less is
_FEW_CELLS = 32  # at the beginning of a line, which tell a row with words from a heading


class Dialect(NamedTuple):
    """How a text writes a table; the delimiter of its columns is None for white space."""

    delimiter: str | None
    decimal_comma: bool

    def plain(self, line: str) -> str:
        """Return a line with decimal points."""
        return line.replace(",", ".") if self.decimal_comma else line


class Table(NamedTuple):
    """The numbers of a table; NaN for missing points and empty cells."""

    values: np.ndarray
    empty: np.ndarray  # columns (n,) without any cell
    empty_corner: bool  # the first cell is empty
    short: bool  # the first row held a word there, or lacked a cell
    spoken: Mapping[str, int]  # words with another meaning, taken as missing -> how often


class Rows(NamedTuple):
    """Rows of a table and their numbers in the file, below `heading`, whose first line is number `first`.

    `broken` is the number of the first row behind an empty line between the rows; 0 where there is none.
    `label` is the word in the corner of the first of them.
    """

    heading: list[str]
    first: int
    texts: list[str]
    lines: list[int]
    broken: int = 0
    label: str = ""

    @property
    def filled(self) -> list[tuple[int, str]]:
        """Filled lines of the heading, with their numbers."""
        return [(number, line) for number, line in enumerate(self.heading, self.first) if line.strip()]

    @property
    def start(self) -> tuple[int, str]:
        """The first line that is not empty, with its number."""
        filled = (numbered for numbered in self.filled if numbered[1].strip(_CELL_SEPARATORS))
        return next(filled, (self.lines[0], self.texts[0]))


def split_header(lines: list[str]) -> tuple[list[str], list[str]]:
    """Return the lines of the header and those of the table."""
    filled = 0
    for number, line in enumerate(lines):
        if not line.strip():
            continue
        if _is_data(line):
            return lines[:number], lines[number:]
        filled += 1
        if filled > _MAX_HEADER_LINES:
            break
    first = next((line.strip() for line in lines if line.strip()), "")
    within = f" in its first {_MAX_HEADER_LINES} lines" if filled > _MAX_HEADER_LINES else ""
    raise InputFileError(f"text without a table of numbers{within}; it starts with {first[:60]!r}")


def counted(body: list[str], delimiter: str | None) -> tuple[list[int], list[str]]:
    """Return the numbers of points alone in a line above the table (``23``, ``256 192``), and the table."""
    filled = [number for number, line in enumerate(body[:50]) if line.strip()][:2]
    alone, row = (
        body[number].strip(" \r\f").rstrip((delimiter or "") + " ") for number in (filled[0], filled[-1])
    )
    counts = re.findall(r"\d+", alone)
    only_counts = len(alone) <= 40 and re.fullmatch(r"\d+(?:[;,\s]+\d+)?", alone)
    if not only_counts or len(row[:_MAX_PREFIX].split(delimiter)) <= len(counts):
        return [], body
    return [*map(int, counts)], body[filled[0] + 1 :]


def unquoted(header: list[str], body: list[str]) -> tuple[list[str], list[str]]:
    """Return header and table without the quotes that spreadsheets put around cells.

    Where there were quotes, semicolons separate the cells; entries of the header without quotes stay.
    """
    first = next((line for line in body if line.strip()), "")
    if '"' not in first[:_MAX_PREFIX]:
        return header, body
    delimiter = next((sign for sign in ";\t" if sign in first), ",")
    cells_of = partial(csv.reader, delimiter=delimiter, skipinitialspace=True)
    try:
        lines = [";".join(next(cells_of([line]), [])) for line in (*header, *body)]
    except csv.Error:  # a cell of more than 131 072 characters
        return header, body
    for number, line in enumerate(header):
        if '"' not in line and re.search("[:=]", line):
            lines[number] = line
    return lines[: len(header)], lines[len(header) :]


def separators(body: list[str]) -> Dialect:
    """Return the delimiter of the columns, and whether the decimal sign is a comma."""
    sample = [line.strip() for line in body[:50] if is_row(line)]
    joined = "\n".join(sample)
    for sign in ";\t":
        if sign in joined:
            doubled = all(line.count(sign) == 2 * line.count(2 * sign) > 0 for line in sample)
            return Dialect(2 * sign if doubled else sign, any(map(re.compile(r"\d,|,\d").search, body)))
    if "," not in joined:
        return Dialect(None, False)
    tokens = [line.split() for line in sample]
    separating = re.search(r",\S*,|,(?:\s|\Z)", joined) or ("." in joined and re.search(r"\s,", joined))
    if any(len(row) > 1 for row in tokens) and not separating:
        return Dialect(None, True)
    one_comma = max(line.count(",") for line in sample) == 1
    leading_zero = re.search(r"(?<!\d)0\d", joined)  # only decimals begin so
    if "." not in joined and one_comma and leading_zero:
        return Dialect(None, True)
    if "." not in joined and (leading_zero or (one_comma and len(sample) > 1)):
        raise InputFileError(
            f"the comma in {sample[0]!r} may be a decimal sign or a separator; "
            "write decimals with a point, or separate columns with a tab or a semicolon"
        )
    return Dialect(",", False)


def is_empty_row(line: str) -> bool:
    """Return whether a line consists of several separators of cells."""
    return not line.strip(_CELL_SEPARATORS) and len(line.strip(" \r\n\f")) > 1


def is_row(line: str) -> bool:
    """Return whether a line among the rows of a table is one of them, perhaps with a word in it.

    Examples
    --------
    >>> [is_row(line) for line in ("1.5;n/a", "0.5 hole", "Profile 2", "x (mm);z (µm)", "# 1 2 3", ";;")]
    [True, True, False, False, False, False]
    """
    if _PLAIN.match(line):
        return bool(line.strip(_CELL_SEPARATORS))
    cells = _cells(line, _FEW_CELLS)[:_FEW_CELLS]
    is_number = [_number_in(cell) is not None for cell in cells]
    return 2 * sum(is_number) > len(cells) or (is_number[:1] == [True] and not is_missing(cells[0]))


def split_tables(header: list[str], body: list[str], first: int, dialect: Dialect) -> list[Rows]:
    """Return the tables of a text, which end at headings between rows; `first` numbers the first line.

    Empty lines and comments without entries are no headings.

    Examples
    --------
    >>> body = ["1 2", "3 4", "", "Phase", "5 6", "7 8"]
    >>> [(table.heading, table.lines) for table in split_tables([], body, 1, Dialect(None, False))]
    [([], [1, 2]), (['', 'Phase'], [5, 6])]
    """
    tables = [Rows(header, first - len(header), [], [])]
    skipped: list[str] = []
    width, alone = 0, True
    for number, line in enumerate(body, start=first):
        comment = line.lstrip()[:1] in ("#", "%")
        ruled = not any(map(str.isalnum, line)) and any(text.strip() for text in skipped)
        if not ((is_row(line) and not ruled) or (comment and word_in_row(line, width, dialect) is not None)):
            skipped.append(line)
            continue
        width = width or len(line.strip().split(dialect.delimiter))
        if tables[-1].lines:
            filled = [text for text in skipped if text.strip(_CELL_SEPARATORS)]
            if any(text.lstrip()[0] not in "#%" or statements([text]) for text in filled):
                tables.append(Rows(skipped, number - len(skipped), [], []))
            elif skipped and not tables[-1].broken:
                tables[-1] = tables[-1]._replace(broken=number)
            alone = alone and bool(skipped)
        tables[-1].texts.append(line)
        tables[-1].lines.append(number)
        skipped = []
    for number, line in enumerate(skipped, start=first + len(body) - len(skipped)):
        if line.strip(_CELL_SEPARATORS) and line.lstrip()[0] not in "#%":
            raise _no_row(line, number)
    if alone and len(tables) == 1 and len(tables[0].lines) > 2:
        gaps = np.diff(tables[0].lines)
        tables[0] = tables[0]._replace(broken=tables[0].lines[gaps.argmax() + 1] if np.ptp(gaps) else 0)
    return [_below_a_label(table, dialect) for table in tables]


def _below_a_label(rows: Rows, dialect: Dialect) -> Rows:
    """Return rows with the line above them, where that has a word in its corner and positions beside it."""
    line = rows.heading[-1] if rows.heading else ""
    if not line.strip() or line.lstrip()[0] in COMMENT_SIGNS:
        return rows
    delimiter = dialect.delimiter
    around = " \r\f" if delimiter else None
    label, *cells = line.strip(around).removesuffix(delimiter or "").split(delimiter)
    first_row = rows.texts[0].strip(around)
    closing = delimiter if delimiter and first_row.endswith(delimiter) else ""
    width = len(first_row.removesuffix(closing).split(delimiter))
    positions = [_number_in(dialect.plain(cell)) for cell in cells]
    if not _FEW_ROWS <= len(cells) == width - 1 or None in positions or _number_in(label) is not None:
        return rows
    steps = np.diff(np.array(positions, dtype=float))
    even = steps.any() and np.ptp(steps) <= _UNEVEN * abs(steps.mean())  # also no missing point
    if not even or statements([line]):
        return rows
    texts = [(delimiter or " ").join(["NaN", *cells]) + closing, *rows.texts]
    lines = [rows.lines[0] - 1, *rows.lines]
    return rows._replace(heading=rows.heading[:-1], texts=texts, lines=lines, label=label)


def parse_table(rows: Rows, dialect: Dialect) -> Table:
    """Return the numbers of a table.

    Examples
    --------
    >>> table = parse_table(Rows([], 1, ["1,5;BAD;;", "2,5;3;;"], [1, 2]), Dialect(";", True))
    >>> table.values
    array([[1.5, nan, nan],
           [2.5, 3. , nan]])
    >>> table.empty
    array([False, False,  True])
    """
    delimiter = dialect.delimiter
    texts = [dialect.plain(line.strip(" \r\f" if delimiter == "\t" else None)) for line in rows.texts]
    if delimiter is not None:
        texts = _without_closing(texts, delimiter)
    numbers, counts, spoken = array("d"), array("q"), Counter[str]()
    for number, line, text in zip(rows.lines, rows.texts, texts, strict=True):
        row = _plain_numbers(text, delimiter)
        if row is None:
            cells = joined(text).split(delimiter)
            spoken.update(filter(is_spoken, map(str.strip, cells)))
            row = [value for cell in cells if (value := _number_in(cell)) is not None]
            if len(row) < len(cells):
                bad = [cell for cell in line.split(delimiter) if _number_in(dialect.plain(cell)) is None]
                raise _no_row([*bad, line][0], number)
        numbers.extend(row)
        counts.append(len(row))
    if lacks_corner := _lacks_corner(counts):
        numbers.insert(0, np.nan)
        counts[0] += 1
    _refuse_unequal_rows(counts, rows.lines)
    shape = len(counts), counts[0]
    check_points(shape)
    values = np.array(numbers).reshape(shape)
    empty = np.isnan(values).all(axis=0) & (delimiter is not None and not lacks_corner)
    for text in texts if empty.any() else ():
        empty &= [not cell.strip() for cell in text.split(delimiter)]
    short = bool(rows.label) or lacks_corner
    return Table(values, empty, short or not texts[0].split(delimiter)[0].strip(), short, spoken)


def _without_closing(texts: list[str], delimiter: str) -> list[str]:
    """Return lines without a separator at their end that closes them, rather than leaves a last cell empty.

    It does where all lines end in one, where only the last line does, which is incomplete then, and where the
    rows have different lengths otherwise.
    """
    ends = [text.endswith(delimiter) for text in texts]
    counts = array("q", [text.count(delimiter) for text in texts])
    if any(ends[:-1]) and not all(ends) and (len({*counts}) == 1 or _lacks_corner(counts)):
        return texts
    return [text.removesuffix(delimiter) for text in texts]


def _lacks_corner(counts: array) -> bool:
    """Return whether the first row has one cell less than all others: positions along x, without a corner."""
    return len(counts) > _FEW_ROWS and counts[0] + 1 == min(counts[1:]) == max(counts[1:])


def _no_row(cell: str, number: int) -> InputFileError:
    """Return the error for a line that is no row of a table, with the cell or line that is no number."""
    way_out = (
        "write NaN for a missing point, leave the table alone in the file, below lines of words, or export "
        "the map as X3P or SDF"
    )
    if re.search(r"\d[.,'\s]\d{3}(?!\d)", cell):
        way_out = "write the numbers without separators of thousands"
    return InputFileError(f"line {number} is no row of numbers ({brief(ValueError(cell))}); {way_out}")


def _refuse_unequal_rows(counts: array, lines: list[int]) -> None:
    """Refuse rows of different lengths."""
    widths = Counter(counts)
    if len(widths) > 1:
        width = widths.most_common(1)[0][0]
        bad = next(index for index, count in enumerate(counts) if count != width)
        cut = "; the last line is incomplete: the file was cut off" if bad == len(counts) - 1 else ""
        number_count = counted_noun(counts[bad], "number")
        raise InputFileError(
            f"row {bad + 1} has {number_count} where the others have {width} (line {lines[bad]}){cut}"
        )


def word_in_row(line: str, width: int, dialect: Dialect) -> str | None:
    """Return the first word in a line that is a row of a table of that `width` but for it, or None."""
    if not width or len(line) > width * _MAX_CELL:
        return None
    text = joined(line.strip(" \r\f\n"))
    cells = [cell.strip() for cell in dialect.plain(text).split(dialect.delimiter)]
    while len(cells) > width and not cells[-1]:
        cells.pop()
    comment = bool(cells[0]) and cells[0][0] in COMMENT_SIGNS
    # in a wide table a lost separator or a blank in a word makes one cell fewer or more
    if abs(len(cells) - width) > (width >= _WIDE_TABLE and not comment) or (comment and len(cells[0]) > 1):
        return None
    values = [_number_in(cell) for cell in cells]
    non_numbers = [cell for cell, value in zip(cells, values, strict=True) if value is None]
    numbers = sum(bool(cell) for cell in cells) - len(non_numbers)
    finite = any(value is not None and np.isfinite(value) for value in values)
    if non_numbers and finite and 2 * numbers > len(cells):
        return non_numbers[0]
    repeated = len(set(non_numbers)) == 1 < len(non_numbers) and len(cells) == width >= _WIDE_TABLE
    if repeated and any(map(str.isalnum, non_numbers[0])) and not is_heading(non_numbers[0]):
        return non_numbers[0]
    return None


def _plain_numbers(text: str, delimiter: str | None) -> list[float] | None:
    """Return the numbers of a row without words, or None."""
    if not any(sign in text for sign in "_nN"):  # Python would read 1_000; "inf" stands for a missing point
        with suppress(ValueError):
            return [*map(float, text.split(delimiter))]
    return None


def _is_data(line: str) -> bool:
    """Return whether a line is a row of numbers."""
    cells = _cells(line)
    if len(line) > _MAX_PREFIX:
        del cells[-1:]  # it may be half a number
    values = [_number_in(cell) for cell in cells]
    if not cells or None in values:
        return False
    phrase = is_spoken(cells[0]) or joined(line[:_MAX_PREFIX]) != line[:_MAX_PREFIX]
    if len(cells) <= 3 and cells[0][:1].isalpha() and phrase:
        return False  # "Masked 12" is an entry of the header
    ruled = "---" in line and not any(map(str.isalnum, line))  # a line drawn below headings
    return bool(np.isfinite(np.array(values, dtype=float)).any()) or (len(values) > 1 and not ruled)


def _cells(line: str, most: int = 0) -> list[str]:
    """Return the cells of a line, after `most` the rest; none of a comment, unlike ``#N/A`` or ``***``."""
    start = line[:_MAX_PREFIX].lstrip()
    text = joined(start).strip(_CELL_SEPARATORS)
    first = re.split(r"[;\t,\s]", start, maxsplit=1)[0]
    comment = start.startswith(tuple(COMMENT_SIGNS)) and not is_missing(first)
    return [] if comment or not text else re.split(r'[;\t,\s"]+', text, maxsplit=most)


def _number_in(token: str) -> float | None:
    """Return the value of a token, NaN for one that stands for a missing point, None for any other word."""
    token = token.strip()
    if is_missing(token):
        return np.nan
    try:
        if "d" in token or "D" in token:
            token = _FORTRAN.sub(r"\1e\2", token)
        return float(token) if "_" not in token else None  # Python would read 1_000
    except ValueError:
        return None
