"""The measured files of a study: dropped or named, what `inspect` says of them, and their maps."""

import os
import re
from collections.abc import AsyncIterable, Iterable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from functools import lru_cache
from itertools import chain, count
from math import ceil
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from threading import Lock
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments import maps
from roughcontact.arguments.quantities import percent, quantity
from roughcontact.errors import SettingsError
from roughcontact.interface.app.study import Row, check_within_study, error_in_words
from roughcontact.interface.command_line.describe import field_in_words, inspection, points_in_words
from roughcontact.interface.command_line.project import collect_files, rows_of
from roughcontact.io.guards import naming, sha256
from roughcontact.io.inspection import inspect_heights
from roughcontact.io.read import read_height_map
from roughcontact.io.request import FILE_OPTIONS, Request
from roughcontact.report import map_plots
from roughcontact.report.colours import coloured
from roughcontact.study.places import find_file

MEASURED = Path("measured")  # where dropped files go
OPTIONS = [name.replace("-", "_") for name in FILE_OPTIONS]
READING = Lock()  # the libraries of netCDF and HDF5 are not for two threads
UNREAD: dict[str, Any] = dict.fromkeys(("key", "line", "sha256", "picture", "channel", "map"), "")
UNREAD |= {"channels": [], "warnings": [], "columns": [], "scale": [], "text": "is read ..."}
# where a terminal states what is missing; the page has a field for it beside the sentence
_PLACE = re.compile(r" \(table of surfaces or arguments?\)| in the table of surfaces or as (an )?arguments?")
_THUMBNAIL = 64  # points along a side, at most
_CUT = 320  # points along a line


class Reader:
    """What the files of rows hold, read in the background one after the other."""

    def __init__(self) -> None:
        self.pool = ThreadPoolExecutor(1)
        self.readings: dict[str, Future[dict[str, Any]]] = {}
        self.columns: dict[str, list[str]] = {}  # that the file of each path needed last

    def inspected(self, rows: Sequence[Row]) -> list[tuple[Row, dict[str, Any]]]:
        """Return rows with what their files hold; those that are not read yet come in a while."""
        inspections = []
        for row in rows:
            key, path = _key(row), row.get("path", "")
            if key not in self.readings:
                self.readings[key] = self.pool.submit(inspect, row)
            # the cells of a row stay while its file is read again
            previous = UNREAD | {"columns": self.columns.get(path, [])}
            inspection = self.readings[key].result() if self.readings[key].done() else previous
            self.columns[path] = inspection["columns"]
            inspections.append((row, inspection))
        return inspections


def unread(rows: Iterable[tuple[Row, Mapping[str, Any]]]) -> list[int]:
    """Return the numbers of the rows whose file has been looked at and cannot be read as it is."""
    return [number for number, (_, content) in enumerate(rows) if content["key"] and not content["map"]]


def _key(row: Row) -> str:
    """Return a text of this process that changes with the file of a row, and with what the row says of it."""
    file = find_file(row.get("path", ""), ["."])
    written = file.stat().st_mtime_ns if file else 0
    return f"{hash(repr((written, row.get('path'), _entries(row)))):x}"


def inspect(row: Row) -> dict[str, Any]:
    """Return what `inspect` says of a file, in a line and in full, its picture, columns that it needs."""
    path, entries = row.get("path", ""), _entries(row)
    result = UNREAD | {"key": _key(row), "row": row}
    try:
        with READING, naming(Path(path)):
            content, heights = inspect_heights(Path(path), Request(**entries))
            result |= content | {"text": inspection(content, path), "line": content["problem"] or ""}
            needed = [*content["needed"]]
            if heights is not None:
                extent, heights = content["map"], heights - np.nanmean(heights)
                if extent["ny"] == 1:  # a line on axes
                    result["picture"] = _curve(heights[0], extent["dx"])
                else:  # a few spikes take no colour of the others
                    step = ceil(max(heights.shape) / _THUMBNAIL)
                    result["scale"] = np.nanpercentile(heights, [0.1, 99.9]).tolist()
                    result["picture"] = _picture(heights[::step, ::step], result["scale"])
                span = quantity(extent["highest"] - extent["lowest"], "m")
                result["line"] = f"{points_in_words(extent)}, {field_in_words(extent)}, heights over {span}"
                if extent["missing_points"]:
                    result["line"] += f", {percent(extent['missing_share'])} not measured"
                # where the unit that the file, or `unit`, says may not be that of the heights
                needed += ["height_unit"] * any("unit" in doubt for doubt in content["warnings"])
    except Exception as error:  # a reader may raise anything
        result["text"] = result["line"] = error_in_words(error)
        needed = [*getattr(error, "keys", ())]
    result["line"] = _PLACE.sub("", result["line"])
    return result | {"columns": [column for column in OPTIONS if column in needed]}


