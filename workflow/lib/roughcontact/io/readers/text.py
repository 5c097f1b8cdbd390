"""Text files: matrices of heights, lists of points x y z, profiles x z, with or without a header.

A matrix is read as it is printed: row 0 is the first line, which programs that write such files draw at the
top. The points of a list carry their positions, so their row 0 is the lowest line.
"""

from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import Channel, MeasuredFile, UnevenPositionsError, even_step, scattered
from roughcontact.io.guards import check_memory
from roughcontact.io.interface import Reader, ToldBy
from roughcontact.io.metadata import instrument_words
from roughcontact.io.text.header import column_units, parse_header
from roughcontact.io.text.lines import lines_of, looks_like_text
from roughcontact.io.text.point_grid import points_on_grid
from roughcontact.io.text.table import parse_table, separators, split_header
from roughcontact.io.units import is_length, metres

_BYTES_PER_BYTE = 12  # memory for each byte of text: lines, their pieces, numbers
# word of `roughcontact.io.metadata` -> what the header calls it
_INSTRUMENT = {"name": "instrument", "serial": "serial", "lens": "lens", "acquisition_time": "date"}


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins as readable text.

    Examples
    --------
    >>> recognises(Path("map.dat"), b"Width: 2 mm"), recognises(Path("map.txt"), bytes(8))
    (True, False)
    """
    return looks_like_text(head)


def read(path: Path) -> MeasuredFile:
    """Open a text file and find out by its content whether it is a matrix, a list of points or a profile.

    Parameters
    ----------
    path : Path

    Returns
    -------
    MeasuredFile
        One channel, with the steps and units that header and column names say.

    Raises
    ------
    InputFileError
        For a file that is cut off, holds no table of numbers, or may be read in two ways.
    """
    size = path.stat().st_size
    check_memory(size * _BYTES_PER_BYTE, f"{size} bytes of text", path)
    header, body = split_header(lines_of(path), path)
    said = parse_header(header)
    delimiter, decimal_comma = separators(body, path)
    table = parse_table(body, delimiter, decimal_comma, path, first=len(header) + 1)
    if said.get("missing") is not None:
        table[table == float(said["missing"])] = np.nan
    units = column_units(header, table.shape[1], delimiter)
    rows, columns = table.shape
    listed = said.get("nx") is None and rows > 2
    if listed and columns == 3:
        file = _points(table, units, said, path)
    elif listed and columns == 2:
        file = _profile(table, units, said, path)
    else:
        file = _matrix(table, said, path)
    file.instrument = instrument_words({word: said.get(key) for word, key in _INSTRUMENT.items()})
    return file


def _matrix(table: np.ndarray, said: dict[str, Any], path: Path) -> MeasuredFile:
    """Return a matrix of heights, whose header says the steps or the size."""
    ny, nx = table.shape
    for word, found, name in (("nx", nx, "columns"), ("ny", ny, "rows")):
        if said.get(word) is not None and said[word] != found:
            raise InputFileError(
                f"{path}: the header says {said[word]:g} {name}, the file has {found}; "
                "it was cut off or changed"
            )
    if ny == 1 and "length_y" in said:
        raise InputFileError(
            f"{path}: the header gives a size along y, the file has one line; it was cut off"
        )
    steps, lateral_unit = _steps(said, {"x": nx, "y": ny}, path)
    heights, words = _heights(table, said, said.get("height_unit"))
    channel = Channel(
        shape=heights.shape,
        read=lambda: heights,
        dx=steps.get("x"),
        dy=steps.get("y") if ny > 1 else None,
        lateral_unit=lateral_unit,
        steps_from_size={"length_x", "length_y"} <= set(said)
        and not {"dx", "dy", "step", "nx", "ny"} & set(said),
        **words,
    )
    return MeasuredFile("text matrix", [channel], first_row="top")


def _profile(
    table: np.ndarray, columns: list[str | None] | None, said: dict[str, Any], path: Path
) -> MeasuredFile:
    """Return a profile of positions and heights, in any order of the points."""
    x, z = table[np.argsort(table[:, 0], kind="stable")].T
    lateral_unit, height_unit = _units(columns, said, path)
    heights, words = _heights(z[None, :], said, height_unit)
    words["lateral_unit"] = lateral_unit
    try:
        step = even_step(x, "x")
        channel = Channel(shape=heights.shape, read=lambda: heights, dx=step, first_x=float(x[0]), **words)
    except UnevenPositionsError as error:
        channel = scattered(x=x, y=None, z=heights, error=error, **words)
    return MeasuredFile("text profile (x, z)", [channel], first_row="bottom")


def _points(
    table: np.ndarray, columns: list[str | None] | None, said: dict[str, Any], path: Path
) -> MeasuredFile:
    """Return a list of points on the even grid that it forms, or as it is."""
    if not np.isfinite(table[:, :2]).all():
        raise InputFileError(f"{path}: a point of the list has no position")
    x, y, z = table.T
    lateral_unit, height_unit = _units(columns, said, path)
    z, words = _heights(z, said, height_unit)
    words["lateral_unit"] = lateral_unit
    try:
        heights, steps, (first_x, first_y) = points_on_grid(x, y, z, path)
        channel = Channel(
            shape=heights.shape,
            read=lambda: heights,
            dx=steps["x"],
            dy=steps["y"],
            first_x=first_x,
            first_y=first_y,
            **words,
        )
    except UnevenPositionsError as error:
        channel = scattered(x=x, y=y, z=z, error=error, **words)
    return MeasuredFile("text list of points (x, y, z)", [channel], first_row="bottom")


def _steps(said: dict[str, Any], points: dict[str, int], path: Path) -> tuple[dict[str, float], str | None]:
    """Return the steps that a header says, by axis, and their unit."""
    steps, units = {}, []
    for axis, count in points.items():
        for word, share in (("d" + axis, 1), ("step", 1), ("length_" + axis, count)):
            if said.get(word) is not None:
                steps[axis] = said[word] / share
                units.append(said.get(word + "_unit", said.get("lateral_unit")))
                break
    lateral_unit = next((unit for unit in units if unit), said.get("lateral_unit"))
    for axis, unit in zip(steps, units, strict=True):
        if unit and lateral_unit and unit != lateral_unit:  # x in µm, y in mm
            steps[axis] *= metres(unit, where=str(path)) / metres(lateral_unit, where=str(path))
    return steps, lateral_unit


def _heights(
    numbers: np.ndarray, said: dict[str, Any], unit: str | None
) -> tuple[np.ndarray, dict[str, Any]]:
    """Return the heights, and the words of their channel: its name, their unit, why they are none."""
    if said.get("z_factor") is not None:  # the numbers are counts or phases; the factor makes them lengths
        numbers, unit = numbers * said["z_factor"], said.get("z_factor_unit", unit)
    wrong = unit is not None and not is_length(unit)
    return numbers, {
        "name": said.get("channel", "height"),
        "height_unit": unit,
        "no_height": f"values in {unit!r}, no length" if wrong else "",
    }


def _units(
    columns: list[str | None] | None, said: dict[str, Any], path: Path
) -> tuple[str | None, str | None]:
    """Return lateral and height unit of a list with columns x (y) z."""
    if columns is None:
        return said.get("lateral_unit"), said.get("height_unit")
    lateral = [unit for unit in columns[:-1] if unit]
    if len(set(lateral)) > 1:
        raise InputFileError(
            f"{path}: the columns x and y have different units, {lateral[0]!r} and {lateral[1]!r}"
        )
    return lateral[0] if lateral else said.get("lateral_unit"), columns[-1] or said.get("height_unit")


READER = Reader(ToldBy.TEXT, recognises, read)
