"""WSxM's exports as text: a matrix below its amplitudes (lengths), or points below names of three columns.

The first line of a matrix is the upper one. The heights of a matrix are in the unit of the amplitude of z.
"""

import re
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import Channel, MeasuredFile, UnevenPositionsError, scattered
from roughcontact.io.guards import check_memory
from roughcontact.io.instrument_kinds import PROBE
from roughcontact.io.interface import Reader, RecognisedBy
from roughcontact.io.text.lines import lines_of
from roughcontact.io.text.point_grid import points_on_grid
from roughcontact.io.units import is_length, same_length

_MARK = re.compile(rb"WSxM file copyright[^\n]*\r?\nWSxM ASCII (Matrix|XYZ) file")
_AMPLITUDE = re.compile(r"([XYZ]) Amplitude:\s*([\d.eE+-]+)\s*(\S*)")
_COLUMN = re.compile(r"(\S+?)\s*\[([^\]]*)\]")
_MEMORY_PER_BYTE = 12  # lines, their cells, numbers


def recognises(path: Path, head: bytes) -> bool:
    r"""Return whether a file begins as one of the two exports.

    Examples
    --------
    >>> recognises(Path("map.txt"), b"WSxM file copyright UAM\r\nWSxM ASCII Matrix file\r\n")
    True
    """
    return _MARK.match(head) is not None


def read(path: Path) -> MeasuredFile:
    """Open a file of one map; a unit that is no length makes it a map without heights."""
    check_memory(path.stat().st_size * _MEMORY_PER_BYTE, f"{path.stat().st_size} bytes of text", path)
    lines = [line for line in lines_of(path) if line.strip()]
    is_matrix = "Matrix" in lines[1]
    start = next((n for n, line in enumerate(lines) if re.match(r"\s*[+-]?[\d.]", line)), len(lines))
    try:
        values = np.array([line.split() for line in lines[start:]], dtype=float)
    except ValueError as error:
        raise InputFileError(f"{path}: the rows of this WSxM file are not alike ({error})") from error
    header = "\n".join(lines[2:start])
    if not values.size or (not is_matrix and values.shape[1] != 3):
        raise InputFileError(f"{path}: this WSxM file has no {'matrix' if is_matrix else 'list of points'}")
    instrument = {"kind": PROBE.name, "software": "WSxM"}
    if is_matrix:
        sizes = {axis: (float(size), unit or None) for axis, size, unit in _AMPLITUDE.findall(header)}
        return MeasuredFile("WSxM text", [_matrix(values, sizes, path)], "top", instrument)
    return MeasuredFile("WSxM text", [_points(values, _COLUMN.findall(header), path)], "bottom", instrument)


def _matrix(values: np.ndarray, sizes: dict[str, tuple[float, str | None]], path: Path) -> Channel:
    """Return the map of a matrix with its lengths."""
    nothing = (0.0, None)
    (length_x, unit), (length_y, unit_y), (_, height_unit) = (sizes.get(axis, nothing) for axis in "XYZ")
    if unit and unit_y and not same_length(unit, unit_y):
        raise InputFileError(f"{path}: the amplitudes of X and Y have different units, {unit} and {unit_y}")
    ny, nx = values.shape
    return Channel(
        "height",
        (ny, nx),
        values.copy,
        dx=length_x / nx or None,
        dy=length_y / ny or None,
        lateral_unit=unit or unit_y,
        height_unit=height_unit,
        no_height=_no_height(height_unit),
    )


def _points(values: np.ndarray, columns: list[tuple[str, str]], path: Path) -> Channel:
    """Return the map of a list of points; the columns have names and units."""
    named = columns if len(columns) == 3 else [("", ""), ("", ""), ("height", "")]
    (_, unit), (_, unit_y), (name, height_unit) = named
    if unit and unit_y and not same_length(unit, unit_y):
        raise InputFileError(f"{path}: the positions have different units, {unit} and {unit_y}")
    stated: dict[str, Any] = {
        "lateral_unit": unit or unit_y or None,
        "height_unit": height_unit or None,
        "no_height": _no_height(height_unit),
    }
    x, y, z = values.T
    try:
        heights, steps, (first_x, first_y), notes = points_on_grid(x, y, z, path)
    except UnevenPositionsError as error:
        return scattered(name, x, y, z, error, **stated)
    stated |= {"dx": steps["x"], "dy": steps["y"], "first_x": first_x, "first_y": first_y, "notes": notes}
    return Channel(name, heights.shape, heights.copy, **stated)


def _no_height(unit: str | None) -> str:
    """Return why values in this unit are no heights; empty where they are, or where it is not stated."""
    return f"values in {unit}, no length" if unit and not is_length(unit) else ""


READER = Reader(RecognisedBy.MARK, recognises, read)
