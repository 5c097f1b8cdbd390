"""One row of the table of surfaces: a measured map, profiles, or a pair of faces."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from roughcontact.errors import SettingsError

Mistake = tuple[str, str]  # the column of a cell, and what is wrong, a sentence that begins with it


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
    parts: str = ""  # into which the map is cut, 2x2
    min_points: int = 0  # of what is solved, whatever its file has
    line: int = field(default=0, kw_only=True)  # of the table

    @property
    def properties(self) -> tuple[str, ...]:
        """What may exclude settings (`KindFacts.excluded`)."""
        return ("faces",) if self.faces else ()

    def files(self) -> list["Surface"]:
        """Return the measured files of a row: itself, or of a pair its face and its counter-face."""
        return [*(self.faces or [self])]


def in_cell(row: Surface, column: str, sentence: str) -> SettingsError:
    """Return the error of a cell, from its column and a sentence that begins with it."""
    return SettingsError(f"line {row.line}, {sentence}", place=f"rows.{row.line}.{column}")
