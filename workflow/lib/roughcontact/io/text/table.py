"""The table of numbers of a text file: its first line, delimiters and tokens."""

import csv
import re
from array import array
from collections import Counter
from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import partial
from itertools import chain, islice, takewhile, zip_longest
from typing import NamedTuple

import numpy as np

from roughcontact.arguments.quantities import counted_noun
from roughcontact.io.guards import brief, check_count, check_points, refusal, sentence
from roughcontact.io.text.columns import WIDE_TABLE, is_heading
from roughcontact.io.text.header import LENGTHS, Stated, statements
from roughcontact.io.units import is_length
from roughcontact.io.vocabulary import meanings, words

COMMENT_SIGNS = "#%;!\\*/"  # at the beginning of a line
_FORTRAN = re.compile(r"^([-+]?(?:\d+\.?\d*|\.\d+))[dD]([-+]?\d+)$")  # double precision, 1.5D-03
# between the thousands of a number with decimals, and of one that is a cell
_GROUPS = {mark: re.compile(rf"(?<=\d)[{mark}](?=\d{{3}}(?:[{mark}]\d{{3}})*[.,]\d)") for mark in ".,"}
_GROUPED = re.compile(r"[-+]?\d{1,3}(?:[ '’\xa0\u202f]\d{3})+(?:\.\d*)?")
_ENTRY = re.compile(r"\s*[^\W\d][^;\t]*[:=]")  # a word that says of what the number is, as "Mean: 0.25"
# a date, perhaps with the time of day, as a cell
_DATE = re.compile(
    r"(?:^|(?<=[;\t,\s]))(?:\d{4}([-/.])\d{1,2}\1\d{1,2}|\d{1,2}([-/.])\d{1,2}\2\d{4})"
    r"(?:[ T]\d{1,2}:\d\d(?::\d\d(?:[.,]\d+)?)?)?(?=[;\t,\s]|$)"
)
_DAY = re.compile(r"(?:19|20)\d\d(?:0[1-9]|1[0-2])(?:0[1-9]|[12]\d|3[01])")  # a date of digits alone
_MAX_HEADER_LINES = 10_000  # without empty lines
_MAX_PREFIX = 2**16  # characters of a line that decide whether it contains numbers
_MAX_CELL = 64  # characters of a cell, on the average
_PLAIN = re.compile(r'[-+\d.,;\s"eEdD]*\Z')  # of a row without words
_ENDS = meanings("end")
_LAST_LINES = 50  # lines whose last numbers are compared with that at the end of a file
_MIN_PEERS = 3
_CELL_SEPARATORS = ' \t;,"\r\n\f'  # what may stand between cells
_UNEVEN = 0.1  # of a step, between positions that are rounded
_FEW_ROWS = 3  # that show what a first row with one cell less is
_SHORT_WORD = 5  # letters; longer ones behind a number are a line of a header
_FEW_CELLS = 32  # at the beginning of a line, which tell a row with words from a heading
_MIN_COUNT = 10  # cells with three digits behind the mark, of which fewer say nothing
_MAX_COMPARED = 200_000  # cells that are compared column by column
# words for a missing point; numbers are in `io.channels`
_MARKERS = {"", *meanings("marker")}  # an empty cell too
# taken as missing, with a warning: they may have another meaning
_SPOKEN = set(words("missing")["spoken"])
_FILLING = "-*?"  # characters that stand for a missing point, repeated any number of times
_PHRASES = "|".join(map(re.escape, words("missing")["phrase"]))
_PHRASE = re.compile(rf"(?i)(?<![^\s;,])(?:{_PHRASES})(?=[\s;,]|$)")


def is_missing(cell: str) -> bool:
    """Return whether a cell without blanks around it stands for a missing point.

    Examples
    --------
    >>> [is_missing(word) for word in ("NaN", "***", "Ungültig", "1.5", "trace")]
    [True, True, True, False, False]
    """
    return cell.lower() in _MARKERS or is_spoken(cell) or not cell.strip(_FILLING)


def is_spoken(cell: str) -> bool:
    """Return whether a cell is a word that may have another meaning beside that of a missing point."""
    return cell.lower() in _SPOKEN


