"""TrueMap's TMD (version 2.0), which GelSight writes too: a map of lengths in millimetres.

Mark and comment end with a zero (24 characters in TrueMap, none in GelSight); then numbers of columns and
rows (32 bits), lengths and origins along x and y, and rows of 4-byte floats, little-endian.
"""

import struct
from pathlib import Path

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import Channel, MeasuredFile, as_heights
from roughcontact.io.guards import check_line_ends, check_points
from roughcontact.io.interface import Reader, RecognisedBy
from roughcontact.io.lengths import compare_size
from roughcontact.io.metadata import instrument_metadata
from roughcontact.io.text.lines import looks_like_text

_MARK = b"Binary TrueMap Data File"
_VERSION = b"v2.0"
_HEADER = struct.Struct("<2I4f")
_MAX_HEADER_BYTES = 4096  # bytes of mark and comment


def recognises(path: Path, head: bytes) -> bool:
    r"""Return whether a file begins with TrueMap's mark."""
    return head.startswith(_MARK) and not looks_like_text(head)


def read(path: Path) -> MeasuredFile:
    """Open a file of one map; other versions are refused."""
    check_line_ends(path)
    with path.open("rb") as stream:
        fields = stream.read(_MAX_HEADER_BYTES).split(b"\0", 2)
        if len(fields) < 3 or not fields[0].removeprefix(_MARK).strip().startswith(_VERSION):
            raise InputFileError(
                "looks like TrueMap TMD, but is damaged or of another version than 2.0; export the "
                "map again, as X3P or SDF where the software can"
            )
        comment = fields[1].decode("latin-1").strip()
        begin = len(fields[0]) + len(fields[1]) + 2
        stream.seek(begin)
        header = stream.read(_HEADER.size)
        required_size = begin + _HEADER.size
        if len(header) == _HEADER.size:
            nx, ny, length_x, length_y, *_ = _HEADER.unpack(header)
            check_points((ny, nx))
            required_size += 4 * nx * ny
        stale, notes = compare_size(path, required_size)
        if not nx * ny or not (0 < length_x < np.inf and 0 < length_y < np.inf):
            raise InputFileError(
                f"looks like TrueMap TMD, but is damaged ({nx} x {ny} points on {length_x:g} mm x "
                f"{length_y:g} mm)"
            )
        values = np.frombuffer(stream.read(4 * nx * ny), "<f4").reshape(ny, nx)
    heights = as_heights(values)
    channel = Channel(
        "Default",
        (ny, nx),
        heights.copy,
        height_unit="mm",
        dx=length_x / nx,
        dy=length_y / ny,
        lateral_unit="mm",
    )
    instrument = instrument_metadata(
        {"vendor": "TrueMap" if "TrueMap" in comment else "", "comment": comment}
    )
    return MeasuredFile("TrueMap TMD", [channel], "top", instrument, warnings=notes, stale=stale)


READER = Reader(RecognisedBy.MARK, recognises, read)
