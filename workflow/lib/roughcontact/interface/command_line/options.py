"""The settings as options: `level.form` is `--level-form`, `contact.tolerance` is `--tolerance`.

Names, meanings, defaults and checks are those of `roughcontact.arguments.settings`.
"""

import os
import re
from argparse import ArgumentParser, Namespace, _ArgumentGroup
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from roughcontact.arguments.kinds import settings_on_form
from roughcontact.arguments.settings.fields import fields_at, grouped, is_list, section_model
from roughcontact.arguments.settings.generated import default_value, flow
from roughcontact.arguments.settings.models import Settings
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.errors import SettingsError

# settings for the workflow alone, or with an option of their own here
_WITHOUT_OPTION = {"contact.bodies", "contact.keep_fields", "contact.unload"}
_BODY = ("youngs_modulus", "poissons_ratio", "hardness")
_LAYER = ("thickness", "youngs_modulus", "poissons_ratio")
_LOADS = ("mean_pressure", "relative_pressure", "force")  # one or the other
_SECTIONS = ("contact", "level", "window", "form", "uncertainty", "instrument")
_DERIVED = ("allowed_pressure", "flow", "seal", "joint", "requirement", "friction")  # of the statistics
COURSES = ("wear", "sliding")  # what follows the contact in a run


def add_settings(parser: ArgumentParser) -> None:
    """Add an option for each setting of the stages to the parser of `roughcontact solve`."""
    models = {section: section_model(Settings.model_fields[section]) for section in _SECTIONS}
    groups = {section: parser.add_argument_group(section, model.__doc__) for section, model in models.items()}
    elasticity, loads = (groups["contact"].add_mutually_exclusive_group() for _ in range(2))
    together = {"contact_modulus": elasticity} | dict.fromkeys(_LOADS, loads)
    for name in _names():
        section, _, key = name.partition(".")
        add_setting(together.get(key, groups[section]), name)
    add_body(elasticity)
    add_derived(parser)
    parser.add_argument(
        "--threads",
        type=int,
        default=min(4, os.cpu_count() or 1),
        metavar="NUMBER",
        help="threads of the solve (default: %(default)s)",
    )


def add_setting(parser: ArgumentParser | _ArgumentGroup, name: str) -> None:
    """Add the option of a setting, by its dotted name, with its meaning and its default, or its keys."""
    *above, key = name.split(".")
    field = fields_at(above)[key]
    text, default = field.description or "", default_value(field)
    form: dict[str, Any] = {"metavar": "VALUE"}
    form |= {"nargs": "*", "action": "extend"} if is_list(field.annotation) else {}
    if section_model(field):
        text, form = keys_in_words(name), {"metavar": "KEY=VALUE", "nargs": "+", "action": "extend"}
    elif default is not None:
        text += f" (default: {' '.join(default) if isinstance(default, list) else flow(default)})"
    parser.add_argument(_option(name), dest=name, help=text.replace("%", "%%"), **form)


def add_derived(parser: ArgumentParser, courses: Sequence[str] = ()) -> None:
    """Add the options for what is derived from the contact, and for courses of a run."""
    group = parser.add_argument_group("what is derived from the contact")
    for name in (*(f"statistics.{key}" for key in _DERIVED), *courses):
        add_setting(group, name)


def add_body(parser: ArgumentParser | _ArgumentGroup) -> None:
    """Add the option for the materials."""
    parser.add_argument(
        "--body",
        nargs="+",
        action="append",
        metavar=("NAME | E NU", "H | KEY=VALUE"),
        help="name of a material (steel, NBR), or Young's modulus (Pa), Poisson's ratio and, if known, "
        "hardness (Pa) of one body; give it twice; units are allowed: 210GPa 0.3 2GPa. Other properties by "
        "their keys, electrical_resistivity=1.7e-8, creep_modulus='1 h: 2 GPa, 10 years: 1 GPa'; layers, "
        "the outermost first: layer=THICKNESS,E,NU or "
        "layer=THICKNESS,NAME",
    )


def keys_in_words(section: str) -> str:
    """Return the keys of a section with what they are, those that it needs first and without brackets.

    Examples
    --------
    >>> keys_in_words("statistics.joint").rpartition("; [")[2]
    'film_conductivity= of that film; a number alone is in W/(m K)]'
    """
    fields = fields_at(section.split("."))
    required = sorted(fields.items(), key=lambda entry: not entry[1].is_required())
    words = [f"{key}= {field.description or ''}" for key, field in required]
    return "; ".join(
        text if field.is_required() else f"[{text}]" for text, (_, field) in zip(words, required, strict=True)
    )


def parse_bodies(texts: Sequence[Sequence[str]]) -> list[str | dict[str, Any]]:
    """Return the two bodies, as in the configuration, from what `--body` was given."""
    if len(texts) != 2:
        times = "once" if len(texts) == 1 else f"{len(texts)} times"
        raise SettingsError(f"--body is given {times}; give it twice, one for each body")
    bodies: list[str | dict[str, Any]] = []
    for text in map(_hardness_in_the_name, texts):
        values = [argument for argument in text if "=" not in argument]
        if files := [value for value in values[1:] if Path(value).exists()]:
            raise SettingsError(f"--body {' '.join(text)}: {files[0]} is a file; files go before --body")
        if len(values) > 3 or (len(values) == 1 and values[0][:1].isdigit()):
            raise SettingsError(
                f"--body {' '.join(text)}: has {len(values)} values; give the name of a material, or "
                "Young's modulus, Poisson's ratio and, if known, hardness"
            )
        plain = [argument for argument in text if not argument.startswith("layer=")]
        body: dict[str, Any] = keyed("--body", plain, names=_BODY, by_name=("material",))
        if "creep_modulus" in body:
            entries = (entry.partition(":") for entry in body["creep_modulus"].strip("{} ").split(","))
            body["creep_modulus"] = {time.strip(): modulus.strip() for time, _, modulus in entries}
        if layers := [
            argument.removeprefix("layer=").split(",") for argument in text if argument.startswith("layer=")
        ]:
            names = {"names": _LAYER, "by_name": ("thickness", "material")}
            body["layers"] = [keyed("--body layer", layer, **names) for layer in layers]
        bodies.append(body["material"] if list(body) == ["material"] else body)
    return bodies