def joined(line: str) -> str:
    """Return a line in which the phrases for a missing point are one word each."""
    return _PHRASE.sub(lambda match: match[0].lower().replace(" ", ""), line) if " " in line else line


Lines = list[str]


class Dialect(NamedTuple):
    """How a text writes a table; the delimiter of its columns is None for white space."""

    delimiter: str | None
    decimal_comma: bool

    def plain(self, line: str) -> str:
        """Return a line with decimal points, and without the other mark where both are in one number."""
        mark = "." if self.decimal_comma else ","
        if mark in line and self.delimiter != mark:
            line = _GROUPS[mark].sub("", line)
        return line.replace(",", ".") if self.decimal_comma else line

    def cells(self, line: str) -> list[str]:
        """Return the cells of a row, in which a phrase for a missing point is one word."""
        return [cell.strip() for cell in joined(line.strip(" \r\n\f")).split(self.delimiter)]

    def number(self, cell: str) -> float | None:
        """Return the value of a cell, NaN for a missing point, None for any other word."""
        return _parse_number(self.plain(cell))


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
        rows = (numbered_line for numbered_line in self.filled if numbered_line[1].strip(_CELL_SEPARATORS))
        return next(rows, (self.lines[0], self.texts[0]))


def split_text(text: str) -> tuple[list[Rows], list[int], Dialect, list[str]]:
    """Return the tables of a text, the numbers of points above the first, the dialect, and notes."""
    header, body = _unquoted(*split_header(text.splitlines()))
    body, footer, dialect = split_footer(body, header)
    header, body, remarks = strip_remarks(header, body, dialect)
    last_line = len(header) + len(body)
    # "Total points: 252" says nothing else than the table
    count = [str(sum(map(is_row, body)))] if re.search(r"\d", "".join(footer)) else []
    lines_below = ["" if re.findall(r"\d+", line) == count else line for line in footer]
    notes = [*_left_out_below(lines_below, last_line + 1), *remarks]
    if not footer:
        notes += _cut_number(body, dialect.delimiter, text, last_line)
    if empty := sum(len([*takewhile(_is_empty_row, reversed(lines))]) for lines in (header, footer)):
        notes.append(left_out(empty, "line"))
    counts, rows = _counted(body, dialect.delimiter)
    return split_tables(header, rows, last_line + 1 - len(rows), dialect), counts, dialect, notes


def left_out(count: int, lines: str) -> str:
    """Return a warning about empty lines or columns beside a table."""
    how = "is" if count == 1 else "are"
    empty = f"{counted_noun(count, lines)} of empty cells beside the table {how} left out"
    return f"{empty}; write NaN in those that are part of the map"


def _cut_number(body: list[str], delimiter: str | None, text: str, last_line: int) -> list[str]:
    """Return a note where a file ends in a number shorter than all others, without the end of a line.

    It is refused where all others have as many decimals and digits of the exponent.
    """
    if {*text[-2:]} & {*"\n\r"}:
        return []
    nonempty = filter(None, map(str.strip, body[-_LAST_LINES:]))
    *cells, last = (line.split(delimiter)[-1].strip() for line in nonempty)
    peers = [cell for cell in cells if cell and not is_missing(cell)]
    if len(peers) < _MIN_PEERS or (is_missing(last) and last != "-"):
        return []
    forms = [tuple(map(len, re.split("[.,]|[eEdD][-+]?", cell)[1:])) for cell in (*peers, last)]
    wrong = f"line {last_line} ends the file in {last!r}, without the end of a line"
    if len({*forms[:-1]}) == 1 and forms[0] and forms[-1] != forms[0]:
        raise refusal("cut number", wrong=wrong)
    *digits, last_digits = (len(re.sub(r"\D", "", cell)) for cell in (*peers, last))
    return [f"{wrong}: if the file was cut off, complete that number"] if last_digits < min(digits) else []


