"""What the verbs ask of a height map and of their options before they begin."""

import difflib
from typing import Any, get_args

import numpy as np
import xarray as xr

from roughcontact.errors import HeightMapError, SettingsError


def check_map(height: xr.DataArray) -> np.ndarray:
    """Return the heights as float64, NaN where not finite, or say why they are no height map.

    Parameters
    ----------
    height : DataArray (y, x), m
        the attribute `source_file` names it in the message.

    Returns
    -------
    array (ny, nx), m
        a copy.

    Raises
    ------
    HeightMapError
        wrong dimensions, fewer than two points, or nothing measured.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.maps import height_map
    >>> check_map(height_map([[1, np.inf, 3]], 1e-6))
    array([[ 1., nan,  3.]])
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


def check_choice(key: str, value: object, choices: Any) -> None:
    """Raise an error, with the nearest valid word, where a value is not among the choices.

    Parameters
    ----------
    key : str
        what the setting or argument is called.
    value : object
        what was given.
    choices : Literal type
        the valid words, one of `roughcontact.choices`.

    Raises
    ------
    SettingsError
        where `value` is none of them.

    Examples
    --------
    >>> from roughcontact.choices import Fill
    >>> check_choice("fill", "harmonic", Fill)
    >>> check_choice("fill", "harmonics", Fill)
    Traceback (most recent call last):
    ...
    roughcontact.errors.SettingsError: fill = 'harmonics': did you mean 'harmonic'? choose harmonic or none
    """
    words = get_args(choices)
    if value in words:
        return
    near = difflib.get_close_matches(str(value), words, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    valid = " or ".join(", ".join(words).rsplit(", ", 1))
    raise SettingsError(f"{key} = {value!r}: {hint}choose {valid}", keys=[key])


def check_positive(name: str, value: Any, *, unit: str) -> float:
    """Return a value as a float where it is a finite positive number.

    Parameters
    ----------
    name : str
        what the setting or argument is called.
    value : number or text
        what was given.
    unit : str
        in which it is meant.

    Returns
    -------
    float
        the number.

    Raises
    ------
    SettingsError
        where it is no number, infinite, NaN, zero or negative.

    Examples
    --------
    >>> check_positive("contact_modulus", "1e9", unit="Pa")
    1000000000.0
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise SettingsError(
            f"{name} = {value!r} is not a number; give a positive number in {unit}", keys=[name]
        ) from None
    if not (np.isfinite(number) and number > 0):
        raise SettingsError(f"{name} = {number:g} must be a positive finite number in {unit}", keys=[name])
    return number
