"""What the numbers of each kind of problem are beside those of a periodic map, and which checks it has."""

from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.finite_body import recover_roughness
from roughcontact.arguments.kinds import FINITE_BODY, KIND_FACTS, PERIODIC_MAP, KindFacts, facts_of
from roughcontact.arguments.quantities import pressure_unit, quantity
from roughcontact.arguments.variables import Numbers
from roughcontact.statistics.finite_body import finite_body_columns, hertz_contact
from roughcontact.statistics.outcome import CheckName


class KindNumbers(NamedTuple):
    """What the numbers of a kind of problem are beside those of a periodic map, by default nothing."""

    roughness: Callable[[xr.DataArray], xr.DataArray] = lambda height: height  # without the form of the body
    smooth_contact: Callable[..., dict[str, float]] = lambda window, numbers, load: {}  # an ellipse
    of_load: Callable[..., dict[str, Any]] = lambda columns, contact, load: {}  # which differ, or are added
    omitted_checks: Collection[CheckName] = ()


_OF_KINDS: Mapping[str, KindNumbers] = {
    FINITE_BODY.name: KindNumbers(
        recover_roughness,
        hertz_contact,
        finite_body_columns,
        {  # of what a body whose form and edges are meant does not have
            *(CheckName.PERIODIC_WINDOW, CheckName.WINDOW, CheckName.LONGEST_WAVE, CheckName.SAMPLE),
            *(CheckName.LOAD_RANGE, CheckName.SLOPES, CheckName.STEEP_PLACES),
        },
    )
}


def numbers_of_kind(attrs: Mapping[str, Any]) -> KindNumbers:
    """Return what is of the kind of problem that the attributes of a map or a result name."""
    return _OF_KINDS.get(facts_of(attrs).name, KindNumbers())


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
