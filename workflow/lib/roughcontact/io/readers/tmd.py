"""TrueMap's TMD (version 2.0), which GelSight writes too: a map of lengths in millimetres.

Mark and comment end with a zero (24 characters in TrueMap, none in GelSight); then numbers of columns and
rows (32 bits), lengths and origins along x and y, and rows of 4-byte floats, little-endian.
"""

import struct
from pathlib import Path

from roughcontact.io.channels import Channel, MeasuredFile, on_field, stored_floats
from roughcontact.io.guards import refusal
from roughcontact.io.interface import Reader, RecognisedBy, begins_with, read_head

_MARK = b"Binary TrueMap Data File"
_VERSION = b"v2.0"
_HEADER = struct.Struct("<2I4f")


def read(path: Path) -> MeasuredFile:
    """Open a file of one map; other versions are refused."""
    mark, *fields = read_head(path).split(b"\0", 2)
    if len(fields) < 2 or not mark.removeprefix(_MARK).strip().startswith(_VERSION):
        raise refusal("version of TrueMap")
    if len(fields[1]) < _HEADER.size:
        raise refusal("cut TrueMap")
    comment = fields[0].decode("latin-1").strip()
    start = len(mark) + len(fields[0]) + 2 + _HEADER.size
    nx, ny, length_x, length_y, *_ = _HEADER.unpack_from(fields[1])
    channel = Channel("Default", (ny, nx), lambda: stored_floats(path, "<f4", (ny, nx), start), "mm")
    channel = on_field(channel, (length_x, length_y), "mm")
    instrument = {"vendor": "TrueMap" if "TrueMap" in comment else "", "comment": comment}
    return MeasuredFile("TrueMap TMD", [channel], "top", instrument, required_size=start + 4 * nx * ny)


READER = Reader(RecognisedBy.MARK, begins_with(_MARK, in_text=False), read, binary=True)
