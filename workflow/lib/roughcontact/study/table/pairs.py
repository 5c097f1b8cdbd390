"""Pairs of faces: rows with a `counter_face`, solved in several placements.

The files of the pair `seal` are read as `seal-face` and `seal-counter-face`, its placements `seal-1`,
`seal-2` ... are solved.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from roughcontact.errors import SettingsError
from roughcontact.study.table.columns import GROUP
from roughcontact.study.table.groups import first_rows
from roughcontact.study.table.row import Surface, in_cell


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


def mistakes_in_names(surfaces: Mapping[str, Surface], count: int) -> Iterator[SettingsError]:
    """Yield the mistakes of surfaces and groups that have the name of a member or of a face of a pair."""
    reserved_names = {
        member.lower(): placement.pair
        for name, placement in placements(surfaces, count).items()
        for member in (name, placement.face, placement.counter_face)
    }
    for column, rows in (("surface", surfaces), (GROUP, first_rows(surfaces))):
        for name, row in rows.items():
            if pair := reserved_names.get(name.lower()):
                text = f"{column} = {name}: the pair {pair} needs this name for one of its parts; rename one"
                yield in_cell(row, column, text)
