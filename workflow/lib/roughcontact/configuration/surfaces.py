"""The table of surfaces: the file of each surface, and information that is not in the file.

A row that names a `counter_face` is a pair: its files are read as `{surface}-face` and
`{surface}-counter-face`, its placements `{surface}-1`, `{surface}-2` ... are solved. A row with `parts` (2x2)
is a map that is cut: its tiles `{surface}-1-1`, `{surface}-2-1` ... (along x, along y) are surfaces of their
own, in its group. Profiles along a lay are no surfaces: those across it in their group are solved with them.
"""

import codecs
import math
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from roughcontact.configuration.messages import name_mistake, nearest, reason
from roughcontact.configuration.models import Instrument
from roughcontact.configuration.tiles import tiles_of
from roughcontact.errors import SettingsError
from roughcontact.units import carries_unit, in_base_unit

REQUIRED = ("surface", "path")
NUMBERS = ("dx", "dy")
TEXTS = ("channel", "unit", "height_unit", "resample", "checksum", "first_row", "missing_value", "lay")
PAIR = "counter_face"
PAIR_FIRST_ROW = "counter_face_first_row"
INSTRUMENT = tuple(
    key for key in Instrument.model_fields if key not in ("finer_spectrum", "correct")
)  # prevail over the settings
REPEAT = "repeat_of"  # the same place measured with nothing done in between: the noise of both follows
BEFORE = "before"  # the same place before something was done to it: their difference is the result
GROUP, SPECIMEN, TILES = "group", "part", "parts"
_OWN = (GROUP, SPECIMEN, TILES, PAIR, PAIR_FIRST_ROW, BEFORE, REPEAT)
COLUMNS = (*REQUIRED, *_OWN, *TEXTS, *NUMBERS, *INSTRUMENT)


@dataclass(frozen=True)
class Surface:
    """One row of the table."""

    name: str  # of the surface and of its folder of results
    path: Path  # the measured file; as in the table where there is no such file
    origin: str  # table and line, for messages
    read_arguments: dict[str, Any]  # keyword arguments of `read_height_map`
    counter_face: Path | None = None  # the other file of a pair
    counter_face_first_row: str = ""  # empty: as in the file
    group: str = ""  # the finish
    specimen: str = ""  # empty where it is of a specimen of its own
    repeat_of: str = ""  # surface of the same area, measured with nothing done in between
    before: str = ""  # surface of the same area before something was done to it


@dataclass(frozen=True)
class Placement:
    """One relative position of the faces of a pair."""

    pair: str  # its name in the table
    number: int  # from 1
    face: str  # names of the two measured surfaces
    counter_face: str


def find(path: str | Path, folders: Iterable[str | Path]) -> Path | None:
    """Return the first existing file among `folder / path`, None where there is none."""
    for folder in folders:
        # relative in the working directory: recorded paths do not depend on where that is
        candidate = Path(folder) / path
        if os.path.isfile(candidate):  # noqa: PTH113 - false also of a path that is too long
            return candidate
    return None


