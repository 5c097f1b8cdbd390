"""What is stated of an instrument, and the arguments of the window where its map is corrected for it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import xarray as xr

from roughcontact.arguments.kinds import facts_of, number_of_faces, properties_of_map
from roughcontact.arguments.maps import side_lengths, spacing
from roughcontact.arguments.measurement import Instrument, json_attribute
from roughcontact.arguments.quantities import quantity
from roughcontact.errors import SettingsError
from roughcontact.surface.window.band import lateral_period_limit, numerical_aperture
from roughcontact.surface.window.transfer import CORRECTED, noise_that_remains

OF_ONE_FACE = "instrument_of_one_face"  # attribute of a pair: what is stated of one of its faces alone


def window_arguments(height: xr.DataArray, settings: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return the arguments of `periodic_window` from the sections `window` and `instrument` (`correct`).

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> settings = {"window": {}, "instrument": {"correct": True, "resolution": 0.1}}
    >>> window_arguments(rough_reference_surface(64), settings)
    {'correct_for': {'resolution': 0.1}}
    """
    section = settings.get("instrument", {})
    if not section.get("correct"):
        return dict(settings["window"])
    name, instrument = height.attrs.get("source_file") or "the map", stated_instrument(height, section)
    wrong = facts_of(height.attrs).reason_against("instrument.correct", properties_of_map(height.attrs))
    if not wrong and not any(instrument.get(key) for key in CORRECTED):
        wrong = (
            "has nothing to be corrected for; state instrument.noise, instrument.resolution or "
            "instrument.numerical_aperture, or leave it out"
        )
    if wrong:
        raise SettingsError(f"instrument.correct = true: {name} {wrong}", keys=["instrument.correct"])
    check_instrument(height, instrument)
    return {**settings["window"], "correct_for": instrument}


def check_instrument(window: xr.DataArray, instrument: Mapping[str, Any]) -> None:
    """Refuse statements about an instrument that cannot be true of a map (y, x; m)."""
    length, pixel = max(side_lengths(window)), max(spacing(window))
    rms_height = float(window.std()) if instrument.get("noise") else 0.0
    for key, value in instrument.items():
        if value is not None and not value >= 0:
            raise SettingsError(f"instrument.{key} = {value:g}: give a number of 0 or more")
    tip_radius, resolution, noise = (
        instrument.get(key) or 0.0 for key in ("tip_radius", "resolution", "noise")
    )
    # in the band of the window less noise remains than is stated of single points
    is_noisy = noise > 0 and noise_that_remains(window, noise)[0] > rms_height
    for key, is_excluded, reason in (
        ("tip_radius", tip_radius > length, f"larger than the map ({quantity(length, 'm')})"),
        (
            "resolution",
            0 < resolution < 2 * pixel,
            f"finer than two pixels of the map ({quantity(2 * pixel, 'm')})",
        ),
        ("noise", is_noisy, f"larger than the rms height of the map ({quantity(rms_height, 'm')})"),
    ):
        if is_excluded:
            raise SettingsError(
                f"instrument.{key} = {quantity(instrument[key], 'm')}: {reason}; correct the number or its "
                "unit (a number alone is in m), or leave it out",
                keys=[f"instrument.{key}"],
            )


def stated_instrument(height: xr.DataArray, settings: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return what is known of the instrument: from the table of surfaces, then the settings, then the file.

    The table is in the attributes `instrument_{name}`. The numerical aperture in the metadata of a file
    counts where its map is to be corrected for it, not in the ±: without metadata it would be narrower.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64).assign_attrs(instrument_noise=1e-9)
    >>> stated_instrument(height, {"noise": 2e-9, "tip_radius": None})
    {'noise': 1e-09}
    """
    values, of_map = dict(settings or {}), Instrument.read(height.attrs)
    of_face = Instrument(**{entry.name: values.get(entry.name) for entry in fields(Instrument)})
    of_pair = instrument_of_sum([of_map, of_face]).properties()
    if values.get("noise"):  # the heights of a pair are a sum
        values["noise"] *= math.sqrt(number_of_faces(height.attrs))
    of_file = numerical_aperture(json_attribute(height.attrs, "instrument"))
    values |= of_map.properties()
    # of the other face the settings are
    values |= {name: of_pair.get(name) for name in height.attrs.get(OF_ONE_FACE, "").split()}
    counts = values.get("correct") and of_file
    # the lens of the file counts only where nobody states another limit
    if counts and not any(values.get(key) for key in ("numerical_aperture", "resolution", "tip_radius")):
        values["numerical_aperture"] = of_file
    return {key: value for key, value in values.items() if value is not None and key != "correct"}


def instrument_of_sum(instruments: Sequence[Instrument]) -> Instrument:
    """Return what is stated of the instruments of two faces for their sum, which shows what both show."""

    def stated(name: str) -> list[float]:
        return [value for instrument in instruments if (value := getattr(instrument, name)) is not None]

    largest = ("resolution", "tip_radius", "amplification_z", "amplification_xy", "lateral_period_limit")
    lenses = [instrument for instrument in instruments if instrument.numerical_aperture]
    coarsest = max(lenses, key=_period_limit, default=Instrument())
    return Instrument(
        # independent noises add in squares
        noise=math.hypot(*stated("noise")) if stated("noise") else None,
        numerical_aperture=coarsest.numerical_aperture,
        wavelength=coarsest.wavelength,
        **{name: max(stated(name), default=None) for name in largest},
    )


def _period_limit(instrument: Instrument) -> float:
    """Return the wavelength (m) of which the lens of an instrument passes half."""
    return lateral_period_limit(instrument.numerical_aperture or math.inf, instrument.wavelength)
