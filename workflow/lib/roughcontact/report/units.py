"""The units of the report: one for each quantity, in tables, figures and sentences.

They follow from material, roughness and window of a surface, of several of the one in the middle.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, GAP, PEAK
from roughcontact.arguments.quantities import Unit, height_unit, number, prefix, quantity
from roughcontact.arguments.units import printed
from roughcontact.arguments.variables import Numbers, has_number
from roughcontact.statistics.decisions import CLOSED
from roughcontact.statistics.kinds import facts_of_numbers, unit_of_pressures

# units that are the same on every page; a leak is by length of the seal
_FIXED = {
    "%": Unit(100.0, "%"),
    "1": Unit(1.0, ""),
    "K": Unit(1.0, "K"),
    "N": Unit(1.0, "N"),
    "m-1": Unit(1e-3, "mm⁻¹"),
    "m2": Unit(1e12, "µm²"),
    "J m-2": Unit(1.0, "J/m²"),
    "W m-2 K-1": Unit(1e-3, "kW/(m² K)"),
    "S m-2": Unit(1e-9, "GS/m²"),
    "m2 K W-1": Unit(1e6, "mm² K/W"),
    "Ohm m2": Unit(1e12, "µΩ mm²"),
    "m2 s-1": Unit(3.6e9, "ml/(h m)"),
    "m3 s-1": Unit(3.6e9, "ml/h"),
}
# of any size: unit that takes a prefix -> the numbers that choose it
_RESISTANCES = {
    "Ohm": ("total_electrical_resistance", "local_electrical_resistance"),
    "K W-1": ("total_thermal_resistance", "local_thermal_resistance"),
}
_ROUNDING = 1e-9
_GAPS = (GAP, "critical_constriction_x", "critical_constriction_y")


def unit_of(numbers: xr.Dataset | Mapping[str, float], unit: str, limit: float | None = None) -> Unit:
    """Return the unit in which numbers of a surface are shown, given their SI `unit`, whatever the number.

    `unit` is "m" for heights and gaps, "m along" for lengths along the surface and depths, "%" for shares. A
    resistance may be of any size: that of a `limit` has a prefix of its own.

    Examples
    --------
    >>> polished = xr.Dataset({"contact_modulus": 115e9, "rms_height": 2e-9})
    >>> [unit_of(polished, unit).symbol for unit in ("Pa", "m", "Pa m-1")]
    ['MPa', 'nm', 'MPa/µm']
    """
    if unit in _FIXED:
        return _FIXED[unit]
    # the variables without their coordinates are found in a hundredth of the time
    plain: Mapping[Any, Any] = numbers.variables if isinstance(numbers, xr.Dataset) else numbers
    if unit in _RESISTANCES:
        names = [name for name in _RESISTANCES[unit] if name in plain]
        resistances = [value for name in names for value in np.ravel(plain[name])]
        finite = [value for value in resistances if 0 < value < np.inf] or [1e-3]
        return Unit(*prefix(limit or float(np.median(finite)), printed(unit)))
    if unit in ("Pa", "Pa m-1"):
        pressure = unit_of_pressures(plain)
        return pressure if unit == "Pa" else Unit(pressure.factor * 1e-6, f"{pressure.symbol}/µm")
    if unit == "m along":
        # a profile has a length alone
        return length_unit(np.nanmax([float(plain.get(f"window_length_{axis}", 0.0)) for axis in "xy"]))
    if unit == "m":
        return height_unit(float(plain.get("rms_height", np.nan)))
    raise ValueError(f"no unit of the report is known for {unit}")


def common_pressure(results: Iterable[xr.Dataset]) -> Unit:
    """Return the unit of all pressures of several surfaces in one table or sentence: that of the stiffest.

    Examples
    --------
    >>> common_pressure([xr.Dataset({"contact_modulus": modulus}) for modulus in (5e6, 1e9)]).symbol
    'MPa'
    """
    units = (unit_of(data, "Pa") for data in results)
    return min(units, key=lambda unit: unit.factor, default=Unit(1e-6, "MPa"))


class Loads(NamedTuple):
    """The loads of a surface as the page shows them: their name, values in the unit of the axis, texts."""

    name: str
    values: np.ndarray
    axis: str  # name and unit
    texts: list[str]


def stated_loads(numbers: Numbers, pressure: Unit | None = None) -> Loads:
    """Return the loads of a surface: mean pressures, or the forces on a body of finite size.

    The unit of a `pressure` is that of the surface unless it is given.

    Examples
    --------
    >>> ball = {"force": [0.2, 1.0], "contact_radius": [1e-5, 2e-5], "mean_pressure": [1e6, 5e6]}
    >>> stated_loads(ball).texts, stated_loads({"mean_pressure": [1e6]}).axis
    (['200 mN', '1.00 N'], 'mean pressure (MPa)')
    """
    kind = facts_of_numbers(numbers)
    loads = np.asarray(numbers[kind.load], float)
    unit = pressure or unit_of(numbers, "Pa")
    unit = unit if kind.load_unit == "Pa" else Unit(*prefix(loads.max(), kind.load_unit))
    # forces of any size: each has a prefix of its own
    written = unit.text if kind.load_unit == "Pa" else partial(quantity, unit=kind.load_unit)
    texts = list(map(written, loads.tolist()))
    return Loads(kind.load_in_words, loads * unit.factor, f"{kind.load_in_words} ({unit.symbol})", texts)


def interval_at(numbers: Numbers, name: str, index: int) -> tuple[float, float, float]:
    """Return a number of a load and both ends of its interval (SI), NaN where it has none.

    Examples
    --------
    >>> interval_at({"mean_gap": [2e-6], "mean_gap_lower": [1e-6]}, "mean_gap", 0)
    (2e-06, 1e-06, nan)
    """
    value, lower, upper = (float(values[index]) for values in interval_values(numbers, name))
    return value, lower, upper


def interval_values(numbers: Numbers, name: str) -> list[np.ndarray]:
    """Return a quantity (load) and both ends of its interval (SI), NaN where it has none.

    A largest pressure that is the hardness has none of its own where the hardness is taken as exact.
    """
    keys = [name, f"{name}_lower", f"{name}_upper"]
    columns = numbers.variables if isinstance(numbers, xr.Dataset) else numbers  # ten times as fast as arrays
    available = {key: np.asarray(columns[key], float) for key in keys if key in columns}
    absent = np.full(next(iter(available.values()), np.array(np.nan)).shape, np.nan)
    value, *ends = (available.get(key, absent) for key in keys)
    if name == PEAK and "hardness" in numbers and "hardness_lower" not in numbers:
        limited, hardness = hardness_reached(numbers), float(numbers["hardness"])
        ends = [np.where(limited, np.nan, np.where(bound > hardness, hardness, bound)) for bound in ends]
    return [value, *ends]


def hardness_reached(numbers: Numbers) -> np.ndarray:
    """Return at which loads the largest pressure is the hardness.

    Examples
    --------
    >>> hardness_reached(xr.Dataset({"max_pressure": ("load", [2e8, 3e8]), "hardness": 3e8})).tolist()
    [False, True]
    """
    hardness = float(numbers.get("hardness", np.nan))
    return np.greater_equal(np.asarray(numbers[PEAK], float), hardness * (1 - _ROUNDING))


def largest_source(numbers: Numbers, name: str, index: int) -> str:
    """Return the source with the largest part in the interval of a quantity at a load; empty without one.

    Examples
    --------
    >>> widths = {"mean_gap_uncertainty": [[0.1, 0.3, 0.32]], "source": ["window", "hardness", "combined"]}
    >>> largest_source(widths, "mean_gap", 0)
    'hardness'
    """
    if name == PEAK and hardness_reached(numbers)[index]:
        return "hardness"
    if (key := f"{name}_uncertainty") not in numbers or "source" not in numbers:
        return ""
    widths = np.nan_to_num(np.asarray(numbers[key], float)[index][:-1], nan=-1.0)
    return str(np.asarray(numbers["source"])[widths.argmax()]) if widths.max(initial=0.0) > 0 else ""


def is_unbounded(numbers: xr.Dataset, name: str) -> bool:
    """Return whether nothing bounds a number upwards that has a lower end, at one load at least."""
    return bool((numbers[f"{name}_lower"].notnull() & numbers[f"{name}_upper"].isnull()).any())


def lacks_interval(numbers: Numbers, name: str) -> bool:
    """Return whether a number follows from others that have an interval, and has none itself."""
    derived = name.endswith(("conductance", "_resistance", "flash_temperature"))
    return derived and not has_number(numbers, f"{name}_lower") and has_number(numbers, f"{AREA}_lower")


def number_text(numbers: Numbers, name: str, unit: Unit, index: int) -> str:
    """Return a number of a load and its interval in a unit: with the same digits on page and screen.

    Examples
    --------
    >>> gap = {"mean_gap": [2e-6], "mean_gap_lower": [1.8e-6], "mean_gap_upper": [2.2e-6]}
    >>> number_text(gap, "mean_gap", Unit(1e6, "µm"), 0)
    '2.00 ± 0.20'
    """
    value, *ends = interval_at(numbers, name, index)
    if name == "contact_clusters":  # a whole number
        return f"{value:.0f}"
    if name in _GAPS and not (value >= CLOSED and ends[0] >= CLOSED):  # finer than atoms nothing is known
        ends = [0.0 if bound < CLOSED else bound for bound in ends]
        if 0 < value < CLOSED:
            interval = f" ({unit.ends(*ends).removesuffix(f' {unit.symbol}')})" if ends[1] > 0 else ""
            return f"< {number(CLOSED * unit.factor, digits=1)}{interval}"
    if lacks_interval(numbers, name):  # the digits that the contact area carries
        area, *area_ends = interval_at(numbers, AREA, index)
        return unit.interval(value, *(value * bound / area for bound in area_ends)).split()[0]
    return unit.interval(value, *ends)


def quantity_text(numbers: Numbers, name: str, unit: Unit, index: int) -> str:
    """Return a number of a load and its interval, as of `number_text`, with the unit.

    Examples
    --------
    >>> quantity_text({"mean_gap": [2e-6]}, "mean_gap", Unit(1e6, "µm"), 0)
    '2.00 µm'
    """
    return f"{number_text(numbers, name, unit, index)} {unit.symbol}".rstrip()


def length_unit(longest: float) -> Unit:
    """Return the unit of all lengths along a surface whose window has this longer side (m; 0: unknown).

    Examples
    --------
    >>> [length_unit(longest).symbol for longest in (5e-7, 9e-5, 4e-3, 12.5e-3, 20.0)]
    ['nm', 'µm', 'µm', 'mm', 'm']
    """
    if 0 < longest < 1e-6:
        return Unit(1e9, "nm")
    if longest < 1e-2:
        return Unit(1e6, "µm")
    return Unit(1e3, "mm") if longest < 10 else Unit(1.0, "m")


def median_numbers(results: Sequence[xr.Dataset]) -> dict[str, float]:
    """Return the medians over several surfaces of the numbers that units depend on, for `unit_of`.

    Examples
    --------
    >>> median_numbers([xr.Dataset({"rms_height": rms}) for rms in (1e-8, 1e-6, 2e-6)])
    {'rms_height': 1e-06}
    """
    names = ["contact_modulus", "rms_height", *(name for key in _RESISTANCES.values() for name in key)]
    available = [name for name in names if all(name in result for result in results)]
    return {name: float(np.median([np.median(result[name]) for result in results])) for name in available}
