"""Instrument files recognised by their first bytes, read through SurfaceTopography.

To add one that the library reads, add a row to `roughcontact.io.instruments.formats`.
"""

from pathlib import Path

from roughcontact.io.channels import MeasuredFile
from roughcontact.io.instruments.formats import marked
from roughcontact.io.instruments.library import BYTES_PER_BYTE, read_as
from roughcontact.io.interface import Reader, RecognisedBy, head_of
from roughcontact.io.text.lines import is_text


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins with the mark of an instrument's format."""
    matching = [format_ for format_ in marked(head) if format_.recognised_by is RecognisedBy.MARK]
    return bool(matching) and not (matching[0].binary_data and is_text(path))


def read(path: Path) -> MeasuredFile:
    """Open a file by the first of the formats with its mark that can read it."""
    return read_as(path, marked(head_of(path)))


READER = Reader(RecognisedBy.MARK, recognises, read, memory_per_byte=BYTES_PER_BYTE, binary=True)
