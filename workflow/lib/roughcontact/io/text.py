"""Text files: matrices of heights, lists of points x y z, profiles x z, with or without a header.

A matrix is read as it is printed: row 0 is the first line, which programs that write such files draw at the
top. The points of a list carry their positions, so their row 0 is the lowest line.
"""

import re
from collections import Counter
from pathlib import Path

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import Channel, SourceFile, UnevenPositions, even_step, scattered
from roughcontact.io.guards import check_memory, check_points
from roughcontact.io.metadata import instrument_words
from roughcontact.io.units import is_length, metres

_MISSING = {"nan", "na", "n/a", "bad", "null", "none", "-", "--", "***", "void", "inf", "+inf", "-inf", ""}
_BYTE_ORDER_MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}

# what a line of the header may say: meaning -> spellings (lower case, without _ and -)
_HEADER_WORDS = {
    "length_x": (
        "width",
        "x size",
        "size x",
        "xsize",
        "x length",
        "length x",
        "scan width",
        "x range",
        "range x",
    ),
    "length_y": (
        "height",
        "y size",
        "size y",
        "ysize",
        "y length",
        "length y",
        "scan height",
        "y range",
        "range y",
    ),
    "step": ("pixel size", "pixelsize", "cell size", "cellsize", "spacing", "step", "resolution"),
    "dx": (
        "dx",
        "x step",
        "step x",
        "xstep",
        "pixel width",
        "x spacing",
        "spacing x",
        "x increment",
        "xscale",
    ),
    "dy": (
        "dy",
        "y step",
        "step y",
        "ystep",
        "pixel height",
        "y spacing",
        "spacing y",
        "y increment",
        "yscale",
    ),
    "nx": ("w", "nx", "columns", "ncols", "x pixels", "xpixels", "x points", "samples", "points per line"),
    "ny": ("h", "ny", "rows", "nrows", "y pixels", "ypixels", "y points", "lines"),
    "height_unit": (
        *(
            "value units",
            "value unit",
            "z unit",
            "z units",
            "zunit",
            "height unit",
            "height units",
            "data unit",
        ),
        *("exported image units", "image units", "image data unit", "heights in"),
    ),
    "lateral_unit": ("lateral unit", "lateral units", "xy unit", "xy units", "x unit", "xunit"),
    "z_factor": ("height conversion factor", "z factor", "zfactor"),
    "missing": ("nodata value", "nodata", "missing value", "no data value"),
    "channel": ("channel", "channel name"),
    "instrument": ("instrument", "instrument name", "microscope", "device"),
    "serial": ("serial", "serial number", "serial no", "instrument serial number"),
    "lens": ("lens", "objective", "objective lens"),
    "date": ("date", "date time", "acquisition date", "acquisition time", "measured"),
}
_WORDS = (
    "channel",
    "height_unit",
    "lateral_unit",
    "instrument",
    "serial",
    "lens",
    "date",
)  # that are no numbers
_MEANING = {word: meaning for meaning, words in _HEADER_WORDS.items() for word in words}
_BYTES_PER_BYTE = 12  # memory for each byte of text: lines, their pieces, numbers
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


def looks_like_text(head: bytes) -> bool:
    """Return whether the first bytes of a file are text (UTF-8, UTF-16 with its mark, or an 8-bit code)."""
    if any(head.startswith(mark) for mark in _BYTE_ORDER_MARKS):
        return True
    return bool(head) and not any((byte < 32 and byte not in b"\t\n\r\f") or byte == 127 for byte in head)


def read_text(path: Path) -> SourceFile:
    """Open a text file and find out by its content whether it is a matrix, a list of points or a profile."""
    size = path.stat().st_size
    check_memory(size * _BYTES_PER_BYTE, f"{size} bytes of text", path)
    lines = _decode(path.read_bytes(), path).replace("−", "-").splitlines()
    header, body, first = _split(lines, path)
    said = _parse_header(header)
    delimiter, decimal_comma = _separators(body, path)
    table = _parse_table(body, delimiter, decimal_comma, first, path)
    if said.get("missing") is not None:
        table[table == float(said["missing"])] = np.nan
    columns = _column_units(header, table.shape[1], delimiter)
    ny, nx = table.shape
    declared = said.get("nx"), said.get("ny")
    if declared[0] is None and ny > 2 and nx == 3:
        source = _points(table, columns, said, path)
    elif declared[0] is None and ny > 2 and nx == 2:
        source = _profile(table, columns, said, path)
    else:
        source = _matrix(table, said, path)
    words = {"name": "instrument", "serial": "serial", "lens": "lens", "acquisition_time": "date"}
    source.instrument = instrument_words({word: said.get(key) for word, key in words.items()})
    return source


