"""Text files: matrices of heights, lists of points x y z, profiles x z, with or without a header.

The first line of a matrix is the upper one, as of instrument software; without a header this is an
assumption. Where positions are given, y increases upwards.
"""

import re
from collections import Counter
from dataclasses import replace
from itertools import islice
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from roughcontact.arguments.quantities import counted_noun
from roughcontact.io.channels import MIN_MARKER, NO_TOPOGRAPHY, Channel, MeasuredFile
from roughcontact.io.guards import listed, refusal, refusing
from roughcontact.io.interface import Reader, RecognisedBy
from roughcontact.io.metadata import LABELS, instrument_metadata
from roughcontact.io.positions import UnevenPositionsError, even_step, points_on_grid, rounded_step, scattered
from roughcontact.io.sources import conspicuous, marker_of, parse_lengths
from roughcontact.io.text.axes import are_points, begins_anew, find_axes, form_a_grid, uneven, wrapped
from roughcontact.io.text.columns import Column, are_map_columns, headed, layout, miscounted, unit_of_heights
from roughcontact.io.text.header import LENGTHS, Stated, Statement, check_agreement, contradiction, statements
from roughcontact.io.text.lines import looks_like_text, read_text
from roughcontact.io.text.table import Dialect, Rows, left_out, parse_table, split_text, thousands
from roughcontact.io.text.traces import are_traces, runs, turn
from roughcontact.io.units import is_length, metres, same_length
from roughcontact.io.vocabulary import pattern, words

_SIZES = {"length_x", "length_y", "dx", "dy", "step", "nx", "ny"}  # header entries on the size of a map
_MANY_PROFILES = 10  # columns; fewer beside a first one of positions may be profiles
_DEPTHS = ("depth", "tiefe", "profond", "profund")  # prefixes of headings that may be positive downwards
# headings of heights that were multiplied, turned, or are others than heights
_COMPUTED = re.compile(rf"(?i)[*×·/^]|\bx\s?\d|^[-−]|\blog\b|invert|{NO_TOPOGRAPHY.pattern}")
_SQUARE = pattern("aside", "square")  # names of the step of both axes
_NAMED, _LENGTH, _UNKNOWN, _NO_HEIGHT = range(4)  # ranks of columns of heights
_LONGEST_LINE = 4096  # characters of a line above a table that is searched for other statements
_PASSAGES = re.compile(r".{1,200}(?=[\s;,]|\Z)|.{1,200}", re.DOTALL)  # of it
_MAX_PASSAGES = 1000
_MAX_DISTANCE = 20  # lines above the table among which may be a heading with a unit
_SIDE = {axis: pattern("side", axis) for axis in "xy"}
_KEYENCE = -99999.9999  # that VR and VK series write for a missing point
_ARC_INFO = {"ncols", "nrows", "cellsize"}  # first words of the header of a grid
_IGOR = re.compile(r"IGOR\s+WAVES\S*\s+\S+\s+BEGIN\s(.*?)\sEND\b((?:(?!WAVES).)*)", re.DOTALL)
_IGOR_STEPS = re.compile(r'SetScale\s*/P\s*([xy])\s+[^,]+,\s*([^,]+),\s*"([^"]+)"')
_IGOR_UNIT = re.compile(r'SetScale\s*[dy]\s+[^,]+,[^,]+,\s*"([^"]+)"')  # y: of a wave of one dimension


class _Text(NamedTuple):
    """One table of a text, its rows, and what the lines above them state."""

    rows: Rows
    values: np.ndarray
    empty: np.ndarray  # columns (n,) without any cell
    empty_corner: bool  # the first cell is empty
    short: bool  # the first row held a word there, or lacked a cell
    delimiter: str | None
    stated: Stated
    columns: list[Column] | None
    doubts: list[str]


def read(path: Path) -> MeasuredFile:
    """Open a text file as a matrix, a list of points or a profile, by its content; both readings: refused."""
    return parsed(read_text(path))


