"""The table of numbers of a text file: its first line, delimiters and tokens."""

import csv
import re
from array import array
from collections import Counter
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.guards import brief, check_points
from roughcontact.io.text.columns import is_heading
from roughcontact.io.text.header import statements
from roughcontact.io.text.missing import is_missing, is_spoken, joined
from roughcontact.quantities import counted_noun

COMMENT_SIGNS = "#%;!\\*/"  # at the beginning of a line
_FORTRAN = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+))[dD]([-+]?\d+)")  # double precision, 1.5D-03
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
    empty_left: int = 0  # empty columns
    empty_right: int = 0
    empty_corner: bool = False  # the first cell is empty
    # words with another meaning, taken as missing -> how often
    spoken: Mapping[str, int] = MappingProxyType({})
    short: bool = False  # the first row held a word there, or lacked a cell


class Rows(NamedTuple):
    """Rows of a table and their numbers in the file, below `heading`, whose first line is number `first`.

    `broken` is the number of the first row behind an empty line between the rows; 0 where there is none.
    """

    heading: list[str]
    first: int
    texts: list[str]
    lines: list[int]
    broken: int = 0

    @property
    def start(self) -> int:
        """Number of the first line that is not empty."""
        lines = enumerate(self.heading, self.first)
        filled = (number for number, line in lines if line.strip(_CELL_SEPARATORS))
        return next(filled, self.lines[0])


def split_header(lines: list[str]) -> tuple[list[str], list[str]]:
    """Return the lines of the header and those of the table."""
    filled = 0
    for number, line in enumerate(lines):
        if not line or line.isspace():
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
    if len(filled) < 2:
        return [], body
    alone, row = (body[number].strip().strip(delimiter or " ") for number in filled)
    cells = re.split(r"[;,\s]+", alone)
    if len(alone) > 40 or len(cells) > 2 or not all(cell.isdecimal() for cell in cells):
        return [], body
    if len(row[:_MAX_PREFIX].split(delimiter)) <= len(cells):
        return [], body
    return [int(cell) for cell in cells], body[filled[0] + 1 :]


def unquoted(header: list[str], body: list[str]) -> tuple[list[str], list[str]]:
    """Return header and table without the quotes that spreadsheets put around cells.

    Where there were quotes, semicolons separate the cells; entries of the header without quotes stay.
    """
    first = next((line for line in body if line.strip()), "")
    if '"' not in first[:_MAX_PREFIX]:
        return header, body
    delimiter = next((sign for sign in ";\t" if sign in first), ",")
    try:
        cells_of_rows = [
            [*csv.reader([line], delimiter=delimiter, skipinitialspace=True)] for line in (*header, *body)
        ]
    except csv.Error:  # a cell of more than 131 072 characters
        return header, body
    lines = [";".join(rows[0]) if rows else "" for rows in cells_of_rows]
    entries = [line if '"' not in line and re.search("[:=]", line) else "" for line in header]
    return [entry or line for entry, line in zip(entries, lines, strict=False)], lines[len(header) :]


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
    if not line.strip(_CELL_SEPARATORS):
        return False
    if _PLAIN.match(line):
        return True
    if line.lstrip()[0] in COMMENT_SIGNS and not _starts_with_missing(line):
        return False
    cells = re.split(r'[;\t,\s"]+', joined(line[:_MAX_PREFIX]).strip(_CELL_SEPARATORS), maxsplit=_FEW_CELLS)
    is_number = [_is_number(cell) for cell in cells[:_FEW_CELLS]]
    return 2 * sum(is_number) > len(is_number) or (is_number[0] and not is_missing(cells[0]))