def split_header(lines: list[str]) -> tuple[list[str], list[str]]:
    """Return the lines of the header and those of the table, whose first rows may hold words.

    Examples
    --------
    >>> split_header(["x;z;note", "0;1.5;start", "1;2.5;"])
    (['x;z;note'], ['0;1.5;start', '1;2.5;'])
    """
    filled = [*islice((number for number, line in enumerate(lines) if line.strip()), _MAX_HEADER_LINES + 1)]
    rows = (at for at in filled if not _is_remark(lines[at : at + 3]) and _is_data(lines[at]))
    # rows of numbers are none of labelled ones
    pairs = (at for at in filled if _are_labelled(lines[at : at + 2]))
    extent = len(filled) > _MAX_HEADER_LINES
    found = next(chain(rows, pairs), None)
    # without one each row has a word, and below them may be lines of words
    ends = (at + 1 for at in reversed(filled) if not extent and is_row(lines[at]))
    bottom = next(ends, len(lines)) if found is None else found
    below = lines[bottom:] if found is not None else lines[:bottom][::-1]
    first_row = next((line for line in below if line.strip()), "")
    # rows with a remark beside the first points stand above the first row of numbers alone
    above = (at for at in reversed(filled) if at < bottom and not (extent and found is None))
    start = min(takewhile(lambda at: _is_row_like(lines[at], first_row), above), default=bottom)
    if found is not None or start < bottom:
        return lines[:start], lines[start:]
    sample = lines[filled[0]].strip() if filled else ""
    name = "long text without a table" if extent else "text without a table"
    raise refusal(name, text=sample[:60], lines=_MAX_HEADER_LINES)


def _is_remark(lines: list[str]) -> bool:
    """Return whether the first of three lines begins with a semicolon, as none of the cells below it end.

    Or holds a word and a number alone above rows of more cells: which number marks a missing point.
    """
    first, second = (re.split(r"[;\t]|,?\s+", line.strip(_CELL_SEPARATORS)) for line in [*lines, ""][:2])
    if first[0][:1].isalpha() and len(first) == 2 != len(second) and second[0]:
        return True
    return lines[0].lstrip().startswith(";") and not any(";" in below for below in lines[1:])


def _are_labelled(lines: list[str]) -> bool:
    """Return whether two lines are rows of numbers behind labels, as "Row 1", or a time of day."""
    if len([*filter(_DATE.match, lines)]) == 2:
        return all(_is_data(_DATE.sub("", line, count=1)) for line in lines)
    delimiter = next((sign for sign in ";\t," if all(sign in line for line in lines)), None)
    if delimiter is None or len(lines) < 2:
        return False
    (label, *cells), (below, *cells_below) = (line.strip().split(delimiter) for line in lines)
    same_words = label != below and re.sub(r"\d", "", label) == re.sub(r"\d", "", below)
    fits = same_words and 1 < len(cells) == len(cells_below) and len(label) <= _MAX_CELL
    numbers = [_parse_number(cell.replace(",", ".")) for cell in cells + cells_below if fits and cell.strip()]
    return bool(numbers) and None not in numbers


def _is_row_like(line: str, row: str) -> bool:
    """Return whether a line is a row that begins with a number and has a word, as wide as those below it.

    Above a column of numbers it is a word alone for a missing point, but no rule drawn below headings.
    """
    is_column = _parse_number(row.replace(",", ".")) is not None  # of which the comma is the decimal sign
    if is_missing(line.strip()) and re.search(r"[^\W_]|\?|^\s*\*\s*$", line) and is_column:
        return True
    signs = ";\t" if re.search(r"\d\s+[-\d]", row) else ";\t,"  # between blanks commas are decimal signs
    delimiter = next((sign for sign in signs if sign in row), None)
    cells = [cell.strip().replace(",", ".") for cell in line.split(delimiter)]
    is_wide = len(cells) >= len(row.split(delimiter)) and len(line) <= len(cells) * _MAX_CELL
    if not (is_wide and is_row(line)) or is_missing(cells[0]) or _parse_number(cells[0]) is None:
        return False
    # between blanks "3 points" and "10 µm" are lines of a header
    words = [] if delimiter else [cell for cell in cells if _parse_number(cell) is None]
    return 2 * len(words) < len(cells) or (max(map(len, words)) < _SHORT_WORD and not is_length(words[0]))


