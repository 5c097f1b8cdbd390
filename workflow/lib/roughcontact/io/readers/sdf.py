"""SDF, ISO 25178-71: a header and one map, in text or binary, in metres; row 0 is the lowest line."""

import io
import re
from pathlib import Path

import numpy as np

from roughcontact.io.channels import Channel, MeasuredFile, as_heights, stated_length
from roughcontact.io.guards import refusal, refusing
from roughcontact.io.interface import Reader, RecognisedBy, begins_with

_MARKS = (b"aISO-", b"bISO-", b"aBCR-", b"bBCR-", b"\xef\xbb\xbfaISO-")
_SOFTGAUGE = re.compile(rb"\A([ab])NPL-(V?\d\.\d)")  # of NPL's softgauges: as BCR-1.0, but for the name
_TEXT = bytes([*b"\t\n\r", *range(32, 127)])


def read(path: Path) -> MeasuredFile:
    """Open an SDF file with sdfio: ASCII and binary, the BCR and ISO revisions, bad points as missing."""
    import sdfio

    with refusing("not readable as SDF"):
        file = sdfio.read(io.BytesIO(_SOFTGAUGE.sub(rb"\1BCR-1.0", path.read_bytes(), count=1)))
    header = file.header
    if not header.z_scale or not np.isfinite(header.z_scale):
        raise refusal("scale of SDF", scale=header.z_scale)
    dates = {"acquisition_time": header.create_date, "modified": header.mod_date}
    instrument = {"vendor": header.manufacturer_id, **dates}
    shape, dx = file.data.shape, stated_length(header.x_scale)
    dy = stated_length(header.y_scale) if shape[0] > 1 else None
    channel = Channel("height", shape, lambda: as_heights(file.data), "m", dx, dy, "m")
    # behind the heights of a binary file lies text or nothing
    trailer = file.trailer if isinstance(file.trailer, bytes) else str(file.trailer or "").encode()
    if any(mark in trailer for mark in _MARKS):
        raise refusal("second SDF")
    required_size = path.stat().st_size - len(trailer) if trailer.translate(None, _TEXT) else None
    return MeasuredFile("SDF (ISO 25178-71)", [channel], "bottom", instrument, required_size=required_size)


READER = Reader(RecognisedBy.MARK, begins_with(*_MARKS, b"aNPL-", b"bNPL-"), read, memory_per_byte=12)
