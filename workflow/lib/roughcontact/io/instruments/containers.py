"""Containers of many formats (TIFF, ZIP, OLE): checks before opening, and names of unsupported ones."""

import html
import mmap
import re
import struct
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, NamedTuple

from roughcontact.errors import InputFileError
from roughcontact.io.guards import ARCHIVE_ERRORS, listed

TIFF = (b"II*\0", b"MM\0*")
ZIP = (b"PK\x03\x04",)
OLE = (b"\xd0\xcf\x11\xe0",)
_MOST_PAGES = 10_000
_WORKBOOK = 2**20  # bytes of the list of sheets that are read
_TIFF_TYPES = {3: "H", 4: "I", 5: "Q", 8: "h", 9: "i", 10: "q", 11: "f", 12: "d"}  # all others: bytes
_STRIPS, _STRIP_LENGTHS = 273, 279  # tags
# member of an archive -> its format in SurfaceTopography
_FORMATS_BY_ENTRY = {"index.xml": "plux", ".dsc": "nmm", ".oir": "poir", ".prf": "qep"}


def check_tiff(path: Path) -> None:
    """Refuse a TIFF whose pages form a loop or lie outside it: a library that follows them would never end.

    A page is a count of its tags (2 bytes), 12 bytes for each of them, and the position of the next page.
    """
    with path.open("rb") as stream:
        for _ in _tiff_pages(stream):
            pass


class Tag(NamedTuple):
    """One tag of a TIFF: its number, and where its value lies (bytes).

    A value of up to four bytes lies within the tag.
    """

    number: int
    layout: str
    place: int
    length: int


def tiff_tags(stream: IO[bytes] | mmap.mmap) -> Iterator[Tag]:
    """Yield the tags of all pages of a TIFF that `check_tiff` has passed."""
    for order, begin, count in _tiff_pages(stream):
        for entry_offset in range(begin + 2, begin + 2 + 12 * count, 12):
            stream.seek(entry_offset)
            number, value_type, values, position = struct.unpack(order + "HHII", stream.read(12))
            letter = _TIFF_TYPES.get(value_type, "s")
            length = values * struct.calcsize(order + letter)
            yield Tag(
                number, f"{order}{values}{letter}", position if length > 4 else entry_offset + 8, length
            )


def tiff_end(stream: IO[bytes] | mmap.mmap) -> int:
    """Return the end of the last page, value or strip of a TIFF that `check_tiff` has passed, bytes."""
    ends = [begin + 6 + 12 * count for _, begin, count in _tiff_pages(stream)]
    strips: dict[int, list[int]] = {_STRIPS: [], _STRIP_LENGTHS: []}
    for tag in tiff_tags(stream):
        ends.append(tag.place + tag.length)
        if tag.number in strips:
            stream.seek(tag.place)
            data = stream.read(tag.length)
            strips[tag.number] += struct.unpack(tag.layout, data) if len(data) == tag.length else ()
    return max([*ends, *map(sum, zip(*strips.values(), strict=False))])


def _tiff_pages(stream: IO[bytes] | mmap.mmap) -> Iterator[tuple[str, int, int]]:
    """Yield byte order, position and number of tags of every page; errors name the path."""
    stream.seek(0, 2)
    size = stream.tell()  # a mapped file returns no position from seek
    stream.seek(0)
    order = "<" if stream.read(4) == TIFF[0] else ">"
    position = _number(stream.read(4), order + "I")
    visited: set[int] = set()
    while position:
        if position in visited or len(visited) == _MOST_PAGES:
            raise InputFileError(f"damaged TIFF: its pages form a loop, or are more than {_MOST_PAGES}")
        visited.add(position)
        stream.seek(min(position, size))
        tags = stream.read(2)
        count = _number(tags, order + "H")
        stream.seek(12 * count, 1)
        following = stream.read(4)
        if len(tags) < 2 or len(following) < 4:
            raise InputFileError("damaged or cut off TIFF: a page lies outside the file")
        yield order, position, count
        position = _number(following, order + "I")


def _number(data: bytes, layout: str) -> int:
    """Return an unsigned number, 0 where the bytes are missing."""
    return struct.unpack(layout, data)[0] if len(data) == struct.calcsize(layout) else 0


def formats_within(path: Path) -> set[str]:
    """Return the formats whose members a ZIP archive has; empty for an archive of another kind."""
    names = [name.lower() for name in _entry_names(path)]
    return {
        format_ for end, format_ in _FORMATS_BY_ENTRY.items() if any(name.endswith(end) for name in names)
    }


def foreign(path: Path, head: bytes) -> str:
    """Return the name of a container format without a reader, and how to convert it; empty where unknown."""
    if head.startswith(TIFF):
        return (
            "a TIFF picture, but none of Park Systems, JPK or Olympus LEXT: nothing says its heights; "
            "export the map itself as X3P, SDF or text"
        )
    if head.startswith(OLE) and "Workbook".encode("utf-16-le") in path.read_bytes():
        return "an Excel workbook; save the sheet as CSV or text"
    return _archive(path) if head.startswith(ZIP) else ""


def _archive(path: Path) -> str:
    """Return the kind of an archive by the files in it, and how to convert it."""
    names = _entry_names(path)
    if any(name.startswith("xl/") for name in names):
        sheets = _sheets(path) if "xl/workbook.xml" in names else []
        return (
            "an Excel workbook, but not one of Mitutoyo's profiles; save the sheet with the heights as CSV "
            "or text" + (f" (its sheets: {listed(sheets, 5)})" if sheets else "")
        )
    if any(name.startswith(("word/", "ppt/")) for name in names):
        return "an Office document; export the map itself as X3P, SDF or text"
    if names and all(name.endswith(".npy") for name in names):
        return "an archive of NumPy arrays (npz); save the array of heights alone with numpy.save"
    return (
        "a ZIP archive of none of the formats that are known (X3P, PLUX, NMM, POIR, QEP, Mitutoyo); it holds "
        f"{listed(names, 4) or 'nothing'}; if one of these is the measured file, unpack it"
    )


def _sheets(path: Path) -> list[str]:
    """Return the names of the sheets of an Excel workbook."""
    with zipfile.ZipFile(path) as archive, archive.open("xl/workbook.xml") as stream:
        text = stream.read(_WORKBOOK).decode("utf-8", "replace")
    return [html.unescape(name) for name in re.findall(r"<(?:\w+:)?sheet\s[^>]*?name=\"([^\"]*)\"", text)]


def _entry_names(path: Path) -> list[str]:
    """Return the names of the files in an archive."""
    try:
        with zipfile.ZipFile(path) as archive:
            return [name for name in archive.namelist() if not name.endswith("/")]
    except ARCHIVE_ERRORS:
        return []
