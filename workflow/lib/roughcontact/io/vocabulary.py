"""Words that files in several languages use for sizes, columns, instruments and missing points."""

from functools import cache
from pathlib import Path


@cache
def words(used_in: str) -> dict[str, list[str]]:
    """Return the words of each meaning in a `header`, a `column` or the like, as `words.tsv` lists them."""
    text = Path(__file__).with_name("words.tsv").read_text(encoding="utf-8")
    rows = (line.split("\t") for line in text.splitlines() if not line.startswith("#"))
    return {meaning: listed.split(", ") for user, meaning, listed in rows if user == used_in}


@cache
def meanings(used_in: str) -> dict[str, str]:
    """Return the meaning of each word."""
    return {word: meaning for meaning, listed in words(used_in).items() for word in listed}