def parsed(content: str) -> MeasuredFile:
    """Return what a text holds."""
    # all tables before any: whether a second one is a channel or a mistake shows only beside the first
    tables, counts, dialect, notes = split_text(_without_igor(content))
    texts: list[_Text] = []
    files: list[MeasuredFile] = []
    for table in tables:
        texts.append(_parsed(table, [] if texts else counts, dialect))
        files.append(_file(texts[-1]))
        files[-1].warnings += texts[-1].doubts
    file = files[0] if len(files) == 1 else _together(texts, files)
    file.warnings += notes
    file.instrument = instrument_metadata({key: texts[0].stated.first(key) for key in LABELS})
    return file


def _without_igor(content: str) -> str:
    """Return a wave of an Igor text as rows along x below its scale; another text as it is."""
    if not (wave := _IGOR.fullmatch(content)):
        return content
    header = [f"d{axis} = {step} {unit}" for axis, step, unit in _IGOR_STEPS.findall(wave[2])]
    header += [f"height unit = {unit}" for unit in _IGOR_UNIT.findall(wave[2])]
    with refusing("a damaged Igor text"):
        rows = zip(*(line.split() for line in wave[1].splitlines() if line.strip()), strict=True)
        return "\n".join([*header, "First row: bottom", *map("\t".join, rows), ""])


def _parsed(rows: Rows, counts: list[int], dialect: Dialect) -> _Text:
    """Return one table with its statements, and warnings about its numbers."""
    values, empty, empty_corner, short, doubts = parse_table(rows, dialect)
    width = values.shape[1]
    sign = "," if dialect.decimal_comma else "." if any("." in line for line in rows.texts) else ""
    by_meaning = statements(rows.heading, start=rows.first, sign=sign)
    # from the table upwards: of several headings the nearest is that of the heights
    lines = ((*each, unit_of_heights(each[1])) for each in rows.filled[: -_MAX_DISTANCE - 1 : -1])
    for number, line, unit in islice((heading for heading in lines if heading[2]), 1):
        by_meaning.setdefault("height_unit", []).append(Statement(unit, line=number, text=line.strip()))
    doubts += _add_markers(by_meaning, rows, values) + _add_counts(by_meaning, values)
    check_agreement(by_meaning)
    values[(np.abs(values) > MIN_MARKER) | (values == _KEYENCE)] = np.nan  # infinite ones too
    doubts += thousands(by_meaning, rows.texts[empty_corner:], dialect)  # without positions
    # a range of heights that is that of the numbers has their unit: no other line needs to say it
    markers = [statement.value for statement in by_meaning.get("missing", [])]
    finite = values[np.isfinite(values) & ~np.isin(values, markers)]
    span = np.ptp(finite) if finite.size else 0.0
    for extent in by_meaning.get("height_range", ())[:1]:
        if extent.unit and abs(extent.value - span) <= 0.01 * span:  # in the unit of the heights
            by_meaning.setdefault("height_unit", [extent._replace(value=extent.unit)])
    columns = headed(rows.heading, width, dialect.delimiter)
    if columns and width == 1 and columns[0].name and columns[0].role != "z":
        columns = None  # another line with a unit
    if not columns and width > 1 and np.array_equal(values[:, 0], np.arange(1, len(values) + 1)):
        named = headed(rows.heading, width - 1, dialect.delimiter)  # R numbers its rows, below no heading
        columns = [Column("", None, "index"), *named] if named else None
    # empty columns beside the map are a spreadsheet's; where a size is stated they may be part of the map
    if empty.any() and not {"length_x", "length_y", "nx", "ny"} & {*by_meaning}:
        occupied = slice(*(np.flatnonzero(~empty)[[0, -1]] + (0, 1)))
        empty_corner = bool(np.isnan(values[0, occupied.start])) if occupied.start else empty_corner
        values, empty = values[:, occupied], empty[occupied]
        if columns:
            columns = columns[occupied]
        elif omitted := width - empty.size:
            doubts.append(left_out(omitted, "column"))
            columns = headed(rows.heading, empty.size, dialect.delimiter)
    above = rows.filled[-1][1] if rows.filled else ""
    units = above.split()
    if empty_corner and len(units) == 3 < width and all(map(is_length, units)):  # FemtoScan: of x, y, z
        x, y, z = (Statement(unit, line=rows.filled[-1][0], text=above) for unit in units)
        by_meaning |= {"lateral_unit": [x, *[y] * same_length(x.value, y.value)], "height_unit": [z]}
    elif not columns and (names := miscounted(above, width, dialect.delimiter)):
        raise refusal("miscounted", text=above.strip()[:60], count=names, line=rows.lines[0], width=width)
    # "256 192" in one line counts both sides; counts in several lines may be of several things
    points = by_meaning.get("count", [])
    counts = counts or [count.value for count in points if count.line == points[0].line]
    _refuse_cut_table(values.shape, counts)
    return _Text(rows, values, empty, empty_corner, short, dialect.delimiter, by_meaning, columns, doubts)


