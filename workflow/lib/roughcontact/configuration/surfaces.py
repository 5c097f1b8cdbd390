"""The table of surfaces: which file is which surface, and what the file itself does not say.

A tab-separated text with a header; columns `surface` and `path`, optionally `channel`, `dx`, `dy`, `unit`,
`height_unit`, `resample`; empty cells mean "as the file says". Lines that start with # are left out.

A row that names a `counter_face` is a pair: two measured files that touch. Its files are read and levelled
as `{surface}-face` and `{surface}-counter-face`; what is solved are its members `{surface}-1`,
`{surface}-2` ..., the ways in which the one lies on the other (`roughcontact.faces.composite`).
"""

import math
from dataclasses import dataclass
from pathlib import Path

from roughcontact.configuration.models import NAME, NAME_RULE, nearest
from roughcontact.errors import SettingsError

REQUIRED = ("surface", "path")
NUMBERS = ("dx", "dy")
TEXTS = ("channel", "unit", "height_unit", "resample")
PAIR = "counter_face"
COLUMNS = (*REQUIRED, PAIR, *TEXTS, *NUMBERS)


@dataclass(frozen=True)
class Surface:
    """One row of the table: `name`, where the file lies, and what overrides or completes it."""

    name: str
    path: Path  # as found; where there is no such file, as the table says
    origin: str  # table and line, for messages
    given: dict  # keyword arguments of read_height_map
    counter_face: Path | None = None  # the other file of a pair


@dataclass(frozen=True)
class Member:
    """One way in which the faces of a pair lie on one another."""

    pair: str  # name in the table
    number: int  # from 1
    face: str  # names of the measured surfaces
    counter_face: str


def find(path: str | Path, folders) -> Path | None:
    """Return the first existing file among `folder / path`, None where there is none.

    An absolute path is taken as it is; a path in the working directory stays relative, so that nothing that
    is recorded depends on where that directory lies.
    """
    for folder in folders:
        candidate = Path(folder) / path
        if candidate.is_file():
            return candidate
    return None


def read_surfaces(table: str | Path, folders=(".",)) -> dict[str, Surface]:
    """Read the table of surfaces.

    Parameters
    ----------
    table
        path of the tab-separated file.
    folders
        where relative paths of the table are looked for, in this order; the table's own folder comes second.

    Returns
    -------
    dict
        name -> Surface, in the order of the table. A height map that does not exist is no mistake of the
        table: its own job reports it and the other surfaces run.

    Raises
    ------
    SettingsError
        one message that lists all mistakes, each with its line, the value and the way out.
    """
    table = Path(table)
    try:
        lines = table.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(
            f"table of surfaces {table}: not readable ({error}); name a tab-separated text as `surfaces`"
        ) from error
    folders = [folders[0], table.parent, *folders[1:]]
    rows = [
        (n, line.split("\t")) for n, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")
    ]
    if not rows:
        raise SettingsError(
            f"table of surfaces {table}: is empty; write a header (surface, path) and one row each"
        )
    (_, header), *rows = rows
    header = [name.strip() for name in header]
    mistakes = _mistakes_in_header(header)
    if not mistakes and not rows:
        mistakes.append("has no row; add one line with the name and the path of each surface")
    surfaces = {}
    for line, cells in rows if not mistakes else ():
        if any(cell.strip() for cell in cells[len(header) :]):
            mistakes.append(f"line {line}: {len(cells)} cells, the header has {len(header)}")
        row = dict(zip(header, (cell.strip() for cell in cells), strict=False))
        given = {key: row[key] for key in TEXTS if row.get(key)}
        given |= {key: _number(row[key], f"line {line}, {key}", mistakes) for key in NUMBERS if row.get(key)}
        name, path = row["surface"], row.get("path", "")
        if not NAME.fullmatch(name):
            mistakes.append(f"line {line}, surface = {name!r}: a name has {NAME_RULE} (it becomes a folder)")
        if name in surfaces:
            mistakes.append(
                f"line {line}, surface = {name}: stands twice (also {surfaces[name].origin}); rename one"
            )
        if not path:
            mistakes.append(f"line {line}, path: is empty; give the file of surface {name}")
        counter = row.get(PAIR)
        surfaces[name] = Surface(
            name,
            find(path, folders) or Path(path),
            f"{table}, line {line}",
            given,
            (find(counter, folders) or Path(counter)) if counter else None,
        )
    if mistakes:
        raise SettingsError(
            "\n".join([f"mistakes in the table of surfaces {table}:", *(f"  {m}" for m in mistakes)])
        )
    return surfaces


def measured(surfaces: dict[str, Surface]) -> dict[str, Surface]:
    """Return name -> surface of every measured file: of a pair its face and its counter-face."""
    files = {}
    for name, row in surfaces.items():
        if row.counter_face is None:
            files[name] = row
            continue
        for side, path in (("face", row.path), ("counter-face", row.counter_face)):
            files[f"{name}-{side}"] = Surface(f"{name}-{side}", path, row.origin, row.given)
    return files


def members(surfaces: dict[str, Surface], count: int) -> dict[str, Member]:
    """Return name -> member of the ensembles of all pairs, `count` of each.

    Raises
    ------
    SettingsError
        where a surface of the table has the name of a member or of a face of a pair.
    """
    found = {
        f"{name}-{number}": Member(name, number, f"{name}-face", f"{name}-counter-face")
        for name, row in surfaces.items()
        if row.counter_face is not None
        for number in range(1, count + 1)
    }
    made = {*found, *(name for member in found.values() for name in (member.face, member.counter_face))}
    for name in surfaces:
        if name in made:
            pair = name.rpartition("-counter-face")[0] or name.rpartition("-")[0]
            raise SettingsError(
                f"table of surfaces, {surfaces[name].origin.rpartition(', ')[2]}, surface = {name}: the pair "
                f"{pair} needs this name for one of its parts; rename one"
            )
    return found


def _mistakes_in_header(header) -> list[str]:
    """Return what is wrong with the column names."""
    if len(header) == 1 and any(mark in header[0] for mark in ",; "):
        return [f"header {header[0]!r}: columns are separated by tabs, nothing else"]
    mistakes = [
        f"column {name!r}: unknown, {nearest(name, COLUMNS)}" for name in header if name not in COLUMNS
    ]
    mistakes += [f"column {name!r}: missing, the header needs it" for name in REQUIRED if name not in header]
    return mistakes + [
        f"column {name!r}: stands twice" for name in dict.fromkeys(header) if header.count(name) > 1
    ]


def _number(text: str, where: str, mistakes: list[str]) -> float:
    """Return a positive number, or add to the mistakes."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (0 < value < math.inf):
        mistakes.append(f"{where} = {text!r}: must be a number greater than 0 (decimal point, no unit)")
    return value
