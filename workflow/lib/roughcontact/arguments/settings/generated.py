"""The default configuration and its JSON schema, generated from the models, and how a run differs from it."""

import json
import re
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic.fields import FieldInfo

from roughcontact.arguments.quantities import Unit, percent, quantity
from roughcontact.arguments.settings.fields import section_model, setting_choices
from roughcontact.arguments.settings.models import Contact, Section, Settings
from roughcontact.arguments.settings.plausible import setting_base
from roughcontact.arguments.units import printed

_HEAD = """\
# yaml-language-server: $schema=../workflow/schemas/config.schema.json
# Settings of roughcontact with their defaults, written by `python -m roughcontact.arguments.settings`.
# For a run of your own copy this file, change it, and name it with `--configfile`. A missing
# key has its default. config/README.md explains settings and table of surfaces.
"""
_QUOTED = re.compile(r"[,:#\[\]{}\"'&*!|>%@`]")  # in a text: it has a meaning in YAML
# what is shown in other units than those of the settings
_PRINTED = {
    "m2": Unit(1e6, "mm²"),
    "m3 s-1": Unit(3.6e9, "ml/h"),
    "m2 s-1": Unit(1e6, "mm²/s"),
    "Ohm m2": Unit(1e12, "µΩ mm²"),
    "m2 K W-1": Unit(1e6, "mm² K/W"),
    "Pa-1": Unit(1e9, "mm³/(N m)"),
    "Pa s": Unit(1e3, "mPa s"),
}
# of JSON schema, by the names that pydantic leaves there for limits behind a validator
_KEYWORDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
_WIDTH = 112  # of a comment with its indentation
# settings without a default that the shipped configuration sets for the samples, to their examples
_SHIPPED = {
    "bodies": "steel and PEEK, a polymer of seals and plain bearings",
    "mean_pressure": "what seals and plain bearings carry",
}
# what the page of a run says of the contact in words of its own, or on what no result depends
_SAID_ELSEWHERE = (
    *("contact_modulus", "bodies", "hardness", "mean_pressure", "relative_pressure", "force", "area"),
    *("boundary", "target_area", "target_gap", "target", "keep_fields"),
)


def default_yaml(*, head: str = _HEAD, values: Mapping[str, Mapping[str, Any]] | None = None) -> str:
    """Return the default configuration: every key with its default, its meaning and its unit.

    It begins with the comment lines `head`; `values` has, by section, keys that are set.

    Examples
    --------
    >>> "  max_missing: 0.4" in default_yaml().splitlines()
    True
    >>> [line for line in default_yaml(values={}).splitlines() if line.endswith(" bodies:")]
    ['  # bodies:']
    """
    if values is None:
        # the shipped configuration solves the samples: it needs bodies and a load
        defaults = {name: (Contact.model_fields[name].examples or [None])[0] for name in _SHIPPED}
        values = {"contact": defaults}
    return head + "\n".join(_yaml(Settings, "", values)) + "\n"


def json_schema() -> str:
    """Return the JSON schema of the configuration, for editors that complete and check YAML."""
    # pydantic's names of limits behind a validator are none of JSON schema
    text = json.dumps(Settings.model_json_schema())
    schema = json.loads(
        text, object_hook=lambda group: {_KEYWORDS.get(key, key): group[key] for key in group}
    )
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    return json.dumps(schema, indent=2) + "\n"


def changed_settings(settings: Mapping[str, Any]) -> list[str]:
    """Return the settings of a case (of `resolve`) that differ from their defaults, each with its value.

    Bodies, hardness, loads and what changes no result are left out.

    Examples
    --------
    >>> from roughcontact.arguments.settings.resolve import resolve
    >>> config = {"level": {"form": "none", "s_filter": "2.5 um"}, "contact": {"contact_modulus": 1e9}}
    >>> changed_settings(resolve(config)[""])
    ['level.form: none', 'level.s_filter: 2.50 µm']
    >>> config = {"contact": {"contact_modulus": 1e9, "hardness": "1 GPa", "unload": ["50 MPa", "0.2 GPa"]}}
    >>> changed_settings(resolve(config)[""])
    ['contact.unload: 50.0 MPa, 200 MPa']
    >>> friction = {"shear_strength": 5e7, "shear_strength_uncertainty": 0.2}
    >>> config = {"contact": {"contact_modulus": 1e9}, "statistics": {"friction": friction}}
    >>> changed_settings(resolve(config)[""])
    ['statistics.friction: shear_strength 50.0 MPa, shear_strength_uncertainty ± 20.0 %']
    """
    return [
        f"{section}.{name}: {value_text(settings[section][name], field, name=name)}"
        for section, of_section in Settings.model_fields.items()
        if section != "report" and (model := section_model(of_section))  # the report changes no number
        for name, field in model.model_fields.items()
        if not (section == "contact" and name in _SAID_ELSEWHERE)
        and settings[section][name] != default_value(field)
    ]


