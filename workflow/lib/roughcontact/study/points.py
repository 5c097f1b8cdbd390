"""Fast estimate of the number of points in a measured file, for memory and time of its jobs.

Nothing is unpacked and no reader of a vendor's format is called, so that damaged files are harmless here.
"""

import re
import zipfile
from contextlib import suppress
from itertools import chain
from math import prod
from pathlib import Path

import numpy as np

from roughcontact.io.guards import ARCHIVE_ERRORS, MAX_POINTS
from roughcontact.io.interface import read_head
from roughcontact.io.text.lines import looks_like_text

_SAMPLE_BYTES = 2**16  # bytes of a text that are examined
_HEADER = 2**20  # bytes of the header of an X3P file that are examined
_SIZES = re.compile(rb"<(?:\w+:)?Size[XYZ]>\s*(\d{1,12})")
# in instrument files with a single map: 2.3 to 8
_BYTES_PER_POINT = 4


def estimate_points(path: str | Path) -> int:
    """Return the approximate number of points of the map in a measured file, 0 where there is no file.

    Exact for NumPy's arrays and X3P, extrapolated from a piece of a text, one for every four bytes of all
    others.
    """
    path = Path(path)
    try:
        head, size = read_head(path), path.stat().st_size
        if head.startswith(b"\x93NUMPY"):
            points = _count_array_points(path)
        elif head.startswith(b"PK"):
            points = _count_archive_points(path)
        else:
            points = _count_text_points(path, size) if looks_like_text(head) else 0
        return min(points or size // _BYTES_PER_POINT, MAX_POINTS)
    except OSError:  # the job that reads it reports the error
        return 0


def _count_array_points(path: Path) -> int:
    """Return the number of points that the header of an array of NumPy states; 0 for a damaged one."""
    with suppress(Exception):  # a damaged header fails in any way
        return np.load(path, mmap_mode="r", allow_pickle=False).size
    return 0


def _count_archive_points(path: Path) -> int:
    """Return the number of points from the header of X3P, or the unpacked size of another archive."""
    try:
        with zipfile.ZipFile(path) as archive:
            for entry in archive.infolist():
                if entry.filename.rpartition("/")[2] == "main.xml":
                    with archive.open(entry) as stream:
                        if sizes := _SIZES.findall(stream.read(_HEADER)):
                            return prod(map(int, sizes))
            return sum(entry.file_size for entry in archive.infolist()) // _BYTES_PER_POINT
    except ARCHIVE_ERRORS:
        return 0


def _count_text_points(path: Path, size: int) -> int:
    """Estimate the number of points of a text from a piece in its middle; 0 where that is no text."""
    with path.open("rb") as stream:
        stream.seek(max(0, (size - _SAMPLE_BYTES) // 2))
        sample = stream.read(_SAMPLE_BYTES)
    text = sample.replace(b"\0", b"")  # of UTF-16
    if not looks_like_text(text):
        return 0
    lines = [_cells(line) for line in text.splitlines()]
    complete_lines = lines[1:-1] or lines
    is_list = max(map(len, complete_lines)) <= 3  # positions and height in each line
    points = sum(map(bool, lines)) if is_list else len(list(chain.from_iterable(lines)))
    return round(points / len(sample) * size)


def _cells(line: bytes) -> list[bytes]:
    """Return the cells of a line; commas are separators only where there is no other."""
    cells = re.findall(rb"[^\s;]+", line)
    return cells if len(cells) != 1 else [cell for cell in cells[0].split(b",") if cell]