def read_surfaces(
    table: str | Path,
    folders: Sequence[str | Path] = (".",),
    *,
    check: Callable[[Surface], list[str]] | None = None,
    placements_each: int = 0,
) -> dict[str, Surface]:
    r"""Read the table of surfaces (tab-separated): name -> Surface, in the order of the table.

    `folders` and the table's own are searched; `check` returns further mistakes of a row, and no row may have
    the name of one of `placements_each` placements. A `SettingsError` lists all mistakes, each with its line.
    """
    table = Path(table)
    header, rows = read_table(table)
    mistakes = [*_mistakes_in_header(header)]
    readable = {*REQUIRED} <= {*header} and len({*header}) == len(header)
    if not mistakes and not rows:
        mistakes.append("has no row; add one line with the name and the path of each surface")
    folders = [folders[0], table.parent, *folders[1:]]
    surfaces: dict[str, Surface] = {}
    before: dict[str, Surface] = {}
    cuts: dict[str, str] = {}
    for line, cells in rows if readable else ():
        row = dict(zip(header, cells, strict=False))
        if any(cells[len(header) :]):
            mistakes.append(f"line {line}: {len(cells)} cells, the header has {len(header)}")
        wrong = [*_mistakes_in_row(row, before)]
        stated = _instrument(row, wrong)
        read_arguments: dict[str, Any] = {key: row[key] for key in TEXTS if row.get(key)}
        read_arguments |= {"instrument": stated} if stated else {}
        read_arguments |= {
            key: row[key] if carries_unit(row[key]) else _length(row[key]) for key in NUMBERS if row.get(key)
        }
        path, counter_face = (
            (find(row[key], folders) or Path(row[key])) if row.get(key) else None for key in ("path", PAIR)
        )
        surface = Surface(
            row.get("surface", ""),
            path or Path(),
            f"{table}, line {line}",
            read_arguments,
            counter_face,
            *(row.get(key, "") for key in (PAIR_FIRST_ROW, GROUP, SPECIMEN, REPEAT, BEFORE)),
        )
        surfaces[surface.name] = before[surface.name.lower()] = surface
        if row.get(TILES):
            cuts[surface.name] = row[TILES]
        mistakes += [f"line {line}, {text}" for text in (*wrong, *(check(surface) if check else ()))]
    mistakes += _mistakes_in_areas(surfaces)
    mistakes += _mistakes_in_tiles(surfaces, cuts)
    mistakes += _mistakes_in_profiles_along(surfaces)
    if not mistakes:
        surfaces = _with_profiles_along(_with_tiles(surfaces, cuts))
    mistakes += _mistakes_in_groups(surfaces)
    if placements_each:
        mistakes += _names_of_faces(surfaces, placements(surfaces, placements_each))
    if mistakes:
        raise SettingsError(
            "\n".join([f"mistakes in the table of surfaces {table}:", *(f"  {m}" for m in mistakes)])
        )
    return _with_repeats(surfaces)


def measured(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return every measured file, name -> Surface: of a pair its face and its counter-face."""
    files = {}
    for name, row in surfaces.items():
        if row.counter_face is None:
            files[name] = row
            continue
        counter = {key: value for key, value in row.read_arguments.items() if key != "first_row"}
        counter |= {"first_row": row.counter_face_first_row} if row.counter_face_first_row else {}
        face, counter_face = f"{name}-face", f"{name}-counter-face"
        files[face] = Surface(face, row.path, row.origin, row.read_arguments)
        files[counter_face] = Surface(counter_face, row.counter_face, row.origin, counter)
    return files


def placements(surfaces: Mapping[str, Surface], count: int) -> dict[str, Placement]:
    """Return the placements of all pairs, name -> Placement, with `count` placements of each pair."""
    return {
        f"{name}-{number}": Placement(name, number, f"{name}-face", f"{name}-counter-face")
        for name, row in surfaces.items()
        if row.counter_face is not None
        for number in range(1, count + 1)
    }


def _names_of_faces(
    surfaces: Mapping[str, Surface], placements_of_pairs: Mapping[str, Placement]
) -> Iterator[str]:
    """Yield the mistakes of surfaces and groups that have the name of a member or of a face of a pair."""
    reserved = {
        needed.lower(): placement.pair
        for name, placement in placements_of_pairs.items()
        for needed in (name, placement.face, placement.counter_face)
    }
    for column, rows in (("surface", surfaces), (GROUP, first_rows(surfaces))):
        for name, row in rows.items():
            if pair := reserved.get(name.lower()):
                yield (
                    f"{_line(row)}, {column} = {name}: the pair {pair} needs this name for one of its "
                    "parts; rename one"
                )


def read_table(table: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Return the header, and the cells of each further row with the number of its line, unchecked."""
    try:
        content = table.read_bytes()
        marked = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))  # as spreadsheets write it
        lines = content.decode("utf-16" if marked else "utf-8-sig").splitlines()
    except FileNotFoundError as error:
        raise SettingsError(
            f"table of surfaces {table}: no such file; correct `surfaces` in the settings, or write the "
            "table (`roughcontact init` writes one to change)"
        ) from error
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise SettingsError(
            f"table of surfaces {table}, line {line}: is no text in UTF-8 ({error.reason}); save it as UTF-8"
        ) from error
    except OSError as error:
        raise SettingsError(
            f"table of surfaces {table}: not readable ({error}); name a tab-separated text as `surfaces`"
        ) from error
    rows = [
        (number, [cell.strip() for cell in line.split("\t")])
        for number, line in enumerate(lines, 1)
        if line.strip() and not line.startswith("#")
    ]
    if not rows:
        raise SettingsError(
            f"table of surfaces {table}: is empty; write a header (surface, path) and one row each"
        )
    (_, header), *rows = rows
    return header, rows


