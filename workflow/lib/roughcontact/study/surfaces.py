"""The table of surfaces: the file of each surface, and information that is not in the file.

A row that names a `counter_face` is a pair: its files are read as `{surface}-face` and
`{surface}-counter-face`, its placements `{surface}-1`, `{surface}-2` ... are solved. A row with `parts` (2x2)
is a map that is cut: its tiles `{surface}-1-1`, `{surface}-2-1` ... (along x, along y) are surfaces of their
own, in its group. Profiles along a lay are no surfaces: those across it in their group are solved with them.
"""

import codecs
import math
import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, field, replace
from functools import partial
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Any, get_args

from pydantic import ValidationError

from roughcontact.arguments.checking import check_choice
from roughcontact.arguments.choices import Checksum, FirstRow, LayInGroup, Resampling
from roughcontact.arguments.lays import lay_facts
from roughcontact.arguments.positions import parse_position, separate_positions
from roughcontact.arguments.rectangles import parse_rectangles
from roughcontact.arguments.settings.messages import name_mistake, nearest, reason
from roughcontact.arguments.settings.models import Instrument
from roughcontact.arguments.units import carries_unit, convert_to_base_unit
from roughcontact.errors import SettingsError
from roughcontact.io.request import FILE_OPTIONS
from roughcontact.study.tiles import parse_tiles

REQUIRED = ("surface", "path")
NUMBERS = ("dx", "dy")
TEXTS = (
    "channel",
    "unit",
    "height_unit",
    "resample",
    "checksum",
    "first_row",
    "missing_value",
    "ignore_lines",
    "lay",
    "crop",
    "mask",
)
REGION = ("crop", "mask")
PAIR = "counter_face"
PAIR_FIRST_ROW = "counter_face_first_row"
INSTRUMENT = tuple(key for key in Instrument.model_fields if key != "correct")  # prevail over the settings
REPEAT = "repeat_of"  # the same place measured with nothing done in between: the noise of both follows
OVERVIEW = "overview"  # files of coarser maps of a larger field around it
OVERVIEW_POSITION = "overview_position"  # where it lies in them
BEFORE = "before"  # the same place before something was done to it: their difference is the result
GROUP, SPECIMEN, TILES = "group", "part", "parts"
_NAMES_OF_OTHERS = ("path", PAIR, OVERVIEW, "channel")  # as files and instruments call them
_OF_OVERVIEWS = ("unit", "height_unit", "first_row", "missing_value", "ignore_lines", "resample", "checksum")
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]")  # and bytes of a name that are no text
_QUOTED = re.compile(r'"(?:[^"]|"")*"')
CHOICES = {"resample": Resampling, "checksum": Checksum, "first_row": FirstRow, "lay": LayInGroup}
_OWN = (GROUP, SPECIMEN, TILES, PAIR, PAIR_FIRST_ROW, BEFORE, REPEAT, OVERVIEW, OVERVIEW_POSITION)
# of columns that no option of the program has
_MEANINGS = {
    GROUP: "finish of the map: maps of one group have one result together, groups are compared",
    SPECIMEN: "workpiece, where a group has several maps of one",
    TILES: "2x2: the map is cut into so many parts along x and y, each solved as if measured alone",
    PAIR: "file of the face in contact with this one",
    PAIR_FIRST_ROW: "top or bottom: position of the first row in that file",
    BEFORE: "surface of the table that is the same place before wear, heat, polish",
    REPEAT: "surface of the table that is the same place, nothing done in between: the noise follows",
    OVERVIEW: "files of coarser maps of a larger field around this one, between semicolons",
    OVERVIEW_POSITION: "x and y of the middle of the map in each, where it cannot be found: 300 250 um",
    "crop": "rectangle that is used, x y x y of two corners and the unit: 20 10 120 110 um",
    "mask": "rectangles that count as not measured (dust, a scratch, an edge), separated by semicolons",
}
COLUMNS = (*REQUIRED, *_OWN, *TEXTS, *NUMBERS, *INSTRUMENT)