def write_generated(root: Path) -> None:
    """Write config/config.yaml and workflow/schemas/config.schema.json below the folder `root`.

    Missing folders are created.
    """
    texts = {"config/config.yaml": default_yaml(), "workflow/schemas/config.schema.json": json_schema()}
    for name, text in texts.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def _yaml(model: type[Section], indent: str, values: Mapping[str, Any]) -> list[str]:
    """Return the lines of one section; without default and not given, a key is a comment with an example."""
    lines = []
    for name, field in model.model_fields.items():
        section = section_model(field)
        if section and model is Settings:
            lines += ["", f"# {section.__doc__}", f"{name}:"]
            lines += _yaml(section, indent + "  ", values.get(name, {}))
            continue
        text = field.description or ""
        if choices := setting_choices(field):
            text += f"; one of {', '.join(choices)}"
        value = values.get(name, default_value(field))
        is_absent = value in (None, {})
        if is_absent:
            (value,) = field.examples or [None]
        if name in _SHIPPED and value == (field.examples or [None])[0]:
            text += f"; {'for example' if is_absent else 'here'} {_SHIPPED[name]}"
        start = f"{indent}# {name}:" if is_absent else f"{indent}{name}:"
        lines += [""] if model is Settings else []
        lines += [f"{indent}# {line}" for line in textwrap.wrap(text, _WIDTH - len(indent))]
        if section and isinstance(value, list):  # a line for each
            item_start = start.replace(f"{name}:", "  -")
            lines += [start, *(f"{item_start} {flow(item)}" for item in value)]
        else:
            lines.append(f"{start} {flow(value)}")
        lines += _keys(section, f"{indent}#   ") if section else []
    return lines


def _keys(section: type[Section], start: str) -> list[str]:
    """Return a comment on each key of a section below those of the settings; its sections are indented."""
    lines = []
    for name, entry in section.model_json_schema()["properties"].items():
        further = section_model(section.model_fields[name]) if name in section.model_fields else None
        example = f", such as {flow(entry['examples'][0])}" if "examples" in entry and not further else ""
        text = f"{name}: {entry['description']}{example}"
        lines += textwrap.wrap(text, _WIDTH, initial_indent=start, subsequent_indent=f"{start}  ")
        lines += _keys(further, f"{start}  ") if further else []
    return lines


def default_value(field: FieldInfo) -> Any:
    """Return the default of a setting, None of one that has none."""
    return None if field.is_required() else field.get_default(call_default_factory=True)


def hint(field: FieldInfo) -> str:
    """Return the default of a setting, or an example of one that has none."""
    if (value := default_value(field)) not in (None, {}):
        return flow(value)
    return f"none; for example {flow(field.examples[0])}" if field.examples else "none"


def flow(value: Any) -> str:
    """Return a value in YAML's one-line spelling, floats such that YAML 1.1 reads them as floats."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {flow(v)}" for key, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(flow, value)) + "]"
    if isinstance(value, float):
        # YAML 1.1 reads 1e6 as a text: it needs a point
        mantissa, _, exponent = f"{value:.6g}".partition("e")
        return mantissa + ("" if "." in mantissa else ".0") + (f"e{exponent}" if exponent else "")
    if isinstance(value, str) and not _QUOTED.search(value):
        return value
    return json.dumps(value, ensure_ascii=False)


def value_text(value: Any, field: FieldInfo, *, name: str = "") -> str:
    """Return the value of a setting: a quantity with its unit, a range in percent, else as in YAML."""
    if isinstance(value, dict) and (section := section_model(field)):
        return ", ".join(
            f"{key} {value_text(entry, section.model_fields[key], name=key)}"
            for key, entry in value.items()
            if entry is not None
        )
    if name.endswith("_uncertainty"):
        shares = list(map(percent, value if isinstance(value, list) else [value]))
        # one number is that of both sides
        return f"± {shares[-1]}" if shares[0] == shares[-1] else f"−{shares[0]} +{shares[-1]}"
    unit = setting_base(field)
    if isinstance(value, list):
        # no load: the largest one, of contact.unload
        is_quantity = unit and all(isinstance(entry, float) for entry in value)
        return (
            ", ".join(value_text(entry, field) for entry in value) or "true" if is_quantity else flow(value)
        )
    if not unit or not isinstance(value, float):
        return flow(value)
    # a unit that people read
    return _PRINTED[unit].text(value) if unit in _PRINTED else quantity(value, printed(unit))