def _add_markers(statements: Stated, rows: Rows, values: np.ndarray) -> list[str]:
    """Add markers of missing points: of the format, and of lines in any words; return what is doubtful."""
    if {line.split()[0].lower() for _, line in rows.filled} >= _ARC_INFO:
        statements.setdefault("missing", [Statement(-9999.0)])  # by default of the format
    used, doubts = {statement.line for group in statements.values() for statement in group}, []
    for number, line in rows.filled:
        marker = marker_of(line) if number not in used else np.nan
        is_number = marker < 0 or marker > values.size or marker % 1 > 0  # and may not be that of such points
        if is_number and marker in conspicuous(values[np.isfinite(values)]):
            statements.setdefault("missing", []).append(Statement(marker, line=number, text=line.strip()))
            points = counted_noun(int(np.count_nonzero(values == marker)), "point")
            doubts.append(f"{statements['missing'][-1]}: {points} with that height are missing")
    return doubts


def _add_counts(statements: Stated, values: np.ndarray) -> list[str]:
    """Add the height of a step along z where heights are whole numbers without a unit; return a note."""
    steps, heights = statements.pop("z_step", []), values[np.isfinite(values)]
    has_unit = {"height_unit", "unit", "z_factor"} & {*statements}
    if not steps or has_unit or not {*LENGTHS} & {*statements}:
        return []
    if np.any(heights[~np.isin(heights, [*conspicuous(heights)])] % 1):  # but for markers
        return []
    statements["z_factor"] = steps
    return [f"{steps[0]}: all heights are whole numbers, and taken as counts of it"]


def _unused(table: _Text) -> list[tuple[int, str]]:
    """Return the lines above a table, with their numbers, that are no statement and name no columns."""
    groups = (group for meaning, group in table.stated.items() if meaning not in ("length", "size", "factor"))
    used = Counter(statement.line for group in groups for statement in group)
    lines = ((number, line[:_LONGEST_LINE]) for number, line in table.rows.filled)
    passages = ((number, line, text) for number, line in lines for text in _PASSAGES.findall(line))
    return [
        (number, text.strip())
        for number, line, text in islice(passages, _MAX_PASSAGES)
        # a line of which only a part was understood is open for the rest of it
        if (number not in used or len(parse_lengths(text)) > used[number])
        # a long line of numbers says nothing
        and (text == line or 2 * len(re.findall(r"[^\W\d_]", text)) > len(text))
        and not _names(table.columns or [], line, table.delimiter)
        and not unit_of_heights(line)
    ]


def _names(columns: list[Column], line: str, delimiter: str | None) -> bool:
    """Return whether a line has the names of some columns, or their units; others may be as many words."""
    cells = headed([line], len(columns), delimiter) if columns else None
    pairs = zip(cells or (), columns, strict=False)
    same = (cell.name in ("", column.name) and cell.unit in (None, column.unit) for cell, column in pairs)
    return cells is not None and all(same)


def _together(texts: list[_Text], files: list[MeasuredFile]) -> MeasuredFile:
    """Return the tables of one text as channels of one file."""
    titles = [text.stated.first("channel") or _title(text) for text in texts]
    pairs = zip(texts, titles, strict=True)
    has_heading = [bool(text.stated or text.columns or (titles[0] and title)) for text, title in pairs]
    if not all(has_heading[1:]) and (has_heading[0] or not texts[0].rows.filled):
        raise refusal("table without a heading", line=texts[has_heading.index(False, 1)].rows.start[0])
    for number, (file, title) in enumerate(zip(files, titles, strict=True), start=1):
        for channel in file.channels:
            label = "" if len(file.channels) == 1 else f", {channel.name}"
            channel.name = (title or f"table {number}") + label
            channel.notes = file.warnings + channel.notes
            if file.first_row != files[0].first_row:
                channel.first_row = file.first_row
    file = replace(files[0], channels=[channel for each in files for channel in each.channels], warnings=[])
    profiles = [channel for channel in file.channels if channel.is_line and not channel.no_height]
    if file.question or len(profiles) > 1 or not any(titles):
        starts = [text.rows.start for text in texts[1:4] if text.rows.start[0] < text.rows.lines[0]]
        headings = "; ".join(f"{line.strip()[:30]!r} at line {number}" for number, line in starts)
        file.question = f"{counted_noun(len(texts), 'table')} below one another ({headings})"
    return file