def strip_remarks(header: Lines, body: Lines, dialect: Dialect) -> tuple[Lines, Lines, Lines]:
    """Return header and table without columns of words and dates, and what stands right of words; a note.

    Examples
    --------
    >>> strip_remarks(["x;z;note"], ["0;1.5;start", "1;2.5;"], Dialect(";", False))
    (['x;z'], ['0;1.5', '1;2.5'], ["column 3 ('note', 'start') holds words and is left out"])
    """
    words = dict[int, str]()
    has_dates = any(map(_DATE.search, body[:1]))
    for line in body:
        if (has_dates or not _PLAIN.match(line)) and is_row(line):
            cells = enumerate(dialect.cells(line))
            words = {index: cell for index, cell in cells if dialect.number(cell) is None} | words
    may_be_days = any(_DAY.match(line.strip()) for line in body[:1])
    rows = [dialect.cells(line) for line in body if is_row(line)] if words or may_be_days else []
    width = max(map(len, rows), default=0)
    cells_by_column = [[*filter(None, column)] for column in zip_longest(*rows)]
    # a column with any number in it holds heights, among which a word is refused later
    columns = {index for index in words if not _are_finite(map(dialect.number, cells_by_column[index])).any()}
    # right of them results beside the table, below which are empty cells
    beside = range(min(columns, default=width), width)
    remarks = {index for index in beside if 2 * len(cells_by_column[index]) < len(rows)}
    if len(rows) >= _FEW_ROWS and all(_DAY.fullmatch(row[0]) for row in rows):
        words, columns = words | {0: rows[0][0]}, columns | {0}
    if not columns or len(columns) == width:
        return header, body, []
    notes = []
    for index in sorted(columns):
        names = [cells[index] for cells in map(dialect.cells, header) if len(cells) == width]
        listing = ", ".join(map(repr, [*names[-1:], words[index]]))
        kind = "dates" if _DAY.fullmatch(words[index]) else "words"
        notes.append(f"column {index + 1} ({listing}) holds {kind} and is left out")

    def kept(line: str) -> str:
        cells = line.strip(" \r\f").split(dialect.delimiter)
        few_names = 2 * sum(map(is_heading, cells)) < width
        # "Heights in µm", "Ra 0.25 µm"
        is_sentence = dialect.delimiter is None and (few_names or bool(statements([line])))
        if not is_row(line) and (len(cells) != width or is_sentence):
            return line
        kept_cells = [cell for index, cell in enumerate(cells) if index not in columns | remarks]
        return (dialect.delimiter or " ").join(kept_cells)

    return [*map(kept, header)], [*map(kept, body)], notes


def _counted(body: list[str], delimiter: str | None) -> tuple[list[int], list[str]]:
    """Return the numbers of points alone in a line above the table (``23``, ``256 192``), and the table."""
    numbers = [number for number, line in enumerate(body[:50]) if line.strip()][:2]
    lines = [body[number].strip(" \r\f").rstrip((delimiter or "") + " ") for number in numbers]
    count_line, row = lines[0], lines[-1]
    counts = re.findall(r"\d+", count_line)
    only_counts = len(count_line) <= 40 and re.fullmatch(r"[1-9]\d*(?:[;,\s]+\d+)?", count_line)
    width = len(row[:_MAX_PREFIX].split(delimiter))
    # "5;" above "6;0.3" is a point without a height
    is_point = width == 2 and len(body[numbers[0]].strip(" \r\f").split(delimiter)) == width
    if not only_counts or width <= len(counts) or is_point:
        return [], body
    return [*map(int, counts)], body[numbers[0] + 1 :]


def _unquoted(header: list[str], body: list[str]) -> tuple[list[str], list[str]]:
    """Return header and table without the quotes that spreadsheets put around cells.

    Where there were quotes, semicolons separate the cells; entries of the header without quotes stay.
    """
    sample = next((line for line in body if line.strip()), "")
    if '"' not in sample[:_MAX_PREFIX]:
        return header, body
    if not all(line.endswith('""') for line in body):  # a cell of a missing point, at the end of a row
        body = [line.removesuffix('""') + '"NaN"' * line.endswith('""') for line in body]
    between_blanks = " " if re.search(r'"\s+[-+.\d"]', sample) else ","  # of R, and of a spreadsheet
    delimiter = next((sign for sign in ";\t" if sign in sample), between_blanks)
    cells_of = partial(csv.reader, delimiter=delimiter, skipinitialspace=True)
    try:
        lines = [";".join(next(cells_of([line]), [])) for line in (*header, *body)]
    except csv.Error:  # a cell of more than 131 072 characters
        return header, body
    separator_count = ";".join(next(cells_of([sample]))).count(";")
    for number, line in enumerate(header):
        is_row_of_names = lines[number].count(";") == separator_count and not re.search("[:=]", line)
        if '"' not in line and not is_row_of_names:
            lines[number] = line
    return lines[: len(header)], lines[len(header) :]


