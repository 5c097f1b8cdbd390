"""Gwyddion's own files (Gwyddion user guide, native format GWY): one channel for each image, in SI units.

Behind the mark lies one object: the name of its class, its size (four bytes), and components of name, letter
for the type, and value. ``/0/data`` has its title in ``/0/data/title``, its mask in ``/0/mask``; rows run
from the top.
"""

import mmap
import re
import struct
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.io.channels import Channel, MeasuredFile, as_heights, on_field
from roughcontact.io.guards import refusal, refusing
from roughcontact.io.interface import Reader, RecognisedBy, begins_with

_MARK = b"GWYP"
_TYPES = {"b": "?", "c": "i1", "i": "<i4", "q": "<i8", "d": "<f8"}  # of numbers; arrays have capital letters
_MASKED = "the mask in the file was applied: the points under it are missing"


def read(path: Path) -> MeasuredFile:
    """Open a file; points under a mask are missing."""
    with refusing("looks like Gwyddion, but is damaged or cut off"):
        with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
            data.seek(len(_MARK))
            container = _object(data)
            required_size = data.tell()
        images = [match[1] for key in container if (match := re.fullmatch(r"/(\d+)/data", key))]
        channels = [_channel(container, f"/{number}") for number in images]
    if not channels:
        raise refusal("no image of Gwyddion")
    meta = container.get(f"/{images[0]}/meta", {})
    serial = {"serial": meta.get("Instrument serial number 2")}
    return MeasuredFile("Gwyddion", channels, "top", serial, required_size=required_size, header=meta)


def _channel(container: dict[str, Any], number: str) -> Channel:
    """Return one image with its mask."""
    image, mask = container[f"{number}/data"], container.get(f"{number}/mask")
    shape = int(image["yres"]), int(image["xres"])
    values = image["data"].reshape(shape)
    if mask is not None:
        values = np.ma.masked_array(values, mask["data"].reshape(shape) > 0.5)
    # a size of 0 is unknown, a negative one has a wrong sign
    field = (float(abs(image[key])) or None for key in ("xreal", "yreal"))
    lateral_unit, unit = (image.get(key, {}).get("unitstr", "") for key in ("si_unit_xy", "si_unit_z"))
    name = str(container.get(f"{number}/data/title", f"image {number[1:]}"))
    notes = [] if mask is None else [_MASKED]
    channel = Channel(name, shape, lambda: as_heights(values), unit or "no unit", notes=notes)
    return on_field(channel, field, lateral_unit)


def _object(data: mmap.mmap) -> dict[str, Any]:
    """Return the components of the object at the position of a file, and go behind it."""
    _text(data)
    stop = _count(data) + data.tell()
    if stop > len(data):
        raise ValueError(f"an object ends at {stop}, the file at {len(data)}")
    components = {}
    while data.tell() < stop:
        name = _text(data)
        components[name] = _value(data, data.read(1).decode())
    return components


def _value(data: mmap.mmap, kind: str) -> Any:
    """Return a value of some type."""
    if kind in "so":
        return (_text if kind == "s" else _object)(data)
    if kind == "c":  # gwyfile, the Python package, writes a text of one letter so
        return data.read(1).decode("latin-1")
    count = _count(data) if kind.isupper() else 1
    if kind in "SO":
        return [_value(data, kind.lower()) for _ in range(count)]
    number_type = np.dtype(_TYPES[kind.lower()])
    numbers = np.frombuffer(data.read(count * number_type.itemsize), number_type, count)
    return numbers if kind.isupper() else numbers[0]


def _text(data: mmap.mmap) -> str:
    """Return the text up to the next zero."""
    stop = data.find(b"\0", data.tell())
    if stop < 0:
        raise ValueError("a text has no end")
    return data.read(stop + 1 - data.tell())[:-1].decode("utf-8", "replace")


def _count(data: mmap.mmap) -> int:
    """Return a number of four bytes."""
    return struct.unpack("<I", data.read(4))[0]


READER = Reader(RecognisedBy.MARK, begins_with(_MARK, in_text=False), read, memory_per_byte=4, binary=True)
