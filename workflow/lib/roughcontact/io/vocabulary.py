"""The tables of this folder: words of files in several languages, and first bytes of formats."""

import re
from functools import cache

from roughcontact.arguments.rows import rows_beside


def rows_of(name: str) -> list[list[str]]:
    """Return the rows of a table of this folder, without its comments."""
    return rows_beside(__file__, name)


def marks(listed: str) -> tuple[bytes, ...]:
    r"""Return first bytes of files from a cell of a table, separated by blanks, with escapes as Python's.

    Examples
    --------
    >>> marks(r"II*\x00 KPK0")
    (b'II*\x00', b'KPK0')
    """
    texts = (mark.encode().decode("unicode_escape") for mark in listed.split(" ") if mark)
    return tuple(text.encode("latin-1") for text in texts)


@cache
def words(used_in: str) -> dict[str, list[str]]:
    """Return words by meaning in a `header`, a `column` or the like, of all languages; ``""``: of any."""
    phrases_by_meaning: dict[str, list[str]] = {}
    for user, meaning, _, phrases in rows_of("words.tsv"):
        if used_in in ("", user):
            phrases_by_meaning.setdefault(meaning, []).extend(phrases.split(", "))
    return phrases_by_meaning


def pattern(used_in: str, *meanings: str) -> re.Pattern[str]:
    """Return the pattern that takes any of the words of some meanings, of all without one, in any case."""
    phrases = (phrase for meaning in meanings or words(used_in) for phrase in words(used_in)[meaning])
    return re.compile("|".join(phrases), re.IGNORECASE)


@cache
def meanings(used_in: str) -> dict[str, str]:
    """Return the meaning of each word."""
    return {word: meaning for meaning, phrases in words(used_in).items() for word in phrases}
