"""Text files: matrices of heights, lists of points x y z, profiles x z, with or without a header.

The first line of a matrix is the upper one, as in the files of instrument software; without a header this is
an assumption. Where positions are given, in a list of points or beside a matrix, y increases upwards.
"""

from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import (
    Channel,
    MeasuredFile,
    UnevenPositionsError,
    even_step,
    rounded_step,
    scattered,
    unreadable,
)
from roughcontact.io.guards import check_memory
from roughcontact.io.interface import Reader, RecognisedBy
from roughcontact.io.markers import remove_marker_values
from roughcontact.io.metadata import instrument_metadata
from roughcontact.io.text.columns import Column, headed, unit_of_heights
from roughcontact.io.text.doubts import counting, cut_number, refuse_lost_row, thousands
from roughcontact.io.text.header import parse_header
from roughcontact.io.text.lines import lines_of, looks_like_text
from roughcontact.io.text.point_grid import points_on_grid
from roughcontact.io.text.table import (
    Table,
    counted,
    parse_table,
    separators,
    split_header,
    unquoted,
)
from roughcontact.io.units import is_length, metres, same_length
from roughcontact.quantities import several

_MEMORY_PER_BYTE = 12  # bytes of memory per byte of text: lines, their cells, numbers
_SIZES = {"length_x", "length_y", "dx", "dy", "step", "nx", "ny"}  # header entries on the size of a map
_MAX_NARROW_ROWS = 1000  # rows of two or three columns that may be a map
_DEPTHS = ("depth", "tiefe", "profond", "profund")  # prefixes of headings that may be positive downwards
# key of `roughcontact.io.metadata` -> key of the header
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
    """Open a text file and decide by its content whether it is a matrix, a list of points or a profile.

    The channel has the steps and units of the header and the column names. A file that can be read in two
    ways is refused.
    """
    size = path.stat().st_size
    check_memory(size * _MEMORY_PER_BYTE, f"{size} bytes of text", path)
    header, body = unquoted(*split_header(lines_of(path), path))
    first = len(header) + 1
    delimiter, decimal_comma = separators(body, path)
    counts, rows = counted(body, delimiter)
    table = parse_table(rows, delimiter, decimal_comma, path, first=first + len(body) - len(rows))
    said = parse_header(header)
    refuse_lost_row(header, table.values.shape[1], delimiter, decimal_comma, path)
    doubts = [
        f"{word!r} occurs in {several(count, 'cell')} of the table and is taken as missing: "
        "write NaN if the point is missing, or correct it"
        for word, count in table.spoken.items()
    ]
    remove_marker_values(table.values, [float(said["missing"])] if said.get("missing") is not None else [])
    doubts += thousands(header, rows, table.values, delimiter, decimal_comma, path)
    doubts += cut_number(rows, delimiter, path)
    file = _file(table, header, said, counts, delimiter, path)
    file.warnings += doubts
    file.instrument = instrument_metadata({word: said.get(key) for word, key in _INSTRUMENT.items()})
    return file


def _file(
    table: Table,
    header: list[str],
    said: dict[str, Any],
    counts: list[int],
    delimiter: str | None,
    path: Path,
) -> MeasuredFile:
    """Return the file contents; header and headings decide on its kind, then the form of the columns."""
    values = table.values
    columns = headed(header, values.shape[1], delimiter)
    if "height_unit" not in said and (unit := unit_of_heights(header)):
        said = said | {"height_unit": unit}
    if not {"length_x", "length_y", "nx", "ny"} & set(said):
        kept = slice(table.empty_left, values.shape[1] - table.empty_right)
        columns = columns and columns[kept]
        values = values[:, kept]
        columns = columns or headed(header, values.shape[1], delimiter)
    if table.empty_corner and not table.empty_left and (axes := _axes_of_a_matrix(values)):
        dy, dx = axes
        rising = values[1:, 1:][:: -1 if dy < 0 else 1, :: -1 if dx < 0 else 1]
        file = _matrix(rising, {"dx": abs(dx), "dy": abs(dy)} | said, path)
        file.first_row, file.first_row_assumed = "bottom", False
        return file
    _refuse_cut_table(values.shape, said, counts, path)
    if columns is not None:
        chosen = _columns_by_name(columns)
        if chosen is not None:
            return _point_list(values, columns, chosen, said, path)
    rows, count = values.shape
    if count == 1 and rows > 1 and not _SIZES & set(said):
        return _one_column(values, columns, said, path)
    if count not in (2, 3) or rows <= 2 or _is_stated_matrix(values, said):
        _refuse_unnamed_points(values, said, path)
        file = _matrix(values, said, path)
        file.warnings += counting(values)
        return file
    columns = columns or [Column("", None, "")] * count
    return _point_list(values, columns, list(range(count)), said, path, named=False)