def _is_number(cell: str) -> bool:
    """Return whether a cell is a number, or stands for a missing point."""
    try:
        _number(cell)
    except ValueError:
        return False
    return True


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
        if (is_row(line) and not ruled) or (comment and word_in_row(line, width, dialect) is not None):
            width = width or len(line.strip().split(dialect.delimiter))
            heads = [text for text in skipped if text.strip(_CELL_SEPARATORS)]
            if tables[-1].lines and any(_names_a_table(text) for text in heads):
                tables.append(Rows(skipped, number - len(skipped), [], []))
            elif tables[-1].lines and skipped and not tables[-1].broken:
                tables[-1] = tables[-1]._replace(broken=number)
            alone = alone and (bool(skipped) or not tables[-1].lines)
            tables[-1].texts.append(line)
            tables[-1].lines.append(number)
            skipped = []
        else:
            skipped.append(line)
    for number, line in enumerate(skipped, start=first + len(body) - len(skipped)):
        if line.strip(_CELL_SEPARATORS) and line.lstrip()[0] not in "#%":
            raise _no_row(line, number)
    if alone and len(tables) == 1 and len(tables[0].lines) > 2:
        tables[0] = tables[0]._replace(broken=0)
    return tables


def below_a_label(rows: Rows, dialect: Dialect) -> Rows | None:
    """Return rows with the line above them, where that has a word in its corner and positions beside it."""
    if not rows.heading or not rows.heading[-1].strip():
        return None
    line = rows.heading[-1]
    delimiter = dialect.delimiter
    around = " \r\f" if delimiter else None
    label, *cells = line.strip(around).removesuffix(delimiter or "").split(delimiter)
    first_row = rows.texts[0].strip(around)
    closing = delimiter if delimiter and first_row.endswith(delimiter) else ""
    width = len(first_row.removesuffix(closing).split(delimiter))
    positions = [*map(dialect.plain, cells)]
    if _is_number(label) or not _FEW_ROWS <= len(cells) == width - 1 or not all(map(_is_number, positions)):
        return None
    steps = np.diff([_number(position) for position in positions])
    even = steps.any() and np.ptp(steps) <= _UNEVEN * abs(steps.mean())  # also no missing point
    if not even or statements([line]) or line.lstrip()[0] in COMMENT_SIGNS:
        return None
    text = (delimiter or " ").join(["NaN", *cells]) + closing
    return rows._replace(
        heading=rows.heading[:-1], texts=[text, *rows.texts], lines=[rows.lines[0] - 1, *rows.lines]
    )


def _names_a_table(line: str) -> bool:
    """Return whether a line between rows is more than a comment: words, or an entry of a header."""
    return line.lstrip()[0] not in "#%" or bool(statements([line]))


def parse_table(rows: list[str], lines: list[int], dialect: Dialect) -> Table:
    """Return the numbers of a table; `lines` number the rows, for messages.

    Examples
    --------
    >>> table = parse_table(["1,5;BAD;;", "2,5;3;;"], [1, 2], Dialect(";", True))
    >>> table.values
    array([[1.5, nan, nan],
           [2.5, 3. , nan]])
    >>> table.empty_right
    1
    """
    closed = _ends_with_delimiter(rows, dialect.delimiter)
    try:
        return _parse(rows, lines, dialect, closed)
    except _UnequalRowsError:
        if closed:
            raise
        return _parse(rows, lines, dialect, closed=True)


class _UnequalRowsError(InputFileError):
    """Rows of different lengths."""


def _ends_with_delimiter(body: list[str], delimiter: str | None) -> bool:
    """Return whether a separator at the end of a line closes it, rather than leaving its last cell empty.

    It does where all lines end in one, and where only the last line does, which is incomplete then.
    """
    if delimiter is None:
        return True
    filled = [line for line in body if line and not line.isspace()]
    ends = [line.rstrip(" \r\f").endswith(delimiter) for line in filled]
    return all(ends) or not any(ends[:-1])


