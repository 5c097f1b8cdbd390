"""What is stated of an instrument, and the arguments of the window where its map is corrected for it."""

import math
from collections.abc import Mapping
from typing import Any

import xarray as xr

from roughcontact.errors import SettingsError
from roughcontact.io.metadata import stored_instrument
from roughcontact.maps import spacing
from roughcontact.window.band import numerical_aperture
from roughcontact.window.transfer import CORRECTED

_STATED = "instrument_"  # beginning of the attributes of a map that hold what the table says


def window_arguments(levelled: xr.DataArray, settings: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return the arguments of `periodic_window` from the sections `window` and `instrument` (`correct`).

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> settings = {"window": {}, "instrument": {"correct": True, "resolution": 0.1}}
    >>> window_arguments(rough_reference_surface(64), settings)
    {'correct_for': {'resolution': 0.1}}
    """
    section = settings.get("instrument", {})
    if not section.get("correct"):
        return dict(settings["window"])
    name, stated = levelled.attrs.get("source_file") or "the map", stated_instrument(levelled, section)
    wrong = ""
    if "counter_face" in levelled.attrs:
        wrong = "is a pair of faces, each with an instrument of its own; leave it out for pairs"
    elif not any(stated.get(key) for key in CORRECTED):
        wrong = (
            "has nothing to be corrected for; state instrument.noise, instrument.resolution or "
            "instrument.numerical_aperture, or leave it out"
        )
    if wrong:
        raise SettingsError(f"instrument.correct = true: {name} {wrong}", keys=["instrument.correct"])
    check_instrument(levelled, stated)
    return {**settings["window"], "correct_for": stated}


def check_instrument(window: xr.DataArray, instrument: Mapping[str, Any]) -> None:
    """Refuse statements about an instrument that cannot be true of a map (y, x; m)."""
    sides = [(n * step, step) for n, step in zip(window.shape, spacing(window), strict=True) if n > 1]
    length, pixel = (max(values) for values in zip(*sides, strict=True))
    rms_height = float(window.std())
    for key, value in instrument.items():
        if key != "finer_spectrum" and value is not None and not value >= 0:
            raise SettingsError(f"instrument.{key} = {value:g}: give a number of 0 or more")
    for key, refused, reason in (
        ("tip_radius", lambda v: v > length, f"larger than the map ({length:.3g} m)"),
        ("resolution", lambda v: 0 < v < 2 * pixel, f"finer than two pixels of the map ({2 * pixel:.3g} m)"),
        ("noise", lambda v: v > rms_height, f"larger than the rms height of the map ({rms_height:.3g} m)"),
    ):
        value = instrument.get(key)
        if value is not None and refused(value):
            raise SettingsError(
                f"instrument.{key} = {value:g} m: {reason}; give it in m or with its unit (2 um)",
                keys=[f"instrument.{key}"],
            )


def stated_instrument(levelled: xr.DataArray, settings: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return what is known of the instrument: from the table of surfaces, then the settings, then the file.

    The table is in the attributes `instrument_{name}`; of the file's `instrument` (JSON) the numerical
    aperture counts.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64).assign_attrs(instrument_noise=1e-9)
    >>> stated_instrument(height, {"noise": 2e-9, "tip_radius": None})
    {'noise': 1e-09}
    """
    stated = dict(settings or {})
    if stated.get("noise") and "counter_face" in levelled.attrs:  # of the sum of two heights
        stated["noise"] *= math.sqrt(2)
    of_file = numerical_aperture(stored_instrument(levelled.attrs))
    optics = ("numerical_aperture", "resolution", "tip_radius")
    in_table = {str(key): value for key, value in levelled.attrs.items() if str(key).startswith(_STATED)}
    stated |= {key.removeprefix(_STATED): value for key, value in in_table.items()}
    if of_file and not any(stated.get(key) for key in optics):
        stated["numerical_aperture"] = of_file
    return {key: value for key, value in stated.items() if value is not None and key != "correct"}
