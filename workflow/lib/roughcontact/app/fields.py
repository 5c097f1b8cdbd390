"""The settings as fields of a form: made from their models, their values as texts under dotted names."""

import json
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple, get_args, get_origin

import yaml
from annotated_types import MinLen
from pydantic.fields import FieldInfo

from roughcontact.configuration.fields import base_of, field_at, section_of, words_of
from roughcontact.configuration.generated import flow
from roughcontact.configuration.models import Body, Instrument, Section, Settings
from roughcontact.configuration.surfaces import COLUMNS, REQUIRED
from roughcontact.errors import SettingsError
from roughcontact.named_materials import material_names

INDEX = "#"  # stands in the names of a further list entry for its index


class Field(NamedTuple):
    """A field of the form; `entries` has the fields of the entries of a list, `more` of a further one."""

    name: str
    meaning: str
    unit: str = ""
    default: str = ""
    choices: tuple[str, ...] = ()
    suggestions: tuple[str, ...] = ()
    entries: tuple[list["Field"], ...] = ()
    more: list["Field"] | None = None
    long: bool = False


def form(texts: Mapping[str, str]) -> dict[str, tuple[str, list[Field]]]:
    """Return the name of each section of the settings with its meaning and its fields."""
    sections = {name: section_of(field) for name, field in Settings.model_fields.items()}
    named = {name: (section.__doc__ or "", section) for name, section in sections.items() if section}
    shown = {name: (doc, list(_fields(section, f"{name}.", texts))) for name, (doc, section) in named.items()}
    cases = Settings.model_fields["cases"]
    shown["cases"] = ("", [Field("cases", cases.description or "", default=_example(cases), long=True)])
    return shown


def _fields(section: type[Section], prefix: str, texts: Mapping[str, str]) -> Iterator[Field]:
    """Yield the fields of a section."""
    if section is Body:
        meaning = Body.model_json_schema()["properties"]["material"]["description"]
        yield Field(f"{prefix}material", meaning, suggestions=tuple(material_names()))
    for key, field in section.model_fields.items():
        name, meaning = f"{prefix}{key}", field.description or ""
        if entry := section_of(field):
            least = next((rule.min_length for rule in field.metadata if isinstance(rule, MinLen)), 0)
            used = [text[len(name) + 1 :].split(".")[0] for text in texts if text.startswith(f"{name}.")]
            count = max([least, *(int(index) + 1 for index in used if index.isdecimal())])
            entries = tuple(list(_fields(entry, f"{name}.{index}.", texts)) for index in range(count))
            further = None if least else list(_fields(entry, f"{name}.{INDEX}.", texts))
            yield Field(name, meaning, entries=entries, more=further)
            continue
        choices = () if _is_list(field.annotation) else tuple(words_of(field))
        if field.annotation is bool:
            choices = ("true", "false")
        words = words_of(field) if _is_list(field.annotation) else ()
        meaning += f"; of {', '.join(words)}" if words else ""
        yield Field(name, meaning, base_of(field), _default(field), choices)


def _default(field: FieldInfo) -> str:
    """Return the default of a setting, or an example of one that has none."""
    value = None if field.is_required() else field.get_default(call_default_factory=True)
    return _example(field) if value is None else text_of(value)


def _example(field: FieldInfo) -> str:
    """Return the example of a setting."""
    return f"none; for example {text_of(field.examples[0])}" if field.examples else "none"


def columns() -> dict[str, str]:
    """Return the optional columns of the table with their meaning, where the program has words for it."""
    from roughcontact.command_line.program import FILE_OPTIONS

    meanings = {name.replace("-", "_"): text for name, text in FILE_OPTIONS.items()}
    meanings |= {name: field.description or "" for name, field in Instrument.model_fields.items()}
    return {name: meanings.get(name, "") for name in COLUMNS if name not in REQUIRED}


def text_of(value: Any) -> str:
    """Return a value as the text of its field."""
    if isinstance(value, list) and value:
        return ", ".join(map(text_of, value))
    return repr(value) if isinstance(value, float) else flow(value)


def texts_of(value: Any, name: str = "") -> dict[str, str]:
    """Return the content of a configuration as texts by dotted names.

    Examples
    --------
    >>> texts_of({"contact": {"bodies": ["steel", {"youngs_modulus": 1e9}], "mean_pressure": ["1 MPa", 2e6]}})
    {'contact.bodies.0.material': 'steel', 'contact.bodies.1.youngs_modulus': '1000000000.0', \
'contact.mean_pressure': '1 MPa, 2000000.0'}
    """
    field = _field_at(name)
    if name == "cases":
        return {name: yaml.safe_dump(value, sort_keys=False, allow_unicode=True)} if value else {}
    if isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list) and field and section_of(field):
        items = dict(
            enumerate({"material": entry} if isinstance(entry, str) else entry for entry in value)
        ).items()
    else:
        return {name: text_of(value)}
    return {
        key: text
        for part, entry in items
        for key, text in texts_of(entry, f"{name}.{part}".strip(".")).items()
    }


def settings_of(texts: Mapping[str, str]) -> dict[str, Any]:
    """Return the configuration of the texts of a form; empty ones are left out.

    Examples
    --------
    >>> settings_of({"contact.bodies.0.material": "steel", "contact.force": "50 N, 80", "level.order": ""})
    {'contact': {'bodies': [{'material': 'steel'}], 'force': ['50 N', 80]}}
    """
    config: dict[str, Any] = {}
    for name, text in texts.items():
        if not text.strip():
            continue
        *above, key = name.split(".")
        group = config
        for part in above:
            group = group.setdefault(part, {})
        group[key] = _value(name, text.strip())
    return _with_lists(config)


def _field_at(name: str) -> FieldInfo | None:
    """Return the setting of a dotted name, whose numbers are indices."""
    return field_at([part for part in name.split(".") if not part.isdecimal()])


def _value(name: str, text: str) -> Any:
    """Return the value that the text of a field stands for."""
    field = _field_at(name)
    if name == "cases":
        try:
            return yaml.safe_load(text)
        except yaml.YAMLError as error:
            raise SettingsError(f"cases: is no YAML ({' '.join(str(error).split())})") from error
    if field and _is_list(field.annotation):
        return [_scalar(entry.strip()) for entry in text.strip("[]").split(",") if entry.strip()]
    return text if field and field.annotation in (str, str | None) else _scalar(text)


def _scalar(text: str) -> Any:
    """Return a number, true, false or null as such, anything else as text."""
    try:
        value = json.loads(text)
    except ValueError:
        return text
    return value if value is None or isinstance(value, bool | int | float) else text


def _with_lists(value: Any) -> Any:
    """Return groups whose keys are all indices as lists, an entry without a value as an empty group."""
    if not isinstance(value, dict):
        return value
    full = {key: _with_lists(entry) for key, entry in value.items()}
    if full and all(key.isdecimal() for key in full):
        return [full.get(str(index), {}) for index in range(max(map(int, full)) + 1)]
    return full


def _is_list(annotation: Any) -> bool:
    """Return whether a setting takes a list."""
    return get_origin(annotation) is list or any(map(_is_list, get_args(annotation)))