def table_text(rows: Sequence[Mapping[str, str]]) -> str:
    r"""Return the text of a table with the columns that have a cell in any of the rows.

    Examples
    --------
    >>> table_text([{"surface": "ground", "path": "ground.txt", "unit": "", "dx": "1 um"}])
    'surface\tpath\tdx\nground\tground.txt\t1 um\n'
    """
    used = {column for row in rows for column, cell in row.items() if cell.strip()} - {*REQUIRED}
    header = [*REQUIRED, *(name for name in COLUMNS if name in used), *sorted(used - {*COLUMNS})]
    lines = [header, *([" ".join(row.get(name, "").split()) for name in header] for row in rows)]
    return "".join("\t".join(line) + "\n" for line in lines)


def _mistakes_in_header(header: Sequence[str]) -> Iterator[str]:
    """Yield the mistakes in the column names."""
    if len(header) == 1 and any(mark in header[0] for mark in ",; "):
        yield f"header {header[0]!r}: columns are separated by tabs, nothing else"
        return
    yield from (
        f"column {name!r}: unknown, {nearest(name, COLUMNS)}" for name in header if name not in COLUMNS
    )
    yield from (f"column {name!r}: missing, the header needs it" for name in REQUIRED if name not in header)
    yield from (f"column {name!r}: occurs twice" for name, count in Counter(header).items() if count > 1)


def _mistakes_in_row(row: Mapping[str, str], before: Mapping[str, Surface]) -> Iterator[str]:
    """Yield the mistakes in the cells of one row; `before` has the rows above by name in small letters."""
    name = row.get("surface", "")
    for key in NUMBERS:
        if row.get(key) and not 0 < _length(row[key]) < math.inf:
            yield (
                f"{key} = {row[key]!r}: must be a number greater than 0 (decimal point), in `unit` or "
                "with its own unit behind it (1.5 um)"
            )
    if wrong := name_mistake(name):
        yield f"surface = {name!r}: {wrong}"
    if first := before.get(name.lower()):  # names that differ in capitals are one folder on macOS and Windows
        how = "" if first.name == name else f" but for capitals, as {first.name}"
        yield f"surface = {name}: occurs twice{how} (also {first.origin}); rename one"
    if not row.get("path"):
        yield f"path: is empty; give the file of surface {name}"