def _columns_by_name(columns: list[Column]) -> list[int] | None:
    """Return the columns of positions and heights by their names, or None if the names are unknown."""
    roles = [column.role for column in columns]
    places = {role: roles.index(role) for role in ("x", "y", "z") if roles.count(role) == 1}
    if len(places) == 3:
        return [places["x"], places["y"], places["z"]]
    data = [place for place, role in enumerate(roles) if role not in ("index", "valid")]
    if len(data) == len(columns) or len(data) not in (2, 3):
        if "x" in places and "z" in places and len(data) == 2:
            return [places["x"], places["z"]]
        return None
    return data


def _point_list(
    values: np.ndarray,
    columns: list[Column],
    chosen: list[int],
    said: dict[str, Any],
    path: Path,
    *,
    named: bool = True,
) -> MeasuredFile:
    """Return a list of points or a profile, from the selected columns."""
    listed = values[:, chosen]
    for place, column in enumerate(columns):
        if column.role == "valid":
            listed[values[:, place] == 0, -1] = np.nan
    listed = listed[~np.isnan(listed).all(axis=1)]
    units = [columns[place].unit for place in chosen]
    kind = _points if len(chosen) == 3 else _profile
    file = kind(listed, units, said, path, None if named else values)
    if (name := columns[chosen[-1]].name).lower().startswith(_DEPTHS):
        file.channels[0].notes.append(
            f"the heights are those of the column {name!r}, as they are; if it counts downwards, change "
            "their sign"
        )
    return file


def _is_stated_matrix(values: np.ndarray, said: dict[str, Any]) -> bool:
    """Return whether a header makes a table of two or three columns a matrix of heights.

    Beside a header that gives the size of the field, the columns are positions only where they form a whole
    grid of three lines and more each way (a profile: even steps), which heights do not.
    """
    rows, count = values.shape
    if said.get("nx") is not None or said.get("ny") is not None:
        return said.get("nx") in (count, None) and said.get("ny") in (rows, None)
    if not ({"step"} <= set(said) or {"length_x", "length_y"} <= set(said) or {"dx", "dy"} <= set(said)):
        return False
    if not np.isfinite(values[:, : count - 1]).all():
        return True
    if count == 2:
        try:
            even_step(np.sort(values[:, 0]), "x")
        except UnevenPositionsError:
            return True
        return False
    lines = [np.unique(values[:, place]).size for place in (0, 1)]
    return min(lines) < 3 or lines[0] * lines[1] != rows


def _refuse_unnamed_points(values: np.ndarray, said: dict[str, Any], path: Path) -> None:
    """Refuse a table whose first two columns are the positions of a grid, with more than one column after."""
    rows, count = values.shape
    if not 3 < count < 10 or _SIZES & set(said) or not np.isfinite(values[:, :2]).all():
        return
    lines = [np.unique(values[:, place]).size for place in (0, 1)]
    if min(lines) >= 3 and lines[0] * lines[1] == rows:
        raise InputFileError(
            f"{path}: the first two of {count} columns are positions on a grid of {lines[0]} x {lines[1]} "
            "points, and nothing says which of the others are the heights; name the columns in a line above "
            "them (x, y, z), or leave these three alone"
        )


def _axes_of_a_matrix(values: np.ndarray) -> tuple[float, float] | None:
    """Return the steps (dy, dx) of positions in the first row and column, negative where they fall.

    None where these are no positions.
    """
    if min(values.shape) < 3:
        return None
    try:
        return even_step(values[1:, 0], "y"), even_step(values[0, 1:], "x")
    except UnevenPositionsError:
        return None


def _refuse_cut_table(shape: tuple[int, ...], said: dict[str, Any], counts: list[int], path: Path) -> None:
    """Refuse a table with fewer rows than the file states."""
    rows, columns = shape
    stated = said.get("count")
    if len(counts) == 1:
        stated = counts[0]
    elif counts:
        if sorted(counts) != sorted(shape) and counts[0] * counts[1] != rows:
            raise InputFileError(
                f"{path}: the line above the table says {counts[0]} and {counts[1]}, the table has {rows} "
                f"rows of {columns} numbers; it was cut off or changed"
            )
        return
    if stated is not None and stated > rows and stated not in (columns, rows * columns):
        raise InputFileError(
            f"{path}: the file says {stated:g} points, the table has {rows} rows; it was cut off or changed"
        )


