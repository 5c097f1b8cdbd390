"""Pairs of faces: rows with a `counter_face`, solved in several placements.

The files of the pair `seal` are read as `seal-face` and `seal-counter-face`, its placements `seal-1`,
`seal-2` ... are solved.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from roughcontact.errors import SettingsError
from roughcontact.study.table.columns import GROUP, PAIR, PAIR_FIRST_ROW
from roughcontact.study.table.groups import first_rows
from roughcontact.study.table.row import Surface, in_cell

# of the names of placements, as many as there may be, and faces
_ENDS = [re.compile(end) for end in (r"-[1-9]\d*$", "-face$", "-counter-face$")]


@dataclass(frozen=True)
class Placement:
    """One relative position of the faces of a pair."""

    pair: str  # its name in the table
    number: int  # from 1
    face: str  # names of the two measured surfaces
    counter_face: str


def placements(surfaces: Mapping[str, Surface], count: int) -> dict[str, Placement]:
    """Return the placements of all pairs, name -> Placement, with `count` placements of each pair."""
    return {
        f"{row.name}-{number}": Placement(row.name, number, *(face.name for face in row.faces))
        for row in surfaces.values()
        if row.faces
        for number in range(1, count + 1)
    }


def with_faces(surface: Surface, row: Mapping[str, str], file: Callable[[str], Path]) -> Surface:
    """Return the surface of a row of the table, of a pair with the measured files of its faces.

    All that the row says of a file is true of both, but for their first rows; `file` finds the path of one.
    """
    if not row[PAIR]:
        return surface
    counter = {key: value for key, value in surface.read_arguments.items() if key != "first_row"}
    counter |= {"first_row": row[PAIR_FIRST_ROW]} if row[PAIR_FIRST_ROW] else {}
    faces = (
        Surface(f"{surface.name}-face", surface.path, surface.origin, surface.read_arguments),
        Surface(f"{surface.name}-counter-face", file(row[PAIR]), surface.origin, counter),
    )
    return replace(surface, faces=faces)


def mistakes_in_names(surfaces: Mapping[str, Surface]) -> Iterator[SettingsError]:
    """Yield the mistakes of surfaces and groups that have a name of a placement or of a face of a pair."""
    pairs = {name.lower(): name for name, row in surfaces.items() if row.faces}
    for column, rows in (("surface", surfaces), (GROUP, first_rows(surfaces))):
        for name, row in rows.items():
            for pair in pairs.keys() & {
                end.sub("", name.lower()) for end in _ENDS if end.search(name.lower())
            }:
                text = f"the pair {pairs[pair]} needs this name for one of its parts; rename one"
                yield in_cell(row, column, f"{column} = {name}: {text}")