def _title(text: _Text) -> str:
    """Return the line next above a table that is neither an entry of a header nor names its columns."""
    width = text.values.shape[1]
    for line in reversed(text.rows.heading):
        title = line.strip('#%;!," \t\r')
        if title and not statements([line]) and not headed([line], width, text.delimiter):
            return title[:60]
    return ""


def _file(text: _Text) -> MeasuredFile:
    """Return the file contents; header and headings decide on its kind, then the form of the columns."""
    values, columns = text.values, text.columns
    rows, count = values.shape
    groups = layout(columns) if columns else None
    if columns and not groups and any(column.name for column in columns) and not are_map_columns(columns):
        listing = listed([f"{name} ({unit})" if unit else name for name, unit, _ in columns if name])
        raise refusal("columns without meaning", count=count, listing=listing)
    # an empty corner tells positions beside a matrix from headings that name its columns
    has_positions = text.empty_corner and find_axes(values, corner=True) is not None
    if groups and not has_positions:
        return _lists(text, groups)
    is_column = count == 1 < rows and text.stated.first("nx") != 1
    is_narrow = 1 < count <= 3 and rows > 2 and not has_positions
    if is_column or (is_narrow and not _is_stated_matrix(values, text.stated)):
        return _lists(text, [[*range(count)]])
    if text.rows.broken:
        between = np.array(text.rows.lines) - text.rows.lines[0]
        # only a stated number of rows tells rows that are missing from a second table
        if text.stated.first("ny") != between[-1] + 1:
            raise refusal("table or rows", line=text.rows.broken)
        whole = np.full((between[-1] + 1, count), np.nan)  # as many rows as are stated
        whole[between] = values
        text = text._replace(values=whole)
    return _matrix_beside(text)


def _matrix_beside(text: _Text) -> MeasuredFile:
    """Return a matrix of heights without the positions in its first row and column."""
    values = text.values
    ny, nx = values.shape
    if row := begins_anew(values):
        raise refusal("positions anew", line=text.rows.lines[row])
    if begins_anew(values.T) or text.empty[1:-1].any():
        raise refusal("maps beside one another", line=text.rows.lines[0])
    unit, note = _unit_in_corner(text.rows.label)
    if heights_unit := unit_of_heights(text.rows.label):
        text.stated.setdefault("height_unit", [Statement(heights_unit, line=text.rows.lines[0])])
        note = ""
    # a unit of x and y, and no steps that it may be of, is that of positions
    with_unit = bool(unit) or ("lateral_unit" in text.stated and not {*LENGTHS} & {*text.stated})
    axes = find_axes(values, corner=text.empty_corner, positions=with_unit)
    if are_points(values.T):
        raise refusal("points in rows", line=text.rows.lines[0])
    if axes is None and (line := uneven(values)):
        raise refusal("uneven first line", which=line, line=text.rows.lines[0])
    # a header that counts the first row and column with the heights says that they are heights
    if axes is None or (text.stated.first("ny"), text.stated.first("nx")) == (ny, nx):
        if text.short:
            raise refusal("short first row", line=text.rows.lines[0], count=nx - 1, width=nx)
        return _matrix(values, text)
    heights, steps, description = axes
    file = _matrix(heights, text, **steps)
    (channel,) = file.channels
    channel.lateral_unit = channel.lateral_unit or (unit if len(steps) == 2 else None)
    file.warnings.append(description + (note if channel.lateral_unit is None else ""))
    if "dy" in steps:
        file.first_row, file.first_row_assumed = "bottom", False
    if channel.doubt:
        return file
    may_be_profiles = len(heights) == ny and nx < _MANY_PROFILES
    if wrong := _contradictions(text, steps, None, channel.shape):
        channel.doubt = f"{description}: {wrong}; correct the file, or {channel.scale_advice}"
    elif may_be_profiles and not {"length_y", "dy", "step", "ny"} & {*text.stated}:
        profiles, advice = counted_noun(nx - 1, "profile"), channel.scale_advice
        channel.doubt = str(refusal("profiles or rows", count=nx, profiles=profiles, advice=advice))
    return file


