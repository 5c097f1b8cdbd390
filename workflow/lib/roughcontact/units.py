"""Accepted units of lengths, pressures and other quantities, and numbers that carry their unit.

Symbols are compared after normalisation (NFKC: micro sign to mu, angstrom sign, superscripts to digits); the
base units are the keys of `_TABLES`.
"""

import difflib
import re
import unicodedata
from collections.abc import Mapping

_LENGTHS = {
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
_POUND_PER_SQUARE_INCH = 0.45359237 * 9.80665 / 0.0254**2
# mPa is left out: it is a millipascal, and mostly a misspelt MPa
_PRESSURES = {
    1.0: ("Pa", "pascal", "N/m2"),
    1e2: ("hPa", "mbar"),
    1e3: ("kPa", "kilopascal", "kN/m2"),
    1e4: ("N/cm2",),
    1e5: ("bar",),
    1e6: ("MPa", "megapascal", "N/mm2", "MN/m2"),
    1e9: ("GPa", "gigapascal", "kN/mm2", "GN/m2"),
    1e12: ("TPa", "terapascal"),
    9.80665e4: ("kgf/cm2",),
    9.80665e6: ("kgf/mm2",),
    _POUND_PER_SQUARE_INCH: ("psi",),
    1e3 * _POUND_PER_SQUARE_INCH: ("ksi",),
    1e6 * _POUND_PER_SQUARE_INCH: ("Msi",),
}
_ANGLES = {1.0: ("degree", "degrees", "deg", "°"), 57.29577951308232: ("rad", "radian", "radians")}
_CONDUCTIVITIES = {1.0: ("W m-1 K-1", "W/(m K)", "W/(m·K)", "W/mK", "W/m/K")}
_RESISTIVITIES = {
    1.0: ("Ohm m", "Ω m", "Ωm"),
    1e-2: ("Ohm cm", "Ω cm", "Ωcm"),
    1e-6: ("uOhm m", "μΩ m", "Ohm mm2/m", "Ω mm2/m"),
    1e-8: ("uOhm cm", "μΩ cm"),
    1e-9: ("nOhm m", "nΩ m"),
}
_WORKS = {1.0: ("J m-2", "J/m2", "N/m"), 1e-3: ("mJ/m2", "mN/m", "erg/cm2")}
_FORCES = {1e-3: ("mN",), 1.0: ("N", "newton"), 1e3: ("kN",), 1e6: ("MN",), 9.80665: ("kgf",)}
_AREAS = {
    factor**2: tuple(f"{name}2" for name in names if name.isalpha() and not name.endswith("s"))
    for factor, names in _LENGTHS.items()
    if factor >= 1e-9
}
_VISCOSITIES = {1.0: ("Pa s", "Pa·s"), 1e-3: ("mPa s", "mPa·s", "cP"), 0.1: ("P",)}
_SPEEDS = {1.0: ("m/s", "m s-1"), 1e-3: ("mm/s",), 1e-6: ("um/s", "μm/s"), 1 / 3.6: ("km/h",)}
_DIFFUSIVITIES = {1.0: ("m2/s", "m2 s-1"), 1e-6: ("mm2/s",)}


def _by_name(spellings: Mapping[float, tuple[str, ...]]) -> dict[str, float]:
    """Return the value of each spelling."""
    return {
        unicodedata.normalize("NFKC", name): value for value, names in spellings.items() for name in names
    }


_TABLES = {
    "m": _by_name(_LENGTHS),
    "Pa": _by_name(_PRESSURES),
    "degree": _by_name(_ANGLES),
    "W m-1 K-1": _by_name(_CONDUCTIVITIES),
    "Ohm m": _by_name(_RESISTIVITIES),
    "Pa s": _by_name(_VISCOSITIES),
    "J m-2": _by_name(_WORKS),
    "N": _by_name(_FORCES),
    "m2": _by_name(_AREAS),
    "m s-1": _by_name(_SPEEDS),
    "m2 s-1": _by_name(_DIFFUSIVITIES),
}
# spellings offered in a message
_USUAL = {
    "m": "m, mm, um, µm, nm, Å, pm, inch, mil, uin and the written-out words",
    "Pa": "Pa, kPa, MPa, GPa, N/mm2, bar, psi",
    "degree": "deg, °, rad",
    "W m-1 K-1": "W/(m K)",
    "Ohm m": "Ohm m, Ohm cm, uOhm cm",
    "Pa s": "Pa s, mPa s, cP",
    "J m-2": "J/m2, mJ/m2",
    "N": "mN, N, kN, MN, kgf",
    "m2": "m2, cm2, mm2, um2, nm2",
    "m s-1": "m/s, mm/s, um/s",
    "m2 s-1": "m2/s, mm2/s",
}
_QUANTITY_NAMES = {
    "m": "length",
    "Pa": "pressure",
    "degree": "angle",
    "W m-1 K-1": "conductivity",
    "Ohm m": "resistivity",
    "Pa s": "viscosity",
    "J m-2": "work of adhesion",
    "N": "force",
    "m2": "area",
    "m s-1": "speed",
    "m2 s-1": "diffusivity",
}
_NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*)", re.DOTALL)


def value_of(unit: object, base: str) -> float | None:
    """Return a unit (symbol, case-sensitive, or word) in its base unit, as a factor; None for any other.

    Examples
    --------
    >>> value_of("nm", "m"), value_of("N/mm²", "Pa"), value_of("V", "m")
    (1e-09, 1000000.0, None)
    """
    table, name = _TABLES[base], _clean(unit)
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
    names = {name.lower(): name for name in reversed(_TABLES[base])}
    close_matches = difflib.get_close_matches(_clean(unit).lower(), names, n=1)
    hint = f"did you mean {names[close_matches[0]]!r}? " if close_matches else ""
    return f"unknown {_QUANTITY_NAMES[base]} unit {str(unit)!r}; {hint}accepted are {_USUAL[base]}"


def carries_unit(value: object) -> bool:
    """Return whether a value is a number followed by a unit, as in ``"115 GPa"``; False for a bare number."""
    return isinstance(value, str) and not _is_number(value) and bool(_NUMBER_AND_UNIT.fullmatch(value))


def in_base_unit(value: object, base: str) -> object:
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
