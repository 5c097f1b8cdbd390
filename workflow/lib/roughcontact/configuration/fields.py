"""Properties of a setting, read from its model: the section below it, its choices, its description."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from roughcontact.configuration.models import Section, Settings
from roughcontact.configuration.plausible import Range


def section_of(field: FieldInfo) -> type[Section] | None:
    """Return the section that a setting holds, alone or in a list; None for a plain value."""
    types = (type_ for type_ in _types(field.annotation) if isinstance(type_, type))
    return next((type_ for type_ in types if issubclass(type_, Section)), None)


def choices_of(field: FieldInfo) -> list[str]:
    """Return the words that a setting, or each entry of its list, may be; none where any value may stand.

    Examples
    --------
    >>> from roughcontact.configuration.models import Level
    >>> choices_of(Level.model_fields["fill"])
    ['harmonic', 'none']
    >>> choices_of(Level.model_fields["order"])
    []
    """
    literals = (type_ for type_ in _types(field.annotation) if get_origin(type_) is Literal)
    return [choice for literal in literals for choice in get_args(literal)]


def is_list(annotation: Any) -> bool:
    """Return whether a setting of this type takes a list."""
    return any(get_origin(type_) is list for type_ in _types(annotation))


def grouped(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by dotted names as groups, those of which all keys are positions as lists.

    Examples
    --------
    >>> grouped({"contact.bodies.0.material": "steel", "contact.boundary": "free"})
    {'contact': {'bodies': [{'material': 'steel'}], 'boundary': 'free'}}
    """
    groups: dict[str, Any] = {}
    for name, value in values.items():
        *path, key = name.split(".")
        group = groups
        for section in path:
            subgroup = group.setdefault(section, {})
            group = subgroup if isinstance(subgroup, dict) else {}  # a value where a group belongs stays
        group[key] = value
    return {key: _with_lists(group) for key, group in groups.items()}


def _with_lists(value: Any) -> Any:
    """Return groups whose keys are all positions as lists, an entry without a value as an empty group."""
    if not isinstance(value, dict):
        return value
    converted = {key: _with_lists(entry) for key, entry in value.items()}
    if converted and all(map(str.isdecimal, converted)):
        return [converted.get(str(index), {}) for index in range(max(map(int, converted)) + 1)]
    return converted


def base_of(field: FieldInfo) -> str:
    """Return the base unit of a setting that may carry its unit; empty for a plain number and for words.

    Examples
    --------
    >>> from roughcontact.configuration.models import Level
    >>> base_of(Level.model_fields["s_filter"]), base_of(Level.model_fields["max_missing"])
    ('m', '')
    """
    noted = (*field.metadata, *_types(field.annotation))
    return next((range_.base for range_ in noted if isinstance(range_, Range)), "")


def fields_at(location: Sequence[str | int]) -> dict[str, FieldInfo]:
    """Return the fields of the section at a location (keys from the top, list positions); none without.

    Examples
    --------
    >>> list(fields_at(("contact", "bodies", 0)))[:3]
    ['name', 'youngs_modulus', 'poissons_ratio']
    """
    section: type[Section] | None = Settings
    for key in _keys(location):
        field = section.model_fields.get(key) if section else None
        section = section_of(field) if field else None
    return section.model_fields if section else {}


def field_at(location: Sequence[str | int]) -> FieldInfo | None:
    """Return the field at a location, as in `fields_at`; None where there is no such setting."""
    *above, key = _keys(location)
    return fields_at(above).get(key)


def _keys(location: Sequence[str | int]) -> list[str]:
    """Return a location without its positions in lists."""
    return [key for key in location if isinstance(key, str) and not key.isdecimal()]


def _types(annotation: Any) -> Iterator[Any]:
    """Yield an annotation, all types within it, and what is noted with them."""
    yield annotation
    for argument in get_args(annotation):
        yield from _types(argument)
