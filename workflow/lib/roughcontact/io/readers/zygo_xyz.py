"""Zygo's XYZ data files (Format 1): the phase as heights in micrometres, a line for each pixel.

The fourth line has the columns and rows, the eighth the side of a pixel in m, 0 where not calibrated; between
two lines with ``#`` lie column, row (upwards) and height, or ``No Data``.
"""

from pathlib import Path

import numpy as np

from roughcontact.io.channels import Channel, MeasuredFile
from roughcontact.io.guards import refusal, refusing
from roughcontact.io.instrument_kinds import OPTICAL
from roughcontact.io.interface import Reader, RecognisedBy, begins_with
from roughcontact.io.text.lines import read_text

_MARK = b"Zygo XYZ Data File - Format 1"


def read(path: Path) -> MeasuredFile:
    """Open a file of one map."""
    lines = [line.strip() for line in read_text(path).splitlines()]
    marks = [number for number, line in enumerate(lines) if line == "#"]
    with refusing("looks like a Zygo XYZ data file, but is damaged"):
        nx, ny = map(int, lines[3].split()[2:4])
        pixel = float(lines[7].split()[6])
        points = [line.split()[:3] for line in lines[marks[0] + 1 : [*marks, None][1]]]
        if len(marks) != 2 or len(points) != nx * ny:
            raise refusal("cut list of pixels", count=len(points), nx=nx, ny=ny)
        x, y = np.array([point[:2] for point in points], dtype=int).T
        heights = np.full((ny, nx), np.nan)
        heights[y - y.min(), x - x.min()] = [float("nan" if z == "No" else z) for _, _, z in points]
    # not calibrated: pixels are asked for, never 1
    side, unit = (pixel, "m") if pixel > 0 else (None, None)
    channel = Channel("height", (ny, nx), heights.copy, "um", side, side, unit)
    return MeasuredFile("Zygo XYZ", [channel], "bottom", {"kind": OPTICAL.name, "vendor": "Zygo"})


READER = Reader(RecognisedBy.MARK, begins_with(_MARK), read, memory_per_byte=12)
