"""Overviews in the table of surfaces: files of coarser maps of a larger field around a map."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from roughcontact.arguments.positions import parse_position, separate_positions
from roughcontact.errors import SettingsError
from roughcontact.study.table.columns import OVERVIEW, OVERVIEW_POSITION
from roughcontact.study.table.row import Mistake
from roughcontact.study.table.text import separate_files

# cells of the row that say how the overviews are read as well
_SHARED = ("unit", "height_unit", "first_row", "missing_value", "ignore_lines", "resample", "checksum")


def read_overviews(
    row: Mapping[str, str], arguments: Mapping[str, Any], path: Path, file: Callable[[str], Path]
) -> tuple[list[dict[str, Any]], list[Mistake]]:
    """Return the arguments to read each overview of a map at `path`, and what is wrong with them.

    `arguments` read the map itself; `file` finds the path of a file in the table.
    """
    names = separate_files(row[OVERVIEW])
    paths, mistakes = [file(name) for name in names], list[Mistake]()
    try:
        positions = separate_positions(row[OVERVIEW_POSITION], len(names))
        for position in positions:
            parse_position(position)
    except SettingsError as error:
        mistakes.append((OVERVIEW_POSITION, str(error)))
        positions = [""] * len(names)
    if path in paths:
        text = f"{OVERVIEW} = {path}: is the map itself; name the file of the larger field"
        mistakes.append((OVERVIEW, text))
    shared = {key: arguments[key] for key in _SHARED if key in arguments}
    overviews = [
        {"path": str(overview), **({"position": position} if position else {}), **shared}
        for overview, position in zip(paths, positions, strict=True)
    ]
    return overviews, mistakes
