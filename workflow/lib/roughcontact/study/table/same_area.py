"""Surfaces of the table that are the same place: measured again, or before and after something was done."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from typing import Any

from roughcontact.arguments.settings.messages import nearest
from roughcontact.errors import SettingsError
from roughcontact.study.table.columns import BEFORE, GROUP, OVERVIEW, PAIR, REPEAT
from roughcontact.study.table.row import Surface, in_cell


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
            if not reference:
                continue
            if pairs & {name, reference}:
                pair = name if name in pairs else reference
                wrong = f"{pair} is a pair ({PAIR}); only single maps are compared; leave {column} out"
            elif name == reference:
                wrong = "is the name of this row; give that of the other map of the place"
            elif reference not in surfaces:
                singles = [single for single in surfaces if single != name and single not in pairs]
                wrong = f"is no other surface of the table; {nearest(reference, singles)}"
            else:
                continue
            yield in_cell(row, column, f"{column} = {reference!r}: {wrong}")


def mistakes_in_areas(surfaces: Mapping[str, Surface]) -> list[SettingsError]:
    """Return what is wrong with surfaces that are the same place."""
    if mistakes := [*_mistakes_in_references(surfaces)]:
        return mistakes
    try:
        _in_order(surfaces)
    except CycleError as error:
        circle = " -> ".join(error.args[1])
        text = f"columns {REPEAT}, {BEFORE}: {circle} is a circle; name in each row what is earlier"
        return [SettingsError(text)]
    mistakes = [
        in_cell(row, BEFORE, f"{BEFORE} = {row.before}: {row.name} and {row.before} are {wrong}")
        for row in surfaces.values()
        if row.before and (wrong := _mistake_in_before(surfaces, row, surfaces[row.before]))
    ]
    return mistakes or [*_mistakes_in_groups(surfaces)]


def _mistakes_in_groups(surfaces: Mapping[str, Surface]) -> Iterator[SettingsError]:
    """Yield the maps of a place that count as independent maps of a group: all but repeats."""
    for names in _places(surfaces):
        first_of_group: dict[str, str] = {}
        for row in map(surfaces.__getitem__, names):
            first_name = first_of_group.setdefault(row.group, row.name)
            if row.group and _first_repeated(surfaces, first_name) != _first_repeated(surfaces, row.name):
                text = f"{GROUP} = {row.group}: {row.name} and {first_name} are the same place"
                yield in_cell(row, GROUP, f"{text}; give before and after a group of their own")


def _mistake_in_before(surfaces: Mapping[str, Surface], row: Surface, earlier: Surface) -> str:
    """Return what a surface and the same place before cannot be, empty where nothing is wrong."""
    if _first_repeated(surfaces, row.name) == _first_repeated(surfaces, earlier.name):
        return f"repeats as well ({REPEAT}), with nothing done in between; choose one"
    files = [(map_.path, map_.read_arguments.get("channel")) for map_ in (row, earlier)]
    if files[0] == files[1]:  # whatever is cut out of it
        return f"the same file, {row.path}; name the file of each"
    return ""


def _in_order(surfaces: Mapping[str, Surface]) -> list[str]:
    """Return the names of the surfaces, each after those that are the same place earlier."""
    earlier = {name: {row.repeat_of, row.before} - {""} for name, row in surfaces.items()}
    return [*TopologicalSorter(earlier).static_order()]


def _first_repeated(surfaces: Mapping[str, Surface], name: str) -> str:
    """Return the first of the measurements that a surface repeats, which may be its own."""
    while surfaces[name].repeat_of:
        name = surfaces[name].repeat_of
    return name


def with_other_maps(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return the rows, each with how the other maps of its place are read.

    `repeats` has the maps with nothing done in between, its partner first, with which it tells the noise.
    `place` has all maps, itself included, where something was done: in the order of time, each (but the
    first) with the name of an `earlier` one. Repeats of a place are no independent maps of a group: all are
    of one specimen, unless the table states some.
    """
    rows = dict(surfaces)
    first_maps = {name: _first_repeated(surfaces, name) for name in surfaces}
    for name, row in surfaces.items():
        repeats = [surfaces[key] for key in surfaces if first_maps[key] == first_maps[name] and key != name]
        if not repeats:
            continue
        partner = surfaces.get(row.repeat_of) or next(map_ for map_ in repeats if map_.repeat_of == name)
        maps = [_as_other_map(map_) for map_ in (partner, *(map_ for map_ in repeats if map_ is not partner))]
        is_one_specimen = row.group and row.group == partner.group and not row.specimen + partner.specimen
        rows[name] = replace(
            row,
            read_arguments={"repeats": maps, **row.read_arguments},
            specimen=first_maps[name] if is_one_specimen else row.specimen,
        )
    for names in _places(surfaces):
        maps = [_as_other_map(surfaces[key]) | _name_of_earlier(surfaces[key]) for key in names]
        for name in names:
            rows[name] = replace(rows[name], read_arguments=rows[name].read_arguments | {"place": maps})
    return rows


def _places(surfaces: Mapping[str, Surface]) -> list[list[str]]:
    """Return the surfaces of each place to which something was done, in the order of time."""
    maps_by_name: dict[str, list[str]] = {}
    for name in _in_order(surfaces):
        earlier = _name_of_earlier(surfaces[name]).get("earlier")
        maps_by_name[name] = maps_by_name[earlier] if earlier else []
        maps_by_name[name].append(name)
    return [
        names
        for name, names in maps_by_name.items()
        if name == names[0] and any(surfaces[key].before for key in names)
    ]


def _name_of_earlier(row: Surface) -> dict[str, str]:
    """Return the name of an earlier map of the place as an argument; none of the first."""
    earlier = row.before or row.repeat_of
    return {"earlier": earlier} if earlier else {}


def _as_other_map(row: Surface) -> dict[str, Any]:
    """Return how the map of a row is read as another map of its place, without what lies around it."""
    cells = {key: cell for key, cell in row.read_arguments.items() if key not in (OVERVIEW, "along")}
    return {"name": row.name, "path": str(row.path), **cells}
