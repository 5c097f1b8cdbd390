"""Error messages for mistakes in the settings: the key, the value, the rule, the way out."""

import re
from collections.abc import Collection, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from pydantic_core import ErrorDetails

from roughcontact.configuration.fields import choices_of, field_at, fields_at
from roughcontact.errors import SettingsError

_NAME_RULE = "a name has letters, digits and hyphens only (it becomes a folder)"
_LONGEST_NAME = 64
# at the end of a name: Snakemake refuses twenty, of which the ending of a member of a pair may be one
_REPETITIONS = 19

# the rule behind a mistake, by its name in pydantic
_RULES = {
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must not be less than {ge:g}",
    "less_than": "must be less than {lt:g}",
    "less_than_equal": "must not be greater than {le:g}",
    "too_short": "the list is empty, give at least one number or leave the key out",
    "too_long": "a list of {actual_length}, more than the {max_length} that are taken",
    "list_type": "must be a list",
    "model_type": "must be a group of settings (indented lines `key: value`)",
    "dict_type": "must be a group of settings (indented lines `key: value`)",
    "string_too_short": "must not be empty",
    "value_error": "{error}",
}
# the same for values of another type, by the start of that name
_TYPES = {
    "bool": "must be true or false",
    "float": "must be a finite number",
    "finite": "must be a finite number",
    "int": "must be a whole number",
    "string": "must be text",
}

# keys of bodies by the letters of textbooks, small
_SYMBOLS = {
    "e": "youngs_modulus",
    "nu": "poissons_ratio",
    "ν": "poissons_ratio",
    "h": "hardness",
    "k": "thermal_conductivity",
    "rho": "electrical_resistivity",
    "t": "thickness",
}


def name_mistake(name: str) -> str:
    """Return what is wrong with the name of a surface or a case, an empty text for a good one.

    Examples
    --------
    >>> name_mistake("ground-1"), name_mistake("ground 1")
    ('', 'a name has letters, digits and hyphens only (it becomes a folder)')
    """
    if re.fullmatch(r"[A-Za-z0-9-]+", name) is None:
        return _NAME_RULE
    if name.lower() == "pages":
        return "results/pages is the folder of the report's own pages; choose another name"
    if len(name) > _LONGEST_NAME:
        return f"a name has at most {_LONGEST_NAME} characters, this one has {len(name)}; shorten it"
    for length in range(1, _LONGEST_NAME // _REPETITIONS + 1):
        end = name[-length:]
        if name.endswith(end * _REPETITIONS):
            return f"the name ends with {end} {_REPETITIONS} times or more; Snakemake refuses it, change it"
    return ""


def nearest(misspelling: object, valid: Collection[str]) -> str:
    """Return the end of a sentence that names the valid word nearest to a misspelling, or all of them.

    Examples
    --------
    >>> nearest("paht", ["surface", "path"])
    'did you mean path?'
    >>> nearest("colour", ["surface", "path"])
    'valid are surface, path'
    """
    close = get_close_matches(str(misspelling).lower(), valid, n=1, cutoff=0.6)
    return f"did you mean {close[0]}?" if close else f"valid are {', '.join(valid)}"


def mistake(case: str, overrides: Mapping[str, Any], detail: ErrorDetails) -> SettingsError:
    """Return the error for one entry of `ValidationError.errors()`: key, value, rule, meaning of a setting.

    A mistake in the `overrides` of a case is named by the case.
    """
    if detail["type"] == "invalid_key":
        above, key = detail["loc"][:-1], detail["input"]
        hint = nearest(key, fields_at(above))
        return SettingsError(f"{_dotted(above) or 'the settings'}: the key {key!r} is no text, {hint}")
    return named(case, overrides, detail["loc"], reason(detail))


def named(case: str, overrides: Mapping[str, Any], location: Sequence[str | int], text: str) -> SettingsError:
    """Return an error with the name of its setting before the text; the first two are those of `mistake`."""
    setting = _dotted([part for part in location if not isinstance(part, int)][:2])
    key = _dotted(location)
    if case and location[0] in overrides and _overridden(overrides, location):
        key = f"cases.{case}.{key}"
    return SettingsError(f"{key}{text}", keys=[setting])


def reason(detail: ErrorDetails) -> str:
    """Return the part of a message after the key: the value, the rule and the meaning of the setting."""
    location = detail["loc"]
    field = field_at(location)
    meaning = (field.description if field else None) or ""
    if detail["type"] == "extra_forbidden":
        key, valid = str(location[-1]), fields_at(location[:-1])
        symbol = _SYMBOLS.get(key.lower())
        hint = f"did you mean {symbol}?" if symbol in valid else nearest(key, valid)
        return f": unknown key, {hint}"
    if detail["type"] == "missing":
        return f": missing ({meaning})"
    return f" = {detail['input']!r}: {_rule(detail)}" + (f" ({meaning})" if meaning else "")


def _rule(detail: ErrorDetails) -> str:
    """Return the rule that a value breaks."""
    error_type, location = detail["type"], detail["loc"]
    field = field_at(location)
    if error_type == "literal_error" and field:
        return f"unknown choice, {nearest(detail['input'], choices_of(field))}"
    if error_type in ("too_short", "too_long") and location[-1] == "bodies":
        return "needs exactly two bodies"
    if error_type in _RULES:
        return _RULES[error_type].format(**detail.get("ctx", {}))
    return next((rule for start, rule in _TYPES.items() if error_type.startswith(start)), detail["msg"])


def _dotted(location: Sequence[str | int]) -> str:
    """Return ("contact", "bodies", 0, "poissons_ratio") as contact.bodies[0].poissons_ratio."""
    text = ""
    for key in location:
        text += f"[{key}]" if isinstance(key, int) else f".{key}" if text else str(key)
    return text


def _overridden(overrides: Any, location: Sequence[str | int]) -> bool:
    """Return whether the overrides of a case reach down to `location` (or to the group it is missing in)."""
    for key in location[:-1]:
        if not isinstance(overrides, dict):
            return True
        overrides = overrides.get(key, {})
    return not isinstance(overrides, dict) or location[-1] in overrides