# a column, another that excludes it in a row, and why
_EXCLUSIVE = {
    **{
        (key, other): f"is of single maps; leave it or {other} empty"
        for key in REGION
        for other in (PAIR, "lay")
    },
    (TILES, PAIR): f"{{name}} is a pair of faces ({PAIR}), which has several placements instead "
    "(composite.shifts); leave one of the two cells empty",
    (
        TILES,
        "lay",
    ): "profiles with lay = {cell} are solved together; leave the cell empty, or name some of them "
    "in a row of its own",
    (OVERVIEW, PAIR): f"{{name}} is a pair ({PAIR}); leave one of the two cells empty",
}

Mistake = tuple[str, str]  # the column of a cell, and what is wrong, a sentence that begins with it


@dataclass(frozen=True)
class Placement:
    """One relative position of the faces of a pair."""

    pair: str  # its name in the table
    number: int  # from 1
    face: str  # names of the two measured surfaces
    counter_face: str


@dataclass(frozen=True)
class Surface:
    """One row of the table."""

    name: str  # of the surface and of its folder of results
    path: Path  # the measured file; as in the table where there is no such file
    origin: str  # table and line, for messages
    read_arguments: dict[str, Any]  # keyword arguments of `read_height_map`
    faces: tuple["Surface", ...] = ()  # of a pair: its two measured files
    group: str = ""  # the finish
    specimen: str = ""  # empty where it is of a specimen of its own
    repeat_of: str = ""  # surface of the same area, measured with nothing done in between
    before: str = ""  # surface of the same area before something was done to it
    line: int = field(default=0, kw_only=True)  # of the table

    @property
    def lay(self) -> str:
        """The direction of a profile to the lay of its surface, empty of a map."""
        return str(self.read_arguments.get("lay", ""))

    @property
    def has_surface_behind(self) -> bool:
        """Whether a surface behind profiles is solved: of profiles without a lay, or of both directions."""
        return lay_facts(self.read_arguments).has_surface_behind or "along" in self.read_arguments

    @property
    def properties(self) -> tuple[str, ...]:
        """What may exclude settings (`KindFacts.excluded_with`)."""
        return ("faces",) if self.faces else ()

    def files(self) -> list["Surface"]:
        """Return the measured files of a row: itself, or of a pair its face and its counter-face."""
        return [*(self.faces or [self])]

    def with_counter_face(self, path: Path, first_row: str = "") -> "Surface":
        """Return the pair with the face in another file, of which all but its `first_row` is the same."""
        counter = {key: value for key, value in self.read_arguments.items() if key != "first_row"}
        counter |= {"first_row": first_row} if first_row else {}
        faces = (
            Surface(f"{self.name}-face", self.path, self.origin, self.read_arguments),
            Surface(f"{self.name}-counter-face", path, self.origin, counter),
        )
        return replace(self, faces=faces)


def column_meaning(name: str) -> str:
    """Return the sentence of a column of the table, in the words of the options of the program or its own.

    Examples
    --------
    >>> column_meaning("height_unit"), column_meaning("noise")
    ('unit of the heights', 'measurement noise N_M, rms; a number alone is in m')
    """
    option = FILE_OPTIONS.get(name.replace("_", "-"), "").replace("--", "").replace("height-", "height_")
    field = Instrument.model_fields.get(name)
    return option or _MEANINGS.get(name) or (field.description if field else None) or ""


def column_choices(name: str) -> list[str]:
    """Return the words that a cell of a column may be; none where any text may stand.

    Examples
    --------
    >>> column_choices("lay"), column_choices("counter_face_first_row"), column_choices("unit")
    (['across', 'along', 'none'], ['top', 'bottom'], [])
    """
    return list(get_args((CHOICES | {PAIR_FIRST_ROW: FirstRow}).get(name)))


def find(path: str | Path, folders: Iterable[str | Path]) -> Path | None:
    """Return the first existing file among `folder / path`, None where there is none."""
    # relative in the working directory: recorded paths do not depend on where that is
    candidates = (Path(folder) / path for folder in folders)
    # false also of a path that is too long
    return next((candidate for candidate in candidates if os.path.isfile(candidate)), None)  # noqa: PTH113


