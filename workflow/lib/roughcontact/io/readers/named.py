"""Formats that are recognised but not supported: rejected by name, with advice on conversion."""

from pathlib import Path
from typing import NoReturn

from roughcontact.errors import InputFileError
from roughcontact.io.interface import Reader, RecognisedBy, head_of
from roughcontact.io.text.lines import looks_like_text

_LINES = Path(__file__).with_name("refused.tsv").read_text(encoding="utf-8").splitlines()
# (first bytes, with escapes as Python's; whether they may begin a text; kind of file and advice)
_ROWS = [
    (mark.encode().decode("unicode_escape").encode("latin-1"), in_text == "yes", description)
    for mark, in_text, description in (line.split("\t") for line in _LINES if not line.startswith("#"))
]


def _description(head: bytes) -> str | None:
    """Return the kind of a file that begins so, and advice; None for another format."""
    binary = not looks_like_text(head)
    return next(
        (advice for mark, in_text, advice in _ROWS if head.startswith(mark) and (in_text or binary)), None
    )


def recognises(path: Path, head: bytes) -> bool:
    r"""Return whether a file begins as one of the formats that are refused by name.

    Examples
    --------
    >>> recognises(Path("map.sur"), b"DSCOMPRESSED\0\0"), recognises(Path("map.txt"), b"BZh is a name")
    (True, False)
    """
    return _description(head) is not None


def read(path: Path) -> NoReturn:
    """Refuse a file by the name of its format, and say how to convert it."""
    raise InputFileError(f"this is {_description(head_of(path))}")


READER = Reader(RecognisedBy.MARK, recognises, read)
