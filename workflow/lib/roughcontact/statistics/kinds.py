"""What the numbers of each kind of problem tell of it: the kind, loads in words, the size of its maps."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from roughcontact.arguments.kinds import KIND_FACTS, PERIODIC_MAP, KindFacts
from roughcontact.arguments.quantities import Unit, pressure_unit, quantity
from roughcontact.arguments.variables import Numbers, has_number
from roughcontact.errors import SettingsError

_SAME_SIZE = 1e-6  # relative


def facts_of_numbers(numbers: Numbers) -> KindFacts:
    """Return the facts of the kind of problem of numbers, by those that only one kind has."""
    kinds = (facts for facts in KIND_FACTS if facts.own_numbers and has_number(numbers, facts.own_numbers[0]))
    return next(kinds, PERIODIC_MAP)


def reason_without_flow(numbers: Numbers) -> str:
    """Return why no fluid flows through the gap of these numbers, nothing where one may."""
    kind = facts_of_numbers(numbers)
    if not kind.has_flow:
        return kind.noun
    lengths = [float(numbers.get(f"window_length_{axis}", 0.0)) for axis in "xy"]
    return "a profile does not tell" if np.isnan(lengths).any() else ""


def unit_of_pressures(numbers: Numbers) -> Unit:
    """Return the unit of the pressures of a surface."""
    heaviest_load = float(np.max(np.nan_to_num(numbers.get("mean_pressure", 0.0))))
    return pressure_unit(float(numbers.get("contact_modulus", np.nan)), heaviest_load)


def load_in_words(pressure: float, numbers: Numbers) -> tuple[str, str]:
    """Return name and text of a mean pressure (Pa) as a load: of a body of finite size the force.

    NaN is that of first yield below the surface where no two of the loads, which rise, have it between them.
    """
    if np.isnan(pressure):
        yields = np.asarray(numbers["volume_above_yield"]).flat[0] > 0
        return "", f"{'below' if yields else 'above'} the loads solved"
    kind, mean = facts_of_numbers(numbers), np.asarray(numbers["mean_pressure"]).flat[0].item()
    load = pressure * np.asarray(numbers[kind.load]).flat[0].item() / mean
    unit = unit_of_pressures(numbers)
    return kind.load_in_words, unit.text(load) if kind.load_unit == "Pa" else quantity(load, kind.load_unit)


def check_sizes(label: str, datasets: Sequence[xr.Dataset]) -> None:
    """Reject bodies of finite size beside periodic maps, or on maps, or groups of maps, of other size."""
    sizes = [size_of_body(data) for data in datasets]
    if len({np.isfinite(size) for size in sizes}) > 1:
        raise SettingsError(
            f"{label}: a body of finite size and one without end, whose relative area and mean gap at a mean "
            "pressure are not the same numbers; give both the same contact.boundary"
        )
    if max(sizes) > min(sizes) * (1 + _SAME_SIZE):
        raise SettingsError(
            f"{label}: its maps differ in size, over which the mean pressure and the relative area of a body "
            "of finite size are taken, so that equal forces are other loads; cut them to one size"
        )


def size_of_body(data: xr.Dataset) -> float:
    """Return the size (m²) of the maps of a body of finite size; NaN for a periodic map."""
    kind = facts_of_numbers(data)
    if not kind.own_numbers:
        return float(data.attrs.get("body_size", np.nan))
    return float((data[kind.load] / data["mean_pressure"])[0])