def separators(body: list[str], header: Sequence[str] = ()) -> Dialect:
    """Return the delimiter of the columns, and whether the decimal sign is a comma, also in the header."""
    sample = [line.strip() for line in body[:50] if is_row(line)]
    text = _DATE.sub("", "\n".join(sample))
    for sign in ";\t":
        if sign in text:
            is_doubled = all(line.count(sign) == 2 * line.count(2 * sign) > 0 for line in sample)
            comma = any(map(re.compile(r"\d,|,\d").search, body)) and not any(map(_GROUPS[","].search, body))
            return Dialect(2 * sign if is_doubled else sign, comma)
    if "," not in text:
        return Dialect(None, False)
    # two in a number, one at its end, or behind decimals
    separating = re.search(r",\S*,|,(?:\s|\Z)|\.(?!\d{3}[.,])\d*,", text)
    behind_blank = "." in text and re.search(r"\s,", text)
    # blanks separate the cells, so that a comma within one is a decimal sign
    if any(len(line.split()) > 1 for line in sample) and not separating and not behind_blank:
        return Dialect(None, True)
    one_comma = max(line.count(",") for line in sample) == 1
    leading_zero = re.search(r"(?<![\d:-])0\d", text)  # only decimals, dates and times begin so
    comma_above = any(map(re.compile(r"(?<![\d.,])(?:0,\d+|\d+,\d\d?) ?[^\W\d]").search, header))  # "0,5 µm"
    if "." not in text and one_comma and (leading_zero or comma_above):
        return Dialect(None, True)
    if "." not in text and (leading_zero or (one_comma and len(sample) > 1)):
        raise refusal("comma of two meanings", text=sample[0])
    return Dialect(",", False)


def split_footer(body: list[str], header: Sequence[str] = ()) -> tuple[list[str], list[str], Dialect]:
    """Return a table, the lines of words below it, and how the table is written.

    Examples
    --------
    >>> split_footer(["1.5;2.5", "3.5;4.5", "", "Ra;0,25;µm"])[:2]
    (['1.5;2.5', '3.5;4.5'], ['', 'Ra;0,25;µm'])
    """
    # upwards: a word among the last rows is one of the table, words below all of them are none
    stop = next((number for number in range(len(body), 0, -1) if is_row(body[number - 1])), len(body))
    table, footer = body[:stop], body[stop:]
    dialect = separators(table, header)
    width = len(table[-1].strip().split(dialect.delimiter))
    rows = [line for line in footer if line.strip() and word_in_row(line, width, dialect) is not None]
    if width <= 3 and all(line.strip()[0].isalpha() for line in rows):  # no position: "Mean;0.25"
        rows = []
    return (body, [], dialect) if rows else (table, footer, dialect)  # rows with unknown words


def _left_out_below(footer: list[str], start: int) -> list[str]:
    """Return a note on the lines below a table, but for comments and words that only say that it ends."""
    filled = ((number, line.strip()) for number, line in enumerate(footer, start) if _has_words(line))
    lines = [(number, text) for number, text in filled if not _is_end(text)]
    note = f" and {counted_noun(len(lines) - 1, 'line')} more" if len(lines) > 1 else ""
    return [f"below the table, line {lines[0][0]} ({lines[0][1][:60]!r}){note} is left out"] if lines else []


def _has_words(line: str) -> bool:
    """Return whether a line that is no row has something in it, and is no comment."""
    return bool(line.strip(_CELL_SEPARATORS)) and line.lstrip()[0] not in "#%"


def _is_end(line: str) -> bool:
    """Return whether a line only says that the table ends."""
    return len(line) < _MAX_CELL and re.sub(r"[\W_]+", " ", line).strip().lower() in _ENDS


