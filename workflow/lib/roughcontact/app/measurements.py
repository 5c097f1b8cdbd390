"""The measured files of a study: dropped or named, what `inspect` says of them, and their maps."""

import hashlib
import re
import shlex
import time
from collections.abc import AsyncIterable, Sequence
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

from roughcontact.app.study import Row
from roughcontact.command_line.program import FILE_OPTIONS
from roughcontact.configuration.surfaces import find
from roughcontact.errors import RoughContactError, SettingsError
from roughcontact.results.storage import atomic_write

MEASURED = Path("measured")  # where dropped files go
OPTIONS = {name.replace("-", "_"): name for name in FILE_OPTIONS}


def inspected(rows: Sequence[Row], cache: dict[str, dict], *, patience: float) -> list[tuple[Row, dict]]:
    """Return rows with what their files say; those not in `cache` are read in the time (s) allowed."""
    end, keys = time.monotonic() + patience, list(map(_key, rows))
    for key, row in zip(keys, rows, strict=True):
        if key not in cache and time.monotonic() < end:
            cache[key] = inspect(row) | {"key": key}
    return [(row, cache.get(key, {})) for key, row in zip(keys, rows, strict=True)]


def _key(row: Row) -> str:
    """Return a text that changes with the file of a row, and with what the row says of it."""
    file = find(row.get("path", ""), ["."])
    stated = [row.get(column) for column in ("path", *OPTIONS)]
    written = file.stat().st_mtime_ns if file else 0
    return hashlib.sha256(repr((written, stated)).encode()).hexdigest()


def inspect(row: Row) -> dict[str, Any]:
    """Return what `inspect` says of a file, a map (SVG), its channels, and columns that it asks for."""
    from roughcontact.command_line.describe import inspection
    from roughcontact.io.inspection import inspect_file
    from roughcontact.io.read import read_height_map
    from roughcontact.report.map_plots import height_map

    path = row.get("path", "")
    stated: dict[str, Any] = {column: row[column] for column in OPTIONS if row.get(column)}
    options = [argument for column, text in stated.items() for argument in (f"--{OPTIONS[column]}", text)]
    command = shlex.join(["roughcontact", "inspect", path, *options])
    result: dict[str, Any] = {"command": command, "picture": "", "channels": []}
    try:
        content = inspect_file(path, **stated)
        result["text"], problem = inspection(content, path), content["problem"] or ""
        result["channels"] = [channel["name"] for channel in content["channels"] if channel["is_height"]]
        if content["map"]:
            source = height_map(read_height_map(path, **stated)).source()
            result["picture"] = unquote(source.partition(",")[2])
    except RoughContactError as error:
        result["text"] = problem = str(error)
    names = re.findall(r"\w+", problem.replace(path, ""))  # "give dx, dy, unit in the table of surfaces"
    result["columns"] = [column for column in OPTIONS if column in names]
    return result


def add(paths: Sequence[str], rows: Sequence[Row]) -> tuple[list[Row], str]:
    """Return rows with those of further files, and of measurements in folders, and a sentence on both."""
    from roughcontact.command_line.project import files_in, rows_of

    if missing := [path for path in paths if not Path(path).exists()]:
        raise SettingsError(f"{missing[0]}: no such file or folder")
    files, skipped = files_in(paths)
    present = {row.get("path") for row in rows}
    new = rows_of([file for file in files if file not in present], present=rows)
    return [*rows, *new], f"{len(new)} added; left out, as no measurements: {', '.join(skipped) or 'none'}"


async def save_upload(name: str, content: AsyncIterable[bytes]) -> str:
    """Write a file that was dropped, and return its path; a SettingsError where the name is taken."""
    MEASURED.mkdir(exist_ok=True)
    path = MEASURED / PurePosixPath(name.replace("\\", "/")).name
    if path.exists():
        raise SettingsError(f"{path} is there already: name its path instead, or rename the new file")
    with atomic_write(path, size=0) as partial, partial.open("wb") as file:
        async for chunk in content:
            file.write(chunk)
    return str(path)
