"""The settings as options: `level.form` is `--level-form`, `contact.tolerance` is `--tolerance`.

Names, meanings, defaults and checks are those of `roughcontact.configuration`; nothing is said twice here.
"""

import os
import re

from roughcontact.configuration.models import Contact, Level, Uncertainty, Window, resolve
from roughcontact.errors import SettingsError

# what only the workflow needs (where fields go), or has an option of its own here
_LEFT_OUT = {"bodies", "keep_fields"}
_LISTS = {"mean_pressure": "+", "relative_pressure": "+", "sources": "*"}
_SECTIONS = {"contact": Contact, "level": Level, "window": Window, "uncertainty": Uncertainty}


def _options():
    """Yield (section, key, option, field) of every setting that is offered."""
    for section, model in _SECTIONS.items():
        for key, field in model.model_fields.items():
            if key not in _LEFT_OUT:
                prefix = "" if section == "contact" else f"{section}-"
                yield section, key, f"--{prefix}{key.replace('_', '-')}", field


def add_settings(parser) -> None:
    """Add the options to the parser of `roughcontact solve`."""
    groups = {
        "contact": parser.add_argument_group("contact (give --contact-modulus or --body twice)"),
        "level": parser.add_argument_group("levelling"),
        "window": parser.add_argument_group("periodic window"),
        "uncertainty": parser.add_argument_group("error budget, the ± of the numbers"),
    }
    for section, key, option, field in _options():
        text = field.description.split("; give this")[0]
        default = field.get_default(call_default_factory=True)
        if default is not None:
            shown = " ".join(default) if isinstance(default, list) else str(default)
            text += f" (default: {shown.lower() if isinstance(default, bool) else shown})"
        words = {"nargs": _LISTS[key]} if key in _LISTS else {}
        groups[section].add_argument(
            option, dest=f"{section}.{key}", metavar="VALUE", help=text.replace("%", "%%"), **words
        )
    groups["contact"].add_argument(
        "--body",
        nargs=2,
        action="append",
        metavar=("E", "NU"),
        help="Young's modulus (Pa) and Poisson's ratio of one body; give it twice",
    )
    parser.add_argument(
        "--threads",
        type=int,
        default=min(4, os.cpu_count() or 1),
        metavar="NUMBER",
        help="threads of the solve (default: %(default)s)",
    )


def chosen_settings(options) -> dict:
    """Return the full settings that the options stand for.

    Raises
    ------
    SettingsError
        for values that the settings do not take.
    """
    config = {section: {} for section in _SECTIONS}
    for section, key, _, _ in _options():
        value = getattr(options, f"{section}.{key}")
        if value is not None:
            config[section][key] = None if value == "null" else value
    if config["contact"].get("contact_modulus") is None and not options.body:
        raise SettingsError("no elasticity given; give --contact-modulus (E* in Pa), or --body E NU twice")
    if options.body:
        if len(options.body) != 2:
            raise SettingsError(
                f"--body is given {len(options.body)} times; give it twice, one for each body"
            )
        names = ("youngs_modulus", "poissons_ratio")
        config["contact"]["bodies"] = [dict(zip(names, body, strict=True)) for body in options.body]
    return resolve(config)[""]


def in_options(message: str) -> str:
    """Return a message about settings as one sentence that speaks of options."""
    _, _, text = message.rpartition("mistakes in the settings:\n")
    text = "; ".join(line.strip() for line in text.split("\n"))
    for section, key, option, _ in _options():
        text = re.sub(rf"\b{section}\.{key}\b", option, text)
        if section == "contact":
            text = re.sub(rf"(?<![-\w])(?:contact: )?{key}\b(?!-)", option, text)
    return re.sub(r"\bcontact: ", "", re.sub(r"\b(contact\.)?bodies\b", "--body", text))
