"""Lines of text files: recognition of text, and its encoding."""

import re
import unicodedata
from itertools import chain
from pathlib import Path

from roughcontact.arguments.units import spellings
from roughcontact.errors import InputFileError
from roughcontact.io.guards import refusing
from roughcontact.io.vocabulary import words

_BYTE_ORDER_MARKS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}
_MAX_BYTES = 2**30  # bytes
_PLAIN_SIGNS = dict(zip("−：＝　（）［］，；", "-:= ()[],;", strict=True))
_TYPOGRAPHY = re.compile(f"[{''.join(_PLAIN_SIGNS)}]")
_MICRO = re.compile(r"\$\\mu\$|&micro;")  # of TeX and HTML
_TEXT_BYTES = bytes([*b"\t\n\r\f", *range(32, 127), *range(128, 256)])
_DOS_END = b"\x1a"  # behind the last line of old programs
# in which programs wrote before UTF-8; the first that makes the most of the words that headers use is taken
_CODES = ("latin-1", "cp1250", "cp1251", "gb18030", "cp932", "cp949", "cp437")
_MAX_HEAD = 2**16  # bytes that decide on the encoding


def looks_like_text(head: bytes) -> bool:
    """Return whether the first bytes of a file are text (UTF-8, UTF-16 with its mark, or an 8-bit code).

    Examples
    --------
    >>> looks_like_text("Width: 10 µm".encode()), looks_like_text(bytes(range(16)))
    (True, False)
    """
    has_code = head.startswith(tuple(_BYTE_ORDER_MARKS)) or _unmarked_utf16(head)
    return bool(has_code or (head and not head.removesuffix(_DOS_END).translate(None, _TEXT_BYTES)))


def is_text(path: Path) -> bool:
    """Return whether a file is text to its end, not only at its beginning."""
    with path.open("rb") as stream:
        blocks = iter(lambda: stream.read(2**20), b"")
        return all(not block.removesuffix(_DOS_END).translate(None, _TEXT_BYTES) for block in blocks)


def _unmarked_utf16(head: bytes) -> str | None:
    """Return the encoding of UTF-16 text without a byte order mark, if it is mostly ASCII; else None."""
    for code, high in (("utf-16-le", head[1::2]), ("utf-16-be", head[::2])):
        if len(head) >= 16 and high.count(0) > 0.9 * len(high):
            text = head[: len(head) // 2 * 2].decode(code, "replace")
            return code if all(sign.isprintable() or sign in "\t\n\r\f" for sign in text) else None
    return None


def read_text(path: Path) -> str:
    """Return the text of a file, with plain signs."""
    return plain(_decode(path.read_bytes()).removesuffix(_DOS_END.decode()))


def plain(text: str) -> str:
    """Return a text with plain signs for those of typography and East Asian keyboards."""
    # a translation of the text takes ten times as long
    return _MICRO.sub("µ", _TYPOGRAPHY.sub(lambda sign: _PLAIN_SIGNS[sign[0]], text))


def _decode(data: bytes) -> str:
    """Return the text by its byte order mark, else as UTF-8, else in the code that makes words of it."""
    if len(data) > _MAX_BYTES:
        raise InputFileError(f"{len(data)} bytes of text; convert the map to X3P, SDF or netCDF")
    for mark, encoding in _BYTE_ORDER_MARKS.items():
        if data.startswith(mark):
            with refusing(f"damaged {encoding} text"):
                return data.decode(encoding)
    if (code := _unmarked_utf16(data[:4096])) and len(data) % 2 == 0:
        return data.decode(code, "replace")
    if b"\0" in data:
        raise InputFileError("starts as text but goes on as binary data; this format is not known")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        head = data[:_MAX_HEAD]
        return data.decode(max(_CODES, key=lambda code: _letters(head.decode(code, "replace"))), "replace")


def _letters(text: str) -> int:
    """Return how many letters of a text make words or units of headers that ASCII lacks."""
    eastern = {word for word in _WORDS if word[0] > "\u2e7f" and word[1:] and word in text}
    return sum(map(len, eastern | (_foreign_words(text) & _WORDS)))


def _foreign_words(text: str) -> set[str]:
    """Return the words of a text, in lower case, that are not ASCII."""
    words_in_text = re.findall(r"[^\W\d_]+", unicodedata.normalize("NFKC", text).lower())
    return {word for word in words_in_text if not word.isascii()}


_WORDS = _foreign_words(" ".join(chain(spellings("m"), *words("").values())))
