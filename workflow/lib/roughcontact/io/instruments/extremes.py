"""Lowest and highest height that some instrument files state beside their heights.

A height beyond them was changed after they were written, or is damaged. Heights that stay within tell
nothing: some programs state the range of the instrument.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from roughcontact.io.units import metres
from roughcontact.quantities import number

Header = Mapping[str, Any]
_ROUNDING = 1e-5  # of the stated numbers, which have six digits in some headers


def _digital_surf(header: Header, unit: str) -> tuple[float, float]:
    """Return the range of the stored integers, times their step."""
    step = header["height_scale_factor"] * (-1 if header["inversion"] in (1, 2, 3) else 1)
    low, high = sorted((header["zmin"] * step, header["zmax"] * step))
    return low, high


def _wsxm(header: Header, unit: str) -> tuple[float, float] | None:
    """Return the range of a map of real numbers, which the header has in the unit of the heights."""
    if header["General Info"].get("Image Data Type") not in ("float", "double"):
        return None
    said = header["Miscellaneous"]
    return float(said["Minimum"]), float(said["Maximum"])


def _bcr(header: Header, unit: str) -> tuple[float, float] | None:
    """Return the lowest height of a map of real numbers."""
    if not str(header["fileformat"]).startswith("bcrf") or "zmin" not in header:
        return None
    return float(header["zmin"]) * metres(header.get("zunit", "nm")) / metres(unit), np.inf


_EXTREMES: dict[str, Callable[[Header, str], tuple[float, float] | None]] = {
    "bcr": _bcr,
    "sur": _digital_surf,
    "wsxm": _wsxm,
}


def beyond_stated(name: str, header: Header, heights: np.ndarray, unit: str) -> list[str]:
    """Return a warning where heights lie beyond the extremes that the file states.

    Parameters
    ----------
    name : str
        Of the format, in SurfaceTopography.
    header : mapping
        As SurfaceTopography gives it with the channel.
    heights : array (ny, nx)
        In `unit`; NaN where not measured.
    unit : str

    Returns
    -------
    list of str
    """
    find = _EXTREMES.get(name)
    if find is None or not np.isfinite(heights).any():
        return []
    try:
        stated = find(header, unit)
    except (KeyError, ValueError, TypeError):  # not in this file
        return []
    if stated is None or not stated[0] < stated[1]:
        return []
    low, high = stated
    slack = _ROUNDING * max(abs(end) for end in stated if np.isfinite(end))
    beyond = np.count_nonzero((heights < low - slack) | (heights > high + slack))
    if not beyond:
        return []
    points = f"{beyond} points lie" if beyond > 1 else "1 point lies"
    limits = f"from {number(low)} to {number(high)}" if np.isfinite(high) else f"from {number(low)}"
    return [
        (
            f"{points} beyond the heights that the file states ({limits} {unit}): it was changed after that "
            "was written, or is damaged"
        )
    ]
