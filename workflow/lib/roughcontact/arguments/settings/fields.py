"""Properties of a setting, read from its model: the section below it, its choices, its description."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from roughcontact.arguments.settings.models import MATERIAL, Section, Settings
from roughcontact.arguments.settings.plausible import nested_types

UNKNOWN = FieldInfo(description="no setting")  # of a key that has no field


def section_model(field: FieldInfo) -> type[Section] | None:
    """Return the section that a setting holds, alone or in a list; None for a plain value."""
    # a section may stand in a union with None, or in a list
    types = (type_ for type_ in nested_types(field.annotation) if isinstance(type_, type))
    return next((type_ for type_ in types if issubclass(type_, Section)), None)


def setting_choices(field: FieldInfo) -> list[str]:
    """Return the words that a setting, or each entry of its list, may be; none where any value may stand.

    Examples
    --------
    >>> from roughcontact.arguments.settings.models import Level
    >>> setting_choices(Level.model_fields["fill"])
    ['harmonic', 'none']
    >>> setting_choices(Level.model_fields["order"])
    []
    """
    literals = (type_ for type_ in nested_types(field.annotation) if get_origin(type_) is Literal)
    return [choice for literal in literals for choice in get_args(literal)]


def is_list(annotation: Any) -> bool:
    """Return whether a setting of this type takes a list."""
    return any(get_origin(type_) is list for type_ in nested_types(annotation))


def grouped(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by dotted names as groups, those of which all keys are positions as lists.

    Examples
    --------
    >>> grouped({"contact.bodies.0.material": "steel", "contact.boundary": "free"})
    {'contact': {'bodies': [{'material': 'steel'}], 'boundary': 'free'}}
    """
    groups = _Group()
    for name, value in values.items():
        *path, key = name.split(".")
        group = groups
        for section in path:
            subgroup = group.setdefault(section, _Group())
            group = subgroup if isinstance(subgroup, _Group) else _Group()  # a value in its place stays
        group[key] = value
    return {key: _normalise_lists(group) for key, group in groups.items()}


def flattened(value: Any, name: str = "") -> dict[str, str]:
    """Return settings that hold texts alone by dotted names; `grouped` is the way back.

    Examples
    --------
    >>> flattened({"contact": {"bodies": [{"material": "steel"}], "unload": [], "force": "1 N"}})
    {'contact.bodies.0.material': 'steel', 'contact.unload': '[]', 'contact.force': '1 N'}
    """
    if isinstance(value, str) or not value:
        return {name: "[]" if value == [] else value or ""}
    entries = value.items() if isinstance(value, Mapping) else enumerate(value)
    groups = (flattened(entry, f"{name}.{key}" if name else str(key)) for key, entry in entries)
    return {key: text for group in groups for key, text in group.items()}


class _Group(dict[str, Any]):
    """A group of values by dotted names; other mappings are values."""


def _normalise_lists(value: Any) -> Any:
    """Return groups whose keys are all positions as lists, an entry without a value as an empty group."""
    if not isinstance(value, _Group):
        return value
    # positions may come in any order, and some may be missing
    entries = {key: _normalise_lists(entry) for key, entry in value.items()}
    # no list has a million entries, which a file of somebody else may ask for in a line
    if entries and all(key.isdecimal() and len(key) < 7 for key in entries):
        return [entries.get(str(index), {}) for index in range(max(map(int, entries)) + 1)]
    return entries


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
        section = section_model(field) if field else None
    return section.model_fields if section else {}


def field_at(location: Sequence[str | int]) -> FieldInfo | None:
    """Return the field at a location, as in `fields_at`; None where there is no such setting."""
    *above, key = _keys(location) or [""]
    return _with_material(fields_at(above)).get(key)


def leaves(section: type[Section], prefix: str, values: Any) -> Iterator[tuple[str, FieldInfo | None, Any]]:
    """Yield dotted name, field and value of each setting below a section, groups before what they hold.

    A list of groups has its entries by position; what is no setting has no field, what is not set is empty.

    Examples
    --------
    >>> from roughcontact.arguments.settings.models import Statistics
    >>> names = [name for name, *_ in leaves(Statistics, "", {"seal": {"width": "2 mm"}, "sael": "1"})]
    >>> names[names.index("seal") :][:3], names[-1]
    (['seal', 'seal.viscosity', 'seal.pressure_difference'], 'sael')
    """
    values = values if isinstance(values, Mapping) else {"material": values} if values else {}
    fields = _with_material(section.model_fields)
    for key in dict.fromkeys([*fields, *values]):
        # an empty text: as a form has it
        name, field, value = f"{prefix}{key}", fields.get(key), values.get(key, "")
        below = section_model(field) if field else None
        entries = list(value) if isinstance(value, list) else []
        if below is None or field is None:
            yield name, field, value
        elif (value and not (entries if is_list(field.annotation) else isinstance(value, Mapping))) or any(
            not isinstance(entry, Mapping | str) for entry in entries
        ):  # a value in the place of a group
            yield name, None, value
        elif is_list(field.annotation):
            least = max((getattr(limit, "min_length", 0) for limit in field.metadata), default=0)
            entries += [""] * (least - len(entries))
            yield name, field, entries
            for index, entry in enumerate(entries):
                yield from leaves(below, f"{name}.{index}.", entry)
        else:
            yield name, field, value
            yield from leaves(below, f"{name}.", value)


def label(name: str) -> str:
    """Return the words of a setting by its dotted name.

    Examples
    --------
    >>> label("contact.bodies.0.youngs_modulus"), label("statistics.seal.width"), label("contact.force")
    ("Body 1: Young's modulus", 'Seal: width', 'Force')
    """
    *path, key = name.split(".")
    field = field_at(path)
    model = section_model(field) if field else None
    of = f"{path[-1]}: " if len(path) > 1 else ""
    of = f"{model.__name__} {int(path[-1]) + 1}: " if model and path[-1].isdecimal() else of
    key = key.replace("youngs", "Young's").replace("poissons", "Poisson's")
    words = f"{of}{key}".replace("_", " ")
    return words[:1].upper() + words[1:]


def _with_material(fields: Mapping[str, FieldInfo]) -> dict[str, FieldInfo]:
    """Return the fields of a section, first the name of the material that those of a body may have."""
    return {"material": MATERIAL, **fields} if "youngs_modulus" in fields else {**fields}


def _keys(location: Sequence[str | int]) -> list[str]:
    """Return a location without its positions in lists."""
    return [key for key in location if isinstance(key, str) and not key.isdecimal()]
