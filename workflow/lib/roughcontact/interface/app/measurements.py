"""The measured files of a study: dropped or named, what `inspect` says of them, and their maps."""

import base64
import hashlib
import os
import secrets
import shlex
from collections.abc import AsyncIterable, Sequence
from functools import lru_cache
from itertools import chain, count
from math import ceil
from pathlib import Path, PurePosixPath
from queue import SimpleQueue
from threading import Lock, Thread
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import side_lengths, spacing
from roughcontact.arguments.quantities import quantity
from roughcontact.arguments.rectangles import parse_rectangles
from roughcontact.errors import SettingsError
from roughcontact.interface.app.study import Row, check_within_study, error_in_words
from roughcontact.io.guards import naming, sha256
from roughcontact.io.inspection import inspect_file
from roughcontact.io.read import read_height_map
from roughcontact.io.request import FILE_OPTIONS
from roughcontact.report.colours import coloured
from roughcontact.study.surfaces import find

MEASURED = Path("measured")  # where dropped files go
OPTIONS = {name.replace("-", "_"): name for name in FILE_OPTIONS}
READING = Lock()  # the libraries of netCDF and HDF5 are not for two threads
_UNREAD = {"picture": b"", "channels": [], "columns": [], "doubts": [], "text": "is read ..."}
_UNREAD |= dict.fromkeys(("line", "sha256", "command", "key"), "")
_SIDE = {"thumbnail": 64, "map": 400}  # points of a picture, at most


class Reader:
    """What the files of rows hold, read in the background one after the other; `count` have been read."""

    def __init__(self) -> None:
        self.inspections: dict[str, dict[str, Any]] = {}
        self.queue: SimpleQueue[tuple[str, Row]] = SimpleQueue()
        self.count = 0
        Thread(target=self._read, daemon=True).start()

    def inspected(self, rows: Sequence[Row]) -> list[tuple[Row, dict[str, Any]]]:
        """Return rows with what their files hold; those that are not read yet come in a while."""
        keys = [_key(row) for row in rows]
        for key, row in zip(keys, rows, strict=True):
            if key not in self.inspections:
                self.inspections[key] = _UNREAD
                self.queue.put((key, row))
        return [(row, self.inspections[key]) for key, row in zip(keys, rows, strict=True)]

    def _read(self) -> None:
        """Read what is asked for, without end."""
        for key, row in iter(self.queue.get, None):
            self.inspections[key] = inspect(row) | {"key": key}
            self.count += 1


def _key(row: Row) -> str:
    """Return a text that changes with the file of a row, and with what the row says of it."""
    file = find(row.get("path", ""), ["."])
    entries = [row.get(column) for column in ("path", *OPTIONS)]
    written = file.stat().st_mtime_ns if file else 0
    return hashlib.sha256(repr((written, entries)).encode()).hexdigest()


def inspect(row: Row) -> dict[str, Any]:
    """Return what `inspect` says of a file, in a line and in full, its picture, columns that it needs."""
    from roughcontact.interface.command_line.describe import inspection

    path, entries = row.get("path", ""), _entries(row)
    options = [word for column, text in entries.items() for word in (f"--{OPTIONS[column]}", text)]
    result: dict[str, Any] = _UNREAD | {"command": shlex.join(["roughcontact", "inspect", path, *options])}
    try:
        with READING, naming(Path(path)):
            content = inspect_file(path, **entries)
            result["text"], needed = inspection(content, path), content["needed"]
            result |= {"sha256": content["sha256"], "doubts": content["warnings"]}
            result["line"] = content["problem"] or ""
            result["channels"] = [channel["name"] for channel in content["channels"] if channel["is_height"]]
            if held := content["map"]:
                sides = " × ".join(quantity(held[side], "m") for side in ("size_x", "size_y"))
                heights = quantity(held["highest"] - held["lowest"], "m")
                result["line"] = f"{held['nx']} × {held['ny']} points, {sides}, heights over {heights}"
                values = _thinned(read_height_map(path, **entries).values, _SIDE["thumbnail"])[::-1]
                picture, _ = coloured(values, _limits(values), "viridis", bad="#ff4fa3")
                result["picture"] = base64.b64decode(picture.partition(",")[2])
                # where the unit of all may not be that of the heights
                needed = [*needed, *["height_unit"] * bool(content["warnings"] and "unit" in entries)]
    except Exception as error:  # a reader may raise anything
        result["text"] = result["line"] = error_in_words(error)
        needed = getattr(error, "keys", ())
    return result | {"columns": [column for column in OPTIONS if column in needed]}


