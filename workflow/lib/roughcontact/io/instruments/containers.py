"""Containers of many formats (TIFF, ZIP, OLE): checks before opening, and names of unsupported ones."""

import html
import mmap
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from roughcontact.io.guards import listed, refusal

TIFF = (b"II*\0", b"MM\0*")
ZIP = (b"PK\x03\x04",)
OLE = (b"\xd0\xcf\x11\xe0",)
_MAX_PAGES = 10_000
_WORKBOOK = 2**20  # bytes of the list of sheets that are read
# all others: bytes
_TIFF_TYPES = {3: "u2", 4: "u4", 5: "u8", 8: "i2", 9: "i4", 10: "i8", 11: "f4", 12: "f8"}
_STRIPS, _STRIP_LENGTHS = 273, 279  # tags
# member of an archive -> its format in SurfaceTopography
_FORMATS = {"index.xml": "plux", ".dsc": "nmm", ".oir": "poir", ".prf": "qep", "workbook.xml": "mitutoyo"}


def check_tiff(path: Path) -> None:
    """Refuse a TIFF whose pages form a loop or lie outside it: a library would follow them without end."""
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        for _ in _tiff_pages(data):
            pass


class Tag(NamedTuple):
    """One tag of a TIFF: its number, and type, place and length (bytes) of its value.

    A value of up to four bytes lies within the tag.
    """

    number: int
    value_type: np.dtype
    place: int
    length: int


def tiff_tags(data: mmap.mmap) -> Iterator[Tag]:
    """Yield the tags of all pages of a TIFF that `check_tiff` has passed."""
    for start, entries in _tiff_pages(data):
        order = entries.dtype[0].byteorder
        for index, (number, value_type, count, position) in enumerate(entries.tolist()):
            element = np.dtype(_TIFF_TYPES.get(value_type, "u1")).newbyteorder(order)
            length = count * element.itemsize
            yield Tag(number, element, position if length > 4 else start + 10 + 12 * index, length)


def tiff_end(data: mmap.mmap) -> int:
    """Return the end of the last page, value or strip of a TIFF that `check_tiff` has passed, bytes."""
    stops = [start + 6 + entries.nbytes for start, entries in _tiff_pages(data)]
    strips: dict[int, list[int]] = {_STRIPS: [], _STRIP_LENGTHS: []}
    for tag in tiff_tags(data):
        stops.append(tag.place + tag.length)
        if tag.number in strips and stops[-1] <= len(data):
            strips[tag.number] += np.frombuffer(data[tag.place : stops[-1]], tag.value_type).tolist()
    return max([*stops, *map(sum, zip(*strips.values(), strict=False))])


def _tiff_pages(data: mmap.mmap) -> Iterator[tuple[int, np.ndarray]]:
    """Yield position and tags of every page: a count (2 bytes), the tags, the position of the next page."""
    order: Literal["little", "big"] = "little" if data[:4] == TIFF[0] else "big"
    entry = np.dtype("u2, u2, u4, u4").newbyteorder("<" if order == "little" else ">")
    position = int.from_bytes(data[4:8], order)
    positions: set[int] = set()
    while position:
        # each page names the next one: nothing keeps a file from naming one of those before
        if position in positions or len(positions) == _MAX_PAGES:
            raise refusal("loop of pages", limit=_MAX_PAGES)
        positions.add(position)
        stop = position + 2 + entry.itemsize * int.from_bytes(data[position : position + 2], order)
        if stop + 4 > len(data):
            raise refusal("page outside")
        yield position, np.frombuffer(data[position + 2 : stop], entry)
        position = int.from_bytes(data[stop : stop + 4], order)


def formats_within(path: Path) -> set[str]:
    """Return the formats whose members a ZIP archive has; empty for an archive of another kind."""
    names = [name.lower() for name in _entry_names(path)]
    return {format_ for suffix, format_ in _FORMATS.items() if any(name.endswith(suffix) for name in names)}


def foreign(path: Path, head: bytes) -> Exception | None:
    """Return the refusal of a container format without a reader, with how to convert it; None: unknown."""
    if head.startswith(TIFF):
        return refusal("picture")
    if head.startswith(OLE) and "Workbook".encode("utf-16-le") in path.read_bytes():
        return refusal("old workbook")
    return _archive(path) if head.startswith(ZIP) else None


def _archive(path: Path) -> Exception:
    """Return the refusal of an archive by the files in it."""
    names = _entry_names(path)
    if any(name.startswith("xl/") for name in names):
        sheets = list_sheets(path) if "xl/workbook.xml" in names else []
        return refusal("workbook", sheets=f" (its sheets: {listed(sheets, 5)})" if sheets else "")
    if any(name.startswith(("word/", "ppt/")) for name in names):
        return refusal("document")
    if names and all(name.endswith(".npy") for name in names):
        return refusal("npz")
    return refusal("archive", listing=listed(names, 4) or "nothing")


def list_sheets(path: Path) -> list[str]:
    """Return the names of the sheets of an Excel workbook."""
    with zipfile.ZipFile(path) as archive, archive.open("xl/workbook.xml") as stream:
        text = stream.read(_WORKBOOK).decode("utf-8", "replace")
    return [html.unescape(name) for name in re.findall(r"<(?:\w+:)?sheet\s[^>]*?name=\"([^\"]*)\"", text)]


def _entry_names(path: Path) -> list[str]:
    """Return the names of the files in an archive."""
    with zipfile.ZipFile(path) as archive:
        return [name for name in archive.namelist() if not name.endswith("/")]
