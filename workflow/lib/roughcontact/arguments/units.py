"""Accepted units of lengths, pressures and other quantities, and numbers that carry their unit.

Symbols are compared after normalisation (NFKC: micro sign to mu, angstrom sign, superscripts to digits); the
spellings of each base unit are in `units.tsv`.
"""

import difflib
import re
import unicodedata
from functools import cache
from typing import Any

from roughcontact.arguments.rows import rows_beside

# base unit -> what it is of, the arguments that may be text with a unit, the spellings offered in a message
_KINDS = {base: kind for base, *kind in rows_beside(__file__, "bases.tsv")}
BASES = {name: base for base, (_, names, _) in _KINDS.items() for name in names.split()}
_RAISED = str.maketrans("23", "²³")
_SIGNS = {"Ohm": "Ω"}  # of units whose symbol is none of Latin letters
_NUMBER = r"([+-]?(?>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?))"  # no digit of it is left for a unit
_ZEROS = {"K": 273.15, **dict.fromkeys(("°C", "degC", "deg C", "C"), 0.0)}  # of °C
_NUMBER_AND_UNIT = re.compile(rf"\s*{_NUMBER}\s*([^\s_].*)", re.DOTALL)


@cache
def spellings(base: str) -> dict[str, float]:
    """Return the value in a base unit of each spelling in `units.tsv`."""
    # µ has two code points, which NFKC makes one
    return {
        unicodedata.normalize("NFKC", name): float(value)
        for of_base, value, *names in rows_beside(__file__, "units.tsv")
        for name in names
        if of_base == base
    }


def printed(base: str) -> str:
    """Return a base unit as it is printed, with a fraction and raised exponents.

    Examples
    --------
    >>> [printed(base) for base in ("m3 s-1", "W m-1 K-1", "Ohm m2", "Pa-1", "Pa s", "")]
    ['m³/s', 'W/(m K)', 'Ω m²', '1/Pa', 'Pa s', '']
    """
    above, below = list[str](), list[str]()
    for name, sign, power in re.findall(r"([A-Za-z]+)(-?)(\d*)", base):
        symbol = _SIGNS.get(name, name)
        (below if sign else above).append(symbol + power.replace("1", "").translate(_RAISED))
    divisor = " ".join(below) if len(below) < 2 else f"({' '.join(below)})"
    return f"{' '.join(above) or 1}/{divisor}" if below else " ".join(above)


def unit_factor(unit: object, base: str) -> float | None:
    """Return a unit (symbol, case-sensitive, or word) in its base unit, as a factor; None for any other.

    Examples
    --------
    >>> unit_factor("nm", "m"), unit_factor("N/mm²", "Pa"), unit_factor("V", "m"), unit_factor("MBAR", "Pa")
    (1e-09, 1000000.0, None, None)
    """
    table, name = spellings(base), _clean(unit)
    if base == "m":  # "[um]", and "µm." at the end of a phrase
        name = name.strip("[]().")
    if name in table:
        return table[name]
    candidates = _spellings_like(name, base)
    # capitals may differ in words, never in symbols: mPa and MPa
    return table.get(name.lower()) if len(name) > 3 and len(candidates) == 1 else None


def is_unit(word: str) -> bool:
    """Return whether a word is a unit of one of the quantities, as it is spelt.

    Examples
    --------
    >>> is_unit("bar"), is_unit("N/mm²"), is_unit("steel"), is_unit("A")
    (True, True, False, False)
    """
    return any(_clean(word) in spellings(base) for base in _KINDS)


@cache
def _spellings_like(name: str, base: str) -> dict[float, str]:
    """Return the values of a unit, in any capitals, with a spelling of each: megabar and millibar differ."""
    table = reversed(spellings(base).items())
    return {value: spelling for spelling, value in table if spelling.lower() == name.lower()}


def unknown_unit(unit: object, base: str) -> str:
    """Return the error message for an unknown unit: with the nearest valid spelling and the usual ones.

    Examples
    --------
    >>> unknown_unit("Mpa", "Pa")
    "unknown pressure unit 'Mpa'; did you mean 'MPa'? accepted are Pa, kPa, MPa, GPa, N/mm2, bar, psi"
    """
    names = [name.lower() for name in spellings(base)]
    close_matches = difflib.get_close_matches(_clean(unit).lower(), names, n=1)
    # all capitals of the nearest word, since they may be different units
    suggestions = [repr(name) for match in close_matches for name in _spellings_like(match, base).values()]
    hint = f"did you mean {' or '.join(suggestions)}? " if suggestions else ""
    quantity, _, usual = _KINDS[base]
    return f"unknown {quantity} unit {str(unit)!r}; {hint}accepted are {usual}"


def carries_unit(value: object) -> bool:
    """Return whether a value is a number followed by a unit, as in ``"115 GPa"``; False for a bare number."""
    # a number alone is in the base unit
    return isinstance(value, str) and bool(_NUMBER_AND_UNIT.fullmatch(value))


def convert_to_base_unit(value: Any, base: str) -> Any:
    """Return a number that carries its unit as one in the base unit, and anything else as it is."""
    match = _NUMBER_AND_UNIT.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return value
    number, unit = float(match[1]), match[2]
    if unit.startswith(","):
        raise ValueError("write a decimal point, not a comma")
    if (factor := unit_factor(unit, base)) is None:
        raise ValueError(unknown_unit(unit, base))
    inverse = round(1 / factor)
    # by a division where that is exact: 2.5e-06 for 2.5 µm, not 2.4999999999999998e-06
    return number / inverse if inverse > 1 and 1 / inverse == factor else number * factor


def celsius(value: Any) -> float:
    """Return a temperature with its scale ("293 K", "20 °C") in °C, a bare number as it is.

    Examples
    --------
    >>> celsius("20 °C"), round(celsius("293.15 K"), 9), celsius(293.15)
    (20.0, 20.0, 293.15)
    """
    number = _NUMBER_AND_UNIT.fullmatch(value) if isinstance(value, str) else None
    if number is None:
        return float(value)
    scale = _clean(number[2])
    if scale not in _ZEROS:
        raise ValueError(f"unknown temperature scale {scale!r}; accepted are °C and K")
    return float(number[1]) - _ZEROS[scale]


def lengths_in_text(text: str, count: int, rule: str) -> list[float]:
    """Return so many numbers that blanks separate and one unit follows, in m.

    Raises
    ------
    ValueError
        If the unit is none of length; for another text with the `rule` of what it must be.

    Examples
    --------
    >>> lengths_in_text("300 250 um", 2, "must be two lengths")
    [0.0003, 0.00025]
    """
    numbers = r"\s+".join([_NUMBER] * count)
    if (form := re.fullmatch(rf"{numbers}\s*([^\d\s.,;+-][^\s;]*)", text)) is None:
        has_comma = re.search(r"\d,\d", text)
        raise ValueError(
            "write a decimal point, not a comma, and blanks between the numbers" if has_comma else rule
        )
    *values, unit = form.groups()
    return [float(convert_to_base_unit(f"{value} {unit}", "m")) for value in values]


def _clean(unit: object) -> str:
    """Return the normalised spelling, for comparison."""
    name = unicodedata.normalize("NFKC", str(unit)).strip()
    # a quotient may be spelt m s^-1 or m/s
    return name.replace("^", "").replace(" / ", "/") if "/" in name else name