def read_surfaces(
    table: str | Path,
    folders: Sequence[str | Path] = (".",),
    *,
    check: Callable[[Surface], Sequence[Mistake]] | None = None,
    placements_each: int = 0,
) -> dict[str, Surface]:
    r"""Read the table of surfaces (tab-separated): name -> Surface, in the order of the table.

    `folders` and the table's own are searched; `check` returns further mistakes of a row, and no row may have
    the name of one of `placements_each` placements. A `SettingsError` lists all mistakes, each with its line.
    """
    table = Path(table)
    header, rows = read_table(table)
    mistakes = [*map(SettingsError, _mistakes_in_header(header))]
    readable = {*REQUIRED} <= {*header} and len({*header}) == len(header)
    if not mistakes and not rows:
        mistakes.append(SettingsError("has no row; add one line with the name and the path of each surface"))
    folders = [folders[0], table.parent, *folders[1:]]
    surfaces: dict[str, Surface] = {}
    earlier: dict[str, Surface] = {}
    cuts: dict[str, str] = {}
    for line, cells in rows if readable else ():
        row = dict(zip(header, cells, strict=False))
        if any(cells[len(header) :]):
            text = f"line {line}: {len(cells)} cells, the header has {len(header)}"
            mistakes.append(SettingsError(text))
        doubts = [*_mistakes_in_row(row, earlier)]
        instrument = _instrument(row, doubts)
        read_arguments: dict[str, Any] = {key: row[key] for key in TEXTS if row.get(key)}
        read_arguments |= {"instrument": instrument} if instrument else {}
        read_arguments |= {
            key: row[key] if carries_unit(row[key]) else _length(row[key]) for key in NUMBERS if row.get(key)
        }
        paths = {key: find(row[key], folders) or Path(row[key]) for key in ("path", PAIR) if row.get(key)}
        if overviews := _overviews(row, doubts):
            shared = {key: value for key, value in read_arguments.items() if key in _OF_OVERVIEWS}
            read_arguments[OVERVIEW] = [
                {**entry, "path": str(find(entry["path"], folders) or entry["path"]), **shared}
                for entry in overviews
            ]
            doubts += [
                (OVERVIEW, f"{OVERVIEW} = {path}: is the map itself; name the file of the larger field")
                for path in (entry["path"] for entry in read_arguments[OVERVIEW])
                if Path(path) == paths.get("path")
            ]
        surface = Surface(
            row.get("surface", ""),
            paths.get("path", Path()),
            f"{table}, line {line}",
            read_arguments,
            (),
            *(row.get(key, "") for key in (GROUP, SPECIMEN, REPEAT, BEFORE)),
            line=line,
        )
        if PAIR in paths:
            surface = surface.with_counter_face(paths[PAIR], row.get(PAIR_FIRST_ROW, ""))
        surfaces[surface.name] = earlier[surface.name.lower()] = surface
        if row.get(TILES):
            cuts[surface.name] = row[TILES]
        mistakes += [in_cell(surface, *wrong) for wrong in (*doubts, *(check(surface) if check else ()))]
    mistakes += _mistakes_in_areas(surfaces)
    mistakes += _mistakes_in_tiles(surfaces, cuts)
    mistakes += _mistakes_in_profiles_along(surfaces)
    if not mistakes:
        surfaces = _attach_profiles_along(_replace_by_tiles(surfaces, cuts))
    mistakes += _mistakes_in_groups(surfaces)
    mistakes += _names_of_faces(surfaces, placements(surfaces, placements_each))
    if mistakes:
        raise SettingsError(
            "\n".join([f"mistakes in the table of surfaces {table}:", *(f"  {m}" for m in mistakes)]),
            mistakes=mistakes,
        )
    return _attach_places(_attach_repeats(surfaces), surfaces)


