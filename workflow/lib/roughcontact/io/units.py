"""Length units: the spellings that files, tables and arguments may use, and their value in metres."""

from typing import TypeGuard

from roughcontact.arguments.units import unit_factor, unknown_unit
from roughcontact.errors import InputFileError


def is_length(unit: object) -> TypeGuard[str]:
    """Return whether a text is one of the accepted spellings of a length unit.

    Examples
    --------
    >>> is_length("µm"), is_length("Microns"), is_length("V"), is_length(None)
    (True, True, False, False)
    """
    return unit is not None and unit_factor(unit, "m") is not None


def metres(unit: str, *, where: str = "unit", error: type[Exception] = InputFileError) -> float:
    """Return how many metres one `unit` (m, um, Å, inch, mil, uin ...) is; unknown: an `error`."""
    factor = unit_factor(unit, "m")
    if factor is None:
        raise error(f"{where}: {unknown_unit(unit, 'm')}")
    return factor


def same_length(unit: str, reference: str) -> bool:
    """Return whether two spellings stand for the same unit of length, or are the same text.

    Examples
    --------
    >>> same_length("um", "micrometre"), same_length("um", "mm"), same_length("lines", "lines")
    (True, False, True)
    """
    value = unit_factor(unit, "m")
    return unit == reference or (value is not None and value == unit_factor(reference, "m"))