def _decode(data: bytes, path) -> str:
    if len(data) > 2**30:
        raise InputFileError(f"{path}: {len(data)} bytes of text; convert the map to X3P, SDF or netCDF")
    for mark, encoding in _BYTE_ORDER_MARKS.items():
        if data.startswith(mark):
            try:
                return data.decode(encoding)
            except UnicodeDecodeError as error:
                raise InputFileError(f"{path}: damaged {encoding} text ({error})") from error
    if b"\0" in data:
        raise InputFileError(f"{path}: starts as text but goes on as binary data; this format is not known")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _number(token: str) -> float:
    """Return the value of a token, NaN for a word that stands for a missing point."""
    token = token.strip()
    if token.lower() in _MISSING:
        return np.nan
    if "_" in token:  # Python would read 1_000
        raise ValueError(f"no number: {token!r}")
    return float(token)


def _is_data(line: str) -> bool:
    if not line.strip() or line.lstrip()[0] in "#%;!\\*/":
        return False
    tokens = re.split(r"[;\t,\s]+", line.strip().strip(";,"))
    try:
        values = [_number(token) for token in tokens]
    except ValueError:
        return False
    return bool(np.isfinite(values).any()) or len(values) > 1


def _split(lines, path):
    """Return the header lines, the data lines, and the number of the first data line (counted from 1)."""
    start = next((number for number, line in enumerate(lines) if _is_data(line)), None)
    if start is None:
        first = next((line.strip() for line in lines if line.strip()), "")
        raise InputFileError(f"{path}: text without a table of numbers; it starts with {first[:60]!r}")
    return lines[:start], lines[start:], start + 1


def _separators(body, path) -> tuple[str | None, bool]:
    """Return the delimiter (None: white space) and whether the decimal sign is a comma."""
    sample = [line.strip() for line in body[:50] if line.strip()]
    joined = "\n".join(sample)
    if ";" in joined:
        return ";", "," in joined
    if "\t" in joined:
        return "\t", "," in joined
    if "," not in joined:
        return None, False
    words = [line.split() for line in sample]
    if any(len(row) > 1 for row in words) and not any(word.endswith(",") for row in words for word in row):
        return None, True
    if all(line.count(",") == 1 and "." not in line for line in sample) and len(sample) > 1:
        raise InputFileError(
            f"{path}: the comma in {sample[0]!r} may be a decimal sign or a separator; "
            "write decimals with a point, or separate columns with a tab or a semicolon"
        )
    return ",", False


def _parse_table(body, delimiter, decimal_comma, first, path) -> np.ndarray:
    rows = []
    for number, line in enumerate(body, start=first):
        text = line.strip(" \r\f" if delimiter == "\t" else None)
        if not text.strip() or text.lstrip()[0] in "#%":
            continue
        if decimal_comma:
            text = text.replace(",", ".")
        if delimiter is not None:
            text = text.rstrip().removesuffix(delimiter)  # a separator at the end of a line closes it
        try:
            rows.append([_number(token) for token in text.split(delimiter)])
        except ValueError as error:
            raise InputFileError(f"{path}: line {number} is no row of numbers ({error})") from error
    counts = Counter(map(len, rows))
    if len(counts) > 1:
        width = counts.most_common(1)[0][0]
        bad = next(index for index, row in enumerate(rows) if len(row) != width)
        cut = "; the last line is not whole: the file was cut off" if bad == len(rows) - 1 else ""
        raise InputFileError(
            f"{path}: row {bad + 1} has {len(rows[bad])} numbers where the others have {width}{cut}"
        )
    check_points((len(rows), len(rows[0])), path)
    return np.array(rows, dtype=float)


