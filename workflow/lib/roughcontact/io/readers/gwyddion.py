"""Gwyddion's own format: a container of typed components; each of its images is a channel.

Behind the mark lies one object: its name, its size, and its components, each with a name, the letter of its
type, and a value. A zero ends every text; numbers are little-endian. Images are stored from the top. Where an
image has a mask, the points under it are missing.
"""

import re
import struct
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import Channel, MeasuredFile, as_heights
from roughcontact.io.guards import brief, check_line_ends, check_memory, check_points
from roughcontact.io.interface import Reader, RecognisedBy
from roughcontact.io.lengths import compare_size
from roughcontact.io.metadata import instrument_metadata
from roughcontact.io.text.lines import looks_like_text
from roughcontact.io.units import is_length

_MARK = b"GWYP"
_NUMBERS = {b"b": "<i1", b"c": "S1", b"i": "<i4", b"q": "<i8", b"d": "<f8"}  # in capitals: arrays of them
_DEEPEST = 32  # objects within objects
_BYTES_PER_BYTE = 4  # memory for each byte of a file


def recognises(path: Path, head: bytes) -> bool:
    r"""Return whether a file begins with the mark.

    Examples
    --------
    >>> recognises(Path("map.gwy"), b"GWYPGwyContainer\0"), recognises(Path("map.txt"), b"GWYP is a word")
    (True, False)
    """
    return head.startswith(_MARK) and not looks_like_text(head)


def read(path: Path) -> MeasuredFile:
    """Open a file; images without a unit are heights only where no image has a length unit."""
    size = path.stat().st_size
    check_memory(size * _BYTES_PER_BYTE, f"{size} bytes of this format", path)
    check_line_ends(path)
    data = path.read_bytes()
    try:
        _, place = _text(data, len(_MARK))
        end = place + 4 + int(_number(data, "<u4", place))
        stale, notes = compare_size(path, end)
        container = _components(data, place + 4, end, depth=0)
        images = {
            int(found[1]): value
            for key, value in container.items()
            if (found := re.fullmatch(r"/(\d+)/data", key)) and isinstance(value, dict)
        }
        measured = any(is_length(_unit(image, "z")) for image in images.values())
        channels = [_channel(number, container, path, measured=measured) for number in images]
    except (ValueError, KeyError, TypeError, struct.error) as error:
        raise InputFileError(
            f"{path}: looks like Gwyddion, but is damaged or cut off ({brief(error)}); save it again"
        ) from error
    if not channels:
        raise InputFileError(f"{path}: this Gwyddion file holds no image")
    meta = container.get(f"/{min(images)}/meta")
    instrument = instrument_metadata({}, meta if isinstance(meta, dict) else None)
    return MeasuredFile("Gwyddion", channels, "top", instrument, notes, stale)


def _channel(number: int, container: dict[str, Any], path: Path, *, measured: bool) -> Channel:
    """Return one image; `measured` says whether any image has a length unit."""
    image = container[f"/{number}/data"]
    shape = int(image["yres"]), int(image["xres"])
    check_points(shape, path)
    if image["data"].size != shape[0] * shape[1]:
        raise ValueError(
            f"image {number} has {image['data'].size} points, and states {shape[0]} x {shape[1]}"
        )
    mask = container.get(f"/{number}/mask", {}).get("data")
    hidden = None if mask is None or mask.size != image["data"].size else mask.reshape(shape) > 0.5
    notes = []
    if hidden is not None and hidden.any():
        notes.append(
            f"the mask in the file covers {np.count_nonzero(hidden)} points, which are taken as missing"
        )
    unit = _unit(image, "z") or None
    no_height = f"values in {unit}, no length" if unit and not is_length(unit) else ""
    return Channel(
        container.get(f"/{number}/data/title") or f"channel {number}",
        shape,
        partial(_heights, image["data"].reshape(shape), hidden, path),
        height_unit=unit,
        dx=(abs(float(image["xreal"])) or 1.0) / shape[1],
        dy=(abs(float(image["yreal"])) or 1.0) / shape[0],
        lateral_unit=_unit(image, "xy") or None,
        no_height=no_height if unit or not measured else "values without a unit",
        notes=notes,
    )


def _heights(values: np.ndarray, hidden: np.ndarray | None, path: Path) -> np.ndarray:
    """Return the heights of an image, NaN under its mask."""
    heights = as_heights(values, str(path))
    if hidden is not None:
        heights[hidden] = np.nan
    return heights


def _unit(image: dict[str, Any], axis: str) -> str:
    """Return the unit of an axis (``xy`` or ``z``) of an image; empty where it has none."""
    return str(image.get(f"si_unit_{axis}", {}).get("unitstr", ""))


def _components(data: bytes, place: int, end: int, *, depth: int) -> dict[str, Any]:
    """Return the components of an object by their names."""
    found = {}
    while place < end:
        name, place = _text(data, place)
        found[name], place = _value(data, data[place : place + 1], place + 1, depth)
    if place != end:
        raise ValueError("an object is longer than it states")
    return found


def _value(data: bytes, kind: bytes, place: int, depth: int) -> tuple[Any, int]:
    """Return a value of a type, and where it ends."""
    if kind in _NUMBERS:
        return _number(data, _NUMBERS[kind], place), place + np.dtype(_NUMBERS[kind]).itemsize
    if kind == b"s":
        return _text(data, place)
    if kind == b"o":
        _, place = _text(data, place)
        end = place + 4 + int(_number(data, "<u4", place))
        if depth == _DEEPEST or end > len(data):
            raise ValueError("an object lies outside the file, or too deep in others")
        return _components(data, place + 4, end, depth=depth + 1), end
    count, place = int(_number(data, "<u4", place)), place + 4
    if kind.lower() in _NUMBERS:
        array = np.frombuffer(data, _NUMBERS[kind.lower()], count, place)
        return array, place + array.nbytes
    if kind not in (b"S", b"O"):
        raise ValueError(f"no type {kind!r}")
    values = []
    for _ in range(count):
        value, place = _value(data, kind.lower(), place, depth)
        values.append(value)
    return values, place


def _number(data: bytes, kind: str, place: int) -> Any:
    """Return one number."""
    return np.frombuffer(data, kind, 1, place)[0]


def _text(data: bytes, place: int) -> tuple[str, int]:
    """Return a text, and where it ends."""
    end = data.index(b"\0", place)
    return data[place:end].decode("utf-8", "replace"), end + 1


READER = Reader(RecognisedBy.MARK, recognises, read)
