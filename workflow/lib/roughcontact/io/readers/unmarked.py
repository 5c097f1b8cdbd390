"""Instrument files without a mark, recognised only by trying to read them; the last reader asked."""

from pathlib import Path

from roughcontact.io.channels import MeasuredFile
from roughcontact.io.instruments.formats import FORMATS, marked
from roughcontact.io.instruments.library import BYTES_PER_BYTE, read_as
from roughcontact.io.interface import Reader, RecognisedBy, head_of


def recognises(path: Path, head: bytes) -> bool:
    """Return True: all files that no other reader recognised are tried."""
    return True


def read(path: Path) -> MeasuredFile:
    """Open a file by the first of the formats without a mark whose header agrees with it."""
    # a container too damaged to be examined has a mark nevertheless
    formats = marked(head_of(path)) or [format_ for format_ in FORMATS if not format_.marks]
    return read_as(path, formats)


READER = Reader(RecognisedBy.NOTHING, recognises, read, memory_per_byte=BYTES_PER_BYTE, binary=True)