def _entries(row: Row) -> dict[str, Any]:
    """Return the arguments of reading that a row states."""
    return {column: row[column] for column in OPTIONS if row.get(column)}


def _picture(heights: np.ndarray, scale: Sequence[float]) -> str:
    """Return a picture of heights as a data URI, rows upwards; `scale` are those of first and last colour."""
    picture, _ = coloured(heights[::-1], (scale[0], scale[1]), "viridis", bad="#ff4fa3")
    return picture


def _curve(heights: np.ndarray, step: float, *, axis: str = "x") -> str:
    """Return a chart of heights (m) along a line with even steps (m) as a data URI."""
    chart = map_plots.height_map(maps.height_map(heights[None], step))
    chart.x = replace(chart.x, label=chart.x.label.replace("x", axis))
    return chart.source()


@lru_cache(maxsize=1)  # a cursor reads once
def _height_map(key: str, path: str, **entries: Any) -> xr.DataArray:
    """Return the map of a file, from the mean; `key` changes with it."""
    with READING:
        height = read_height_map(path, **entries)
    return height - height.mean()


def large_picture(inspection: Mapping[str, Any]) -> str:
    """Return the picture of all points of a map."""
    row = inspection["row"]
    return _picture(_height_map(_key(row), row["path"], **_entries(row)).values, inspection["scale"])


def cut(row: Row, line: str) -> dict[str, str]:
    """Return in words what a map holds along a line, and a chart of it, heights from the mean of the map.

    `line` has x and y of both ends, µm from the lower left corner, between commas; a point has no chart.
    """
    height = _height_map(_key(row), row["path"], **_entries(row))
    start, end = np.reshape([1e-6 * float(word) for word in line.split(",")], (2, 2))
    x, y = (xr.DataArray(np.linspace(*bounds, _CUT), dims="point") for bounds in zip(start, end, strict=True))
    levels = height.sel(x=x, y=y, method="nearest").values
    length, finite = float(np.hypot(*(end - start))), levels[np.isfinite(levels)]
    words = f"x {quantity(start[0], 'm')}, y {quantity(start[1], 'm')}: "
    if length:
        words = f"{quantity(length, 'm')} along the line, heights over "
    if not finite.size:
        return {"words": f"{words}not measured", "chart": ""}
    value = np.ptp(finite) if length else finite[0]
    chart = _curve(levels, length / (_CUT - 1), axis="along the line") if length else ""
    return {"words": words + quantity(float(value), "m"), "chart": chart}


def further(paths: Sequence[str], rows: Sequence[Row]) -> tuple[list[Row], str]:
    """Return rows of files that have none yet, of folders of the measurements in them, and what was done."""
    files, omissions = collect_files(paths)
    present = {row.get("path") for row in rows}
    new = rows_of([file for file in files if file not in present], present=rows)
    duplicates = f", {len(files) - len(new)} there already" if len(files) > len(new) else ""
    left_out = f"; left out, as no measurements: {', '.join(omissions)}" if omissions else ""
    return new, f"{len(new)} added{duplicates}{left_out}"


async def save_upload(name: str, content: AsyncIterable[bytes]) -> str:
    """Write a file that was dropped, unless it is there, and return its path; namesakes have numbers."""
    path = MEASURED / PurePosixPath(name.replace("\\", "/")).name
    if "\0" in name or path in (MEASURED, MEASURED / ".."):
        raise SettingsError(f"{name!r} names no file: rename it")
    check_within_study(path)
    MEASURED.mkdir(exist_ok=True)
    with TemporaryDirectory(dir=MEASURED, prefix=".") as folder:
        partial = Path(folder, "partial")
        with partial.open("wb") as file:
            async for chunk in content:  # files may be larger than the memory
                file.write(chunk)
        for target in chain([path], (path.with_stem(f"{path.stem}-{number}") for number in count(2))):
            if not os.path.lexists(target):
                partial.rename(target)
                break
            if target.is_file() and sha256(target) == sha256(partial):
                break
    return str(target)
