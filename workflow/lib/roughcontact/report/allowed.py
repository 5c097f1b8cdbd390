"""Whether what is allowed holds, in words, with the load from which on it does."""

from typing import NamedTuple

import numpy as np

from roughcontact.arguments.answers import ALLOWED_VALUES, AREA, ENDS, TOTALS, UNITS
from roughcontact.arguments.quantities import quantity, range_in_words
from roughcontact.arguments.variables import Numbers
from roughcontact.report.units import quantity_text, unit_of
from roughcontact.statistics.allowed import compared_ends
from roughcontact.statistics.decisions import is_lifted, lifting_pressure
from roughcontact.statistics.kinds import load_in_words

HOLDS, FAILS, NOT_DECIDED = "holds", "does not hold", "not decided"
HOLDING = {1.0: HOLDS, 0.0: FAILS}  # the word of `{name}_holds`; of NaN it is not decided
# the outcome in whose colour each stands
DECISIONS = {HOLDS: "passed", FAILS: "failed", NOT_DECIDED: "review"}


class Sentence(NamedTuple):
    """A sentence of an answer; as text its parts are joined."""

    subject: str
    decision: str = ""  # a key of `DECISIONS`; empty where nothing is decided
    detail: str = ""

    def __str__(self) -> str:
        return "".join(self)

    def continued(self, opening: str) -> "Sentence":
        """Return the sentence after an opening that it goes on from."""
        return self._replace(subject=f"{opening}, {self.subject[0].lower()}{self.subject[1:]}")


def stated_allowed(numbers: Numbers, answer: str = "") -> list[str]:
    """Return the names of the allowed values of numbers, of one of the answers alone."""
    names = [name for name, allowed in ALLOWED_VALUES.items() if answer in ("", allowed.answer)]
    return [name for name in names if f"{name}_holds" in numbers]


def allowed_in_words(numbers: Numbers, name: str, index: int, *, brief: bool = False) -> Sentence:
    """Return whether an allowed value holds at a load, and from which one on; `brief`, without that.

    Examples
    --------
    >>> bounds = {"leak_holds_from": 1.8e6, "leak_holds_from_lower": 1.2e6, "leak_holds_from_upper": 3.4e6}
    >>> numbers = {"contact_modulus": 1e9, "mean_pressure": [1e6], "allowed_leak": 3e-10}
    >>> str(allowed_in_words(numbers | bounds | {"leak_holds": [np.nan]}, "leak", 0))
    'leak of at most 1.08 ml/h: not decided, would be from 1.80 MPa on (1.20 MPa to 3.40 MPa)'
    """
    allowed, holds = ALLOWED_VALUES[name], float(numbers[f"{name}_holds"][index])
    total, limit = _total_in_words(numbers, name, index), limit_in_words(numbers, name)
    if total and not brief:  # it is of this load, and the rest of all
        limit = f"at {load_in_words(float(numbers['mean_pressure'][index]), numbers)[1]}, {limit}"
    word = HOLDING.get(holds, NOT_DECIDED)
    link = {HOLDS: "", FAILS: "would hold ", NOT_DECIDED: "would be "}[word]
    # a number needs no name below its own heading, and is not said twice
    is_shown = brief and (
        allowed.answer in allowed.numbers or name in stated_allowed(numbers, "conductance")[:1]
    )
    subject, total = ("", "") if is_shown else (allowed.words, total)
    detail = f" ({lifts})" if (lifts := fluid_in_words(numbers, index, name)) else ""
    if not brief:
        detail += f", {link}{_load_in_words(numbers, name)}{_roughness_in_words(numbers, name, index)}"
    return Sentence(f"{' '.join(filter(None, [subject, total, limit]))}: ", word, detail)


def limit_in_words(numbers: Numbers, name: str) -> str:
    """Return what is allowed of a number.

    Examples
    --------
    >>> allowed = {"allowed_leak": 3e-10, "allowed_contact_area": 0.01}
    >>> limit_in_words(allowed, "leak"), limit_in_words(allowed, "contact_area")
    ('of at most 1.08 ml/h', 'of at least 1.00 %')
    """
    allowed, limit = ALLOWED_VALUES[name], float(numbers[f"allowed_{name}"])
    return f"of at {allowed.bound} {unit_of(numbers, UNITS[allowed.numbers[0]], limit).text(limit)}"