def _one_column(
    values: np.ndarray, columns: list[Column] | None, said: dict[str, Any], path: Path
) -> MeasuredFile:
    """Return one height per line: a profile, or a map of one column if the user gives both steps."""
    unit = said.get("height_unit", columns[0].unit if columns else said.get("unit"))
    heights, attributes = _heights(values.T, said, unit)
    matrix = _matrix(values, said, path)
    channel = Channel(
        shape=heights.shape, read=lambda: heights, lateral_unit=said.get("lateral_unit"), **attributes
    )
    channel.otherwise = matrix.channels[0]
    return MeasuredFile("text matrix", [channel], first_row="top")


def _matrix(table: np.ndarray, said: dict[str, Any], path: Path) -> MeasuredFile:
    """Return a matrix of heights, with steps or size from the header."""
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
    heights, attributes = _heights(table, said, said.get("height_unit", said.get("unit")))
    channel = Channel(
        shape=heights.shape,
        read=lambda: heights,
        dx=steps.get("x"),
        dy=steps.get("y") if ny > 1 else None,
        lateral_unit=lateral_unit,
        **attributes,
    )
    if {"length_x", "length_y"} <= set(said) and not {"dx", "dy", "step", "nx", "ny"} & set(said):
        channel.size_rounding = tuple(
            said[f"length_{axis}_rounding"] / said[f"length_{axis}"] if said[f"length_{axis}"] else 0.0
            for axis in "xy"
        )
    assumed = not _SIZES & set(said)  # programs that write sizes begin at the top
    return MeasuredFile("text matrix", [channel], first_row="top", first_row_assumed=assumed)


def _profile(
    table: np.ndarray, units: list[str | None], said: dict[str, Any], path: Path, whole: np.ndarray | None
) -> MeasuredFile:
    """Return a profile from positions and heights in any order."""
    x, z = table[np.argsort(table[:, 0], kind="stable")].T
    _refuse_lost_lines((1, x.size), said, path)
    lateral_unit, height_unit = _units(units, said, path)
    heights, attributes = _heights(z[None, :], said, height_unit)
    attributes["lateral_unit"] = lateral_unit
    try:
        step, notes = _even_step(x)
        channel = Channel(
            shape=heights.shape, read=lambda: heights, dx=step, first_x=float(x[0]), notes=notes, **attributes
        )
    except UnevenPositionsError as error:
        channel = scattered(x=x, y=None, z=heights, error=error, **attributes)
        channel.otherwise = None if whole is None else _as_matrix(whole, said)
    return MeasuredFile("text profile (x, z)", [channel], first_row="bottom")


def _even_step(x: np.ndarray) -> tuple[float, list[str]]:
    """Return the step of positions that are evenly spaced, at least within their rounding."""
    try:
        return even_step(x, "x"), []
    except UnevenPositionsError:
        step = rounded_step(x)
        if step is None:
            raise
        note = "the positions are even up to the rounding of their last digit in the file, and taken as even"
        return step, [note]


def _points(
    table: np.ndarray, units: list[str | None], said: dict[str, Any], path: Path, whole: np.ndarray | None
) -> MeasuredFile:
    """Return a list of points on the regular grid that it forms, or as an irregular list."""
    x, y, z = table.T
    lateral_unit, height_unit = _units(units, said, path)
    z, attributes = _heights(z, said, height_unit)
    attributes["lateral_unit"] = lateral_unit
    try:
        if not np.isfinite(table[:, :2]).all():
            raise InputFileError(f"{path}: a point of the list has no position")
        heights, steps, (first_x, first_y), notes = points_on_grid(x, y, z, path)
        _refuse_lost_lines(heights.shape, said, path)
        channel = Channel(
            shape=heights.shape,
            read=lambda: heights,
            dx=steps["x"],
            dy=steps["y"],
            first_x=first_x,
            first_y=first_y,
            notes=notes,
            **attributes,
        )
    except UnevenPositionsError as error:
        if whole is not None and np.ptp(np.diff(x)) == 0 and abs(x[1] - x[0]) == 1:
            error = UnevenPositionsError(
                f"{error}; the first column counts the rows: delete it if it is no x"
            )
        channel = scattered(x=x, y=y, z=z, error=error, **attributes)
        channel.otherwise = None if whole is None else _as_matrix(whole, said)
    except InputFileError as error:
        if whole is None or (matrix := _as_matrix(whole, said)) is None:
            raise
        channel = Channel(
            shape=matrix.shape,
            read=unreadable(str(error)),
            otherwise=matrix,
            doubt=_without_path(error, path),
            **attributes,
        )
    return MeasuredFile("text list of points (x, y, z)", [channel], first_row="bottom")


