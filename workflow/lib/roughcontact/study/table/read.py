"""Reading the table of surfaces: the file of each surface, and information that is not in the file."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from roughcontact.arguments.settings.messages import name_mistake, nearest, reason
from roughcontact.arguments.settings.models import Instrument
from roughcontact.arguments.units import carries_unit
from roughcontact.errors import SettingsError
from roughcontact.study.places import find_file
from roughcontact.study.table import columns
from roughcontact.study.table.cut_maps import mistakes_in_parts, with_parts
from roughcontact.study.table.groups import mistakes_in_groups
from roughcontact.study.table.overviews import read_overviews
from roughcontact.study.table.pairs import mistakes_in_names, with_faces
from roughcontact.study.table.profiles import mistakes_in_profiles, with_profiles
from roughcontact.study.table.row import Mistake, Surface, in_cell
from roughcontact.study.table.same_area import mistakes_in_areas, with_other_maps
from roughcontact.study.table.text import read_table


def read_surfaces(
    table: str | Path,
    folders: Sequence[str | Path] = (".",),
    *,
    files_exist: bool = False,
) -> dict[str, Surface]:
    r"""Read the table of surfaces (tab-separated): name -> Surface, in the order of the table.

    `folders` and the table's own are searched; all files must exist with `files_exist`. A `SettingsError`
    lists all mistakes, each with its line.
    """
    table = Path(table)
    header, rows = read_table(table)
    mistakes = [*map(SettingsError, _mistakes_in_header(header))]
    is_readable = {*columns.REQUIRED} <= {*header} and len({*header}) == len(header)
    if not mistakes and not rows:
        mistakes.append(SettingsError("has no row; add one line with the name and the path of each surface"))
    folders = [folders[0], table.parent, *folders[1:]]
    surfaces: dict[str, Surface] = {}
    in_small_letters: dict[str, Surface] = {}
    for line, cells in rows if is_readable else ():
        if any(cells[len(header) :]):
            mistakes.append(SettingsError(f"line {line}: {len(cells)} cells, the header has {len(header)}"))
        row = dict.fromkeys(columns.COLUMNS, "") | dict(zip(header, cells, strict=False))
        surface, doubts = _read_row(row, folders, origin=f"{table}, line {line}", line=line)
        doubts = [*_mistakes_in_name(surface, in_small_letters), *columns.mistakes_in_cells(row), *doubts]
        doubts += _missing_files(surface) if files_exist else ()
        mistakes += [in_cell(surface, *doubt) for doubt in doubts]
        surfaces[surface.name] = in_small_letters[surface.name.lower()] = surface
    for mistakes_in in (mistakes_in_areas, mistakes_in_parts, mistakes_in_profiles):
        mistakes += mistakes_in(surfaces)
    if not mistakes:
        surfaces = with_profiles(with_parts(surfaces))
    mistakes += [*mistakes_in_groups(surfaces), *mistakes_in_names(surfaces)]
    if mistakes:
        raise SettingsError(
            "\n".join([f"mistakes in the table of surfaces {table}:", *(f"  {m}" for m in mistakes)]),
            mistakes=mistakes,
        )
    return with_other_maps(surfaces)


def measured(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return every measured file, name -> Surface: of a pair its face and its counter-face."""
    return {file.name: file for row in surfaces.values() for file in row.files()}


def _mistakes_in_header(header: Sequence[str]) -> Iterator[str]:
    """Yield the mistakes in the column names."""
    if len(header) == 1 and any(mark in header[0] for mark in ",; "):
        yield f"header {header[0]!r}: columns are separated by tabs, nothing else"
        return
    yield from (
        f"column {name!r}: unknown, {nearest(name, columns.COLUMNS)}"
        for name in header
        if name not in columns.COLUMNS
    )
    yield from (
        f"column {name!r}: missing, the header needs it" for name in columns.REQUIRED if name not in header
    )
    yield from (f"column {name!r}: occurs twice" for name, count in Counter(header).items() if count > 1)


def _mistakes_in_name(row: Surface, above: Mapping[str, Surface]) -> Iterator[Mistake]:
    """Yield what is wrong with the name of a surface; `above` has the rows above by name in small letters."""
    if wrong := name_mistake(row.name):
        yield "surface", f"surface = {row.name!r}: {wrong}"
    # names that differ in capitals are one folder on macOS and Windows
    if namesake := above.get(row.name.lower()):
        how = "" if namesake.name == row.name else f" but for capitals, as {namesake.name}"
        yield "surface", f"surface = {row.name}: occurs twice{how} (also {namesake.origin}); rename one"


def _read_row(
    row: Mapping[str, str], folders: Sequence[str | Path], *, origin: str, line: int
) -> tuple[Surface, list[Mistake]]:
    """Return the surface of a row, and what is wrong with cells that are read together."""

    def file(path: str) -> Path:
        return find_file(path, folders) or Path(path)

    arguments: dict[str, Any] = {key: row[key] for key in columns.TEXTS if row[key]}
    instrument, mistakes = _instrument(row)
    arguments |= {"instrument": instrument} if instrument else {}
    lengths = {key: row[key] for key in columns.NUMBERS if row[key]}
    arguments |= {key: text if carries_unit(text) else columns.length(text) for key, text in lengths.items()}
    path = file(row["path"]) if row["path"] else Path()
    if path == Path():
        mistakes.append(
            ("path", f"path = {row['path']!r}: names no file; give that of surface {row['surface']}")
        )
    overviews, mistakes_in_overviews = read_overviews(row, arguments, path, file)
    arguments |= {columns.OVERVIEW: overviews} if overviews else {}
    cells: dict[str, Any] = {key: row[key] for key in columns.OF_SURFACES}
    specimen = row[columns.SPECIMEN]
    surface = Surface(row["surface"], path, origin, arguments, specimen=specimen, line=line, **cells)
    return with_faces(surface, row, file), mistakes + mistakes_in_overviews


def _instrument(row: Mapping[str, str]) -> tuple[dict[str, float], list[Mistake]]:
    """Return what a row says of its instrument, in SI units, and what is wrong with that."""
    cells = {key: row[key] for key in columns.INSTRUMENT if row[key]}
    try:
        return Instrument.model_validate(cells).model_dump(include={*cells}), []
    except ValidationError as error:
        mistakes = []
        for detail in error.errors():
            key = str(detail["loc"][0])
            where: Any = {"loc": ("instrument", key), "input": cells[key]}
            mistakes.append((key, f"{key}{reason({**detail, **where})}"))
        return {}, mistakes


def _missing_files(row: Surface) -> list[Mistake]:
    """Return the mistakes of a row in names of files that do not exist."""
    paths = [*zip(("path", columns.PAIR), (file.path for file in row.files()), strict=False)]
    paths += [
        (columns.OVERVIEW, Path(overview["path"]))
        for overview in row.read_arguments.get(columns.OVERVIEW, ())
    ]
    return [
        (key, f"{key} = {str(path)!r}: no such file; correct the path or put # before the row")
        for key, path in paths
        if (key, path) != ("path", Path()) and find_file(path, ["."]) is None
    ]