def _parse_header(lines) -> dict:
    """Return what the header says: meaning -> value, and meaning + '_unit' -> unit of that value."""
    said = {}
    for line in lines:
        line = re.sub(r"(\d),(\d)", r"\1.\2", line.strip().lstrip("#%;!\\*/ \t").strip())
        pairs = re.findall(r"(\w+)\s*=\s*(\S+)", line)
        if len(pairs) > 1:  # "h=305 w=75"
            for key, value in pairs:
                _note(said, key, "", value)
            continue
        match = re.match(r"([^:=\t]+?)\s*[:=\t]\s*(.*)$", line) or re.match(r"(\w+)\s+(\S+)$", line)
        if match:
            key, value = match.groups()
            unit = re.search(r"[(\[]\s*(?:->)?\s*([^)\]]+?)\s*[)\]]", key)
            _note(said, re.sub(r"[(\[].*", "", key), unit[1] if unit else "", value)
    return said


def _note(said, key, unit, value):
    meaning = _MEANING.get(re.sub(r"[\s_-]+", " ", key).strip().lower())
    if meaning is None or meaning in said:
        return
    if meaning in _WORDS:
        if value.strip():
            said[meaning] = value.strip()
        return
    match = re.match(rf"({_NUMBER})\s*(.*)$", value.strip())
    if match:
        said[meaning] = float(match[1])
        unit = match[2].strip().strip("()[]") or unit
        if unit:
            said[meaning + "_unit"] = unit


def _column_units(header, count, delimiter) -> list[str | None] | None:
    """Return the unit of each column from a line of column names, `x (µm)`, `X_[mm]` or `z/nm`."""
    for line in reversed(header):
        names = line.strip().lstrip("#%").strip().split(delimiter)
        if len(names) != count or delimiter is None:
            continue
        units = [re.search(r"[(\[]\s*([^)\]]+?)\s*[)\]]|/\s*(\S+)$", name) for name in names]
        return [match and (match[1] or match[2]) for match in units]
    return None


def _matrix(table, said, path) -> SourceFile:
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
    steps, units = {}, []
    for axis, points in (("x", nx), ("y", ny)):
        for word, share in (("d" + axis, 1), ("step", 1), ("length_" + axis, points)):
            if said.get(word) is not None:
                steps[axis] = said[word] / share
                units.append(said.get(word + "_unit", said.get("lateral_unit")))
                break
    lateral_unit = next((unit for unit in units if unit), said.get("lateral_unit"))
    for axis, unit in zip(steps, units, strict=True):
        if unit and lateral_unit and unit != lateral_unit:  # x in µm, y in mm
            steps[axis] *= metres(unit, where=str(path)) / metres(lateral_unit, where=str(path))
    from_size = "length_x" in said and "length_y" in said and not {"dx", "dy", "step", "nx", "ny"} & set(said)
    return SourceFile(
        "text matrix",
        [_channel(table, said, said.get("height_unit"), steps, lateral_unit, from_size)],
        first_row="top",
    )


def _channel(table, said, height_unit, steps, lateral_unit, from_size=False, first=(None, None)):
    values = table
    if said.get("z_factor") is not None:  # the numbers are counts or phases; the factor makes them lengths
        values, height_unit = table * said["z_factor"], said.get("z_factor_unit", height_unit)
    wrong = height_unit is not None and not is_length(height_unit)
    return Channel(
        name=said.get("channel", "height"),
        shape=values.shape,
        read=lambda: values,
        height_unit=height_unit,
        dx=steps.get("x"),
        dy=steps.get("y") if table.shape[0] > 1 else None,
        lateral_unit=lateral_unit,
        first_x=first[0],
        first_y=first[1],
        no_height=f"values in {height_unit!r}, no length" if wrong else "",
        steps_from_size=from_size,
    )


def _units_of_columns(columns, said, path):
    """Return lateral and height unit of a list with columns x (y) z."""
    if columns is None:
        return said.get("lateral_unit"), said.get("height_unit")
    lateral = [unit for unit in columns[:-1] if unit]
    if len(set(lateral)) > 1:
        raise InputFileError(
            f"{path}: the columns x and y have different units, {lateral[0]!r} and {lateral[1]!r}"
        )
    return lateral[0] if lateral else said.get("lateral_unit"), columns[-1] or said.get("height_unit")