def _is_empty_row(line: str) -> bool:
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
    if _ENTRY.match(line) or _is_end(line):
        return False
    cells = _cells(line, _FEW_CELLS)[:_FEW_CELLS]
    is_number = [_parse_number(cell) is not None for cell in cells]
    return 2 * sum(is_number) > len(cells) or (is_number[:1] == [True] and not is_missing(cells[0]))


def split_tables(header: list[str], body: list[str], start: int, dialect: Dialect) -> list[Rows]:
    """Return the tables of a text, which end at headings between rows; `start` numbers the first line.

    Empty lines and comments without entries are no headings.

    Examples
    --------
    >>> body = ["1 2", "3 4", "", "Phase", "5 6", "7 8"]
    >>> [(table.heading, table.lines) for table in split_tables([], body, 1, Dialect(None, False))]
    [([], [1, 2]), (['', 'Phase'], [5, 6])]
    """
    tables = [Rows(header, start - len(header), [], [])]
    gap_lines: list[str] = []
    width, is_separate = 0, True
    for number, line in enumerate(body, start=start):
        comment = line.lstrip()[:1] in ("#", "%")
        rule = not any(map(str.isalnum, line)) and any(text.strip() for text in gap_lines)
        if not ((is_row(line) and not rule) or (comment and word_in_row(line, width, dialect) is not None)):
            gap_lines.append(line)
            continue
        width = width or len(line.strip().split(dialect.delimiter))
        if tables[-1].lines:
            if any(map(_has_words, gap_lines)) or statements(gap_lines):
                tables.append(Rows(gap_lines, number - len(gap_lines), [], []))
                check_count(len(tables))
            elif gap_lines and not tables[-1].broken:
                tables[-1] = tables[-1]._replace(broken=number)
            is_separate = is_separate and bool(gap_lines)
        tables[-1].texts.append(line)
        tables[-1].lines.append(number)
        gap_lines = []
    for number, line in enumerate(gap_lines, start=start + len(body) - len(gap_lines)):
        if _has_words(line):
            raise _no_row(line, number)
    # an empty line below every row, as of some line ends, separates nothing; a longer gap does
    if is_separate and len(tables) == 1 and len(tables[0].lines) > 2:
        gaps = np.diff(tables[0].lines)
        tables[0] = tables[0]._replace(broken=tables[0].lines[gaps.argmax() + 1] if np.ptp(gaps) else 0)
    return [_add_label_row(table, dialect) for table in tables]


def _add_label_row(rows: Rows, dialect: Dialect) -> Rows:
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
    is_complete = _FEW_ROWS <= len(cells) == width - 1 and _parse_number(label) is None
    steps = np.diff(np.array([*map(dialect.number, cells)], dtype=float))
    even = steps.any() and np.ptp(steps) <= _UNEVEN * abs(steps.mean())  # also no word and no missing point
    if not (is_complete and even) or statements([line]):
        return rows
    texts = [(delimiter or " ").join(["NaN", *cells]) + closing, *rows.texts]
    return Rows(rows.heading[:-1], rows.first, texts, [rows.lines[0] - 1, *rows.lines], rows.broken, label)


