"""Length units: the spellings that files, tables and arguments may use, and their value in metres."""

from typing import TypeGuard

from roughcontact.errors import InputFileError
from roughcontact.units import unknown_unit, value_of


def is_length(unit: object) -> TypeGuard[str]:
    """Return whether a text is one of the accepted spellings of a length unit.

    Examples
    --------
    >>> is_length("µm"), is_length("Microns"), is_length("V"), is_length(None)
    (True, True, False, False)
    """
    return unit is not None and value_of(unit, "m") is not None


def metres(unit: str, *, where: str = "unit", error: type[Exception] = InputFileError) -> float:
    """Return how many metres one `unit` is.

    Units are m, mm, um (or with the micro sign or the letter mu), nm, Å, pm, inch, mil, uin, ... and their
    names written out. An unknown one raises `error`; the message names the place, `where`, and the nearest
    accepted spelling, if any is near.

    Examples
    --------
    >>> metres("nm"), metres("inch"), metres("micrometre")
    (1e-09, 0.0254, 1e-06)
    """
    factor = value_of(unit, "m")
    if factor is None:
        raise error(f"{where}: {unknown_unit(unit, 'm')}")
    return factor


def same_length(unit: str, second: str) -> bool:
    """Return whether two spellings stand for the same unit of length.

    Two texts that are no units of length are the same where they are spelled alike.

    Examples
    --------
    >>> same_length("um", "micrometre"), same_length("um", "mm"), same_length("lines", "lines")
    (True, False, True)
    """
    value = value_of(unit, "m")
    return unit == second or (value is not None and value == value_of(second, "m"))
