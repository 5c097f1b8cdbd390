"""Digital Surf's SUR and PRO (MountainsMap): surfaces, profiles, and series of them.

Each object is a header of 512 bytes, a comment, a private zone, and integer points, row by row from the top;
in a series of profiles the rows are the profiles. The offset of the heights is left out.
"""

import datetime
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import Channel, MeasuredFile, as_heights
from roughcontact.io.instruments.formats import IMPRINT, INVERTED
from roughcontact.io.interface import Reader, RecognisedBy, begins_with
from roughcontact.io.lengths import refuse_cut_off
from roughcontact.io.metadata import instrument_metadata
from roughcontact.io.units import is_length, metres, same_length

_MARK = b"DIGITAL SURF"
_HEADER_BYTES = 512
_FIELDS: Any = {  # name -> type, and position in the header
    "objects": ("<u2", 14),
    "type": ("<u2", 18),
    "object_name": ("S30", 20),
    "instrument_name": ("S30", 50),
    "special_points": ("<u2", 86),
    "bits": ("<u2", 98),
    "lowest": ("<i4", 100),
    "shape": (("<i4", 2), 108),  # points of a row, rows
    "points": ("<u4", 116),
    "steps": (("<f4", 3), 120),  # x, y, z
    "step_units": (("S16", 3), 180),
    "imprint": ("<u2", 288),
    "inversion": ("<u2", 290),
    "time": (("<u2", 6), 306),  # second, minute, hour, day, month, year
    "sizes": (("<u2", 2), 334),  # comment, private zone
}
_LAYOUT = np.dtype(_FIELDS)
# types of objects; behind those of other types may lie colours
_PROFILE, _SURFACE, _PROFILES, _SURFACES = 1, 2, 4, 5
_SERIES = (_PROFILES, _SURFACES)
_COMPLETE = (_PROFILE, _SURFACE, *_SERIES)
_MIRRORED_X, _MIRRORED_Y = 2, 3  # inversions; 1 changes the sign alone, and so do these
_MISSING = -2  # beside the lowest integer


def read(path: Path) -> MeasuredFile:
    """Open a file; each object is a channel, in a series of profiles each row."""
    objects, end = _objects(path)
    first = objects[0][0]
    channels = [channel for header, begin in objects for channel in _channels(header, begin, path)]
    if len(channels) > 1:
        for number, channel in enumerate(channels, 1):
            channel.name = f"{_text(first['object_name']) or 'object'} {number}"
    required_size = end if first["type"] in _COMPLETE else None
    return MeasuredFile("Digital Surf SUR", channels, "top", _instrument(first), required_size=required_size)


def _objects(path: Path) -> tuple[list[tuple[np.void, int]], int]:
    """Return header and first byte of the points of all objects, one behind the other, and their end."""
    objects: list[tuple[np.void, int]] = []
    size, end = path.stat().st_size, 0
    with path.open("rb") as stream:
        while not objects or (objects[0][0]["type"] != _SURFACE and stream.read(len(_MARK)) == _MARK):
            stream.seek(end)
            data = stream.read(_HEADER_BYTES)
            if len(data) < _HEADER_BYTES:
                raise InputFileError("a header of this Digital Surf file is cut off")
            header = np.frombuffer(data, _LAYOUT, 1)[0]
            nx, ny = map(int, header["shape"])
            if min(nx, ny) < 1 or nx * ny != header["points"] or header["bits"] not in (16, 32):
                raise InputFileError(
                    f"damaged Digital Surf file: a header states {header['points']} points of "
                    f"{header['bits']} bits in {ny} rows of {nx}"
                )
            begin = end + _HEADER_BYTES + int(header["sizes"].sum())
            end = begin + nx * ny * int(header["bits"]) // 8
            refuse_cut_off(size, end)
            objects.append((header, begin))
            stream.seek(end)
    first = objects[0][0]
    if first["type"] in _SERIES and len(objects) < first["objects"]:
        raise InputFileError(
            f"{len(objects)} objects where its header states {first['objects']}: it was cut off"
        )
    return objects, end


def _channels(header: np.void, begin: int, path: Path) -> Iterator[Channel]:
    """Yield the channels of one object."""
    nx, ny = map(int, header["shape"])
    dx, dy = (float(step) if 0 < step < np.inf else None for step in header["steps"][:2])
    unit, unit_y, height_unit = map(_unit, header["step_units"])
    notes = [IMPRINT] if header["imprint"] else []
    notes += [INVERTED] if header["inversion"] else []
    rows = [slice(row, row + 1) for row in range(ny)] if header["type"] == _PROFILES else [slice(0, ny)]
    if rows[0].stop > 1 and dy and unit and not same_length(unit, unit_y):
        notes.append(f"the axes have different units, {unit} along x and {unit_y or 'none'} along y")
        dy = dy * metres(unit_y) / metres(unit) if is_length(unit) and is_length(unit_y) else None
    for chosen_rows in rows:
        shape = chosen_rows.stop - chosen_rows.start, nx
        yield Channel(
            "Default",
            shape,
            partial(_read, header, begin, chosen_rows, path),
            height_unit=height_unit or None,
            dx=dx,
            dy=dy if shape[0] > 1 else None,
            lateral_unit=unit or None,
            notes=list(notes),
        )


def _read(header: np.void, begin: int, rows: slice, path: Path) -> np.ndarray:
    """Return the heights of some rows of an object."""
    nx, ny = map(int, header["shape"])
    counts = np.fromfile(path, f"<i{header['bits'] // 8}", nx * ny, offset=begin).reshape(ny, nx)
    heights = as_heights(counts)
    if header["special_points"] == 1:
        heights[counts == int(header["lowest"]) + _MISSING] = np.nan
    inversion = int(header["inversion"])
    heights *= float(header["steps"][2]) * (-1 if inversion in (1, _MIRRORED_X, _MIRRORED_Y) else 1)
    turned = heights[:: -1 if inversion == _MIRRORED_Y else 1, :: -1 if inversion == _MIRRORED_X else 1]
    return turned[rows].copy()


def _instrument(header: np.void) -> dict[str, Any]:
    """Return name, sample and date that a header states."""
    stated = {
        "vendor": "Digital Surf",
        "name": _text(header["instrument_name"]),
        "sample": _text(header["object_name"]),
    }
    with suppress(ValueError):  # no date
        year, month, day, hour, minute, second = map(int, header["time"][::-1])
        stated["acquisition_time"] = datetime.datetime(year, month, day, hour, minute, second).isoformat()
    return instrument_metadata(stated)


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


READER = Reader(RecognisedBy.MARK, begins_with(_MARK + b"\0"), read, binary=True)
