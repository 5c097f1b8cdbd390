"""Digital Surf's SUR and PRO (MountainsMap): surfaces, profiles, and series of them.

Each object is a header of 512 bytes, a comment, a private zone, and integer points, row by row from the top;
in a series of profiles the rows are the profiles. The offset of the heights is left out. Points may be packed
(zlib): a number of streams, the bytes of each unpacked and packed (4 bytes each), and the streams.
"""

import datetime
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from roughcontact.io.channels import Channel, MeasuredFile, as_heights, counted_channels, stated_length
from roughcontact.io.guards import check_count, check_points, refusal, refuse_cut_off, refusing
from roughcontact.io.instruments.rules import IMPRINT, INVERTED
from roughcontact.io.interface import Reader, RecognisedBy, begins_with
from roughcontact.io.units import is_length, metres, same_length
from roughcontact.io.vocabulary import rows_of

_PLAIN, _PACKED = b"DIGITAL SURF", b"DSCOMPRESSED"
_HEADER_BYTES = 512
_FIELDS: Any = {name: (kind, int(place)) for name, kind, place, *_ in rows_of("digital_surf.tsv")}
_LAYOUT = np.dtype(_FIELDS)
# types of objects; behind those of other types may lie colours
_PROFILE, _SURFACE, _PROFILES, _SURFACES = 1, 2, 4, 5
_SERIES = (_PROFILES, _SURFACES)
_IMAGES = (3, 10, 12, 18)  # binary, of intensities, of colours, and series of these
_COMPLETE = (_PROFILE, _SURFACE, *_SERIES)
_MIRRORED_X, _MIRRORED_Y = 2, 3  # inversions; 1 changes the sign alone, and so do these
_MISSING = -2  # beside the lowest integer


def read(path: Path) -> MeasuredFile:
    """Open a file; each object is a channel, in a series of profiles each row."""
    objects, stop = _objects(path)
    header = objects[0][0]
    channels = counted_channels(channel for each in objects for channel in _channels(*each, path))
    for number, channel in enumerate(channels if len(channels) > 1 else (), 1):
        channel.name = f"{_text(header['object_name']) or 'object'} {number}"
    required_size = stop if header["type"] in _COMPLETE else None
    return MeasuredFile("Digital Surf SUR", channels, "top", _instrument(header), required_size=required_size)


def _objects(path: Path) -> tuple[list[tuple[np.void, int]], int]:
    """Return header and first byte of the points of all objects, one behind the other, and their end."""
    objects: list[tuple[np.void, int]] = []
    size, stop = path.stat().st_size, 0
    with path.open("rb") as stream:
        # a surface alone may be followed by anything; objects of a series follow one another
        while not objects or (objects[0][0]["type"] != _SURFACE and stream.read(12) in (_PLAIN, _PACKED)):
            stream.seek(stop)
            data = stream.read(_HEADER_BYTES)
            if len(data) < _HEADER_BYTES:
                raise refusal("cut header of an object")
            header = np.frombuffer(data, _LAYOUT, 1)[0]
            nx, ny, bits = map(int, (*header["shape"], header["bits"]))
            start = stop + _HEADER_BYTES + int(header["sizes"].sum())
            stream.seek(start)
            sizes = _stream_sizes(stream, header, size)
            stop = stream.tell() + int(sizes[:, 1].sum())
            if header["spectrum"] > 1:
                raise refusal("spectra", points=header["spectrum"])
            points = min(nx, ny) > 0 and nx * ny == header["points"] and bits in (16, 32)
            if not points or sizes[:, 0].sum() != nx * ny * bits // 8:
                raise refusal("damaged object", points=header["points"], bits=bits, nx=nx, ny=ny)
            check_points((ny, nx))
            refuse_cut_off(size, stop)
            objects.append((header, start))
            check_count(len(objects))
            stream.seek(stop)
    first_header = objects[0][0]
    if first_header["type"] in _SERIES and len(objects) < first_header["objects"]:
        raise refusal("cut series", count=len(objects), stated=first_header["objects"])
    return objects, stop