def _unit_in_corner(label: str) -> tuple[str | None, str]:
    r"""Return the unit of both axes in the corner of a matrix, and a note on a unit that is not used.

    Examples
    --------
    >>> _unit_in_corner("Y[µm]\\X[µm]"), _unit_in_corner("y (mm)")
    (('µm', ''), (None, "; 'y (mm)' in the corner is not used: check the units"))
    """
    tokens = re.findall(r"\w+", label)
    units = {token for token in tokens if is_length(token)}
    axes = [axis for token in tokens for axis in "xy" if _SIDE[axis].fullmatch(token)]
    if len(units) == 1 and axes == ["y", "x"] and len(tokens) <= 4:  # the rows are named first
        return units.pop(), ""
    return None, f"; {label!r} in the corner is not used: check the units" if units else ""


def _contradictions(text: _Text, steps: dict[str, float], unit: str | None, shape: tuple[int, int]) -> str:
    """Return what of the header the steps of positions contradict; without a unit they have its unit."""
    for key, step in steps.items():
        name = f"the positions have {key} = {step:.6g} {unit or ''}".strip()
        stated = Stated({key: [Statement(step, unit or "", 0.01 * step, text.rows.lines[0], name)]})
        for entry in (key, "step", f"length_{key[1]}"):
            for each in text.stated.get(entry, [])[:1]:
                stated.setdefault(entry, []).append(each if unit else each._replace(unit=""))
        if wrong := contradiction(stated, shape):
            return wrong
    return ""


def _lists(text: _Text, groups: list[list[int]]) -> MeasuredFile:
    """Return lists of points or profiles: one for each column of heights, and each trace in it."""
    columns = text.columns or [Column("", None, "")] * text.values.shape[1]
    values, usual_name = text.values, text.stated.first("channel") or "height"
    valid = [index for index, column in enumerate(columns) if column.role == "valid"]
    invalid = (values[:, valid] == 0).any(axis=1)
    files: list[tuple[int, MeasuredFile]] = []  # with their ranks
    for indices in groups:
        table = values[:, indices]
        table[invalid, -1] = np.nan
        if len(indices) == 1 < len(groups):  # columns of several lengths
            table = table[: len(table) - int(np.argmax(np.isfinite(table[::-1, 0])))]
        file = _list(table, [columns[index] for index in indices], text)
        column = columns[indices[-1]]
        name = column.name
        for channel in file.channels:
            if len(groups) > 1:
                channel.name = name if channel.name == usual_name else f"{name}, {channel.name}"
            as_they_are = f"the heights are those of the column {name!r}, as they are"
            if name.lower().startswith(_DEPTHS):
                channel.notes.append(f"{as_they_are}; if it counts downwards, change their sign")
            elif _COMPUTED.search(name):
                channel.notes.append(as_they_are)
        files.append((_rank(column, file), file))
    (rank, file), *alternatives = sorted(files, key=lambda entry: entry[0])
    if not alternatives:
        return file
    question = file.question
    # a column that nothing says to be a length is no rival of one that is
    if alternatives[0][0] <= max(rank, _LENGTH) < _NO_HEIGHT:
        names = ", ".join(repr(columns[indices[-1]].name) for indices in groups)
        question = f"{counted_noun(len(groups), 'column')} that may be heights: {names}"
    parts = [file, *(part for _, part in files if part is not file)]
    return replace(file, channels=[channel for part in parts for channel in part.channels], question=question)


