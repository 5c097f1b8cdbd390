"""Roles and units of the columns of a text table, from their headings."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from roughcontact.io.units import is_length

_MAX_LINE_LENGTH = 4096  # characters of a line of headings
_MAX_DISTANCE = 20  # lines above the table that may contain headings

# role of a column -> headings (lower case, letters only)
_ROLES = {
    "index": ("index", "idx", "no", "nr", "number", "nummer", "numéro", "point", "punkt", "id", "n", "row"),
    "valid": ("valid", "validity", "isvalid", "gültig", "flag"),
    "x": (
        *("x", "xpos", "xposition", "xcoordinate", "xaxis", "lateral", "lateralposition", "position", "pos"),
        *("distance", "length", "scanlength", "scanposition", "traverse", "travel", "abscissa"),
        *("abstand", "weg", "strecke", "länge", "messweg", "abszisse", "distanz", "longueur", "distancia"),
    ),
    "y": ("y", "ypos", "yposition", "ycoordinate", "yaxis"),
    "z": (
        *("z", "zpos", "zposition", "zcoordinate", "zaxis", "height", "heights", "topography", "elevation"),
        *(
            "raw",
            "rawprofile",
            "profile",
            "primary",
            "roughness",
            "waviness",
            "leveled",
            "levelled",
            "zheight",
        ),
        *("höhe", "hoehe", "höhenwert", "profil", "hauteur", "altura", "altezza", "rohprofil"),
    ),
}
_ROLE = {name: role for role, names in _ROLES.items() for name in names}


class Column(NamedTuple):
    """One column, by its heading.

    The name is the heading without its unit. The role is ``index``, ``valid`` (0 at missing points), ``x``,
    ``y``, ``z``, or empty where the name says none of these.
    """

    name: str
    unit: str | None
    role: str


def headed(lines: Sequence[str], count: int, delimiter: str | None) -> list[Column] | None:
    """Return one entry per column of a table from the header line that names them, and a line of units below.

    A `delimiter` of None stands for white space. The result is None where no line names the columns.

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
    for line in reversed(lines[-_MAX_DISTANCE:]):
        cells = _cells(line, count, delimiter)
        if cells is None:
            continue
        found = [_column(cell) for cell in cells]
        if not any(column.name for column in found):  # a line of units, below the names
            if any(column.unit for column in found) and not any(units):
                units = [column.unit for column in found]
        elif any(column.unit or column.role for column in found):
            return _indexed(
                [column._replace(unit=column.unit or unit) for column, unit in zip(found, units, strict=True)]
            )
        elif delimiter is not None and delimiter in line and nearest is None:
            nearest = found
    if any(units):
        return [Column("", unit, "") for unit in units]
    return nearest


def unit_of_heights(lines: Sequence[str]) -> str | None:
    """Return the unit in a heading above a matrix, as ``Height (nm)``.

    None where no line among the last ones of the header is such a heading.

    Examples
    --------
    >>> unit_of_heights(["Monday", "Height Sensor(nm)"]), unit_of_heights(["Height: 12 nm"])
    ('nm', None)
    """
    for line in reversed(lines[-_MAX_DISTANCE:]):
        text = line.strip(' \r\n\t"#%')
        if (
            len(text) <= _MAX_LINE_LENGTH
            and text.endswith((")", "]"))
            and not set(text) & set(":=0123456789")
        ):
            column = _column(text)
            if column.role == "z" and is_length(column.unit):
                return column.unit
    return None


def is_heading(cell: str) -> bool:
    """Return whether a cell is a known heading or has a unit."""
    column = _column(cell)
    return bool(column.role or column.unit)


def _indexed(columns: list[Column]) -> list[Column]:
    """Return the columns; a first column without a heading among others with headings is a row index."""
    first = columns[0]
    if first.name or first.unit or not all(column.name for column in columns[1:]):
        return columns
    return [first._replace(role="index"), *columns[1:]]


def _cells(line: str, count: int, delimiter: str | None) -> list[str] | None:
    """Return the cells of a line, or None if their number is not that of the columns."""
    text = line.strip(" \r\n").lstrip("#%").strip(" " if delimiter == "\t" else None)
    if len(text) > _MAX_LINE_LENGTH or not text:
        return None
    delimited = delimiter is not None and delimiter in text
    cells = text.split(delimiter) if delimited else re.split(r"\t|\s\s+", text)
    while len(cells) > count and not cells[-1].strip():
        cells.pop()
    if len(cells) != count and not delimited:
        cells = re.sub(r"\s+(?=[(\[])|\s+in\s+", "\0", text).split()
        cells = [cell.replace("\0", " ") for cell in cells]
    if len(cells) != count:
        return None
    return [cell.strip().strip('"').strip() for cell in cells]


def _column(cell: str) -> Column:
    """Return name, unit and role of a heading such as ``x (µm)``, ``X_[mm]``, ``z/nm``, ``Lateral um``."""
    name, unit = _name_and_unit(cell)
    words = re.split(r"[\s_]+", name.lower())
    whole, first = ("".join(filter(str.isalpha, text)) for text in ("".join(words), words[0]))
    role = "index" if name == "#" else _ROLE.get(whole, _ROLE.get(first, ""))
    return Column(name, unit, role)


def _name_and_unit(cell: str) -> tuple[str, str | None]:
    """Return a heading without its unit, and the unit."""
    if is_length(cell):
        return "", cell
    name, opening, rest = cell.replace("[", "(").partition("(")
    inside, closing, after = rest.replace("]", ")").partition(")")
    if opening and closing and inside.strip():
        return f"{name} {after}".strip(" _"), inside.strip()
    if "/" in cell:
        name, _, unit = cell.rpartition("/")
        if unit.strip() and " " not in unit.strip():
            return name.strip(), unit.strip()
    words = re.split(r"[\s_,:]+", cell.strip())
    if len(words) > 1 and is_length(words[-1]):
        kept = words[:-2] if words[-2].lower() == "in" and len(words) > 2 else words[:-1]
        return " ".join(kept), words[-1]
    if len(words) > 1 and is_length(words[0]) and words[0] != "in":  # "µm x"
        return " ".join(words[1:]), words[0]
    return cell, None