def _profile(table, columns, said, path) -> SourceFile:
    table = table[np.argsort(table[:, 0], kind="stable")]
    lateral_unit, height_unit = _units_of_columns(columns, said, path)
    x, heights = table.T
    try:
        step = even_step(x, "x")
        channel = _channel(
            heights[None, :], said, height_unit, {"x": step}, lateral_unit, first=(float(x[0]), None)
        )
    except UnevenPositions as error:
        channel = _scattered(x, None, heights, said, height_unit, lateral_unit, error)
    return SourceFile("text profile (x, z)", [channel], first_row="bottom")


def _points(table, columns, said, path) -> SourceFile:
    """Put a list of points x, y, z on the even grid that it forms; absent grid points are missing points.

    Positions are sorted into lines by gaps larger than half the median step, so that rounding does no harm.
    """
    if not np.isfinite(table[:, :2]).all():
        raise InputFileError(f"{path}: a point of the list has no position")
    lateral_unit, height_unit = _units_of_columns(columns, said, path)
    try:
        heights, steps, first = _on_grid(table, path)
        channel = _channel(heights, said, height_unit, steps, lateral_unit, first=first)
    except UnevenPositions as error:
        if np.unique(table[:, 0] + 1j * table[:, 1]).size != len(table):
            raise _same_position(path) from error
        channel = _scattered(*table.T, said, height_unit, lateral_unit, error)
    return SourceFile("text list of points (x, y, z)", [channel], first_row="bottom")


def _on_grid(table, path):
    """Return the heights (ny, nx) of a list of points, the steps and the position of the first grid point."""
    x, column = _grid_lines(table[:, 0], "x")
    y, row = _grid_lines(table[:, 1], "y")
    if len(table) < 0.5 * x.size * y.size:
        raise UnevenPositions(
            f"{len(table)} points x y z do not form an even grid ({x.size} different x, {y.size} different y)"
        )
    check_points((y.size, x.size), path)
    if np.unique(row * x.size + column).size != len(table):
        raise _same_position(path)
    _refuse_cut_list(row, column, path)
    heights = np.full((y.size, x.size), np.nan)
    heights[row, column] = table[:, 2]
    steps = {name: even_step(lines, name) if lines.size > 1 else None for name, lines in (("x", x), ("y", y))}
    return heights, steps, (float(x[0]), float(y[0]))


def _same_position(path):
    return InputFileError(f"{path}: several points of the list have the same position")


def _scattered(x, y, z, said, height_unit, lateral_unit, error):
    """Return the channel of points off any grid, with the units that `_channel` finds for the heights."""
    full = _channel(np.asarray(z)[None, :], said, height_unit, {}, lateral_unit)
    words = {"height_unit": full.height_unit, "lateral_unit": lateral_unit, "no_height": full.no_height}
    return scattered(full.name, x, y, full.read(), error, **words)


def _refuse_cut_list(row, column, path):
    """Refuse a list in which only the grid line that stands last in the file is incomplete, at its end."""
    for line, across in ((row, column), (column, row)):
        written_by_line = np.count_nonzero(np.diff(line)) == np.unique(line).size - 1
        counts = np.bincount(line)
        others = np.delete(counts, line[-1])
        if written_by_line and others.size and others.min() == others.max() > counts[line[-1]]:
            before = across[line != line[-1]][: others[0]]
            if np.array_equal(across[line == line[-1]], before[: counts[line[-1]]]):
                raise InputFileError(
                    f"{path}: the list of points ends in the middle of a grid line: the file was cut off"
                )


def _grid_lines(positions, name):
    """Return the distinct positions of the grid lines and the line of each point."""
    distinct = np.unique(positions)
    if distinct.size == 1:
        return distinct, np.zeros(positions.size, dtype=int)
    gaps = np.diff(distinct)
    limit = 0.5 * np.max(gaps)
    if np.any((gaps < limit) & (gaps > 0.02 * np.max(gaps))):
        raise UnevenPositions(
            f"the points x y z do not lie on an even grid (steps along {name} between "
            f"{gaps.min():g} and {gaps.max():g})"
        )
    starts = np.concatenate([[0], np.flatnonzero(gaps > limit) + 1])
    centres = np.add.reduceat(distinct, starts) / np.diff(np.append(starts, distinct.size))
    line = np.searchsorted(starts, np.searchsorted(distinct, positions), side="right") - 1
    return centres, line
