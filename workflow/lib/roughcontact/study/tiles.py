"""Cutting a measured map into equal parts, which are solved as if each had been measured alone."""

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from roughcontact.arguments.measurement import add_remark
from roughcontact.errors import HeightMapError, SettingsError

if TYPE_CHECKING:  # the plan of a run imports this module
    import xarray as xr

MAX_TILES = 400
_FORM = re.compile(r"(\d{1,3})\s*[x×X]\s*(\d{1,3})")


@dataclass(frozen=True)
class Tile:
    """One part of a map cut into `columns` along x and `rows` along y; counted from 1, y upwards."""

    column: int
    row: int
    columns: int
    rows: int


def parse_tiles(text: str) -> list[Tile]:
    """Return the tiles that a text such as `3x2`, three along x and two along y, cuts a map into."""
    match = _FORM.fullmatch(text.strip())
    columns, rows = (int(match[1]), int(match[2])) if match else (0, 0)
    if not 2 <= columns * rows <= MAX_TILES:
        raise SettingsError(
            f"parts = {text!r}: must be two numbers with an x between them, along x and along y, of 2 to "
            f"{MAX_TILES} parts in all: 2x2, 4x1"
        )
    return [
        Tile(column, row, columns, rows) for row in range(1, rows + 1) for column in range(1, columns + 1)
    ]


def cut(height: "xr.DataArray", tile: Tile) -> "xr.DataArray":
    """Return a part of a measured map (y, x), m, at its place in the map; parts differ by a point at most."""
    edges = []
    name, (ny, nx) = height.attrs.get("source_file") or "the map", height.shape
    for axis, n, index, count in (("y", ny, tile.row, tile.rows), ("x", nx, tile.column, tile.columns)):
        if n < count:
            raise HeightMapError(
                f"{name}: has {n} points along {axis}, too few for parts = {tile.columns}x{tile.rows}; take "
                "fewer, or leave the cell empty"
            )
        edges.append(slice((index - 1) * n // count, index * n // count))
    heights = height[tuple(edges)]
    missing = int(heights.isnull().sum())
    if missing == heights.size:
        raise HeightMapError(
            f"{name}: part {tile.column}-{tile.row} of {tile.columns}x{tile.rows} has no measured point; "
            "take fewer parts"
        )
    remark = (
        f"part {tile.column} of {tile.columns} along x, {tile.row} of {tile.rows} along y (upwards), of "
        f"{nx} x {ny} points"
    )
    remarks = add_remark(height.attrs, remark, fact=True)
    return heights.assign_attrs(missing_points=missing, missing_share=missing / heights.size, **remarks)
