"""Containers of many formats (TIFF, ZIP, OLE): checks before opening, and names of unsupported ones."""

import struct
import zipfile
from pathlib import Path

from roughcontact.errors import InputFileError
from roughcontact.io.guards import ARCHIVE_ERRORS

TIFF = (b"II*\0", b"MM\0*")
ZIP = (b"PK\x03\x04",)
OLE = (b"\xd0\xcf\x11\xe0",)
_MOST_PAGES = 10_000
# member of an archive -> its format in SurfaceTopography
_MEMBERS = {
    "index.xml": "plux",
    ".dsc": "nmm",
    ".oir": "poir",
    "xl/workbook.xml": "mitutoyo",
    ".prf": "qep",
}


def check_tiff(path: Path) -> None:
    """Refuse a TIFF whose pages form a loop or lie outside it: a library that follows them would never end.

    A page is a count of its tags (2 bytes), 12 bytes for each of them, and the position of the next page.
    """
    size = path.stat().st_size
    seen: set[int] = set()
    with path.open("rb") as stream:
        order = "<" if stream.read(4) == TIFF[0] else ">"
        position = _number(stream.read(4), order + "I")
        while position:
            if position in seen or len(seen) == _MOST_PAGES:
                raise InputFileError(
                    f"{path}: damaged TIFF: its pages form a loop, or are more than {_MOST_PAGES}"
                )
            seen.add(position)
            stream.seek(min(position, size))
            tags = stream.read(2)
            stream.seek(12 * _number(tags, order + "H"), 1)
            following = stream.read(4)
            if len(tags) < 2 or len(following) < 4:
                raise InputFileError(f"{path}: damaged or cut off TIFF: a page lies outside the file")
            position = _number(following, order + "I")


def _number(data: bytes, layout: str) -> int:
    """Return an unsigned number, 0 where the bytes are missing."""
    return struct.unpack(layout, data)[0] if len(data) == struct.calcsize(layout) else 0


def formats_within(path: Path) -> set[str]:
    """Return the formats whose members a ZIP archive has; empty for an archive of another kind."""
    names = [name.lower() for name in _members(path)]
    return {each for end, each in _MEMBERS.items() if any(name.endswith(end) for name in names)}


def foreign(path: Path, head: bytes) -> str:
    """Return the name of a container format without a reader, and how to convert it; empty where unknown."""
    if head.startswith(TIFF):
        return (
            "a TIFF picture, but none of Park Systems, JPK or Olympus LEXT: nothing says its heights; "
            "export the map itself as X3P, SDF or text"
        )
    if head.startswith(OLE) and "Workbook".encode("utf-16-le") in path.read_bytes():
        return "an Excel workbook; save the sheet as CSV or text"
    return _archive(_members(path)) if head.startswith(ZIP) else ""


def _archive(names: list[str]) -> str:
    """Return the kind of an archive with these files, and how to convert it."""
    if any(name.startswith("xl/") for name in names):
        return "an Excel workbook, but not one of Mitutoyo's profiles; save the sheet as CSV or text"
    if any(name.startswith(("word/", "ppt/")) for name in names):
        return "an Office document; export the map itself as X3P, SDF or text"
    if names and all(name.endswith(".npy") for name in names):
        return "an archive of NumPy arrays (npz); save the array of heights alone with numpy.save"
    listed = ", ".join(repr(name) for name in names[:4]) + (", ..." if len(names) > 4 else "")
    return (
        "a ZIP archive of none of the formats that are known (X3P, PLUX, NMM, POIR, QEP, Mitutoyo); it holds "
        f"{listed or 'nothing'}; if one of these is the measured file, unpack it"
    )


def _members(path: Path) -> list[str]:
    """Return the names of the files in an archive."""
    try:
        with zipfile.ZipFile(path) as archive:
            return [name for name in archive.namelist() if not name.endswith("/")]
    except ARCHIVE_ERRORS:
        return []
