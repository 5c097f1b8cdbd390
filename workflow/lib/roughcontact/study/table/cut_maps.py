"""Maps that are cut: their tiles `map-1-1`, `map-2-1` ... (along x, along y) are surfaces of their own."""

from collections.abc import Iterator, Mapping
from dataclasses import astuple, replace

from roughcontact.errors import SettingsError
from roughcontact.study.table.columns import BEFORE, GROUP, REPEAT, TILES
from roughcontact.study.table.groups import first_rows
from roughcontact.study.table.row import Surface, in_cell
from roughcontact.study.table.same_area import same_area_pairs
from roughcontact.study.tiles import Tile, parse_tiles


def mistakes_in_parts(surfaces: Mapping[str, Surface]) -> Iterator[SettingsError]:
    """Yield what is wrong with the maps that are cut."""
    of_same_area = {name for pair in same_area_pairs(surfaces) for name in pair}
    names, groups = {name.lower(): name for name in surfaces}, first_rows(surfaces)
    for row in surfaces.values():
        if not row.parts:
            continue
        cell = f"{TILES} = {row.parts}"
        if row.name in of_same_area:
            text = (
                f"{cell}: {row.name} is the same place as another surface ({REPEAT}, {BEFORE}), which its "
                "parts are not; compare the whole maps, or leave that cell empty"
            )
            yield in_cell(row, TILES, text)
        if not row.group and (member := groups.get(row.name)):
            text = f"the parts of {row.name} ({cell}) are a group of this name; rename one"
            yield in_cell(member, GROUP, f"{GROUP} = {row.name}: {text}, or name its {GROUP} too")
        try:
            tiles = parse_tiles(row.parts)
        except SettingsError as error:
            yield in_cell(row, TILES, str(error))
            continue
        for tile in tiles:
            if namesake := names.get(_name(row, tile).lower()):
                text = f"{row.name} needs this name for one of its parts ({cell}); rename one"
                yield in_cell(surfaces[namesake], "surface", f"surface = {namesake}: {text}")


def with_parts(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return the rows, with its tiles in place of each map that is cut.

    Where its group has other maps as well, the tiles of a map are of one specimen, as they lie side by side;
    so are several crops of one.
    """
    maps: dict[str, dict[tuple[str, ...], list[str]]] = {}  # of each group: the rows of every measured map
    for name, row in surfaces.items():
        maps.setdefault(row.group, {}).setdefault(_measured_map(row), []).append(name)
    rows: dict[str, Surface] = {}
    for name, row in surfaces.items():
        crops = maps[row.group][_measured_map(row)]
        is_cut = bool(row.parts) or len(crops) > 1
        is_one_specimen = row.group and is_cut and len(maps[row.group]) > 1
        of_specimen = replace(row, specimen=row.specimen or (crops[0] if is_one_specimen else ""))
        tiles = [
            replace(
                of_specimen,
                name=_name(row, tile),
                read_arguments=row.read_arguments | {TILES: [*astuple(tile)]},
                group=row.group or name,
            )
            for tile in (parse_tiles(row.parts) if row.parts else ())
        ]
        rows |= {part.name: part for part in tiles or [of_specimen]}
    return rows


def _measured_map(row: Surface) -> tuple[str, ...]:
    """Return what rows that are cut out of one measured map have in common."""
    return (*(str(file.path) for file in row.files()), str(row.read_arguments.get("channel", "")))


def _name(row: Surface, tile: Tile) -> str:
    """Return the name of the surface that a tile of a map is."""
    return f"{row.name}-{tile.column}-{tile.row}"
