r"""Gwyddion Simple Field (GSF): a header of lines ``Name = value``, and one map of 4-byte floats.

After zero bytes up to the next multiple of four (one at least) the heights follow row by row from the top,
little-endian, NaN where not measured.
"""

from pathlib import Path

from roughcontact.io.channels import Channel, MeasuredFile, on_field, stored_floats
from roughcontact.io.guards import refusal, refusing
from roughcontact.io.interface import HEADER_BYTES, Reader, RecognisedBy, begins_with, read_head

_MARK = b"Gwyddion Simple Field 1.0\n"


def read(path: Path) -> MeasuredFile:
    """Open a file of one map; lengths and units that the header omits stay unknown."""
    text, zero, _ = read_head(path, HEADER_BYTES).partition(b"\0")
    lines = text.removeprefix(_MARK).decode("utf-8", "replace").splitlines()
    statements = {key.strip(): value.strip() for key, _, value in (line.partition("=") for line in lines)}
    with refusing("looks like GSF, but is damaged: no size in its header"):
        nx, ny = int(statements["XRes"]), int(statements["YRes"])
        lengths = [float(statements[key]) if key in statements else None for key in ("XReal", "YReal")]
    if not zero:
        raise refusal("cut GSF")
    shape, start = (ny, nx), len(text) + 4 - len(text) % 4
    name, unit, unit_xy = map(statements.get, ("Title", "ZUnits", "XYUnits"))
    channel = Channel(name or "height", shape, lambda: stored_floats(path, "<f4", shape, start), unit or None)
    channel = on_field(channel, lengths, unit_xy)
    return MeasuredFile("Gwyddion Simple Field", [channel], "top", required_size=start + 4 * nx * ny)


READER = Reader(RecognisedBy.MARK, begins_with(_MARK.rstrip()), read, binary=True)
