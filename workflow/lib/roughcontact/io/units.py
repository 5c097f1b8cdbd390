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
    """Return how many metres one `unit` (m, um, Å, inch, mil, uin ...) is; unknown: an `error`."""
    factor = value_of(unit, "m")
    if factor is None:
        raise error(f"{where}: {unknown_unit(unit, 'm')}")
    return factor


def same_length(unit: str, second: str) -> bool:
    """Return whether two spellings stand for the same unit of length, or are the same text.

    Examples
    --------
    >>> same_length("um", "micrometre"), same_length("um", "mm"), same_length("lines", "lines")
    (True, False, True)
    """
    value = value_of(unit, "m")
    return unit == second or (value is not None and value == value_of(second, "m"))
