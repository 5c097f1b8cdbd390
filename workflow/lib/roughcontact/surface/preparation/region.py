"""The part of a measured map that is used: one rectangle of it (crop), without others (mask).

A crop makes the map smaller, as if the rest had never been measured. Points that are masked, dust, a scratch,
an edge, count as not measured: levelling fills them, and the checks say how much of the contact lies there.
"""

from pathlib import Path
from typing import Any

import xarray as xr

from roughcontact.arguments.maps import dimensions, side_lengths, spacing
from roughcontact.arguments.measurement import add_remark
from roughcontact.arguments.quantities import counted_noun, percent, quantity
from roughcontact.arguments.rectangles import Rectangle, parse_rectangles
from roughcontact.errors import HeightMapError, InputFileError
from roughcontact.io.read import read_height_map


def read_region(path: str | Path, *, crop: str = "", mask: str = "", **arguments: Any) -> xr.DataArray:
    """Return what is used of the map of a file (y, x; m); `arguments` are those of `read_height_map`."""
    return used_region(read_height_map(path, **arguments), crop=crop, mask=mask)


def read_overview(path: str | Path, **arguments: Any) -> xr.DataArray:
    """Read a coarser map around another one, as `read_height_map`; its file has to say its size."""
    try:
        return read_height_map(path, **arguments)
    except InputFileError as error:
        if not {"dx", "dy"} & {*error.keys}:
            raise
        finding, _, _ = str(error).partition("; give ")
        way_out = "write lines before the heights, # Width: 300 um, # Height: 200 um, # Value units: um"
        wrong = f"{finding}; the size of an overview is stated in its file"
        raise InputFileError(f"{wrong}: {way_out}, or save it in a format that has them") from error


def used_region(height: xr.DataArray, *, crop: str = "", mask: str = "") -> xr.DataArray:
    """Return the part of a measured map (y, x; m) within `crop`, without the points in `mask` (NaN there).

    Both are texts of the table of surfaces (`parse_rectangles`), from the lower left corner of the map; a
    point belongs to a rectangle that its centre lies in. The map keeps its coordinates.

    Raises
    ------
    HeightMapError
        If a rectangle reaches beyond the map, or no measured point is left.
    SettingsError
        If a text is none of rectangles.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> flat = height_map(np.zeros((20, 40)), "1 um")
    >>> part = used_region(flat, crop="10 0 40 10 um", mask="10 0 12 2 um")
    >>> part.shape, part.attrs["missing_points"]
    ((10, 30), 4)
    """
    if not crop and not mask:
        return height
    name, remarks = height.attrs.get("source_file") or "the map", height.attrs
    if dimensions(height.shape) < 2:
        key, text = ("crop", crop) if crop else ("mask", mask)
        raise HeightMapError(f"{name}: {key} = {text}: is of maps, and this is a profile; leave it empty")
    used = height
    for rectangle in parse_rectangles("mask", mask):
        used = used.where(~_inside(height, rectangle, f"{name}: mask = {mask}"))
    if mask:
        share = float((used.isnull() & height.notnull()).mean())
        rectangles = counted_noun(len(parse_rectangles("mask", mask)), "rectangle")
        text = f"{rectangles} masked (mask = {mask}), {percent(share)} of the points of {_size(height)}"
        remarks = {**remarks, **add_remark(remarks, f"{text}: they count as not measured", fact=True)}
    for rectangle in parse_rectangles("crop", crop):
        inside = _inside(height, rectangle, f"{name}: crop = {crop}")
        used = used.isel(y=inside.any("x").values, x=inside.any("y").values)
        text = f"cropped to {_size(used)} of {_size(height)} (crop = {crop})"
        remarks = {**remarks, **add_remark(remarks, text, fact=True)}
    missing = int(used.isnull().sum())
    if missing == used.size:
        raise HeightMapError(f"{name}: crop and mask leave no measured point; draw them smaller")
    return used.assign_attrs(remarks, missing_points=missing, missing_share=missing / used.size)


def _size(height: xr.DataArray) -> str:
    """Return the lengths of the sides of a map along x and y, in words."""
    return " × ".join(quantity(length, "m") for length in side_lengths(height)[::-1])


def _inside(height: xr.DataArray, rectangle: Rectangle, origin: str) -> xr.DataArray:
    """Return which points (y, x) of a map lie in a rectangle; `origin` begins the message of an error."""
    (ly, lx), (dy, dx) = side_lengths(height), spacing(height)
    overhang_x = max(-rectangle.left, rectangle.right - lx) / dx
    overhang_y = max(-rectangle.lower, rectangle.upper - ly) / dy
    if max(overhang_x, overhang_y) > 1:  # a unit may be wrong; what is drawn by hand ends at the border
        raise HeightMapError(
            f"{origin}: reaches beyond the map, which is {quantity(lx, 'm')} along x and "
            f"{quantity(ly, 'm')} along y; count from its lower left corner, and check the unit"
        )
    x, y = height["x"] - height["x"][0] + dx / 2, height["y"] - height["y"][0] + dy / 2
    inside = (y > rectangle.lower) & (y < rectangle.upper) & (x > rectangle.left) & (x < rectangle.right)
    if not inside.any():
        raise HeightMapError(
            f"{origin}: no point lies in a rectangle; draw it larger than {quantity(dx, 'm')}"
        )
    return inside
