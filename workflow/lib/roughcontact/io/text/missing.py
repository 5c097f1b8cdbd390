"""Words that programs write in a text for a missing point; numbers are in `io.channels`."""

import re

from roughcontact.io.vocabulary import meanings, words

_MARKERS = {"", *meanings("marker")}  # an empty cell too
# taken as missing, with a warning: they may have another meaning
_SPOKEN = set(words("missing")["spoken"])
_FILLING = "-*?"  # characters that stand for a missing point, repeated any number of times
_PHRASE = re.compile(
    rf"(?<![^\s;,])(?:{'|'.join(map(re.escape, words('missing')['phrase']))})(?=[\s;,]|$)", re.IGNORECASE
)


def is_missing(cell: str) -> bool:
    """Return whether a cell without blanks around it stands for a missing point.

    Examples
    --------
    >>> [is_missing(word) for word in ("NaN", "***", "Ungültig", "1.5", "trace")]
    [True, True, True, False, False]
    """
    return cell.lower() in _MARKERS or is_spoken(cell) or not cell.strip(_FILLING)


def is_spoken(cell: str) -> bool:
    """Return whether a cell is a word that may have another meaning beside that of a missing point."""
    return cell.lower() in _SPOKEN


def joined(line: str) -> str:
    """Return a line in which the phrases for a missing point are one word each."""
    return _PHRASE.sub(lambda match: match[0].lower().replace(" ", ""), line) if " " in line else line