def parse_table(rows: Rows, dialect: Dialect) -> tuple[np.ndarray, np.ndarray, bool, bool, list[str]]:
    """Return the numbers of a table, NaN for missing points and empty cells, and what is known of these.

    Known are the columns (n,) without any cell, whether the first cell is empty, whether the first row held a
    word there or lacked a cell, and notes on words with another meaning that are taken as missing.

    Examples
    --------
    >>> values, empty, *_ = parse_table(Rows([], 1, ["1,5;BAD;;", "2,5;3;;"], [1, 2]), Dialect(";", True))
    >>> values
    array([[1.5, nan, nan],
           [2.5, 3. , nan]])
    >>> empty
    array([False, False,  True])
    """
    delimiter = dialect.delimiter
    texts = [dialect.plain(line.strip(" \r\f" if delimiter == "\t" else None)) for line in rows.texts]
    if delimiter is not None:
        texts = _drop_closing_separators(texts, delimiter, rows.filled[-1][1] if rows.filled else "")
    numbers, counts, spoken = array("d"), array("q"), Counter[str]()
    for number, line, text in zip(rows.lines, rows.texts, texts, strict=True):
        row = _plain_numbers(text, delimiter)
        if row is None:
            cells = joined(text).split(delimiter)
            spoken.update(filter(is_spoken, map(str.strip, cells)))
            row = [value for cell in cells if (value := _parse_number(cell)) is not None]
            if len(row) < len(cells):
                bad = (cell for cell in line.split(delimiter) if dialect.number(cell) is None)
                raise _no_row(next(bad, line), number)
        numbers.extend(row)
        counts.append(len(row))
    if lacks_corner := _lacks_corner(counts):
        numbers.insert(0, np.nan)
        counts[0] += 1
    _refuse_unequal_rows(counts, rows.lines)
    check_points((len(counts), counts[0]))
    values = np.array(numbers).reshape(len(counts), counts[0])
    empty = np.isnan(values).all(axis=0) & (delimiter is not None and not lacks_corner)
    for text in texts if empty.any() else ():
        empty &= [not cell.strip() for cell in text.split(delimiter)]
    # a row above the table that a word keeps out of it would be a line of the map that is lost
    refuse_lost_row(rows, counts[0], dialect)
    cells_of = {word: counted_noun(count, "cell") for word, count in spoken.items()}
    advice = "is taken as missing: write NaN if the point is missing, or correct it"
    notes = [f"{word!r} occurs in {cells} of the table and {advice}" for word, cells in cells_of.items()]
    short = bool(rows.label) or lacks_corner
    return values, empty, short or not texts[0].split(delimiter)[0].strip(), short, notes


def _drop_closing_separators(texts: list[str], delimiter: str, heading: str) -> list[str]:
    """Return lines without a separator at their end that closes them, rather than leaves a last cell empty.

    It does where all lines end in one, where only the last line does, which is incomplete then, and where the
    rows have different lengths otherwise; not below a `heading` that names a last column of remarks, say.
    """
    has_separator = [text.endswith(delimiter) for text in texts]
    counts = array("q", [text.count(delimiter) for text in texts])
    names = [name.strip() for name in heading.split(delimiter)]
    is_named = {*counts} == {len(names) - 1} and all(has_separator) and names[-1]
    if is_named and any(map(is_heading, names)) and not is_heading(names[-1]):
        return texts
    if any(has_separator[:-1]) and not all(has_separator) and (len({*counts}) == 1 or _lacks_corner(counts)):
        return texts
    return [text.removesuffix(delimiter) for text in texts]


def _lacks_corner(counts: array) -> bool:
    """Return whether the first row has one cell less than all others: positions along x, without a corner."""
    return len(counts) > _FEW_ROWS and counts[0] + 1 == min(counts[1:]) == max(counts[1:])


def _no_row(cell: str, number: int) -> Exception:
    """Return the error for a line that is no row of a table, with the cell or line that is no number."""
    name = "row with thousands" if re.search(r"\d[.,'\s]\d{3}(?!\d)", cell) else "no row"
    return refusal(name, line=number, cell=brief(ValueError(cell)))


def _refuse_unequal_rows(counts: array, lines: list[int]) -> None:
    """Refuse rows of different lengths."""
    widths = Counter(counts)
    if len(widths) > 1:
        width = widths.most_common(1)[0][0]
        bad = next(index for index, count in enumerate(counts) if count != width)
        name = "cut row" if bad == len(counts) - 1 else "unequal row"
        numbers = counted_noun(counts[bad], "number")
        raise refusal(name, row=bad + 1, numbers=numbers, width=width, line=lines[bad])


def word_in_row(line: str, width: int, dialect: Dialect) -> str | None:
    """Return the first word in a line that is a row of a table of that `width` but for it, or None."""
    if not width or len(line) > width * _MAX_CELL:
        return None
    cells = dialect.cells(line)
    while len(cells) > width and not cells[-1]:
        cells.pop()
    comment = bool(cells[0]) and cells[0][0] in COMMENT_SIGNS
    # in a wide table a lost separator or a blank in a word makes one cell fewer or more
    if abs(len(cells) - width) > (width >= WIDE_TABLE and not comment) or (comment and len(cells[0]) > 1):
        return None
    values = [*map(dialect.number, cells)]
    non_numbers = [cell for cell, value in zip(cells, values, strict=True) if value is None]
    numbers = sum(bool(cell) for cell in cells) - len(non_numbers)
    has_word = bool(non_numbers) and _are_finite(values).any() and 2 * numbers > len(cells)
    is_marker = len(set(non_numbers)) == 1 < len(non_numbers) and len(cells) == width >= WIDE_TABLE
    is_marker = is_marker and any(map(str.isalnum, non_numbers[0])) and not is_heading(non_numbers[0])
    return non_numbers[0] if has_word or is_marker else None


