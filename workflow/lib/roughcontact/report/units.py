"""The units of the report: one for each quantity, in tables, figures and sentences.

They follow from material, roughness and window of a surface, of several of the one in the middle.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.quantities import Unit, height_unit, pressure_unit
from roughcontact.variables import Numbers

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
    "K W-1": Unit(1.0, "K/W"),
    "Ohm": Unit(1e3, "mΩ"),
    "Ohm m2": Unit(1e12, "µΩ mm²"),
    "m2 s-1": Unit(3.6e9, "ml/(h m)"),
}


def unit_of(numbers: xr.Dataset | Mapping[str, float], unit: str) -> Unit:
    """Return the unit in which numbers of a surface are shown, given their SI `unit`, whatever the number.

    `unit` is "m" for heights and gaps, "m along" for lengths along the surface and depths, "%" for shares.

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
    pressure = pressure_unit(float(plain.get("contact_modulus", np.nan)))
    if unit == "Pa":
        return pressure
    if unit == "Pa m-1":
        return Unit(pressure.factor * 1e-6, f"{pressure.symbol}/µm")
    if unit == "m along":
        # a profile has a length alone
        return length_unit(np.nanmax([float(plain.get(f"window_length_{axis}", 0.0)) for axis in "xy"]))
    if unit == "m":
        return height_unit(float(plain.get("rms_height", np.nan)))
    raise ValueError(f"no unit of the report is known for {unit}")


def interval_at(numbers: Numbers, name: str, index: int) -> tuple[float, float, float]:
    """Return a number of a load and both ends of its interval (SI), NaN where it has none.

    Examples
    --------
    >>> interval_at({"mean_gap": [2e-6], "mean_gap_lower": [1e-6]}, "mean_gap", 0)
    (2e-06, 1e-06, nan)
    """
    value, lower, upper = (float(values[index]) for values in interval_of(numbers, name))
    return value, lower, upper


def interval_of(numbers: Numbers, name: str) -> list[np.ndarray]:
    """Return a quantity (load) and both ends of its interval (SI), NaN where it has none."""
    keys = [name, f"{name}_lower", f"{name}_upper"]
    available = {key: np.asarray(numbers[key], float) for key in keys if key in numbers}
    absent = np.full(next(iter(available.values()), np.array(np.nan)).shape, np.nan)
    return [available.get(key, absent) for key in keys]


def length_unit(longest: float) -> Unit:
    """Return the unit of all lengths along a surface whose window has this longer side (m; 0: unknown).

    Examples
    --------
    >>> [length_unit(longest).symbol for longest in (5e-7, 9e-5, 4e-3, 12.5e-3, 20.0)]
    ['nm', 'µm', 'µm', 'mm', 'm']
    """
    if 0 < longest < 1e-6:
        return Unit(1e9, "nm")
    if longest >= 1e-2:
        return Unit(1e3, "mm") if longest < 10 else Unit(1.0, "m")
    return Unit(1e6, "µm")


def middle_of(results: Sequence[xr.Dataset]) -> dict[str, float]:
    """Return the medians over several surfaces of the numbers that units depend on, for `unit_of`.

    Examples
    --------
    >>> middle_of([xr.Dataset({"rms_height": rms}) for rms in (1e-8, 1e-6, 2e-6)])
    {'rms_height': 1e-06}
    """
    available = (
        name for name in ("contact_modulus", "rms_height") if all(name in result for result in results)
    )
    return {name: float(np.median([float(result[name]) for result in results])) for name in available}
