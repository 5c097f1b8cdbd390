"""Formats that are recognised but not supported: rejected by name, with advice on conversion."""

from pathlib import Path
from typing import NoReturn

from roughcontact.errors import InputFileError
from roughcontact.io.interface import Reader, RecognisedBy, read_head
from roughcontact.io.text.lines import looks_like_text
from roughcontact.io.vocabulary import marks, rows_of

# (first bytes, whether they may begin a text, kind of file and advice)
_ROWS = [(marks(mark), in_text == "yes", advice) for mark, in_text, advice in rows_of("refused.tsv")]


def _description(head: bytes) -> str | None:
    """Return the kind of a file that begins so, and advice; None for another format."""
    binary = not looks_like_text(head)
    matching = (advice for mark, in_text, advice in _ROWS if head.startswith(mark) and (in_text or binary))
    return next(matching, None)


def recognises(path: Path, head: bytes) -> bool:
    r"""Return whether a file begins as one of the formats that are refused by name.

    Examples
    --------
    >>> recognises(Path("map.png"), b"GIF89a\0\0"), recognises(Path("map.txt"), b"BZh is a name")
    (True, False)
    """
    return _description(head) is not None


def read(path: Path) -> NoReturn:
    """Refuse a file by the name of its format, and say how to convert it."""
    raise InputFileError(f"this is {_description(read_head(path))}")


READER = Reader(RecognisedBy.MARK, recognises, read)
