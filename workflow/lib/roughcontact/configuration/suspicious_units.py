"""Suspected unit errors in the settings: bare numbers beyond those of all materials, loads and filters.

A bare number is in SI units. A value with its unit is never questioned.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from roughcontact import materials
from roughcontact.materials import Doubt
from roughcontact.quantities import quantity
from roughcontact.units import carries_unit

LONGEST = 0.1  # m, of a nesting index or a wavelength: measured maps are smaller
MOST_RELATIVE = 100.0  # load in units of E* g; any surface is in full contact long before

_LENGTHS = (
    ("level", "s_filter"),
    ("level", "l_filter"),
    ("window", "shortest_wavelength"),
    ("window", "longest_wavelength"),
)
_WAY_OUT = "A bare number is in {unit}: write the unit behind it, even if the number is correct"
_NO_PRESSURE = (
    "is in units of E* x rms gradient, in which contact is full from about 1 on; did you mean mean_pressure?"
)

Location = tuple[str | int, ...]


def suspicious_units(
    given: Mapping[str, Any], settings: Mapping[str, Any]
) -> Iterator[tuple[Location, Any, str]]:
    """Yield location, value and question for each value that is implausible as it stands.

    Parameters
    ----------
    given : mapping
        the configuration of one case as it was written: numbers possibly as text, with or without a unit.
    settings : mapping
        the same, checked: every key present, all in SI units.

    Yields
    ------
    location : tuple
        of the setting, from the top down.
    value : object
        as it was written.
    question : str
        likely values, and the way out.

    Examples
    --------
    >>> from roughcontact.configuration.models import Settings
    >>> given = {"contact": {"contact_modulus": 115}}
    >>> settings = Settings.model_validate(given).model_dump()
    >>> for location, value, question in suspicious_units(given, settings):
    ...     print(location, value)
    ...     print(question.partition("?")[0])
    ('contact', 'contact_modulus') 115
    115 Pa is softer than any gel (1.00 kPa); did you mean 115 GPa or 115 MPa
    """
    yield from _in_contact(given, settings["contact"])
    for location in _LENGTHS:
        length, written = (_at(mapping, location) for mapping in (settings, given))
        if length is not None and length > LONGEST and not carries_unit(written):
            likely = " or ".join(quantity(length * factor, "m") for factor in (1e-3, 1e-6))
            way_out = _WAY_OUT.format(unit="metres")
            yield (
                location,
                written,
                f"{quantity(length, 'm')} is longer than any map; did you mean {likely}? {way_out}",
            )


def _in_contact(given: Mapping[str, Any], contact: Mapping[str, Any]) -> list[tuple[Location, Any, str]]:
    """Return the implausible moduli, hardnesses and loads."""
    found: list[tuple[Location, Any, str]] = []

    def meant(value: float, doubt: Doubt | None, *place: str | int) -> float:
        """Return the likely value at a place, and note where it differs from the written one."""
        location = ("contact", *place)
        written = _at(given, location)
        if doubt is None or carries_unit(written):
            return value
        found.append((location, written, f"{doubt.question()} {_WAY_OUT.format(unit='Pa')}"))
        return doubt.meant[0] if doubt.meant else value

    bodies = []
    for index, body in enumerate(contact["bodies"] or ()):
        own = []
        places = [
            *((layer, ("layers", number)) for number, layer in enumerate(body["layers"] or ())),
            *([(body, ())] if body["base"] is None else []),
        ]
        for material, place in places:
            stiffness = material["youngs_modulus"]
            if stiffness is None or material["poissons_ratio"] is None:  # a mistake of another kind
                return found
            doubt = materials.doubt_of_body(stiffness, material["poissons_ratio"])
            stiffness = meant(stiffness, doubt, "bodies", index, *place, "youngs_modulus")
            own.append(material | {"youngs_modulus": stiffness})
        bodies.append({**own[0], "layers": None})  # of the surface
        if body["hardness"] is not None:
            doubt = materials.doubt_of_hardness(body["hardness"], own[0]["youngs_modulus"])
            meant(body["hardness"], doubt, "bodies", index, "hardness")
    if bodies:
        modulus = materials.contact_modulus(bodies)
    elif contact["contact_modulus"] is not None:
        modulus = contact["contact_modulus"]
        borne = [*(contact["mean_pressure"] or ()), contact["hardness"] or 0.0]
        doubt = materials.doubt_of_modulus(modulus) or materials.doubt_of_gel(modulus, borne)
        modulus = meant(modulus, doubt, "contact_modulus")
    else:  # a mistake of another kind
        return found
    if contact["hardness"] is not None:
        doubt = materials.doubt_of_hardness(contact["hardness"], modulus)
        meant(contact["hardness"], doubt, "hardness")
    for index, load in enumerate(contact["mean_pressure"] or ()):
        meant(load, materials.doubt_of_load(load, modulus), "mean_pressure", index)
    for index, load in enumerate(contact["relative_pressure"] or ()):
        if load > MOST_RELATIVE:
            location = ("contact", "relative_pressure", index)
            found.append((location, _at(given, location), _NO_PRESSURE))
    return found


def _at(given: Any, location: Location) -> Any:
    """Return the value at a location, None where there is none; one load may stand for a list of one."""
    for part in location:
        if isinstance(part, int):
            given = given[part] if isinstance(given, list | tuple) else given
        else:
            given = (given or {}).get(part)
    return given
