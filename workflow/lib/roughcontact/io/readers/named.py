"""Formats that are recognised but not supported: rejected by name, with advice on conversion."""

from pathlib import Path
from typing import NoReturn

from roughcontact.errors import InputFileError
from roughcontact.io.interface import Reader, RecognisedBy, head_of
from roughcontact.io.text.lines import looks_like_text

_PICTURE = "a picture, whose colours are no heights; export the map itself as X3P, SDF or text"
_PACKED = "a packed file; unpack it first"
_SURFER = "a grid of Surfer, which is not read; save it as ASCII XYZ, or as an Arc/Info ASCII grid"
# first bytes -> kind of file, and advice
_UNREADABLE = {
    b"DSCOMPRESSED": (
        "a Digital Surf file in its compressed form (DSCOMPRESSED), which is not read; save it uncompressed "
        "(SUR), or export it as X3P or SDF"
    ),
    b"\x1f\x8b": _PACKED + " (gunzip)",
    b"BZh": _PACKED + " (bunzip2)",
    b"\xfd7zXZ\0": _PACKED + " (unxz)",
    b"7z\xbc\xaf\x27\x1c": _PACKED + " (7-Zip)",
    b"Rar!\x1a\x07": _PACKED + " (RAR)",
    b"\x89PNG\r\n\x1a\n": _PICTURE,
    b"\xff\xd8\xff": _PICTURE,
    b"GIF8": _PICTURE,
    b"%PDF-": "a PDF; export the map itself as X3P, SDF or text",
    b"DSBB": _SURFER,
    b"DSRB": _SURFER,
    b"ISO 5436": (
        "a profile in the form of ISO 5436-2 (SMD), which is not read; export it as X3P, or as text x z"
    ),
}
# the same for files in plain text
_KNOWN_TEXTS = {
    b"MATLAB 7.3 MAT-file": (
        "a MATLAB file of version 7.3 (HDF5), which is not read; save it with save(..., '-v7')"
    ),
    b"Wyko ASCII Data File": (
        "a Wyko file in ASCII, whose heights are counted in waves, which is not read; take the OPD file "
        "itself"
    ),
    b"Zygo ASCII Data File": (
        "a MetroPro file in ASCII, whose heights may be counts of the phase, which is not read; take the DAT "
        "or DATX file itself"
    ),
    b"Zygo XYZ Data File - Format 2": "a Zygo XYZ data file of another format than 1; export it as format 1",
    b"DSAA": _SURFER,
    b"ply": "a mesh (PLY), whose columns may be in any order; export the map as a text of points x, y, z",
}


def recognises(path: Path, head: bytes) -> bool:
    r"""Return whether a file begins as one of the formats that are refused by name.

    Examples
    --------
    >>> recognises(Path("map.sur"), b"DSCOMPRESSED\0\0"), recognises(Path("map.txt"), b"BZh is a name")
    (True, False)
    """
    return head.startswith(tuple(_KNOWN_TEXTS)) or (
        head.startswith(tuple(_UNREADABLE)) and not looks_like_text(head)
    )


def read(path: Path) -> NoReturn:
    """Refuse a file by the name of its format, and say how to convert it."""
    head = head_of(path)
    description = next(
        description for mark, description in (_UNREADABLE | _KNOWN_TEXTS).items() if head.startswith(mark)
    )
    raise InputFileError(f"{path}: this is {description}")


READER = Reader(RecognisedBy.MARK, recognises, read)