def _refuse_lost_lines(shape: tuple[int, ...], said: dict[str, Any], path: Path) -> None:
    """Refuse a list with fewer lines or columns of points than its header states."""
    for word, found, name in (("nx", shape[1], "columns"), ("ny", shape[0], "rows")):
        if shape[0] == 1 and name == "rows":
            continue
        if said.get(word, 0) > found:
            raise InputFileError(
                f"{path}: the header says {said[word]:g} {name}, the points make {found}; "
                "the list was cut off or changed"
            )


def _without_path(error: Exception, path: Path) -> str:
    """Return a message without the path at its beginning."""
    return str(error).removeprefix(f"{path}: ")


def _as_matrix(table: np.ndarray, said: dict[str, Any]) -> Channel | None:
    """Return a table as a matrix, in case its columns are not positions; None if it cannot be a matrix."""
    rows, columns = table.shape
    if columns == 2:
        positions = bool(np.all(np.diff(table[:, 0]) > 0))
    else:  # each position along x and along y occurs several times: the lines of a scan
        along_x, along_y = (np.unique(table[:, place]).size for place in (0, 1))
        positions = max(along_x, along_y) <= rows / 2 <= along_x * along_y
    if positions or rows > _MAX_NARROW_ROWS:
        return None
    heights, attributes = _heights(table, said, said.get("height_unit", said.get("unit")))
    return Channel(
        shape=heights.shape,
        read=lambda: heights,
        lateral_unit=said.get("lateral_unit"),
        first_row="top",
        **attributes,
    )


def _steps(said: dict[str, Any], points: dict[str, int], path: Path) -> tuple[dict[str, float], str | None]:
    """Return the steps in the header, by axis, and their unit."""
    steps, units = {}, []
    for axis, count in points.items():
        for word, share in (("d" + axis, 1), ("step", 1), ("length_" + axis, count)):
            if said.get(word) is not None:
                steps[axis] = said[word] / share
                units.append(said.get(word + "_unit", said.get("lateral_unit", said.get("unit"))))
                break
    lateral_unit = next((unit for unit in units if unit), said.get("lateral_unit"))
    for axis, unit in zip(steps, units, strict=True):
        if unit and lateral_unit and unit != lateral_unit:  # x in µm, y in mm
            steps[axis] *= metres(unit, where=str(path)) / metres(lateral_unit, where=str(path))
    return steps, lateral_unit


def _heights(
    numbers: np.ndarray, said: dict[str, Any], unit: str | None
) -> tuple[np.ndarray, dict[str, Any]]:
    """Return the heights and the arguments of their channel: name, unit, reason if they are not heights."""
    if said.get("z_factor") is not None:  # the numbers are counts or phases; the factor makes them lengths
        numbers, unit = numbers * said["z_factor"], said.get("z_factor_unit", unit)
    wrong = unit is not None and not is_length(unit)
    return numbers, {
        "name": said.get("channel", "height"),
        "height_unit": unit,
        "no_height": f"values in {unit!r}, no length" if wrong else "",
    }


def _units(columns: list[str | None], said: dict[str, Any], path: Path) -> tuple[str | None, str | None]:
    """Return lateral and height unit of a list with columns x (y) z."""
    lateral = [unit for unit in columns[:-1] if unit]
    if len(set(lateral)) > 1 and not same_length(*lateral):
        raise InputFileError(
            f"{path}: the columns x and y have different units, {lateral[0]!r} and {lateral[1]!r}"
        )
    stated = said.get("lateral_unit", said.get("unit")), said.get("height_unit", said.get("unit"))
    return lateral[0] if lateral else stated[0], columns[-1] or stated[1]


READER = Reader(RecognisedBy.TEXT, recognises, read)
