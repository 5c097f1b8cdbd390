"""Ranges of properties: the ends of 95 % intervals, as shares of a value below and above it."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from roughcontact.arguments.units import BASES, carries_unit, convert_to_base_unit

Shares = Sequence[float]  # of the value: one both below and above, or one below and one above
# properties that may be a range, whose shares are in `{property}_uncertainty`
OF_BODIES = ("youngs_modulus", "hardness", "thermal_conductivity", "electrical_resistivity")
_RANGED = {*OF_BODIES, "contact_modulus", "shear_strength"}
TO = ".."  # between both ends, where a range is text
_DIGITS = 6  # of a share


def name_of_range(name: str) -> str:
    """Return the key of the range of a property."""
    return f"{name}_uncertainty"


def shares_of_range(value: float, lowest: float, highest: float) -> list[float]:
    """Return how far a range reaches below and above a value.

    Examples
    --------
    >>> shares_of_range(1.4e9, 1.1e9, 1.8e9)
    [0.214286, 0.285714]
    """
    return [round(1 - lowest / value, _DIGITS), round(highest / value - 1, _DIGITS)]


def ends(value: float, shares: float | Shares | None) -> tuple[float, float]:
    """Return the lowest and the highest value of a property; of one without a range itself twice.

    Examples
    --------
    >>> ends(2.0, 0.25), ends(2.0, [0.25, 1.0]), ends(2.0, None)
    ((1.5, 2.5), (1.5, 4.0), (2.0, 2.0))
    """
    sides = [shares or 0.0] if shares is None or isinstance(shares, int | float) else list(shares)
    return value * (1 - sides[0]), value * (1 + sides[-1])  # one share is that of both sides


def weighted(values: Sequence[float], ranges: Sequence[float | Shares | None]) -> tuple[float, float, float]:
    """Return a sum of independent values and its ends: their distances add in quadrature.

    Examples
    --------
    >>> weighted([3.0, 4.0], [1 / 3, 0.0])
    (7.0, 6.0, 8.0)
    """
    # without rounding in the order of summation
    total = math.fsum(values)
    bounds = [ends(value, shares) for value, shares in zip(values, ranges, strict=True)]
    below, above = (
        math.hypot(*(bound - value for value, bound in zip(values, side, strict=True)))
        for side in zip(*bounds, strict=True)
    )
    return total, total - below, total + above


def with_shares(section: Any, names: Iterable[str]) -> Any:
    """Return settings of a section whose ranges, [LOW, HIGH] or LOW..HIGH, are the middle and its shares.

    `names` are the keys of the section. What is no range stays for others to refuse.

    Examples
    --------
    >>> with_shares({"hardness": "1.1..1.7 GPa"}, ["hardness"])
    {'hardness': 1400000000.0, 'hardness_uncertainty': [0.214286, 0.214286]}
    """
    if not isinstance(section, Mapping):
        return section
    full = dict(section)
    for name in _RANGED & {*names} & full.keys():
        # one number, or a list of loads, is no range
        if (pair := both_ends(full[name])) is None:
            continue
        if full.get(name_of_range(name)) is not None:
            raise ValueError(f"{name} is a range, and {name_of_range(name)} is given too; give one of them")
        try:
            low, high = sorted(float(convert_to_base_unit(end, BASES[name])) for end in pair)
        except (TypeError, ValueError):
            continue  # the check of the setting itself names it
        if not 0 < low < high < math.inf:
            continue
        middle = (low + high) / 2
        full |= {name: middle, name_of_range(name): shares_of_range(middle, low, high)}
    return full


def both_ends(value: Any) -> list[Any] | None:
    """Return the ends of a range; the lower one has the unit of the upper one where it states none.

    Examples
    --------
    >>> both_ends("1.1..1.7 GPa"), both_ends("1.1 GPa")
    (['1.1 GPa', '1.7 GPa'], None)
    """
    if isinstance(value, str):
        low, dots, high = (part.strip() for part in value.partition(TO))
        if not dots:
            return None
        # 2..3 GPa: the unit behind both
        unit = high.lstrip("+-.0123456789eE ") if carries_unit(high) and not carries_unit(low) else ""
        return [f"{low} {unit}".strip(), high]
    return list(value) if isinstance(value, list | tuple) and len(value) == 2 else None