def _stream_sizes(stream: BinaryIO, header: np.void, size: int) -> np.ndarray:
    """Return the bytes (n, 2), unpacked and packed, of the streams of points that follow in a file."""
    if header["mark"] == _PLAIN:
        return np.full((1, 2), int(header["points"]) * int(header["bits"]) // 8)
    count = int.from_bytes(stream.read(4), "little")
    refuse_cut_off(size, stream.tell() + 8 * count)
    return np.frombuffer(stream.read(8 * count), "<u4").reshape(-1, 2).astype(int)


def _channels(header: np.void, start: int, path: Path) -> Iterator[Channel]:
    """Yield the channels of one object."""
    nx, ny = map(int, header["shape"])
    dx, dy = map(stated_length, header["steps"][:2])
    unit, unit_y, height_unit = map(_unit, header["step_units"])
    names = [_text(header[key]) for key in ("object_name", "instrument_name", "client")]
    # two programs mark all files as imprints: Gwyddion, under these names, and surfalize
    always = names[:2] == ["SCRATCH", "csm"] or "surfalize" in names[2]
    notes = [IMPRINT] if header["imprint"] and not always else []
    notes += [INVERTED] if header["inversion"] else []
    height = 1 if header["type"] == _PROFILES else ny
    if height > 1 and dy and unit and not same_length(unit, unit_y):
        notes.append(f"the axes have different units, {unit} along x and {unit_y or 'none'} along y")
        dy = dy * metres(unit_y) / metres(unit) if is_length(unit) and is_length(unit_y) else None
    dy = dy if height > 1 else None
    load = cache(partial(_counts, header, start, path))
    for first_row in range(0, ny, height):
        rows = partial(_read, header, load, slice(first_row, first_row + height))
        channel = Channel("Default", (height, nx), rows, height_unit or None, dx, dy, unit or None)
        yield replace(channel, no_height="an image" * (header["type"] in _IMAGES), notes=[*notes])


def _counts(header: np.void, start: int, path: Path) -> np.ndarray:
    """Return the integer points (ny, nx) of an object."""
    nx, ny = map(int, header["shape"])
    number_type = f"<i{header['bits'] // 8}"
    with path.open("rb") as stream, refusing("its packed points are damaged"):
        stream.seek(start)
        if header["mark"] == _PLAIN:
            return np.fromfile(stream, number_type, nx * ny).reshape(ny, nx)
        data = bytearray()
        for raw_size, stored_size in _stream_sizes(stream, header, path.stat().st_size).tolist():
            unpacker = zlib.decompressobj()
            data += unpacker.decompress(stream.read(stored_size), raw_size + 1)
            if not unpacker.eof:
                raise ValueError("a stream is longer than its header says")
    return np.frombuffer(data, number_type).reshape(ny, nx)


def _read(header: np.void, load: Callable[[], np.ndarray], rows: slice) -> np.ndarray:
    """Return the heights of some rows of an object, whose points are loaded once."""
    inversion = int(header["inversion"])
    counts = load()[:: -1 if inversion == _MIRRORED_Y else 1, :: -1 if inversion == _MIRRORED_X else 1][rows]
    heights = as_heights(counts)
    if header["special_points"] == 1:
        heights[counts == int(header["lowest"]) + _MISSING] = np.nan
    heights *= float(header["steps"][2]) * (-1 if inversion in (1, _MIRRORED_X, _MIRRORED_Y) else 1)
    return heights


def _instrument(header: np.void) -> dict[str, Any]:
    """Return name, sample and date that a header states."""
    metadata = {"vendor": "Digital Surf", "name": _text(header["instrument_name"])}
    metadata["sample"] = _text(header["object_name"])
    with suppress(ValueError):  # no date
        metadata["acquisition_time"] = datetime.datetime(*header["time"][::-1].tolist()).isoformat()
    return metadata


def _unit(data: bytes) -> str:
    """Return a unit; the micro sign may be that of Latin-1, of UTF-8, or of a code page of MS-DOS."""
    return "µm" if data.strip(b"\0 ") == b"\xe6m" else _text(data)


def _text(data: bytes) -> str:
    """Return a text of a header, in UTF-8 or Latin-1."""
    data = data.partition(b"\0")[0].strip()
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


READER = Reader(RecognisedBy.MARK, begins_with(_PLAIN + b"\0", _PACKED + b"\0"), read, binary=True)
