"""What was asked: bodies and loads of a run, in words, for the head of its page."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from roughcontact.quantities import number, percent, quantity

_OF_BODY = (("hardness", "hardness"), ("yield_stress", "yield stress"))
_TARGETS = {"percolation": "the load at which the gap closes", "first_yield": "the load of first yield"}


def asked_in_words(settings: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return for each case of a run (an empty name where there are none) its bodies and loads.

    `settings` are those of the run, or of each case by its name.

    Examples
    --------
    >>> rubber = {"youngs_modulus": 6e6, "poissons_ratio": 0.5}
    >>> steel = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "hardness": 2e9}
    >>> asked_in_words({"contact": {"bodies": [steel, rubber], "mean_pressure": [1e5, 2e5]}})
    [('', '210 GPa (ν 0.30, hardness 2.00 GPa) on 6.00 MPa (ν 0.50); mean pressure 100 kPa, 200 kPa')]
    >>> asked_in_words({"contact": {"bodies": [steel | {"name": "steel"}], "target_area": 0.1}})
    [('', 'steel (210 GPa, ν 0.30, hardness 2.00 GPa) on a rigid body; contact area 10.0 %')]
    """
    cases = {"": settings} if "contact" in settings else settings
    return [
        (name, f"{_bodies(case['contact'])}; {_loads(case['contact'])}")
        for name, case in cases.items()
        if isinstance(case, Mapping) and "contact" in case
    ]


def _bodies(contact: Mapping[str, Any]) -> str:
    """Return the bodies, or the contact modulus where that is given."""
    if bodies := contact.get("bodies"):
        return " on ".join([*map(_body, bodies), "a rigid body"][:2])
    words = f"contact modulus E* = {quantity(contact['contact_modulus'], 'Pa')}"
    hardness = contact.get("hardness")
    return f"{words}, hardness {quantity(hardness, 'Pa')}" if hardness else words


def _body(body: Mapping[str, Any]) -> str:
    """Return a body: its modulus, what limits its pressure, its layers."""
    if body.get("youngs_modulus") is None:
        words, known = "a rigid base", []
    else:
        words = quantity(body["youngs_modulus"], "Pa")
        known = [f"ν {number(body['poissons_ratio'], digits=2)}"]
    known += [f"{text} {quantity(body[key], 'Pa')}" for key, text in _OF_BODY if body.get(key)]
    layers = [
        f"{quantity(layer['thickness'], 'm')} of {quantity(layer['youngs_modulus'], 'Pa')}"
        for layer in body.get("layers") or []
    ]
    if name := body.get("name"):
        words, known = name, [words, *known] if words[0].isdigit() else known
    words += f" ({', '.join(known)})" if known else ""
    return f"{' and '.join(layers)} over {words}" if layers else words


def _loads(contact: Mapping[str, Any]) -> str:
    """Return the loads, or what they are to bring about."""
    parts = list(_given(contact))
    return " and ".join(parts) if parts else "loads planned for each map"


def _given(contact: Mapping[str, Any]) -> Iterator[str]:
    """Yield each kind of loads that is given."""
    for key, words, show in (
        ("mean_pressure", "mean pressure", lambda value: quantity(value, "Pa")),
        ("relative_pressure", "p̄/(E* g)", number),
        ("target_area", "contact area", percent),
        ("target_gap", "mean gap", lambda value: quantity(value, "m")),
    ):
        if (values := contact.get(key)) is not None:
            values = values if isinstance(values, Sequence) else [values]
            yield f"{words} {', '.join(show(float(value)) for value in values)}"
    if target := contact.get("target"):
        yield " and ".join(_TARGETS[one] for one in ([target] if isinstance(target, str) else target))