def first_rows(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return the first row of each group, by its name."""
    rows: dict[str, Surface] = {}
    for row in surfaces.values():
        if row.group:
            rows.setdefault(row.group, row)
    return rows


def _mistakes_in_groups(surfaces: Mapping[str, Surface]) -> Iterator[str]:
    """Yield what is wrong with the groups of maps, and each part without one."""
    groups: dict[str, list[Surface]] = {}
    for row in surfaces.values():
        if row.group:
            groups.setdefault(row.group, []).append(row)
        elif row.specimen:
            yield f"{_line(row)}, {SPECIMEN} = {row.specimen}: is in no group; name its {GROUP} as well"
    for name, rows in groups.items():
        origin = f"{_line(rows[0])}, {GROUP} = {name}"
        if wrong := name_mistake(name):
            yield f"{origin}: {wrong}"
        if name in surfaces:
            yield f"{origin}: a surface has this name as well; rename one"
        read: dict[str, Surface] = {}
        for row in rows:
            arguments = {key: value for key, value in row.read_arguments.items() if key != TILES}
            channels = arguments.pop("channel", "").split(";")  # of profiles several
            for channel in dict.fromkeys(map(str.strip, channels)):
                first = read.setdefault(f"{row.path} {row.counter_face} {channel} {arguments}", row)
                if first.origin != row.origin:
                    file = f"{row.path} {channel}".strip()
                    yield f"{origin}: {first.name} and {row.name} are the same file, {file}; leave one out"
        if len(rows) == 1 and rows[0].counter_face is None:
            yield (
                f"{origin}: has {rows[0].name} alone; name further maps of the finish, or leave the cell "
                "empty"
            )


def _mistakes_in_tiles(surfaces: Mapping[str, Surface], cuts: Mapping[str, str]) -> Iterator[str]:
    """Yield what is wrong with the maps that are cut; `cuts` has their cells `parts`."""
    of_same_area = {name for pair in same_area_pairs(surfaces) for name in pair}
    small = {name.lower(): name for name in surfaces}
    for name, text in cuts.items():
        row = surfaces[name]
        origin = f"{_line(row)}, {TILES} = {text}"
        if row.counter_face is not None:
            yield (
                f"{origin}: {name} is a pair of faces ({PAIR}), which has several placements instead "
                "(composite.shifts); leave one of the two cells empty"
            )
        elif name in of_same_area:
            yield (
                f"{origin}: {name} is the same place as another surface ({REPEAT}, {BEFORE}), which its "
                "parts are not; compare the whole maps, or leave that cell empty"
            )
        elif lay := row.read_arguments.get("lay"):
            yield (
                f"{origin}: profiles with lay = {lay} are solved together; leave the cell empty, or name "
                "some of them in a row of its own"
            )
        try:
            tiles = tiles_of(text)
        except SettingsError as error:
            yield f"{_line(row)}, {error}"
            continue
        for tile in tiles:
            if namesake := small.get(f"{name}-{tile.column}-{tile.row}".lower()):
                yield (
                    f"{_line(surfaces[namesake])}, surface = {namesake}: {name} needs this name for one of "
                    f"its parts ({TILES} = {text}); rename one"
                )


def _with_tiles(surfaces: Mapping[str, Surface], cuts: Mapping[str, str]) -> dict[str, Surface]:
    """Return the rows, with its tiles in place of each map that is cut.

    Where its group has other maps as well, the tiles of a map are of one specimen, as they lie side by side.
    """
    sizes = Counter(row.group for row in surfaces.values())
    rows: dict[str, Surface] = {}
    for name, row in surfaces.items():
        if name not in cuts:
            rows[name] = row
            continue
        specimen = row.specimen or (name if row.group and sizes[row.group] > 1 else "")
        for tile in tiles_of(cuts[name]):
            rows[f"{name}-{tile.column}-{tile.row}"] = replace(
                row,
                name=f"{name}-{tile.column}-{tile.row}",
                read_arguments=row.read_arguments | {TILES: [*astuple(tile)]},
                group=row.group or name,
                specimen=specimen,
            )
    return rows


def _mistakes_in_profiles_along(surfaces: Mapping[str, Surface]) -> Iterator[str]:
    """Yield what is wrong with profiles along a lay, which serve those across it alone."""
    across = {row.group for row in surfaces.values() if row.read_arguments.get("lay") == "across"}
    of_same_area = {name for pair in same_area_pairs(surfaces) for name in pair}
    for name, row in surfaces.items():
        if row.read_arguments.get("lay") != "along":
            continue
        if not row.group or row.group not in across:
            yield (
                f"{_line(row)}, lay = along: a profile along the lay runs on one ridge and shows nothing of "
                f"the others; give it the {GROUP} of profiles with lay = across"
            )
        if name in of_same_area or row.counter_face is not None:
            yield (
                f"{_line(row)}, lay = along: {name} is not solved by itself; leave {PAIR}, {REPEAT} and "
                f"{BEFORE} out"
            )


def _with_profiles_along(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return the rows without profiles along a lay, which those across it in their group are given."""
    along: dict[str, list[dict[str, Any]]] = {}
    solved = {}
    for name, row in surfaces.items():
        if row.read_arguments.get("lay") == "along":
            arguments = row.read_arguments | {"path": str(row.path), "lay": "across"}
            along.setdefault(row.group, []).append(arguments)
        else:
            solved[name] = row
    sizes = Counter(row.group for row in solved.values())
    for name, row in solved.items():
        if row.group in along and row.read_arguments.get("lay") == "across":
            arguments = row.read_arguments | {"along": along[row.group]}
            group = row.group if sizes[row.group] > 1 else ""  # of a single surface there is no group
            solved[name] = replace(row, read_arguments=arguments, group=group)
    return solved


def same_area_pairs(surfaces: Mapping[str, Surface]) -> list[tuple[str, str]]:
    """Return the names of every two surfaces that are the same place, the earlier one first."""
    return [
        (earlier, name)
        for name, row in surfaces.items()
        for earlier in (row.repeat_of, row.before)
        if earlier
    ]


def _mistakes_in_areas(surfaces: Mapping[str, Surface]) -> list[str]:
    """Return what is wrong with the names of the surfaces that are the same place."""
    pairs = {name for name, row in surfaces.items() if row.counter_face is not None}
    mistakes = [
        f"{_line(row)}, {column} = {reference!r}: "
        + (
            f"{name if name in pairs else reference} is a pair (counter_face), and single maps are compared; "
            f"leave {column} out"
            if pairs & {name, reference}
            else "is the name of this row; give that of the other map of the place"
            if name == reference
            else "is no other surface of the table; "
            + nearest(reference, [other for other in surfaces if other != name and other not in pairs])
        )
        for name, row in surfaces.items()
        for column, reference in ((REPEAT, row.repeat_of), (BEFORE, row.before))
        if reference and (name == reference or reference not in surfaces or pairs & {name, reference})
    ]
    if mistakes:
        return mistakes
    try:
        TopologicalSorter(
            {name: {row.repeat_of, row.before} - {""} for name, row in surfaces.items()}
        ).prepare()
    except CycleError as error:
        circle = " -> ".join(error.args[1])
        return [f"columns {REPEAT}, {BEFORE}: {circle} is a circle; name in each row what is earlier"]
    for name, row in surfaces.items():
        begin = f"{_line(row)}, {BEFORE} = {row.before}: {name} and {row.before} are"
        if row.before and _first_repeated(surfaces, name) == _first_repeated(surfaces, row.before):
            mistakes.append(f"{begin} repeats as well ({REPEAT}), with nothing done in between; choose one")
        elif row.before and (row.path, row.read_arguments) == (
            surfaces[row.before].path,
            surfaces[row.before].read_arguments,
        ):
            mistakes.append(f"{begin} the same file, {row.path}; name the file of each")
        elif row.before and row.group and row.group == surfaces[row.before].group:
            mistakes.append(f"{begin} both in group {row.group}; give before and after a group of their own")
    return mistakes


def _first_repeated(surfaces: Mapping[str, Surface], name: str) -> str:
    """Return the first of the measurements that a surface repeats, which may be its own."""
    while surfaces[name].repeat_of:
        name = surfaces[name].repeat_of
    return name


def _line(row: Surface) -> str:
    """Return where a row stands in the table."""
    return row.origin.rpartition(", ")[2]


def _with_repeats(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return the rows; each of two repeats knows name and file of the other, and both are of one part.

    Repeats of a place are no independent maps of a group. A part that the table states stays.
    """
    linked = dict(surfaces)
    pairs = [(name, row.repeat_of) for name, row in surfaces.items() if row.repeat_of]
    for name, partner in [*pairs, *(pair[::-1] for pair in pairs)]:
        row, repeated = surfaces[name], surfaces[partner]
        repeat = {"name": partner, "path": str(repeated.path), **repeated.read_arguments}
        specimen = row.specimen
        if row.group == repeated.group and row.group and not (row.specimen or repeated.specimen):
            specimen = _first_repeated(surfaces, name)
        linked[name] = replace(
            linked[name], read_arguments={"repeat": repeat, **linked[name].read_arguments}, specimen=specimen
        )
    return linked


def _instrument(row: Mapping[str, str], mistakes: list[str]) -> dict[str, float]:
    """Return what a row says of its instrument, in SI units, and add what is wrong with it to `mistakes`."""
    cells = {key: row[key] for key in INSTRUMENT if row.get(key)}
    try:
        return Instrument.model_validate(cells).model_dump(include={*cells})
    except ValidationError as error:
        for detail in error.errors():
            key = str(detail["loc"][0])
            where: Any = {"loc": ("instrument", key), "input": cells[key]}
            mistakes.append(f"{key}{reason({**detail, **where})}")
        return {}


def _length(text: str) -> float:
    """Return a length in `unit`, or in m if it has its own unit; NaN for any other text."""
    try:
        return float(in_base_unit(text, "m"))
    except ValueError:
        return math.nan