def _list(table: np.ndarray, columns: list[Column], text: _Text) -> MeasuredFile:
    """Return one list with columns x (y) z, or z alone, of which x and y may have no name."""
    units = [column.unit for column in columns]
    _refuse_other_units(units, text)
    if len(columns) == 1:
        return _one_column(table[:, 0], columns[0], text)
    lateral = [unit for unit in units[:-1] if unit]
    factor = 1.0 if len(lateral) < 2 or same_length(*lateral) else _ratio(lateral[1], lateral[0], text)
    lateral_unit = [*lateral, text.stated.first("lateral_unit", "unit")][0]
    # empty cells below the shorter of two lists are no points of it
    has_values = ~np.isnan(table).all(axis=1)
    lines = [line for line, has_value in zip(text.rows.lines, has_values, strict=True) if has_value]
    *positions, heights = table[has_values].T
    has_position = np.isfinite(positions).all(axis=0)
    if not has_position.all():
        raise refusal("no position", line=lines[int(np.argmin(has_position))])
    channel = _channel(heights[None], text, columns[-1].unit, lateral_unit=lateral_unit)
    channel.sources |= {"dx": "positions", "dy": "positions"}
    if len(positions) == 1:
        return _profile(channel, positions[0], lines, text)
    return _points(channel, positions[0], positions[1] * factor, lines, text)


def _rank(column: Column, file: MeasuredFile) -> int:
    """Return the rank of a column of heights: by its name, its unit, neither, or none of heights."""
    if all(channel.no_height for channel in file.channels):
        return _NO_HEIGHT
    return _NAMED if column.role == "z" else _LENGTH if is_length(column.unit) else _UNKNOWN


def _is_stated_matrix(values: np.ndarray, statements: Stated) -> bool:
    """Return whether a header makes a table of two or three columns a matrix of heights.

    Beside a header that gives the size of the field, the columns are positions only where they form a whole
    grid of three lines and more each way (a profile: even steps), which heights do not.
    """
    rows, count = values.shape
    if statements.keys() & {"nx", "ny"}:
        return statements.first("nx") in (None, count) and statements.first("ny") in (None, rows)
    if not any(sizes <= statements.keys() for sizes in ({"step"}, {"length_x", "length_y"}, {"dx", "dy"})):
        return False
    if count == 3 or not np.isfinite(values[:, 0]).all():
        return not (np.isfinite(values[:, :-1]).all() and form_a_grid(values[:, 0], values[:, 1]))
    try:
        even_step(np.sort(values[:, 0]), "x")
    except UnevenPositionsError:
        return True
    return False


def _refuse_cut_table(shape: tuple[int, ...], counts: list[int]) -> None:
    """Refuse a table with fewer rows than the file states: their number, or those along both sides."""
    rows, columns = shape
    total, is_whole = prod(counts), prod(counts) == rows or sorted(counts) == sorted(shape)
    if is_whole and len(counts) == 2 and columns == 1 < min(counts):
        raise refusal("column of a map", rows=rows, counts=counts)
    if len(counts) == 1:
        # two or three columns are positions and heights, of which half may be lost
        is_whole = total <= rows or total == columns or (columns > 3 and total == rows * columns)
    if counts and not is_whole:
        statements = " and ".join(f"{count:g}" for count in counts)
        raise refusal("cut table", stated=statements, rows=rows, columns=columns)


def _one_column(heights: np.ndarray, column: Column, text: _Text) -> MeasuredFile:
    """Return a profile of one height per line."""
    if text.rows.broken:
        raise refusal("table or heights", line=text.rows.broken)
    if {"length_y", "dy", "ny"} & {*text.stated}:
        raise refusal("column with a size along y", rows=heights.size)
    for index, counter in enumerate(text.columns or ()):
        pieces = runs(text.values[:, index]) if counter.role == "index" else []
        if len(pieces) > 1:
            raise refusal("counter anew", name=counter.name, line=text.rows.lines[pieces[1].start])
    return _matrix(heights[None], text, column.unit)


