"""Accepted units of lengths, pressures and other quantities, and numbers that carry their unit.

Symbols are compared after normalisation (NFKC: micro sign to mu, angstrom sign, superscripts to digits); the
spellings of each base unit are in `units.tsv`.
"""

import difflib
import re
import unicodedata
from functools import cache
from pathlib import Path
from typing import Any

# base unit: what it is of, and the spellings offered in a message
_QUANTITIES = {
    "m": ("length", "m, mm, um, µm, nm, Å, pm, inch, mil, uin and the written-out words"),
    "Pa": ("pressure", "Pa, kPa, MPa, GPa, N/mm2, bar, psi"),
    "degree": ("angle", "deg, °, rad"),
    "W m-1 K-1": ("conductivity", "W/(m K)"),
    "Ohm m": ("resistivity", "Ohm m, Ohm cm, uOhm cm"),
    "Pa s": ("viscosity", "Pa s, mPa s, cP"),
    "J m-2": ("work of adhesion", "J/m2, mJ/m2"),
    "N": ("force", "nN, µN, mN, N, kN, MN, kgf"),
    "m2": ("area", "m2, cm2, mm2, um2, nm2"),
    "m s-1": ("speed", "m/s, mm/s, um/s"),
    "m2 s-1": ("diffusivity", "m2/s, mm2/s"),
}
_NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*)", re.DOTALL)


@cache
def _spellings(base: str) -> dict[str, float]:
    """Return the value in a base unit of each spelling in `units.tsv`."""
    text = Path(__file__).with_name("units.tsv").read_text(encoding="utf-8")
    rows = [line.split("\t") for line in text.splitlines() if line.startswith(f"{base}\t")]
    return {unicodedata.normalize("NFKC", name): float(value) for _, value, *names in rows for name in names}


def value_of(unit: object, base: str) -> float | None:
    """Return a unit (symbol, case-sensitive, or word) in its base unit, as a factor; None for any other.

    Examples
    --------
    >>> value_of("nm", "m"), value_of("N/mm²", "Pa"), value_of("V", "m")
    (1e-09, 1000000.0, None)
    """
    table, name = _spellings(base), _clean(unit)
    if name in table:
        return table[name]
    return table.get(name.lower()) if len(name) > 3 else None


def unknown_unit(unit: object, base: str) -> str:
    """Return the error message for an unknown unit: with the nearest valid spelling and the usual ones.

    Examples
    --------
    >>> unknown_unit("Mpa", "Pa")
    "unknown pressure unit 'Mpa'; did you mean 'MPa'? accepted are Pa, kPa, MPa, GPa, N/mm2, bar, psi"
    """
    names = {name.lower(): name for name in reversed(_spellings(base))}
    close_matches = difflib.get_close_matches(_clean(unit).lower(), names, n=1)
    hint = f"did you mean {names[close_matches[0]]!r}? " if close_matches else ""
    quantity, usual = _QUANTITIES[base]
    return f"unknown {quantity} unit {str(unit)!r}; {hint}accepted are {usual}"


def carries_unit(value: object) -> bool:
    """Return whether a value is a number followed by a unit, as in ``"115 GPa"``; False for a bare number."""
    return isinstance(value, str) and not _is_number(value) and bool(_NUMBER_AND_UNIT.fullmatch(value))


def in_base_unit(value: Any, base: str) -> Any:
    """Return a number that carries its unit as one in the base unit, and anything else as it is."""
    if not isinstance(value, str) or _is_number(value):
        return value
    number_and_unit = _NUMBER_AND_UNIT.fullmatch(value)
    if number_and_unit is None:
        return value
    if number_and_unit[2].startswith(","):
        raise ValueError("write a decimal point, not a comma")
    factor = value_of(number_and_unit[2], base)
    if factor is None:
        raise ValueError(unknown_unit(number_and_unit[2], base))
    # by a division where that is exact: 2.5e-06 for 2.5 µm, not 2.4999999999999998e-06
    inverse = round(1 / factor) if factor < 1 else 0
    return (
        float(number_and_unit[1]) / inverse
        if inverse and 1 / inverse == factor
        else float(number_and_unit[1]) * factor
    )


def _clean(unit: object) -> str:
    """Return the normalised spelling, for comparison."""
    name = unicodedata.normalize("NFKC", str(unit)).strip()
    return name.replace("^", "").replace(" / ", "/") if "/" in name else name


def _is_number(text: str) -> bool:
    """Return whether a text is a number without a unit."""
    try:
        float(text)
    except ValueError:
        return False
    return True
