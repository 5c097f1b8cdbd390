"""Interface of the readers: how each recognises a file, and how it reads it."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

from roughcontact.io.channels import MeasuredFile
from roughcontact.io.text.lines import looks_like_text

HEAD_BYTES = 4096
HEADER_BYTES = 2**20  # within which a header of plain text has to end


class RecognisedBy(IntEnum):
    """How a format is recognised, in the order in which the readers are asked.

    Formats that are recognised in the same way exclude one another, so that their order does not matter.
    """

    #: Contents of a container. First, because other formats are recognised by the mark of the container
    #: alone: an X3P file is a ZIP archive as several instruments' files are, and a netCDF file may be HDF5.
    CONTENTS = 1
    #: First bytes that no other format has. Before text, because the header of some of these is plain text.
    MARK = 2
    #: Readable text without a mark.
    TEXT = 3
    #: Nothing: the one reader of last resort, for files that no other reader recognises.
    NOTHING = 4


@dataclass(frozen=True)
class Reader:
    """One reader; each module of `roughcontact.io.readers` defines one with the name `READER`.

    Attributes
    ----------
    recognised_by : RecognisedBy
        How it recognises files, which determines when it is asked.
    recognises : callable (path, head) -> bool
        Whether it reads this file. `head` has the first 4096 bytes, which are sufficient for most formats. It
        is called for files of every format: so it imports nothing large before the mark agrees, and raises
        `InputFileError` only for a container (HDF5) that is damaged beyond recognition.
    read : callable (path) -> MeasuredFile
        Opens a file that it recognised. It raises `InputFileError`, without the path, for a file that is
        damaged, cut off, refers to others or holds no map, and guesses nothing that the file does not state.
    memory_per_byte, binary : int, bool
        Memory for each byte of a file; whether line ends show that it was transferred as text.
    """

    recognised_by: RecognisedBy
    recognises: Callable[[Path, bytes], bool]
    read: Callable[[Path], MeasuredFile]
    memory_per_byte: int = 0
    binary: bool = False


def read_head(path: Path, size: int = HEAD_BYTES) -> bytes:
    """Return the first bytes of a file, which identify most formats.

    Parameters
    ----------
    path : Path
    size : int
        How many of them.

    Returns
    -------
    bytes
    """
    with path.open("rb") as stream:
        return stream.read(size)


def begins_with(*marks: bytes, in_text: bool = True) -> Callable[[Path, bytes], bool]:
    r"""Return a function that tells by its first bytes whether a file begins with one of some marks.

    Parameters
    ----------
    *marks : bytes
    in_text : bool
        Whether a text that begins so is of that format, too.

    Returns
    -------
    callable (path, head) -> bool

    Examples
    --------
    >>> recognises = begins_with(b"GWYP", in_text=False)
    >>> recognises(Path("map.dat"), b"GWYPGwyContainer\0"), recognises(Path("map.txt"), b"GWYP 1 2 3")
    (True, False)
    """
    return lambda path, head: head.startswith(marks) and (in_text or not looks_like_text(head))