def _parse(rows: list[str], lines: list[int], dialect: Dialect, closed: bool) -> Table:
    """Return the numbers of a table, whose lines may end with a delimiter."""
    numbers, counts, spoken = array("d"), array("q"), Counter[str]()
    delimiter = dialect.delimiter
    sides: tuple[int, int] | None = None
    corner = short = False
    for number, line in zip(lines, rows, strict=True):
        text = dialect.plain(line.strip(" \r\f" if delimiter == "\t" else None))
        if delimiter is not None and closed:
            text = text.removesuffix(delimiter)
        before = len(numbers)
        try:
            empty = _append(numbers, text, delimiter, spoken)
        except ValueError as error:
            cells = zip(line.split(delimiter), text.split(delimiter), strict=False)
            raise _no_row(
                next((cell for cell, read in cells if not _is_number(read)), line), number
            ) from error
        counts.append(len(numbers) - before)
        sides = empty if sides is None else (min(sides[0], empty[0]), min(sides[1], empty[1]))
        corner = corner or (len(counts) == 1 and empty[0] > 0)
    if len(counts) > _FEW_ROWS and counts[0] + 1 == min(counts[1:]) == max(counts[1:]):
        numbers.insert(0, np.nan)  # positions along x, without a cell in the corner
        counts[0], corner, sides, short = counts[1], True, (0, 0), True
    _refuse_unequal_rows(counts, lines)
    shape = len(counts), counts[0]
    check_points(shape)
    return Table(np.array(numbers).reshape(shape), *(sides or (0, 0)), corner, spoken, short)


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
        raise _UnequalRowsError(
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
    non_numbers, numbers, finite = [], 0, 0
    for cell in cells:
        try:
            finite += bool(np.isfinite(_number(cell)))
            numbers += bool(cell)
        except ValueError:
            non_numbers.append(cell)
    if non_numbers and finite and 2 * numbers > len(cells):
        return non_numbers[0]
    repeated = len(set(non_numbers)) == 1 < len(non_numbers) and len(cells) == width >= _WIDE_TABLE
    if repeated and any(map(str.isalnum, non_numbers[0])) and not is_heading(non_numbers[0]):
        return non_numbers[0]
    return None


def _append(numbers: array, text: str, delimiter: str | None, spoken: Counter[str]) -> tuple[int, int]:
    """Append the numbers of a row; return the numbers of empty cells at its beginning and at its end.

    Words that are taken as missing but may have another meaning are counted in `spoken`.
    """
    if "_" not in text:  # Python would read 1_000
        before = len(numbers)
        try:
            numbers.extend(map(float, text.split(delimiter)))
        except ValueError:
            del numbers[before:]
        else:
            if "n" not in text and "N" not in text:  # "inf" stands for a missing point
                return 0, 0
            del numbers[before:]
    tokens = joined(text).split(delimiter)
    numbers.extend([_number(token) for token in tokens])
    spoken.update(filter(is_spoken, map(str.strip, tokens)))
    filled = [index for index, token in enumerate(tokens) if token.strip()]
    return (filled[0], len(tokens) - 1 - filled[-1]) if filled else (len(tokens), len(tokens))


def _is_data(line: str) -> bool:
    """Return whether a line is a row of numbers."""
    if re.match(r";[-+.\d]", line) and ";" in line[1:]:  # an empty first cell, no comment
        line = line[1:]
    if not line.strip() or (line.lstrip()[0] in COMMENT_SIGNS and not _starts_with_missing(line)):
        return False
    text = joined(line[:_MAX_PREFIX])
    tokens = re.split(r'[;\t,\s"]+', text.strip().strip(';,"'))
    if len(line) > _MAX_PREFIX:
        tokens.pop()  # it may be half a number
    try:
        values = [_number(token) for token in tokens]
    except ValueError:
        return False
    if (
        0 < len(values) <= 3
        and tokens[0][:1].isalpha()
        and (is_spoken(tokens[0]) or text != line[:_MAX_PREFIX])
    ):
        return False  # "Masked 12" is an entry of the header
    ruled = "---" in line and not any(map(str.isalnum, line))  # a line drawn below headings
    return bool(np.isfinite(values).any()) or (len(values) > 1 and not ruled)


def _starts_with_missing(line: str) -> bool:
    """Return whether a line begins with a token for a missing point, such as ``#N/A`` or ``***``."""
    return is_missing(re.split(r"[;\t,\s]", line[:_MAX_PREFIX].lstrip(), maxsplit=1)[0])


def _number(token: str) -> float:
    """Return the value of a token, NaN for one that stands for a missing point."""
    token = token.strip()
    if is_missing(token):
        return np.nan
    if "_" in token:  # Python would read 1_000
        raise ValueError(f"no number: {token!r}")
    if double := _FORTRAN.fullmatch(token):
        token = f"{double[1]}e{double[2]}"
    return float(token)
