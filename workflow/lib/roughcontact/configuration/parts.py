"""Cutting a measured map into equal parts, which are solved as if each had been measured alone."""

import json
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from roughcontact.errors import HeightMapError, SettingsError

if TYPE_CHECKING:  # the plan of a run imports this module
    import xarray as xr

MAX_PARTS = 400
_FORM = re.compile(r"(\d{1,3})\s*[x×X]\s*(\d{1,3})")


@dataclass(frozen=True)
class MapPart:
    """One part of a map cut into `columns` along x and `rows` along y; counted from 1, y upwards."""

    column: int
    row: int
    columns: int
    rows: int


def parts_of(text: str) -> list[MapPart]:
    """Return the parts that a text such as `3x2`, three along x and two along y, cuts a map into."""
    match = _FORM.fullmatch(text.strip())
    columns, rows = (int(match[1]), int(match[2])) if match else (0, 0)
    if not 2 <= columns * rows <= MAX_PARTS:
        raise SettingsError(
            f"parts = {text!r}: must be two numbers with an x between them, along x and along y, of 2 to "
            f"{MAX_PARTS} parts in all: 2x2, 4x1"
        )
    return [
        MapPart(column, row, columns, rows) for row in range(1, rows + 1) for column in range(1, columns + 1)
    ]


def cut(height: "xr.DataArray", part: MapPart) -> "xr.DataArray":
    """Return a part of a measured map (y, x), m, at its place in the map; parts differ by a point at most."""
    edges = []
    name, (ny, nx) = height.attrs.get("source_file") or "the map", height.shape
    for axis, n, index, count in (("y", ny, part.row, part.rows), ("x", nx, part.column, part.columns)):
        if n < count:
            raise HeightMapError(
                f"{name}: has {n} points along {axis}, too few for parts = {part.columns}x{part.rows}; take "
                "fewer, or leave the cell empty"
            )
        edges.append(slice((index - 1) * n // count, index * n // count))
    piece = height[tuple(edges)]
    missing = int(piece.isnull().sum())
    if missing == piece.size:
        raise HeightMapError(
            f"{name}: part {part.column}-{part.row} of {part.columns}x{part.rows} has no measured point; "
            "take fewer parts"
        )
    remark = (
        f"part {part.column} of {part.columns} along x, {part.row} of {part.rows} along y (upwards), of "
        f"{nx} x {ny} points"
    )
    remarks = {
        key: json.dumps([*json.loads(height.attrs.get(key, "[]")), remark], ensure_ascii=False)
        for key in ("ingest_warnings", "ingest_facts")
    }
    return piece.assign_attrs(missing_points=missing, missing_share=missing / piece.size, **remarks)