def refuse_lost_row(rows: Rows, width: int, dialect: Dialect) -> None:
    """Refuse a table of `width` columns below a line that is one of its rows except for a word."""
    number, line = rows.filled[-1] if rows.filled else (0, "")
    stray_word = word_in_row(line, width, dialect) if line else None
    is_text = width <= 3 and (line.strip()[:1].isalpha() or line.strip()[:1] in COMMENT_SIGNS)
    if stray_word is None or is_text or re.search(r"[^\W\d]\s*[:=]", line) or statements([line]):
        return
    raise refusal("lost row", line=number, word=stray_word[:40])


def _are_finite(values: Iterable[float | None]) -> np.ndarray:
    """Return which of some values are finite numbers."""
    return np.isfinite(np.array([*values], dtype=float))


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
    values = [_parse_number(cell) for cell in cells]
    if not cells or None in values:
        return False
    phrase = is_spoken(cells[0]) or joined(line[:_MAX_PREFIX]) != line[:_MAX_PREFIX]
    is_entry = len(cells) <= 3 and cells[0][:1].isalpha() and phrase  # "Masked 12", of the header
    rule = "---" in line and not any(map(str.isalnum, line))  # a line drawn below headings
    return not is_entry and (bool(_are_finite(values).any()) or (len(values) > 1 and not rule))


def _cells(line: str, limit: int = 0) -> list[str]:
    """Return the cells of a line, after `limit` the rest; none of a comment, unlike ``#N/A`` or ``***``."""
    start = line[:_MAX_PREFIX].lstrip()
    text = joined(_DATE.sub("date", start)).strip(_CELL_SEPARATORS)
    cell = re.split(r"[;\t,\s]", start, maxsplit=1)[0]
    comment = start.startswith(tuple(COMMENT_SIGNS)) and not is_missing(cell)
    return [] if comment or not text else re.split(r'[;\t,\s"]+', text, maxsplit=limit)


def _parse_number(token: str) -> float | None:
    """Return the value of a token, NaN for one that stands for a missing point, None for any other word."""
    token = token.strip()
    if is_missing(token):
        return np.nan
    try:
        if "d" in token or "D" in token:
            token = _FORTRAN.sub(r"\1e\2", token)
        return float(token) if "_" not in token else None  # Python would read 1_000
    except ValueError:
        return float(re.sub(r"[^-+.\d]", "", token)) if _GROUPED.fullmatch(token) else None


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
    for column, cell in islice(cells, _MAX_COMPARED):
        text = cell.strip()
        if match := number.fullmatch(text):
            examples[bool(match[1])].setdefault(column, text)
            count += bool(match[1])
        elif text != "0" and not is_missing(text):
            return []
    lengths = [statement.text for meaning in LENGTHS for statement in by_meaning.get(meaning, [])]
    if count < _MIN_COUNT or any(re.search(rf"\d{re.escape(sign)}\d{{1,2}}(?!\d)", text) for text in lengths):
        return []
    example = next(iter(examples[True].values()))
    if conflict := examples[True].keys() & examples[False].keys():
        raise refusal("thousands or decimals", one=example, other=examples[False][min(conflict)], sign=sign)
    return [sentence("decimals or thousands", sign=sign, example=example)]


def _refuse_both_marks(body: list[str]) -> None:
    """Refuse points as separators of thousands, or decimals, in a table with decimal commas."""
    number = re.compile(r"(?<![\d.,])\d+([.,])(\d+)(?![\d.,eE])")
    if not any("." in line and number.search(line) for line in body):
        return
    matches = [match for line in body for match in number.finditer(line)]
    first_examples = {match[1]: match[0] for match in reversed(matches)}
    lengths = {mark: {len(match[2]) for match in matches if match[1] == mark} for mark in ".,"}
    if len(first_examples) == 2 and {3} in lengths.values():
        raise refusal("both marks", comma=first_examples[","], point=first_examples["."])
