"""Measurement noise from two measurements of the same place (ISO 25178-700:2022)."""

import math

import numpy as np
import xarray as xr

from roughcontact.errors import HeightMapError
from roughcontact.levelling.level import level
from roughcontact.maps import spacing

_LEAST_CORRELATION = 0.5  # of the heights of both maps; another place gives about 0, noise of Sq gives 0.5


def noise_of_repeats(first: xr.DataArray, second: xr.DataArray) -> float:
    """Return the measurement noise N_M (m, rms) from the difference of two maps of the same place.

    Both are levelled by a plane; the difference has twice the variance of the noise of one.

    Raises
    ------
    HeightMapError
        for maps of another size or pitch, and of places that do not look alike.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> surface, noise = rough_reference_surface(64), np.random.default_rng(0).standard_normal((2, 64, 64))
    >>> f"{noise_of_repeats(*(surface + 1e-3 * each for each in noise)):.4f}"
    '0.0010'
    """
    names = [each.attrs.get("source_file") or "a map" for each in (first, second)]
    steps = [spacing(each) for each in (first, second)]
    if first.shape != second.shape or not np.allclose(steps[0], steps[1], rtol=1e-6, atol=0):
        sizes = [f"{each.shape[1]} x {each.shape[0]} points" for each in (first, second)]
        raise HeightMapError(
            f"repeat_of: {names[0]} ({sizes[0]}) and {names[1]} ({sizes[1]}) differ in size "
            "or pitch; a repeat is the same place measured again with the same settings"
        )
    heights = [level(each, fill="none", outlier_threshold=None).values for each in (first, second)]
    known = np.isfinite(heights[0]) & np.isfinite(heights[1])
    one, other = (each[known] - each[known].mean() for each in heights)
    correlation = float(one @ other) / math.sqrt(float(one @ one) * float(other @ other) or 1.0)
    if not correlation >= _LEAST_CORRELATION:
        raise HeightMapError(
            f"repeat_of: {names[0]} and {names[1]} do not show the same place (correlation "
            f"{correlation:.2f}); measure again without moving the part, or leave repeat_of empty"
        )
    return float(np.std(one - other) / math.sqrt(2))
