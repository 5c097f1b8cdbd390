"""What the verbs ask of a height map and of their options before they begin."""

import difflib

import numpy as np
import xarray as xr

from roughcontact.errors import HeightMapError, SettingsError


def check_map(height: xr.DataArray) -> np.ndarray:
    """Return the heights as float64, NaN where not finite, or say why they are no height map.

    Raises
    ------
    HeightMapError
        wrong dimensions, fewer than two points, or nothing measured.
    """
    name = height.attrs.get("source_file") or "the map"
    if height.dims != ("y", "x"):
        raise HeightMapError(f"{name} has the dimensions {height.dims}: transpose it to ('y', 'x')")
    if height.size < 2:
        raise HeightMapError(
            f"{name} has {height.size} point: at least two are needed; check how the file was cut or read"
        )
    values = np.asarray(height.values, dtype=float)
    values = np.where(np.isfinite(values), values, np.nan)
    if np.isnan(values).all():
        raise HeightMapError(
            f"all {values.size} points of {name} are missing: choose another channel, or measure again"
        )
    return values


def check_choice(key, value, choices):
    """Raise SettingsError, with the nearest valid word, where `value` is not among `choices`."""
    if value in choices:
        return
    near = difflib.get_close_matches(str(value), choices, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    raise SettingsError(f"{key} = {value!r}: {hint}choose one of {', '.join(choices)}")
