"""Length units: the spellings that files, tables and arguments may use, and their value in metres."""

import difflib
import unicodedata
from typing import TypeGuard

from roughcontact.errors import InputFileError

# Compared after compatibility normalisation (NFKC), which maps the micro sign U+00B5 to the Greek letter
# mu U+03BC and the angstrom sign U+212B to the letter U+00C5.
_SPELLINGS = {
    1e3: ("km", "kilometre", "kilometres", "kilometer", "kilometers"),
    1.0: ("m", "metre", "metres", "meter", "meters"),
    1e-1: ("dm", "decimetre", "decimetres", "decimeter", "decimeters"),
    1e-2: ("cm", "centimetre", "centimetres", "centimeter", "centimeters"),
    1e-3: ("mm", "millimetre", "millimetres", "millimeter", "millimeters"),
    1e-6: (
        *("um", "μm", "micron", "microns", "micrometre", "micrometres", "micrometer", "micrometers"),
        *("micro_meter", "micro metre", "micro meter"),
    ),
    1e-9: ("nm", "nanometre", "nanometres", "nanometer", "nanometers"),
    1e-10: ("Å", "angstrom", "angstroms", "angstroem", "ångström", "ångstrom"),
    1e-12: ("pm", "picometre", "picometres", "picometer", "picometers"),
    0.0254: ("in", "inch", "inches", '"'),
    2.54e-5: ("mil", "mils", "thou"),
    2.54e-8: ("uin", "μin", "microinch", "microinches"),
}
_METRES = {
    unicodedata.normalize("NFKC", name): value for value, names in _SPELLINGS.items() for name in names
}


def _clean(unit: object) -> str:
    """Return the spelling that is compared."""
    return unicodedata.normalize("NFKC", str(unit)).strip()


def _lookup(unit: object) -> float | None:
    """Return the value in metres, or None; symbols are case-sensitive, written-out words are not."""
    name = _clean(unit)
    if name in _METRES:
        return _METRES[name]
    return _METRES.get(name.lower()) if len(name) > 3 else None


def is_length(unit: object) -> TypeGuard[str]:
    """Return whether a text is one of the accepted spellings of a length unit.

    Parameters
    ----------
    unit : str or None

    Returns
    -------
    bool

    Examples
    --------
    >>> is_length("µm"), is_length("Microns"), is_length("V"), is_length(None)
    (True, True, False, False)
    """
    return unit is not None and _lookup(unit) is not None


def metres(unit: str, *, where: str = "unit", error: type[Exception] = InputFileError) -> float:
    """Return how many metres one `unit` is.

    Parameters
    ----------
    unit : str
        m, mm, um (or with the micro sign or the letter mu), nm, Å, pm, inch, mil, uin, ... and the words
        written out.
    where : str
        What the message shall name as the place of the unit.
    error : type
        What is raised for an unknown unit; the message names the nearest accepted spelling, if any is near.

    Returns
    -------
    float, m

    Raises
    ------
    InputFileError
        Or `error`: for an unknown unit.

    Examples
    --------
    >>> metres("nm"), metres("inch"), metres("micrometre")
    (1e-09, 0.0254, 1e-06)
    """
    factor = _lookup(unit)
    if factor is None:
        near = difflib.get_close_matches(_clean(unit).lower(), _METRES, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise error(
            f"{where}: unknown length unit {str(unit)!r}; {hint}accepted are m, mm, um, µm, nm, Å, pm, inch, "
            "mil, uin and the written-out words"
        )
    return factor
