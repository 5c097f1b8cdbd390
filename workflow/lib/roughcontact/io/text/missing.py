"""Words that programs write in a text for a missing point; numbers are in `io.channels`."""

import re

from roughcontact.io.vocabulary import meanings

# Words that are taken as missing, in lower case.
_MARKERS = {
    "",  # empty cell
    *("nan", "inf", "+inf", "-inf", "infinity", "+infinity", "-infinity"),  # IEEE 754, as C, Java and Python
    *("nan(ind)", "-nan(ind)", "nan(snan)", "-nan(snan)"),  # C library of Windows, from 2015
    *("1.#ind", "-1.#ind", "1.#qnan", "-1.#qnan", "1.#snan", "-1.#snan", "1.#inf", "-1.#inf"),  # before 2015
    *("na", "<na>", "none", "null"),  # R; pandas; Python; JSON
    r"\n",  # NULL of MySQL and PostgreSQL
    *("#n/a", "n/a", "#null!", "#num!", "#div/0!", "#value!", "#ref!", "#name?"),  # Excel, in English
    *("#nv", "#zahl!", "#wert!", "#bezug!"),  # Excel, in German
    *("#nombre!", "#valeur!"),  # Excel, in French
    *("bad", "nodata"),  # Wyko Vision; Zygo MetroPro ("No Data") and Arc/Info
    *("void", "invalid"),  # exports of several programs, whose headers have no such words
}
_FILLING = "-*?"  # characters that stand for a missing point, repeated any number of times
_PHRASE = re.compile(
    r"(?<![^\s;,])(?:no data|not measured|out of range|n\. def\.|keine daten|nicht gemessen|non valide"
    r"|non mesuré|sin datos|non valido)(?=[\s;,]|$)",
    re.IGNORECASE,
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
    return cell.lower() in meanings("missing")


def joined(line: str) -> str:
    """Return a line in which the phrases for a missing point are one word each."""
    return _PHRASE.sub(lambda match: match[0].lower().replace(" ", ""), line) if " " in line else line