def _total_in_words(numbers: Numbers, name: str, index: int) -> str:
    """Return what a seal or a joint has in all of what is allowed, with its interval; empty for none.

    What a fluid lifts has none: the leak is that of the gap without it.

    Examples
    --------
    >>> ends = {"temperature_drop_lower": [0.8], "temperature_drop_upper": [1.2]}
    >>> joint = {"mean_pressure": [1e6], "temperature_drop": [1.0]}
    >>> _total_in_words(joint | ends, "temperature_drop", 0)
    '1.00 ± 0.20 K'
    """
    totals = [total for total in ALLOWED_VALUES[name].numbers if total in TOTALS and total in numbers]
    if is_lifted(numbers, name)[index] or not totals:
        return ""
    # each end is the largest of theirs, as what leaks less along an axis may be known less
    compared = {key: numbers[key] for suffix in ENDS if (key := f"{AREA}{suffix}") in numbers}
    for suffix, values in zip(ENDS, compared_ends(numbers, name), strict=True):
        compared[f"{totals[0]}{suffix}"] = values
    if not compared[totals[0]][index] > 0:
        return ""
    return quantity_text(compared, totals[0], unit_of(numbers, ALLOWED_VALUES[name].unit), index)


def fluid_in_words(numbers: Numbers, index: int, name: str = "leak") -> str:
    """Return that a fluid lifts the bodies at a load; empty where it does not what an allowed value is of.

    Examples
    --------
    >>> seal = {"mean_pressure": [2e5, 1e6], "contact_modulus": 7e6, "fluid_pressure": 5e5}
    >>> [fluid_in_words(seal, index) for index in range(2)]
    ['the fluid, at 0.500 MPa, lifts the bodies', '']
    """
    if not is_lifted(numbers, name)[index]:
        return ""
    return f"the fluid, at {load_in_words(float(numbers['fluid_pressure']), numbers)[1]}, lifts the bodies"


def _roughness_in_words(numbers: Numbers, name: str, index: int) -> str:
    """Return up to which Sq a requirement holds, after its sentence; empty where it is not known.

    Examples
    --------
    >>> bounds = {"gap_largest_Sq_lower": [1.1e-7], "gap_largest_Sq_upper": [1.6e-7]}
    >>> _roughness_in_words({"gap_largest_Sq": [1.4e-7]} | bounds, "gap", 0)
    '; holds for Sq up to 140 nm (110 nm to 160 nm) of this texture with its S- and L-filter'
    """
    names = [f"{name}_largest_Sq{suffix}" for suffix in ENDS]
    if names[0] not in numbers or not np.isfinite(np.asarray(numbers[names[0]])[index]):
        return ""
    largest, *bounds = (float(np.asarray(numbers[key])[index]) for key in names)
    lower, upper = (quantity(bound, "m") if np.isfinite(bound) else "" for bound in bounds)
    interval = f" ({_bounds_in_words(lower, upper)})" if lower else ""
    return f"; holds for Sq up to {quantity(largest, 'm')}{interval} of this texture with its S- and L-filter"


def _bounds_in_words(low: str, high: str) -> str:
    """Return where a number lies that has another beside it, by the texts of one end or two.

    Examples
    --------
    >>> _bounds_in_words("1.20 MPa", ""), _bounds_in_words("", "3.40 MPa")
    ('at least 1.20 MPa', 'at most 3.40 MPa')
    """
    if low and high:
        return range_in_words(low, high)
    return f"at least {low}" if low else f"at most {high}"


def _load_in_words(numbers: Numbers, name: str) -> str:
    """Return the load from which on, or up to which, an allowed value holds, with its bounds."""
    crossings = [float(numbers[f"{name}_holds_from{suffix}"]) for suffix in ENDS]
    (crossing, lower, upper), loads = crossings, np.asarray(numbers["mean_pressure"], float)
    at, low, high = (load_in_words(load, numbers)[1] if load > 0 else "" for load in crossings)
    has_interval = (low or high) and len({at, low, high}) > 1  # that of a fluid has none
    interval = _bounds_in_words(low, high) if has_interval else ""
    if np.isnan(crossing):
        sentence = f"{'below' if ALLOWED_VALUES[name].trend > 0 else 'beyond'} the loads solved"
    elif ALLOWED_VALUES[name].trend > 0:
        sentence = f"up to {at}"
        if crossing == loads.max() and not high:
            sentence += " at least"
            interval = f"decided up to {low}" if 0 < lower < crossing else ""
    elif crossing == loads.min() > lower and lower <= lifting_pressure(numbers, name):
        sentence = f"from {at} or less on"
        interval = f"decided from {high} on" if upper > crossing else ""
    else:
        sentence = f"from {at} on"
    return f"{sentence} ({interval})" if interval else sentence
