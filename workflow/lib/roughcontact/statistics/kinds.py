"""What the numbers of each kind of problem are beside those of a periodic map, and which checks it has."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.kinds import FINITE_BODY, KIND_FACTS, PERIODIC_MAP, KindFacts, facts_of
from roughcontact.arguments.quantities import pressure_unit, quantity
from roughcontact.arguments.variables import Numbers
from roughcontact.statistics.finite_body import finite_body_columns, hertz_contact
from roughcontact.statistics.outcome import CheckName

# checks of what a body whose form and edges are meant does not have
OMITTED_CHECKS: Mapping[str, set[CheckName]] = {
    FINITE_BODY.name: {
        *(CheckName.PERIODIC_WINDOW, CheckName.WINDOW, CheckName.LONGEST_WAVE, CheckName.SAMPLE),
        *(CheckName.LOAD_RANGE, CheckName.SLOPES, CheckName.STEEP_PLACES),
    }
}
# (columns, contact, load) -> the numbers of that load which differ, or are added
_NUMBERS: Mapping[str, Callable[..., dict[str, Any]]] = {FINITE_BODY.name: finite_body_columns}


# (window, numbers, load) -> the ellipse in which smooth bodies of this kind would touch
_SMOOTH: Mapping[str, Callable[..., dict[str, float]]] = {FINITE_BODY.name: hertz_contact}


def facts_of_numbers(numbers: Numbers) -> KindFacts:
    """Return the facts of the kind of problem of numbers, by those that only one kind has."""
    return next(
        (
            facts
            for facts in KIND_FACTS
            for name in facts.own_numbers[:1]
            if name in numbers  # looked for first, as in `decisions`
            if np.isfinite(np.asarray(numbers[name], float)).any()
        ),
        PERIODIC_MAP,
    )


def reason_without_flow(numbers: Numbers) -> str:
    """Return why no fluid flows through the gap of these numbers, nothing where one may."""
    kind = facts_of_numbers(numbers)
    if not kind.has_flow:
        return kind.noun
    lengths = [float(numbers.get(f"window_length_{axis}", 0.0)) for axis in "xy"]
    return "a profile does not tell" if np.isnan(lengths).any() else ""


def load_in_words(pressure: float, numbers: Numbers) -> tuple[str, str]:
    """Return name and text of a mean pressure (Pa) as a load: of a body of finite size the force.

    NaN is that of first yield below the surface where no two of the loads, which rise, have it between them.
    """
    if np.isnan(pressure):
        yields = np.asarray(numbers["volume_above_yield"]).flat[0] > 0
        return "", f"{'below' if yields else 'above'} the loads solved"
    kind, mean = facts_of_numbers(numbers), np.asarray(numbers["mean_pressure"]).flat[0].item()
    load = pressure * np.asarray(numbers[kind.load]).flat[0].item() / mean
    unit = pressure_unit(float(numbers["contact_modulus"]))
    return kind.load_in_words, unit.text(load) if kind.load_unit == "Pa" else quantity(load, kind.load_unit)


def smooth_contact(window: xr.DataArray, numbers: xr.Dataset, load: int) -> dict[str, float]:
    """Return the ellipse in which the bodies would touch without their roughness: mostly nothing."""
    name = facts_of(window.attrs).name
    return _SMOOTH[name](window, numbers, load) if name in _SMOOTH else {}


def numbers_of_kind(columns: Mapping[str, Any], contact: xr.Dataset, load: int) -> dict[str, Any]:
    """Return the numbers of one load in which a contact differs from that of a periodic map: mostly none."""
    name = facts_of(contact.attrs).name
    return _NUMBERS[name](columns, contact, load) if name in _NUMBERS else {}
