"""The words of a command line: numbers and the units behind them."""

from collections.abc import Sequence
from pathlib import Path

from roughcontact.arguments.units import is_unit


def with_units(words: Sequence[str]) -> list[str]:
    """Return the words after an option with units joined to the bare numbers before them.

    Examples
    --------
    >>> with_units(["ground.x3p", "--mean-pressure", "1", "5", "MPa", "--threads", "2"])
    ['ground.x3p', '--mean-pressure', '1 MPa', '5 MPa', '--threads', '2']
    """
    joined: list[str] = []
    after_option = False
    for word in words:
        after_option = after_option or word.startswith("--")
        if not (after_option and joined and _is_number(joined[-1]) and is_unit(word)) or Path(word).exists():
            joined.append(word)
            continue
        for index in range(len(joined) - 1, -1, -1):
            if not _is_number(joined[index]):
                break
            joined[index] += f" {word}"
    return joined


def _is_number(word: str) -> bool:
    """Return whether a word is a bare number."""
    try:
        float(word)
    except ValueError:
        return False
    return word[:1] in "+-.0123456789"
