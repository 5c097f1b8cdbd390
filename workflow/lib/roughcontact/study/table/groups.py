"""Groups of the table of surfaces: maps of one finish, which have a result together."""

from collections.abc import Iterator, Mapping

import numpy as np

from roughcontact.arguments.rectangles import parse_rectangles
from roughcontact.arguments.settings.messages import name_mistake
from roughcontact.errors import SettingsError
from roughcontact.study.table.columns import GROUP, REGION, SPECIMEN, TILES
from roughcontact.study.table.row import Surface, in_cell


def first_rows(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return the first row of each group, by its name."""
    return {row.group: row for row in reversed([*surfaces.values()]) if row.group}


def mistakes_in_groups(surfaces: Mapping[str, Surface]) -> Iterator[SettingsError]:
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
        read: dict[str, list[Surface]] = {}
        for row in rows:
            arguments = {key: cell for key, cell in row.read_arguments.items() if key not in (TILES, *REGION)}
            channels = arguments.pop("channel", "").split(";")
            for channel in dict.fromkeys(map(str.strip, channels)):
                files = [str(file.path) for file in row.files()]
                originals = read.setdefault(f"{files} {channel} {arguments}", [])
                for original in originals:
                    if original.origin != row.origin and _share_points(original, row):
                        file = f"{row.path} {channel}".strip()
                        text = f"{cell}: {original.name} and {row.name} are the same file, {file}"
                        yield in_cell(rows[0], GROUP, f"{text}; leave one out, or crop them apart")
                originals.append(row)
        if len(rows) == 1 == len(rows[0].files()):
            text = (
                f"{cell}: has {rows[0].name} alone; name further maps of the finish, or leave the cell empty"
            )
            yield in_cell(rows[0], GROUP, text)


def _share_points(*rows: Surface) -> bool:
    """Return whether two maps of one file may have points in common: what their crops show overlaps."""
    cells = [row.read_arguments.get("crop", "") for row in rows]
    try:
        crops = [rectangle for cell in cells for rectangle in parse_rectangles("crop", cell)]
    except SettingsError:  # told of its cell
        return False
    lower, upper = np.array(crops).reshape(-1, 2, 2).swapaxes(0, 1)
    return len(crops) < len(rows) or bool((lower.max(axis=0) < upper.min(axis=0)).all())
