"""What a reader of a format offers: how it recognises a file, and how it reads it."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

from roughcontact.io.channels import MeasuredFile

HEAD_BYTES = 4096


class ToldBy(IntEnum):
    """How a format is told from others, in the order in which the readers are asked.

    Readers that are told in the same way exclude one another, so that their order does not matter.
    """

    #: What lies inside a container. First, because other formats are told by the mark of the container alone:
    #: an X3P file is a ZIP archive as several instruments' files are, and a netCDF file may be HDF5.
    CONTENTS = 1
    #: First bytes that no other format has. Before text, because the header of some of these is plain text.
    MARK = 2
    #: Readable text without a mark.
    TEXT = 3
    #: Nothing: the one reader of last resort, for what no other took.
    NOTHING = 4


@dataclass(frozen=True)
class Reader:
    """One reader, which a module of `roughcontact.io.readers` offers under the name `READER`.

    Attributes
    ----------
    told_by : ToldBy
        When it is asked.
    recognises : callable (path, head) -> bool
        Whether it reads this file. `head` are the first 4096 bytes, and for most formats all that is looked
        at. It is called for files of every format: so it imports nothing large before the mark agrees, and
        raises `InputFileError` only for a container that is damaged beyond recognition.
    read : callable (path) -> MeasuredFile
        Opens a file that it recognised. It raises `InputFileError` for one that is damaged, cut off or holds
        no map, and guesses nothing that the file does not say.
    """

    told_by: ToldBy
    recognises: Callable[[Path, bytes], bool]
    read: Callable[[Path], MeasuredFile]


def head_of(path: Path) -> bytes:
    """Return the first bytes of a file, by which most formats are told.

    Parameters
    ----------
    path : Path

    Returns
    -------
    bytes
    """
    with path.open("rb") as stream:
        return stream.read(HEAD_BYTES)
