"""What was asked: bodies, loads and changed settings of a run, in words, for the head of its page."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from roughcontact.arguments.materials import RIGID
from roughcontact.arguments.quantities import Unit, prefix
from roughcontact.arguments.stacks import layers_in
from roughcontact.report.template import sentence

_TARGETS = {"percolation": "the load at which the gap closes", "first_yield": "the load of first yield"}


def describe_problem(
    settings: Mapping[str, Any], changes: Mapping[str, Sequence[str]] | None = None
) -> list[tuple[str, str]]:
    """Return for each case of a run ("" without cases) its bodies, loads, and `changes` settings.

    Examples
    --------
    >>> rubber = {"youngs_modulus": 6e6, "poissons_ratio": 0.5}
    >>> steel = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "hardness": 2e9}
    >>> describe_problem({"contact": {"bodies": [steel, rubber], "mean_pressure": [1e5, 2e5]}})
    [('', '210 GPa (ν 0.30, hardness 2.00 GPa) on 6.00 MPa (ν 0.50); mean pressure 100 kPa, 200 kPa')]
    >>> describe_problem({"contact": {"bodies": [steel | {"name": "steel"}], "target_area": 0.1}})
    [('', 'steel (210 GPa, ν 0.30, hardness 2.00 GPa) on a rigid body; contact area 10.0 %')]
    """
    return [
        (name, "; ".join([bodies_in_words(contact), _loads(contact), *_plain((changes or {}).get(name, ()))]))
        for name, contact in contacts(settings)
    ]


def _plain(changes: Sequence[str]) -> Iterator[str]:
    """Yield settings in the words of their keys: "seal: pressure difference 500 kPa"."""
    for change in changes:
        section, _, text = change.partition(".")
        yield (text if section in ("contact", "statistics") else f"{section} {text}").replace("_", " ")


def same_loads(settings: Mapping[str, Any]) -> bool:
    """Return whether all cases ask for the same loads, or the same that loads bring about.

    Planned ones are of each map: as many of them may be others.

    Examples
    --------
    >>> same_loads({"soft": {"contact": {"mean_pressure": 1e5}}, "hard": {"contact": {"target_area": 0.1}}})
    False
    """
    requests = {tuple(_stated_loads(contact)) for _, contact in contacts(settings)}
    return len(requests) < 2 and () not in requests


def contacts(settings: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    """Return the settings of the contact by case, whose name is empty where there are none."""
    cases = {"": settings} if "contact" in settings else settings
    sections = {name: case for name, case in cases.items() if isinstance(case, Mapping)}
    return [(name, case["contact"]) for name, case in sections.items() if "contact" in case]


def measured_in_words(dates: Mapping[str, str]) -> str:
    """Return when the maps of a run were measured, given the date of each, empty where it is not stated.

    Examples
    --------
    >>> measured_in_words({"one": "2024-01-31", "two": "2024-01-31"})
    'measured 2024-01-31'
    >>> measured_in_words({"one": "2024-02-01", "two": "2023-12-24", "three": ""})
    'measured 2023-12-24 to 2024-02-01 (2 of 3 maps state it)'
    >>> measured_in_words({"one": ""})
    ''
    """
    return sentence("measured_on", sorted(filter(None, dates.values())), len(dates))


def bodies_in_words(contact: Mapping[str, Any]) -> str:
    """Return the bodies, or the contact modulus where that is given."""
    return sentence("bodies", contact, layers_in, RIGID)


def _loads(contact: Mapping[str, Any]) -> str:
    """Return the loads, or what they are to bring about."""
    return " and ".join(_stated_loads(contact)) or "loads planned for each map"


def _stated_loads(contact: Mapping[str, Any]) -> Iterator[str]:
    """Yield each kind of loads that is given."""
    for key, text, unit in (
        ("force", "force", "N"),
        ("mean_pressure", "mean pressure", "Pa"),
        ("relative_pressure", "relative pressure", ""),
        ("target_area", "contact area", "%"),
        ("target_gap", "mean gap", "m"),
    ):
        if (values := contact.get(key)) is None or (key == "force" and contact.get("area")):
            continue
        values = [float(value) for value in (values if isinstance(values, Sequence) else [values])]
        scale = Unit(100.0, "%") if unit == "%" else Unit(*prefix(max(values), unit))  # one for all
        yield f"{text} {', '.join(map(scale.text, values))}{' on a body of finite size' * (key == 'force')}"
    if target := contact.get("target"):
        yield " and ".join(_TARGETS[result] for result in ([target] if isinstance(target, str) else target))