def _matrix(table: np.ndarray, text: _Text, unit: str | None = None, /, **positions: float) -> MeasuredFile:
    """Return a matrix of heights, with steps or size from the header, or by the positions beside it."""
    ny, entries = len(table), text.stated
    sizes = _SIZES & {*entries}
    _refuse_lost_lines(table.shape, text, "the file has")
    if ny == 1 and "length_y" in entries:
        raise refusal("cut to one line")
    wrong = contradiction(entries, table.shape) or wrapped(table)
    steps, lateral_unit = ({}, None) if wrong else _steps(text, table.shape)
    steps = positions | steps
    dy = steps.get("dy") if ny > 1 else None
    channel = _channel(table, text, unit, dx=steps.get("dx"), dy=dy, lateral_unit=lateral_unit)
    channel.sources = dict.fromkeys(positions, "positions") | channel.sources
    if wrong:
        channel.doubt = f"{wrong}; correct the file, or {channel.scale_advice}"
    elif sizes == {"length_x", "length_y"}:
        lengths = [entries[f"length_{axis}"][0] for axis in "xy"]
        channel.size_rounding = tuple(length.rounding / (length.value or np.inf) for length in lengths)
    elif ny > 1 and sizes == {"step"} and not _SQUARE.search(entries["step"][0].text):
        channel.notes.append(f"{entries['step'][0]}: taken as the step along x and along y")
    # programs that write sizes begin at the top
    first_row, is_assumed = entries.first("first_row"), not sizes and "first_row" not in entries
    return MeasuredFile("text matrix", [channel], first_row or "top", first_row_assumed=is_assumed)


def _profile(channel: Channel, x: np.ndarray, lines: list[int], text: _Text) -> MeasuredFile:
    """Return a profile from positions that rise or fall, or several, where they begin anew."""
    traces = runs(x)
    if len(traces) == 1:
        return MeasuredFile("text profile (x, z)", [_trace(channel, x, text)], first_row="bottom")
    where = turn(x, traces, lines)
    if are_traces(x, traces):
        channels = []
        for number, trace in enumerate(traces, start=1):
            part = replace(channel, read=channel.read()[:, trace].copy, notes=[])
            channels.append(replace(_trace(part, x[trace], text), name=f"profile {number}"))
        profiles = counted_noun(len(traces), "profile")
        question = f"{where}: {profiles} below one another, 'profile 1' to 'profile {len(traces)}'"
        return MeasuredFile("text profiles (x, z)", channels, first_row="bottom", question=question)
    raise refusal("no profile", where=where)


def _trace(channel: Channel, x: np.ndarray, text: _Text) -> Channel:
    """Return one profile from positions that rise, or fall, evenly at least within their rounding."""
    order = slice(None, None, -1 if x[0] > x[-1] else 1)
    x, heights = x[order], channel.read()[:, order]
    _refuse_lost_lines(heights.shape, text)
    channel = replace(channel, shape=heights.shape, read=heights.copy)
    try:
        channel.dx = even_step(x, "x")
    except UnevenPositionsError as error:
        channel.dx = rounded_step(x)
        if channel.dx is None:
            return scattered(channel, x, None, heights, str(error) + _or_map(text))
        channel.notes.append("positions, even up to the rounding of their last digit, are taken as even")
    if wrong := _contradictions(text, {"dx": channel.dx}, channel.lateral_unit, channel.shape):
        channel.notes.append(f"{wrong}; the positions are used")
    channel.first_x = float(x[0])
    return channel


def _points(channel: Channel, x: np.ndarray, y: np.ndarray, lines: list[int], text: _Text) -> MeasuredFile:
    """Return a list of points on the regular grid that it forms, or as an irregular list."""
    z = channel.read()[0]
    try:
        heights, steps, origin = points_on_grid(x, y, z, lines)
        _refuse_lost_lines(heights.shape, text)
        stated_steps = {"d" + axis: step for axis, step in steps.items() if step}
        if wrong := _contradictions(text, stated_steps, channel.lateral_unit, heights.shape):
            channel.notes.append(f"{wrong}; the positions are used")
        if not channel.lateral_unit and set(steps.values()) == {1} and {*origin} <= {0, 1}:
            numbers = f"the positions count from {origin[0]:g} on"
            channel.notes.append(f"{numbers}: if they number the points, give dx and dy")
        channel.shape, channel.read = heights.shape, lambda: heights
        channel.dx, channel.dy, channel.first_x, channel.first_y = steps["x"], steps["y"], *origin
    except UnevenPositionsError as error:
        # x, z1, z2 of two profiles, or a counter before x and y, look like points x, y, z
        if text.columns is None and (are_points(np.column_stack([x, z])) or form_a_grid(y, z)):
            raise refusal("profiles or points", error=error) from error
        channel = scattered(channel, x, y, z, str(error) + _or_map(text))
    return MeasuredFile("text list of points (x, y, z)", [channel], first_row="bottom")


