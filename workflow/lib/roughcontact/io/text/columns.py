"""Roles and units of the columns of a text table, from their headings."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from roughcontact.io.guards import refusal
from roughcontact.io.text.header import MAX_LINE_LENGTH, statements
from roughcontact.io.units import is_length, same_length
from roughcontact.io.vocabulary import meanings, pattern, words

_MAX_DISTANCE = 20  # lines above the table that may contain headings
_ENTRY = re.compile(r"[^\W\d][.)\]]?\s*[:=]\s*[-+.]?\d")  # a number behind a word: no heading
# as a whole cell, or behind a separator that is not the table's
_VALUE = re.compile(r"(?:[-+]?[\d.,]+|.*\s\d+[.,]\d+)\s*(?:\[?[^\W\d_]+\]?)(?:/\w+)?|[-+]?\d[\d.,-]*|=")
_VALUE_BEHIND = re.compile(r"[^\W\d];\s*[-+.]?\d")
# before the names
_LABEL = re.compile(r"(?i)(?:columns?|fields|formats?|spalten|colonn[ei]s?|columnas)\b\s*[:=]?\s+(?!\d)")
# above a matrix, as ``Height (nm)``, ``z/nm``
_HEADING = re.compile(rf"[^:=\d]{{1,{MAX_LINE_LENGTH - 1}}}(?:[)\]]|/\s*[^\W\d]+)")
WIDE_TABLE = 8  # columns; so many with one heading are the columns of a map

# heading -> role of its column
_ROLE = meanings("column") | dict.fromkeys(words("header")["height"] + words("part")["height"], "z")
_DOTTED = re.compile(r"(\w+)\.+(\w+)\.?")  # as R writes "x (um)"
_ERROR = pattern("name", "error")  # of heights
_NO_NAMES = {"", *words("unit")["other"]}  # cells of a line of units that are no length
_BESIDE = "|".join(words("beside")["letter"])
_BLANKS_IN_NAMES = [  # of a word before the letter of an axis, or behind it
    re.compile(rf"\b((?:{_BESIDE})\.?) ([xyz])\b", re.IGNORECASE),
    re.compile(rf"\b([xyz]) ((?:{_BESIDE})\.?)(?!\w)", re.IGNORECASE),
]
_LETTER = re.compile(rf"(?:{_BESIDE})*([xyz])(?:{_BESIDE})*")  # "posx", "xcoordinate"


class Column(NamedTuple):
    """One column, by its heading without its unit."""

    name: str
    unit: str | None
    # `index` (also time), `valid` (0 at missing points), `parameter` (no position), `x`, `y`, `z`, or empty
    role: str


def headed(lines: Sequence[str], count: int, delimiter: str | None) -> list[Column] | None:
    """Return one entry per column by the line that names them, and units below; None without names.

    Examples
    --------
    >>> [tuple(column) for column in headed(["a trace", "X (µm);z/nm"], 2, ";")]
    [('X', 'µm', 'x'), ('z', 'nm', 'z')]
    >>> [tuple(column) for column in headed(["index,x in µm,y in µm"], 3, ",")]
    [('index', None, 'index'), ('x', 'µm', 'x'), ('y', 'µm', 'y')]
    >>> [tuple(column) for column in headed(["Distance Height", "mm µm"], 2, None)]
    [('Distance', 'mm', 'x'), ('Height', 'µm', 'z')]
    """
    units: list[str | None] = [None] * count
    nearest = None
    near_lines = lines[-_MAX_DISTANCE:]
    # upwards, so that units are known when the names above them are met
    for number, line in reversed([*enumerate(near_lines)]):
        if number > 1 and _are_names_above_units(near_lines[number - 2 : number], count, delimiter):
            continue  # of Origin: names, units and remarks
        cells = _cells(line, count, delimiter)
        columns = [_column(cell) for cell in cells]
        if not cells or (sum(map(bool, cells)) < min(count, 2) and not any(map(is_length, cells))):
            continue
        has_headings = any(column.unit or column.role for column in columns)
        for index, (column, unit) in enumerate(zip(columns, units, strict=True)):
            if column.unit and unit and not same_length(column.unit, unit):
                raise refusal("units below", text=line.strip()[:60], unit=column.unit, below=unit)
            columns[index] = column._replace(unit=column.unit or unit)
        if all(is_length(cell) or cell.strip("[]()").lower() in _NO_NAMES for cell in cells):
            units = [column.unit for column in columns]  # a line of units, below the names
        elif has_headings:
            corner, *named_columns = columns
            if not corner.name and not corner.unit and all(column.name for column in named_columns):
                columns[0] = corner._replace(role="index")
            roles = [column.role for column in columns]
            if number and all(roles) and not any(column.unit for column in columns):
                above = headed(near_lines[:number], count, delimiter) or columns  # "x in mm; z in nm"
                if [column.role for column in above] == roles:
                    pairs = zip(columns, above, strict=True)
                    columns = [column._replace(unit=other.unit) for column, other in pairs]
            return columns
        elif delimiter is not None and delimiter in line and nearest is None:
            nearest = columns
    return [Column("", unit, "") for unit in units] if any(units) else nearest


def _are_names_above_units(lines: Sequence[str], count: int, delimiter: str | None) -> bool:
    """Return whether the first of two lines names columns, and the other has the unit of each."""
    names, units = (_cells(line, count, delimiter) for line in lines)
    return bool(units) and all(map(is_length, units)) and any(map(_role, names))


def miscounted(line: str, count: int, delimiter: str | None) -> int:
    """Return how many columns a line names, where the table below it has another `count`; or 0.

    Examples
    --------
    >>> miscounted("x (um);y (um);z (um)", 4, ";"), miscounted("x (um);y (um);z (um)", 3, ";")
    (3, 0)
    """
    has_delimiter = delimiter is not None and delimiter in line
    only_units = statements([line]).keys() & {"lateral_unit", "height_unit"}
    if len(line) > MAX_LINE_LENGTH or re.search(r"\d[.,]\d", line) or only_units:
        return 0
    for width in sorted({*map(_filled, _divided(line, delimiter))} - {0, 1}):
        columns = [_column(cell) for cell in _cells(line, width, delimiter)]
        useful = [column for column in columns if column.role or column.unit]
        positions = any(column.role in ("x", "y") for column in useful)
        if 2 * len(useful) > width and len(useful) > 1 and (positions or has_delimiter):
            return width if width != count else 0
    return 0


def layout(columns: Sequence[Column]) -> list[list[int]]:
    """Return the columns of each profile or list of points, its heights last; none if headings do not say it.

    Without names of positions, a few columns of heights are profiles, two or three others positions and
    heights.

    Examples
    --------
    >>> layout([Column("index", None, "index"), Column("Weg", "mm", "x"), Column("Profil 1", "nm", "z")])
    [[1, 2]]
    >>> layout([Column(name, "nm", name[0]) for name in ("x", "z1", "z2")])
    [[0, 1], [0, 2]]
    """
    data = [index for index, column in enumerate(columns) if column.role not in ("index", "valid")]
    x, y = ([index for index in data if columns[index].role == axis] for axis in "xy")
    x, y = (y, x) if y and not x else (x, y)  # a profile along y
    if len(x) == len(data) == 2 or (len(x) == len(y) == 1 and len(data) == 2):
        return [x + y]  # a sensor above a stage, "position, distance"; "X (µm), y1"
    if len(x) == 1 and len(y) <= 1:
        return [[*x, *y, index] for index in data if index not in x + y]
    if len(x) > 1 and x == data[::2] and y in ([], data[1::2]) and len(data) == 2 * len(x):  # pairs x, z
        return [[*pair] for pair in zip(x, data[1::2], strict=True)]
    if data and all(columns[index].role == "z" for index in data) and len(data) < WIDE_TABLE:
        return [[index] for index in data]
    if len(data) == 3 and columns[data[-1]].role != "z" and any(columns[index].name for index in data):
        return []
    is_anonymous = not x and not y and not any(columns[index].role for index in data[:-1])
    return [data] if is_anonymous and len(data) in (2, 3) else []


def are_map_columns(columns: Sequence[Column]) -> bool:
    """Return whether headings are those of the columns of a map: many, and equal but for numbers."""
    headings = [column for column in columns if column.name and column.role != "index"]  # R numbers its rows
    distinct_headings = {(re.sub(r"[\W\d_]", "", column.name), column.unit) for column in headings}
    return len(distinct_headings) == 1 and len(columns) >= WIDE_TABLE


def unit_of_heights(line: str) -> str | None:
    """Return the unit in a heading above a matrix, as ``Height (nm)``; None for any other line."""
    text = line.strip(' \r\n\t"#%:')
    column = _column(text) if _HEADING.fullmatch(text) else Column("", None, "")
    is_height = column.role == "z" and not _ERROR.search(column.name)
    return column.unit if is_height and is_length(column.unit) else None


def is_heading(cell: str) -> bool:
    """Return whether a cell is a known heading or has a unit."""
    column = _column(cell)
    return bool(column.role or column.unit)


def _divided(line: str, delimiter: str | None) -> list[list[str]]:
    """Return the ways to divide a line of headings into cells, the strictest first."""
    text = line.strip(" \r\n").lstrip("#%/*").strip(" " if delimiter == "\t" else None)
    text = _LABEL.sub("", text)
    if len(text) > MAX_LINE_LENGTH or not text:
        return []
    if delimiter is not None and delimiter in text:
        cells = text.split(delimiter)
        names_and_units = cells[1::2] and all(map(is_length, cells[1::2])) and all(map(str.strip, cells[::2]))
        if len(cells) % 2 == 0 and names_and_units and not any(map(is_length, cells[::2])):
            cells = [" ".join(pair) for pair in zip(cells[::2], cells[1::2], strict=True)]  # "x, µm, z, nm"
        return [cells]
    if delimiter in (";", ",") and "\t" in text:
        return []  # an entry of a header
    words = text.split()
    wide = words if all(map(is_length, words)) else re.split(r"\t|\s\s+", text)
    narrow = re.sub(r"(?<!\s)\s+(?:(?=[(\[])|in\s+)", "\0", text).split()
    # "Position Y Height"
    return [wide, narrow, *(blank.sub("\\1\0\\2", " ".join(narrow)).split() for blank in _BLANKS_IN_NAMES)]


def _filled(cells: Sequence[str]) -> int:
    """Return the number of cells without the empty ones at the end."""
    return max((number for number, cell in enumerate(cells, start=1) if cell.strip()), default=0)


def _cells(line: str, count: int, delimiter: str | None) -> list[str]:
    """Return the cells of a line of headings; none if it is an entry, or if they are not `count`."""
    if _ENTRY.search(line) or (delimiter != ";" and _VALUE_BEHIND.search(line)):
        return []
    ways = _divided(line, delimiter)
    fitting = [cells[:count] if _filled(cells) <= count <= len(cells) else [] for cells in ways]
    if len(ways) > 1 and not any(fitting[:2]) and all(fitting[2:]) and fitting[2] != fitting[3]:
        raise refusal("names with blanks", text=line.strip()[:60])
    chosen = next(filter(None, fitting), [])
    cells = [cell.replace("\0", " ").strip(' "').rstrip(",;").strip() for cell in chosen]
    columns = [_column(cell) for cell in cells]
    known = sum(bool(column.role or column.unit) for column in columns)
    is_sentence = bool(ways) and chosen is not fitting[0] and 2 * known < count
    # "Y_um , X_um , Z_um" names columns, though its last cell alone would state a unit
    are_names = len(ways) == 1 and all(column.role and column.name.isalnum() for column in columns)
    if is_sentence or any(map(_VALUE.fullmatch, cells)) or not cells:
        return []
    return [] if not are_names and statements([line]) else cells


def _column(cell: str) -> Column:
    """Return name, unit and role of a heading such as ``x (µm)``, ``X_[mm]``, ``z/nm``, ``Lateral um``."""
    name, unit = _name_and_unit(cell)
    return Column(name, unit, _role(name))


def _role(name: str) -> str:
    """Return the role of a column by its name: the letter of an axis, all of it, or its first word."""
    name_parts = re.split(r"[\s_]+", name.lower())
    full_name = re.sub(r"[\W_]", "", "".join(name_parts))
    if full_name[:1].isdigit():  # "50x" of a lens
        return ""
    if letter := _LETTER.fullmatch("".join(filter(str.isalpha, full_name))):
        return letter[1]
    spellings = (full_name, *("".join(filter(str.isalpha, text)) for text in (full_name, name_parts[0])))
    roles = (_ROLE[spelling] for spelling in spellings if spelling in _ROLE)
    return "index" if name == "#" else next(roles, "")


def _name_and_unit(cell: str) -> tuple[str, str | None]:
    """Return a heading without its unit, and the unit."""
    if (dotted := _DOTTED.fullmatch(cell)) and is_length(dotted[2]):
        cell = f"{dotted[1]} ({dotted[2]})"
    if is_length(cell):
        return "", cell
    name, opening, remainder = cell.replace("[", "(").partition("(")
    inside, closing, tail = remainder.replace("]", ")").partition(")")
    unit = inside.strip()
    if opening and closing and unit and not unit.isdigit() and (name or tail or is_length(unit)):
        return f"{name} {tail}".strip(" _"), unit
    if "/" in cell:
        name, _, unit = cell.rpartition("/")
        if is_length(unit.strip()) or (" " not in unit.strip() and _role(name) in ("x", "y", "z")):
            return name.strip(), unit.strip()
    head, *parts = re.split(r"[\s_,:]+", cell.strip())
    for start in (len(parts) - 2, len(parts) - 1):  # "1e-6 m" before "m"
        unit = " ".join(parts[start:]) if start >= 0 else ""
        if is_length(unit):
            name_words = [head, *parts[:start]]
            if parts[:start] and name_words[-1].lower() == "in":
                name_words.pop()
            return " ".join(name_words), unit
    if parts and is_length(head) and head != "in":  # "µm x"
        return " ".join(parts), head
    return cell, None