def _hardness_in_the_name(words: Sequence[str]) -> list[str]:
    """Return the words of a body with the name of an elastomer and its hardness, NBR 70 Shore A, as one."""
    plain = [word for word in words if "=" not in word]
    is_name = len(plain) > 1 and plain[0][:1].isalpha() and plain[1][:1].isdigit()
    return [" ".join(plain), *(word for word in words if "=" in word)] if is_name else [*words]


def keyed(
    option: str, arguments: Sequence[str], *, names: Sequence[str] = (), by_name: Sequence[str] = ()
) -> dict[str, Any]:
    """Return values by their keys, from KEY=VALUE, after those of `names` (or `by_name`) without a key.

    Examples
    --------
    >>> keyed("--body", ["210GPa", "0.3", "yield_stress=400MPa"], names=("youngs_modulus", "poissons_ratio"))
    {'youngs_modulus': '210GPa', 'poissons_ratio': '0.3', 'yield_stress': '400MPa'}
    >>> keyed("--wear", ["distance=1 m 10 m", "coefficient=1e-7 mm³/(N m)"])  # several numbers are a list
    {'distance': ['1 m', '10 m'], 'coefficient': '1e-7 mm³/(N m)'}
    """
    values = [argument for argument in arguments if "=" not in argument]
    names = by_name if len(values) == len(by_name) else names
    pairs = [*zip(names, values, strict=False)]
    pairs += [
        (key, value)
        for key, _, value in (argument.partition("=") for argument in arguments if "=" in argument)
    ]
    result = {key: _listed(value) for key, value in pairs}
    if len(values) > len(names) or len(result) < len(pairs) or not all(map(all, pairs)):
        keys = f"{', '.join(names)}, then " if names else ""
        raise SettingsError(f"{option} {' '.join(arguments)}: give {keys}KEY=VALUE, each key once")
    return result


def _listed(text: str) -> Any:
    """Return the value of a key, as in a configuration: several numbers with their units are a list."""
    numbers = re.sub(r"(?<=\S)\s+(?=[+-]?\.?\d)", "\n", text.strip()).split("\n")
    is_list = len(numbers) > 1 and all(re.match(r"[+-]?\.?\d", entry) for entry in numbers)
    return None if text == "null" else numbers if is_list and ":" not in text else text


def stated_settings(options: Namespace) -> dict[str, Any]:
    """Return the settings that options state, but for bodies, by their dotted names."""
    settings = {}
    for name, value in vars(options).items():
        *above, key = name.split(".")
        if value is not None and (field := fields_at(above).get(key)):
            settings[name] = keyed(_option(name), value) if section_model(field) else value
    return settings


def initial_settings(options: Namespace) -> dict[str, Any]:
    """Return what options of `roughcontact init` state, by section."""
    settings = stated_settings(options)
    settings |= {"contact.bodies": parse_bodies(options.body)} if options.body else {}
    return grouped(settings | settings_on_form(settings))


def chosen_settings(options: Namespace) -> dict:
    """Return the full settings of a single case, as `resolve` does, from options of `add_settings`."""
    literals: dict[str, Any] = {"null": None, "['null']": None, "['[]']": []}  # as in a configuration
    config = {"contact": {}} | grouped(
        {name: literals.get(str(value), value) for name, value in stated_settings(options).items()}
    )
    if config["contact"].get("contact_modulus") is None and not options.body:
        raise SettingsError(
            "no elasticity given; give --contact-modulus (E* in Pa, or as 115GPa), or --body (a name, or E "
            "NU) twice"
        )
    if options.body:
        config["contact"]["bodies"] = parse_bodies(options.body)
    return resolve(config)[""]


def message_with_options(error: SettingsError) -> str:
    """Return the message of an error about settings as one sentence that names options."""
    return "; ".join(_name_options(mistake) for mistake in error.mistakes or (error,))


def _name_options(mistake: SettingsError) -> str:
    """Return the message of one mistake, with its settings replaced by their options."""
    names = {"contact.bodies": "--body"}
    for name in _names():
        names[name] = names[name.removeprefix("contact.")] = _option(name)  # `solve_contact` has no section
    message = str(mistake)
    if mistake.place:  # the sentence begins with the setting; other settings in it are meant as they are
        setting = "".join(mistake.keys[:1])
        return names.get(setting, setting) + message.removeprefix(setting)
    for key in mistake.keys:
        message = message.replace(key, names.get(key, key))
    return message


def _names() -> list[str]:
    """Return the dotted names of the settings of the stages that have an option."""
    names = [f"{section}.{key}" for section in _SECTIONS for key in fields_at([section])]
    return [name for name in names if name not in _WITHOUT_OPTION]


def _option(name: str) -> str:
    """Return the option of a setting: its key, and before it a section other than contact and statistics."""
    section, _, key = name.rpartition(".")
    prefix = "" if section in ("", "contact", "statistics") else f"{section}-"
    return f"--{prefix}{key.replace('_', '-')}"
