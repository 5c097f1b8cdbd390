"""Error messages for mistakes in the settings: the key, the value, the rule, the way out."""

import re
from collections.abc import Collection, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from pydantic_core import ErrorDetails

from roughcontact.arguments.rows import rows_beside
from roughcontact.arguments.settings.fields import field_at, fields_at, leaves, setting_choices
from roughcontact.arguments.settings.models import Settings
from roughcontact.errors import SettingsError

_NAME_RULE = "a name has letters, digits and hyphens only (it becomes a folder)"
NAME = r"(?:[^\W_]|-)+"  # letters and digits of any script
_MAX_NAME_LENGTH = 64
# at the end of a name: Snakemake refuses twenty, of which the ending of a member of a pair may be one
_REPETITIONS = 19

MAX_VALUE = 500  # characters of a value that a message repeats: it is read by a person
_RULES = rows_beside(__file__, "rules.tsv")

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

# key -> why it is no setting, and the way out
_NO_SETTINGS = dict.fromkeys(
    [f"statistics.requirement.{key}" for key in ("lengths", "wavelength", "Sal", "RSm")],
    "no factor on the lengths is offered: with it the S- and the L-filter of the map move, too, and nobody "
    "has measured the waves that come between the old and the new ones. Leave it out: the largest Sq is that "
    "of the same lengths; of a finer grinding measure a face",
)


def name_mistake(name: str) -> str:
    """Return what is wrong with the name of a surface or a case, an empty text for a good one.

    Examples
    --------
    >>> name_mistake("Prüfling-1"), name_mistake("ground 1")
    ('', 'a name has letters, digits and hyphens only (it becomes a folder)')
    """
    if re.fullmatch(NAME, name) is None:
        return _NAME_RULE
    if name.lower() == "pages":  # capitals do not tell folders apart everywhere
        return "results/pages is the folder of the report's own pages; choose another name"
    if len(name) > _MAX_NAME_LENGTH:
        return f"a name has at most {_MAX_NAME_LENGTH} characters, this one has {len(name)}; shorten it"
    # any repeated ending: "aaaa", "-1-1-1"
    for length in range(1, _MAX_NAME_LENGTH // _REPETITIONS + 1):
        suffix = name[-length:]
        if name.endswith(suffix * _REPETITIONS):
            return (
                f"the name ends with {suffix} {_REPETITIONS} times or more; Snakemake refuses it, change it"
            )
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
    # a word farther from it is rarely meant
    close = get_close_matches(str(misspelling).lower(), valid, n=1, cutoff=0.6)
    return f"did you mean {close[0]}?" if close else f"valid are {', '.join(valid)}"


def elsewhere(key: str) -> str:
    """Return the end of a sentence that names the settings of this key in other sections, "" without any.

    Examples
    --------
    >>> elsewhere("seal"), elsewhere("colour")
    ('did you mean statistics.seal?', '')
    """
    names = (name for name, *_ in leaves(Settings, "", {}))
    places = dict.fromkeys(re.sub(r"\.\d+", "", name) for name in names if name.split(".")[-1] == key)
    return f"did you mean {' or '.join(places)}?" if places else ""


def mistake(case: str, overrides: Mapping[str, Any], detail: ErrorDetails) -> SettingsError:
    """Return the error for one entry of `ValidationError.errors()`: key, value, rule, meaning of a setting.

    A mistake in the `overrides` of a case is named by the case.
    """
    if detail["type"] == "invalid_key":
        above, key = detail["loc"][:-1], detail["input"]
        hint = nearest(key, fields_at(above))
        return SettingsError(f"{dotted(above) or 'the settings'}: the key {key!r} is no text, {hint}")
    location = tuple(part for part in detail["loc"] if part != "[key]")  # of a time that is a key
    return named(case, overrides, location, reason(detail))


def named(case: str, overrides: Mapping[str, Any], location: Sequence[str | int], text: str) -> SettingsError:
    """Return an error with the name of its setting before the text; the first two are those of `mistake`."""
    return setting_error(dotted(location), text, case=case if _overridden(overrides, location) else "")


def setting_error(key: str, text: str, *, case: str = "") -> SettingsError:
    """Return the error of a setting: its dotted name, that of the case that states it, and the text."""
    # section and key, without positions in lists; a section as a whole is no setting
    setting = re.sub(r"\[\d+\]", "", key).split(".")[:2]
    is_section = len(setting) == 1 and bool(fields_at(setting))
    dotted_name = f"cases.{case}.{key}" if case else key
    return SettingsError(
        f"{dotted_name}{text}", keys=[] if is_section else [".".join(setting)], place=dotted_name
    )


def reason(detail: ErrorDetails) -> str:
    """Return the part of a message after the key: the value, the rule and the meaning of the setting."""
    location = detail["loc"]
    field = field_at(location)
    meaning = (field.description if field else None) or ""
    if detail["type"] == "extra_forbidden":
        if text := _NO_SETTINGS.get(dotted(location)):
            return f": {text}"
        key, valid = str(location[-1]), fields_at(location[:-1])
        symbol = _SYMBOLS.get(key.lower())  # E, nu, H as in a textbook
        hint = f"did you mean {symbol}?" if symbol in valid else elsewhere(key) or nearest(key, valid)
        return f": unknown key, {hint}"
    if detail["type"] == "missing":
        return f": missing ({meaning})"
    if isinstance(detail["input"], Mapping):  # of two keys of a section
        return f": {_rule(detail)}"
    value = repr(_brief(detail["input"]))
    value = value if len(value) <= MAX_VALUE else f"{value[:MAX_VALUE]} ..."
    return f" = {value}: {_rule(detail)}" + (f" ({meaning})" if meaning else "")


def _brief(value: Any) -> Any:
    """Return a value as a message repeats it: a body that is a name without the numbers of its material."""
    if isinstance(value, list):
        return [_brief(entry) for entry in value]
    return value["name"] if isinstance(value, Mapping) and value.get("name") else value


def _rule(detail: ErrorDetails) -> str:
    """Return the rule that a value breaks."""
    error_type, location = detail["type"], detail["loc"]
    field = field_at(location)
    if error_type == "literal_error" and field:
        return f"unknown choice, {nearest(detail['input'], setting_choices(field))}"
    if error_type in ("too_short", "too_long") and location[-1] == "bodies":
        return "needs exactly two bodies"
    # 1,5: a decimal comma has a rule of its own
    comma = error_type == "float_parsing" and re.search(r"\d,\d", str(detail["input"]))
    share = error_type == "float_parsing" and str(detail["input"]).rstrip().endswith("%")
    kind = "decimal_comma" if comma else "percent" if share else error_type
    rules = (rule.format(**detail.get("ctx", {})) for start, rule in _RULES if kind.startswith(start))
    return next(rules, detail["msg"])


def dotted(location: Sequence[str | int]) -> str:
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
