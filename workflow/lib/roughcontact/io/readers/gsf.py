r"""Gwyddion Simple Field (GSF): a header of lines ``Name = value``, and one map of 4-byte floats.

After zero bytes up to the next multiple of four (one at least) the heights follow row by row from the top,
little-endian, NaN where not measured.
"""

from pathlib import Path

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import Channel, MeasuredFile, as_heights
from roughcontact.io.guards import check_line_ends, check_points
from roughcontact.io.interface import Reader, RecognisedBy

_MARK = b"Gwyddion Simple Field 1.0\n"
_MAX_HEADER_BYTES = 2**20  # bytes of the header


def recognises(path: Path, head: bytes) -> bool:
    r"""Return whether a file begins with the mark."""
    return head.startswith(_MARK.rstrip())


def read(path: Path) -> MeasuredFile:
    """Open a file of one map; lengths and units that the header omits stay unknown."""
    check_line_ends(path)
    with path.open("rb") as stream:
        text, zero, _ = stream.read(_MAX_HEADER_BYTES).partition(b"\0")
        lines = text.removeprefix(_MARK).decode("utf-8", "replace").splitlines()
        statements = {
            key.strip(): value.strip() for key, equals, value in (line.partition("=") for line in lines)
        }
        try:
            nx, ny = int(statements["XRes"]), int(statements["YRes"])
            lengths = [float(statements[key]) if key in statements else None for key in ("XReal", "YReal")]
        except (KeyError, ValueError) as error:
            raise InputFileError(
                f"looks like GSF, but is damaged: no size in its header ({error})"
            ) from error
        if (
            not zero
            or min(nx, ny) < 1
            or not all(length is None or 0 < length < np.inf for length in lengths)
        ):
            raise InputFileError("looks like GSF, but its header is damaged or cut off")
        check_points((ny, nx))
        begin = len(text) + 4 - len(text) % 4
        stored = path.stat().st_size - begin
        if stored != 4 * nx * ny:
            raise InputFileError(
                f"{stored} bytes of heights where its header needs {4 * nx * ny}: it was cut off or changed"
            )
        stream.seek(begin)
        values = np.frombuffer(stream.read(stored), "<f4").reshape(ny, nx)
    heights = as_heights(values)
    length_x, length_y = lengths
    channel = Channel(
        statements.get("Title") or "height",
        (ny, nx),
        heights.copy,
        height_unit=statements.get("ZUnits") or None,
        dx=length_x / nx if length_x else None,
        dy=length_y / ny if length_y else None,
        lateral_unit=statements.get("XYUnits") or None,
    )
    return MeasuredFile("Gwyddion Simple Field", [channel], first_row="top")


READER = Reader(RecognisedBy.MARK, recognises, read)
