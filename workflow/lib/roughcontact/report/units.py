"""The units of a surface's part of the report: one for each quantity, in tables, figures and sentences."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from roughcontact.quantities import Unit, height_unit, pressure_unit

# what has the same unit on every page; a leak is by length of the seal
_FIXED = {
    "%": Unit(100.0, "%"),
    "1": Unit(1.0, ""),
    "m-1": Unit(1.0, "m⁻¹"),
    "m2": Unit(1e12, "µm²"),
    "J m-2": Unit(1e3, "mJ/m²"),
    "W m-2 K-1": Unit(1e-3, "kW/(m² K)"),
    "S m-2": Unit(1e-6, "MS/m²"),
    "m2 s-1": Unit(3.6e9, "ml/(h m)"),
    "m along": Unit(1e6, "µm"),
}


def unit_of(numbers: xr.Dataset | Mapping[str, float], unit: str) -> Unit:
    """Return in what the numbers of a surface are shown that are of a unit.

    It depends on the surface and its material alone, not on the numbers: a quantity has the same unit
    everywhere on the page, and on the pages of other surfaces of the kind.

    Parameters
    ----------
    numbers : Dataset or mapping
        statistics of the surface, with its contact modulus and its rms height; MPa and µm without.
    unit : str
        "m" for heights and gaps, "m along" for lengths along the surface and into the depth, "%" for a share;
        else an SI unit.

    Returns
    -------
    Unit

    Examples
    --------
    >>> polished = xr.Dataset({"contact_modulus": 115e9, "rms_height": 2e-9})
    >>> [unit_of(polished, unit).shown for unit in ("Pa", "m", "Pa m-1")]
    ['MPa', 'nm', 'MPa/nm']
    """
    if unit in _FIXED:
        return _FIXED[unit]
    pressure = pressure_unit(float(numbers.get("contact_modulus", np.nan)))
    if unit == "Pa":
        return pressure
    height = height_unit(float(numbers.get("rms_height", np.nan)))
    if unit == "m":
        return height
    if unit == "Pa m-1":
        return Unit(pressure.factor / height.factor, f"{pressure.shown}/{height.shown}")
    raise ValueError(f"no unit of the report is known for {unit}")


def middle_of(results: Sequence[xr.Dataset]) -> dict[str, float]:
    """Return the medians over several surfaces of what their units depend on.

    Parameters
    ----------
    results : sequence of Dataset
        statistics of the surfaces.

    Returns
    -------
    dict
        what `unit_of` takes in place of a single surface.

    Examples
    --------
    >>> middle_of([xr.Dataset({"rms_height": rms}) for rms in (1e-8, 1e-6, 2e-6)])
    {'rms_height': 1e-06}
    """
    known = (name for name in ("contact_modulus", "rms_height") if all(name in one for one in results))
    return {name: float(np.median([float(one[name]) for one in results])) for name in known}
