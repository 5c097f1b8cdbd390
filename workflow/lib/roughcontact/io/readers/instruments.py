"""Instrument files recognised by their first bytes, read through SurfaceTopography.

To add one that the library reads, add a row to `io/formats.tsv`.
"""

from pathlib import Path

from roughcontact.io.instruments.library import instrument_reader, marked
from roughcontact.io.interface import RecognisedBy
from roughcontact.io.text.lines import is_text


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins with the mark of an instrument's format."""
    # of HDF5 the contents decide
    matching = [format_ for format_ in marked(head) if format_.name != "datx"]
    return bool(matching) and not (matching[0].text == "binary" and is_text(path))


READER = instrument_reader(RecognisedBy.MARK, recognises)