def measured(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return every measured file, name -> Surface: of a pair its face and its counter-face."""
    return {file.name: file for row in surfaces.values() for file in row.files()}


def placements(surfaces: Mapping[str, Surface], count: int) -> dict[str, Placement]:
    """Return the placements of all pairs, name -> Placement, with `count` placements of each pair."""
    return {
        f"{row.name}-{number}": Placement(row.name, number, *(face.name for face in row.faces))
        for row in surfaces.values()
        if row.faces
        for number in range(1, count + 1)
    }


def _names_of_faces(
    surfaces: Mapping[str, Surface], placements_of_pairs: Mapping[str, Placement]
) -> Iterator[SettingsError]:
    """Yield the mistakes of surfaces and groups that have the name of a member or of a face of a pair."""
    reserved_names = {
        member.lower(): placement.pair
        for name, placement in placements_of_pairs.items()
        for member in (name, placement.face, placement.counter_face)
    }
    for column, rows in (("surface", surfaces), (GROUP, first_rows(surfaces))):
        for name, row in rows.items():
            if pair := reserved_names.get(name.lower()):
                text = f"{column} = {name}: the pair {pair} needs this name for one of its parts; rename one"
                yield in_cell(row, column, text)


def read_table(table: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Return the header, and the cells of each further row with the number of its line, unchecked."""
    try:
        content = table.read_bytes()
        has_mark = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))  # as spreadsheets write it
        lines = re.split(r"\r\n?|\n", content.decode("utf-16" if has_mark else "utf-8-sig"))
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise SettingsError(
            f"table of surfaces {table}, line {line}: is no text in UTF-8 ({error.reason}); save it as UTF-8"
        ) from error
    except OSError as error:
        why = "no such file" if isinstance(error, FileNotFoundError) else f"not readable ({error})"
        raise SettingsError(
            f"table of surfaces {table}: {why}; correct `surfaces` in the settings, or write the table, a "
            "tab-separated text (`roughcontact init` writes one to change)"
        ) from error
    rows = [(number, _cells(line)) for number, line in enumerate(lines, 1)]
    rows = [(number, cells) for number, cells in rows if any(cells) and not cells[0].startswith("#")]
    if not rows:
        raise SettingsError(
            f"table of surfaces {table}: is empty; write a header (surface, path) and one row each"
        )
    (_, header), *rows = rows
    return header, rows


def _cells(line: str) -> list[str]:
    """Return the cells of a line: in quotes, as spreadsheets write some, as they are, else without blanks."""
    cells = [_CONTROL.sub("\ufffd", cell.strip()) for cell in line.rstrip().split("\t")]
    return [cell[1:-1].replace('""', '"') if _QUOTED.fullmatch(cell) else cell for cell in cells]


def table_text(rows: Sequence[Mapping[str, str]]) -> str:
    r"""Return the text of a table with the columns that have a cell in any of the rows.

    Names in and of files stay as they are, if necessary in quotes; control characters, and bytes that are no
    text, are refused.

    Examples
    --------
    >>> table_text([{"surface": "ground", "path": "ground.txt", "unit": "", "dx": "1 um"}])
    'surface\tpath\tdx\nground\tground.txt\t1 um\n'
    """
    used = {column for row in rows for column, cell in row.items() if cell.strip()} - {*REQUIRED}
    header = [*REQUIRED, *(name for name in COLUMNS if name in used), *sorted(used - {*COLUMNS})]
    lines = [header, *([_written(name, row.get(name, "")) for name in header] for row in rows)]
    return "".join("\t".join(line) + "\n" for line in lines)


def _written(column: str, cell: str) -> str:
    """Return a cell of a column as it stands in a table."""
    cell = cell if column in _NAMES_OF_OTHERS else cell.strip()
    if _CONTROL.search(cell):
        raise SettingsError(f"{column} = {cell!r}: a cell is text without tabs or control marks; rename it")
    return cell if _cells(cell) == [cell] else '"' + cell.replace('"', '""') + '"'


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


def _mistakes_in_row(row: Mapping[str, str], earlier: Mapping[str, Surface]) -> Iterator[Mistake]:
    """Yield the mistakes in the cells of one row; `earlier` has the rows above by name in small letters."""
    name = row.get("surface", "")
    for key in NUMBERS:
        if row.get(key) and not 0 < _length(row[key]) < math.inf:
            rule = (
                "a number greater than 0 (decimal point), in `unit` or with its own unit behind it (1.5 um)"
            )
            yield key, f"{key} = {row[key]!r}: must be {rule}"
    if wrong := name_mistake(name):
        yield "surface", f"surface = {name!r}: {wrong}"
    if namesake := earlier.get(
        name.lower()
    ):  # names that differ in capitals are one folder on macOS and Windows
        how = "" if namesake.name == name else f" but for capitals, as {namesake.name}"
        yield "surface", f"surface = {name}: occurs twice{how} (also {namesake.origin}); rename one"
    for (key, conflicting), sentence in _EXCLUSIVE.items():
        if row.get(key) and row.get(conflicting):
            yield key, f"{key} = {row[key]}: {sentence.format(name=name, cell=row[conflicting])}"
    checks: dict[str, Callable[[str], object]] = {key: partial(parse_rectangles, key) for key in REGION}
    checks[PAIR_FIRST_ROW] = partial(check_choice, PAIR_FIRST_ROW, choices=FirstRow)
    for key, check_cell in checks.items():
        if text := row.get(key):
            try:
                check_cell(text)
            except SettingsError as error:
                yield key, str(error)
    if row.get("path", "") in ("", ".", "./"):
        yield "path", f"path = {row.get('path', '')!r}: names no file; give that of surface {name}"