def _or_map(text: _Text) -> str:
    """Return what tells a map from a list, for one whose columns have no names."""
    return f" (of a map a line above says 'nx: {text.values.shape[1]}')" if text.columns is None else ""


def _refuse_lost_lines(shape: tuple[int, ...], text: _Text, content: str = "the points make") -> None:
    """Refuse a map with fewer lines or columns than its header states, a matrix also with more."""
    for entry, count, name in (("nx", shape[1], "columns"), ("ny", shape[0], "rows")):
        expected = text.stated.first(entry) if entry in text.stated else count
        exceeds = expected > count and (name == "columns" or shape[0] > 1)
        if exceeds if content == "the points make" else expected != count:
            raise refusal("lost lines", stated=expected, name=name, content=content, count=count)


def _steps(text: _Text, shape: tuple[int, ...]) -> tuple[dict[str, float], str | None]:
    """Return the steps in the header, `dx` and `dy`, and their unit."""
    steps: dict[str, float] = {}
    units: dict[str, str | None] = {}
    for axis, count in zip("yx", shape, strict=True):
        for length, points in text.stated.lengths_along(axis, count)[:1]:
            steps["d" + axis] = length.value / points
            units["d" + axis] = length.unit or text.stated.first("lateral_unit", "unit")
    lateral_unit = units.get("dx") or units.get("dy") or text.stated.first("lateral_unit")
    for step, unit in units.items():
        if unit and lateral_unit and not same_length(unit, lateral_unit):
            steps[step] *= _ratio(unit, lateral_unit, text)
    return steps, lateral_unit


def _ratio(unit_y: str, unit_x: str, text: _Text) -> float:
    """Return the unit along y over that along x, with a warning that they differ."""
    doubt = f"the steps are stated in {unit_x} along x and in {unit_y} along y: check both"
    if doubt not in text.doubts:
        text.doubts.append(doubt)
    return metres(unit_y, where="y") / metres(unit_x, where="x")


def _channel(numbers: np.ndarray, text: _Text, unit: str | None = None, **attributes: Any) -> Channel:
    """Return a channel of numbers in a unit, by default that of the header."""
    unit = unit or text.stated.first("height_unit", "unit")
    for marker in text.stated.get("missing", []):
        numbers[numbers == marker.value] = np.nan
    for factor in text.stated.get("z_factor", [])[:1]:  # of counts or phases: it makes them lengths
        attributes["count_height"], unit = factor.value, factor.unit or unit
    numbers_of = {entry: group[0].line for entry, group in text.stated.items() if group[0].line}
    columns = ((column, entry) for column, entries in words("source").items() for entry in entries)
    lines = {column: f"line {numbers_of[entry]}" for column, entry in columns if entry in numbers_of}
    otherwise = {"unit": lines.get("dx", "headings"), "height_unit": "headings"}
    attributes["sources"] = otherwise | {"missing_value": "words and NaN"} | lines
    attributes["unused"] = _unused(text)
    name = text.stated.first("channel") or "height"
    return Channel(name, (len(numbers), numbers.shape[1]), lambda: numbers, unit, **attributes)


def _refuse_other_units(units: list[str | None], text: _Text) -> None:
    """Refuse the units of headings, that of heights last, where an entry of the header says others."""
    entries = text.stated
    bare = any(not entries[key][0].unit for key in LENGTHS if key in entries)  # "Unit" is that of these
    general = [column.unit for column in text.columns or ()] if all(units) and not bare else []
    for entry, own in (("lateral_unit", units[:-1]), ("height_unit", units[-1:]), ("unit", general)):
        known_units = [unit for unit in own if unit]
        for statement in entries.get(entry, [])[:1] if known_units else ():
            if not any(same_length(unit, statement.value) for unit in known_units):
                raise refusal("unit of a heading", statement=statement, unit=known_units[-1])
    for scaled in entries.get("z_factor", [])[:1] if is_length(units[-1]) else ():
        if scaled.value != 1 or scaled.unit not in ("", units[-1]):
            raise refusal("factor beside a unit", unit=units[-1])


READER = Reader(RecognisedBy.TEXT, lambda path, head: looks_like_text(head), read, memory_per_byte=12)