def _entries(row: Row) -> dict[str, Any]:
    """Return the arguments of reading that a row states."""
    return {column: row[column] for column in OPTIONS if row.get(column)}


def _thinned(values: np.ndarray, side: int) -> np.ndarray:
    """Return an array of no more than so many points along each side."""
    return values[:: ceil(values.shape[0] / side), :: ceil(values.shape[1] / side)]


def _limits(values: np.ndarray) -> tuple[float, float]:
    """Return the heights of the first and the last colour: a few spikes take none."""
    lowest, highest = np.nanpercentile(values, [0.1, 99.9]) if np.isfinite(values).any() else (0.0, 1.0)
    return float(lowest), float(highest)


@lru_cache(maxsize=1)  # zooming in reads once
def _height_map(key: str, path: str, **entries: Any) -> xr.DataArray:
    """Return the map of a file; `key` changes with it."""
    with READING:
        return read_height_map(path, **entries)


def heights(row: Row, box: str) -> tuple[bytes, dict[str, Any]]:
    """Return heights (m, 32 bits, rows upwards) in a box (left, lower, right, upper; m), and its facts."""
    height = _height_map(_key(row), row["path"], **_entries(row))
    (ly, lx), (dy, dx) = side_lengths(height), spacing(height)
    left, lower, right, upper = map(float, box.split(",")) if box else (0.0, 0.0, lx, ly)
    ny, nx = height.shape
    first_x, first_y = min(max(int(left / dx), 0), nx - 1), min(max(int(lower / dy), 0), ny - 1)
    last_x, last_y = min(max(ceil(right / dx), first_x + 1), nx), min(max(ceil(upper / dy), first_y + 1), ny)
    values = _thinned(height.values[first_y:last_y, first_x:last_x] - np.nanmean(height.values), _SIDE["map"])
    sides = [first_x * dx, first_y * dy, last_x * dx, last_y * dy]
    return values.astype("<f4").tobytes(), {"shape": values.shape, "sides": sides, "limits": _limits(values)}


def rectangles(row: Row) -> dict[str, list[Any]]:
    """Return the rectangles of `crop` and `mask` of a row, m; none of a cell with a mistake."""
    result: dict[str, list[Any]] = {"crop": [], "mask": []}
    for column in result:
        try:
            result[column] = parse_rectangles(column, row.get(column, ""))
        except SettingsError:  # the table says what is wrong
            continue
    return result


def add(paths: Sequence[str], rows: Sequence[Row]) -> tuple[list[Row], str]:
    """Return rows with those of further files, and of measurements in folders, and a sentence on both."""
    from roughcontact.interface.command_line.project import collect_files, rows_of

    if missing := [path for path in paths if not Path(path).exists()]:
        raise SettingsError(f"{missing[0]}: no such file or folder")
    files, omissions = collect_files(paths)
    present = {row.get("path") for row in rows}
    new = rows_of([file for file in files if file not in present], present=rows)
    known = f", {len(files) - len(new)} there already" if len(files) > len(new) else ""
    return [
        *rows,
        *new,
    ], f"{len(new)} added{known}; left out, as no measurements: {', '.join(omissions) or 'none'}"


async def save_upload(name: str, content: AsyncIterable[bytes]) -> str:
    """Write a file that was dropped, unless it is there, and return its path; namesakes have numbers."""
    path = MEASURED / PurePosixPath(name.replace("\\", "/")).name
    if "\0" in name or path in (MEASURED, MEASURED / ".."):
        raise SettingsError(f"{name!r} names no file: rename it")
    check_within_study(path)
    MEASURED.mkdir(exist_ok=True)
    partial = MEASURED / f".{secrets.token_hex(8)}.partial"
    try:
        with partial.open("xb") as file:
            async for chunk in content:
                file.write(chunk)
        names = (path.with_stem(f"{path.stem}-{number}") for number in count(2))
        for target in chain([path], names):
            if not os.path.lexists(target):
                partial.rename(target)
                break
            if target.is_file() and sha256(target) == sha256(partial):
                break
    finally:
        partial.unlink(missing_ok=True)
    return str(target)