def _overviews(row: Mapping[str, str], mistakes: list[Mistake]) -> list[dict[str, Any]]:
    """Return path and stated position of the overviews of a row, and add what is wrong to `mistakes`."""
    files = separate_files(row.get(OVERVIEW, ""))
    try:
        positions = separate_positions(row.get(OVERVIEW_POSITION, ""), len(files))
        for position in positions:
            parse_position(position)
    except SettingsError as error:
        mistakes.append((OVERVIEW_POSITION, str(error)))
        positions = [""] * len(files)
    return [
        {"path": file, **({"position": position} if position else {})}
        for file, position in zip(files, positions, strict=True)
    ]


def separate_files(cell: str) -> list[str]:
    """Return the names of the files in a cell, which semicolons separate.

    Examples
    --------
    >>> separate_files("a 10x.plu; b.plu"), separate_files("")
    (['a 10x.plu', 'b.plu'], [])
    """
    return [name.strip() for name in cell.split(";") if name.strip()]


def first_rows(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return the first row of each group, by its name."""
    return {row.group: row for row in reversed([*surfaces.values()]) if row.group}


def _mistakes_in_groups(surfaces: Mapping[str, Surface]) -> Iterator[SettingsError]:
    """Yield what is wrong with the groups of maps, and each part without one."""
    groups: dict[str, list[Surface]] = {}
    for row in surfaces.values():
        if row.group:
            groups.setdefault(row.group, []).append(row)
        elif row.specimen:
            text = f"{SPECIMEN} = {row.specimen}: is in no group; name its {GROUP} as well"
            yield in_cell(row, SPECIMEN, text)
    for name, rows in groups.items():
        cell = f"{GROUP} = {name}"
        if wrong := name_mistake(name):
            yield in_cell(rows[0], GROUP, f"{cell}: {wrong}")
        if name in surfaces:
            yield in_cell(rows[0], GROUP, f"{cell}: a surface has this name as well; rename one")
        read: dict[str, Surface] = {}
        for row in rows:
            arguments = {key: value for key, value in row.read_arguments.items() if key != TILES}
            channels = arguments.pop("channel", "").split(";")  # of profiles several
            for channel in dict.fromkeys(map(str.strip, channels)):
                files = [str(file.path) for file in row.files()]
                original = read.setdefault(f"{files} {channel} {arguments}", row)
                if original.origin != row.origin:
                    file = f"{row.path} {channel}".strip()
                    text = f"{cell}: {original.name} and {row.name} are the same file, {file}; leave one out"
                    yield in_cell(rows[0], GROUP, text)
        if len(rows) == 1 == len(rows[0].files()):
            text = (
                f"{cell}: has {rows[0].name} alone; name further maps of the finish, or leave the cell empty"
            )
            yield in_cell(rows[0], GROUP, text)


def _mistakes_in_tiles(surfaces: Mapping[str, Surface], cuts: Mapping[str, str]) -> Iterator[SettingsError]:
    """Yield what is wrong with the maps that are cut; `cuts` has their cells `parts`."""
    of_same_area = {name for pair in same_area_pairs(surfaces) for name in pair}
    small = {name.lower(): name for name in surfaces}
    for name, text in cuts.items():
        row = surfaces[name]
        if name in of_same_area:
            yield in_cell(
                row,
                TILES,
                f"{TILES} = {text}: {name} is the same place as another surface ({REPEAT}, {BEFORE}), which "
                "its parts are not; compare the whole maps, or leave that cell empty",
            )
        try:
            tiles = parse_tiles(text)
        except SettingsError as error:
            yield in_cell(row, TILES, str(error))
            continue
        for tile in tiles:
            if namesake := small.get(f"{name}-{tile.column}-{tile.row}".lower()):
                yield in_cell(
                    surfaces[namesake],
                    "surface",
                    f"surface = {namesake}: {name} needs this name for one of its parts ({TILES} = {text}); "
                    "rename one",
                )


def _replace_by_tiles(surfaces: Mapping[str, Surface], cuts: Mapping[str, str]) -> dict[str, Surface]:
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
        for tile in parse_tiles(cuts[name]):
            rows[f"{name}-{tile.column}-{tile.row}"] = replace(
                row,
                name=f"{name}-{tile.column}-{tile.row}",
                read_arguments=row.read_arguments | {TILES: [*astuple(tile)]},
                group=row.group or name,
                specimen=specimen,
            )
    return rows


def _mistakes_in_profiles_along(surfaces: Mapping[str, Surface]) -> Iterator[SettingsError]:
    """Yield what is wrong with profiles along a lay, which serve those across it alone."""
    groups = {row.group for row in _with_lay(surfaces, "across")} - {""}
    of_same_area = {name for pair in same_area_pairs(surfaces) for name in pair}
    for row in _with_lay(surfaces, "along"):
        if row.group not in groups:
            yield in_cell(
                row,
                "lay",
                "lay = along: a profile along the lay runs on one ridge and shows nothing of the others; "
                f"give it the {GROUP} of profiles with lay = across",
            )
        if row.name in of_same_area or row.faces:
            text = f"lay = along: {row.name} is not solved by itself; leave {PAIR}, {REPEAT} and {BEFORE} out"
            yield in_cell(row, "lay", text)


def _attach_profiles_along(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return the rows without profiles along a lay, which those across it in their group are given."""
    along: dict[str, list[dict[str, Any]]] = {}
    remaining_rows = {**surfaces}
    for row in _with_lay(surfaces, "along"):
        arguments = row.read_arguments | {"path": str(row.path), "lay": "across"}
        along.setdefault(row.group, []).append(arguments)
        del remaining_rows[row.name]
    sizes = Counter(row.group for row in remaining_rows.values())
    for row in _with_lay(surfaces, "across"):
        if row.group in along:
            arguments = row.read_arguments | {"along": along[row.group]}
            group = row.group if sizes[row.group] > 1 else ""  # of a single surface there is no group
            remaining_rows[row.name] = replace(row, read_arguments=arguments, group=group)
    return remaining_rows


def _with_lay(surfaces: Mapping[str, Surface], lay: str) -> list[Surface]:
    """Return the rows of profiles in a direction to the lay."""
    return [row for row in surfaces.values() if row.lay == lay]


def same_area_pairs(surfaces: Mapping[str, Surface]) -> list[tuple[str, str]]:
    """Return the names of every two surfaces that are the same place, the earlier one first."""
    return [
        (earlier, name)
        for name, row in surfaces.items()
        for earlier in (row.repeat_of, row.before)
        if earlier
    ]


def _mistakes_in_references(surfaces: Mapping[str, Surface]) -> Iterator[SettingsError]:
    """Yield what is wrong with the names of the surfaces that are the same place."""
    pairs = {name for name, row in surfaces.items() if row.faces}
    for name, row in surfaces.items():
        for column, reference in ((REPEAT, row.repeat_of), (BEFORE, row.before)):
            if not reference or (
                reference in surfaces and name != reference and not pairs & {name, reference}
            ):
                continue
            singles = [other for other in surfaces if other != name and other not in pairs]
            wrong = f"is no other surface of the table; {nearest(reference, singles)}"
            if pairs & {name, reference}:
                pair = name if name in pairs else reference
                wrong = f"{pair} is a pair (counter_face); only single maps are compared; leave {column} out"
            elif name == reference:
                wrong = "is the name of this row; give that of the other map of the place"
            yield in_cell(row, column, f"{column} = {reference!r}: {wrong}")


def _mistakes_in_areas(surfaces: Mapping[str, Surface]) -> list[SettingsError]:
    """Return what is wrong with surfaces that are the same place."""
    if mistakes := [*_mistakes_in_references(surfaces)]:
        return mistakes
    try:
        _in_order(surfaces)
    except CycleError as error:
        circle = " -> ".join(error.args[1])
        text = f"columns {REPEAT}, {BEFORE}: {circle} is a circle; name in each row what is earlier"
        return [SettingsError(text)]
    for name, row in surfaces.items():
        start, wrong = f"{BEFORE} = {row.before}: {name} and {row.before} are", ""
        if row.before and _first_repeated(surfaces, name) == _first_repeated(surfaces, row.before):
            wrong = f"repeats as well ({REPEAT}), with nothing done in between; choose one"
        elif row.before and (row.path, row.read_arguments) == (
            surfaces[row.before].path,
            surfaces[row.before].read_arguments,
        ):
            wrong = f"the same file, {row.path}; name the file of each"
        elif row.before and row.group and row.group == surfaces[row.before].group:
            wrong = f"both in group {row.group}; give before and after a group of their own"
        if wrong:
            mistakes.append(in_cell(row, BEFORE, f"{start} {wrong}"))
    return mistakes


def _in_order(surfaces: Mapping[str, Surface]) -> list[str]:
    """Return the names of the surfaces, each after those that are the same place earlier."""
    earlier = {name: {row.repeat_of, row.before} - {""} for name, row in surfaces.items()}
    return [*TopologicalSorter(earlier).static_order()]


def _first_repeated(surfaces: Mapping[str, Surface], name: str) -> str:
    """Return the first of the measurements that a surface repeats, which may be its own."""
    while surfaces[name].repeat_of:
        name = surfaces[name].repeat_of
    return name


def in_cell(row: Surface, column: str, sentence: str) -> SettingsError:
    """Return the error of a cell, from its column and a sentence that begins with it."""
    return SettingsError(f"line {row.line}, {sentence}", place=f"rows.{row.line}.{column}")


def _attach_repeats(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return the rows; each of some repeats knows names and files of the others, and all are of one part.

    The first of the others is its partner, with which it tells the noise. Repeats of a place are no
    independent maps of a group. A part that the table states stays.
    """
    result, of_first = dict(surfaces), {name: _first_repeated(surfaces, name) for name in surfaces}
    partners = {row.repeat_of: name for name, row in reversed([*surfaces.items()]) if row.repeat_of}
    partners |= {name: row.repeat_of for name, row in surfaces.items() if row.repeat_of}
    for name, partner in partners.items():
        row, partner_row = surfaces[name], surfaces[partner]
        others = [key for key in surfaces if of_first[key] == of_first[name] and key not in (name, partner)]
        repeats = [_as_other_map(surfaces[key]) for key in (partner, *others)]
        specimen = row.specimen
        if row.group == partner_row.group and row.group and not (row.specimen or partner_row.specimen):
            specimen = of_first[name]
        arguments = {"repeats": repeats, **row.read_arguments}
        result[name] = replace(row, read_arguments=arguments, specimen=specimen)
    return result


def _as_other_map(row: Surface) -> dict[str, Any]:
    """Return how the map of a row is read as another map of its place, without what lies around it."""
    cells = {key: cell for key, cell in row.read_arguments.items() if key not in (OVERVIEW, "along")}
    return {"name": row.name, "path": str(row.path), **cells}


def _attach_places(rows: Mapping[str, Surface], as_read: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return the rows; those of a place before and after something was done to it know all maps of it.

    These are in the order of time, each with the name of an earlier one (but the first).
    """
    result = dict(rows)
    earlier = {name: row.before or row.repeat_of for name, row in as_read.items()}
    places: dict[str, list[str]] = {}
    for name in _in_order(as_read):
        places[name] = places[earlier[name]] if earlier[name] else []
        places[name].append(name)
    for name, maps in places.items():
        if not any(as_read[member].before for member in maps):
            continue
        of_place = [
            _as_other_map(as_read[member]) | ({"earlier": earlier[member]} if earlier[member] else {})
            for member in maps
        ]
        result[name] = replace(result[name], read_arguments={**rows[name].read_arguments, "place": of_place})
    return result


def _instrument(row: Mapping[str, str], mistakes: list[Mistake]) -> dict[str, float]:
    """Return what a row says of its instrument, in SI units, and add what is wrong with it to `mistakes`."""
    cells = {key: row[key] for key in INSTRUMENT if row.get(key)}
    try:
        return Instrument.model_validate(cells).model_dump(include={*cells})
    except ValidationError as error:
        for detail in error.errors():
            key = str(detail["loc"][0])
            where: Any = {"loc": ("instrument", key), "input": cells[key]}
            mistakes.append((key, f"{key}{reason({**detail, **where})}"))
        return {}


def _length(text: str) -> float:
    """Return a length in `unit`, or in m if it has its own unit; NaN for any other text."""
    try:
        return float(convert_to_base_unit(text, "m"))
    except ValueError:
        return math.nan
