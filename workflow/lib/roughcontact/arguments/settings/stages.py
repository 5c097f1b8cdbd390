"""The stages of one surface, and the settings on which each one depends.

If two cases agree in those of a stage and of the stages before it, the first computes it for both. Where the
fields of the contact are not kept, contact and statistics are one stage.
"""

import hashlib
from collections.abc import Mapping
from typing import Any

from roughcontact.arguments.kinds import facts_of_settings

SECTIONS: dict[str, tuple[str, ...]] = {
    "height": (),
    "levelled": ("level",),
    "window": ("level", "window"),
    "overview": ("level", "window"),
    "contact": ("level", "window", "contact"),
    "uncertainty": ("level", "window", "contact", "uncertainty", "instrument"),
    "statistics": ("level", "window", "contact", "uncertainty", "instrument", "statistics"),
}
_COURSE = ("level", "window", "contact", "statistics", "instrument", "uncertainty")
# files that follow the contact, which no other case shares: the setting that asks for each, and its sections
AFTER = {
    "residual": ("contact", "unload", ("level", "window", "contact", "statistics")),
    "worn": ("wear", "coefficient", (*_COURSE, "wear")),
    "sliding": ("sliding", "speed", (*_COURSE, "sliding")),
}


def stages_after(settings: Mapping[str, Any]) -> list[str]:
    """Return the stages after the contact that settings ask for."""
    return [
        stage for stage, (section, key, _) in AFTER.items() if settings.get(section, {}).get(key) is not None
    ]


def stage_settings(settings: Mapping[str, Any], stage: str) -> dict[str, Any]:
    """Return the settings (section -> settings) on which a stage depends, those of `AFTER` as well."""
    # without its maps the contact and its numbers are one job
    if stage == "contact" and not settings["contact"]["keep_fields"]:
        stage = "statistics"
    sections = AFTER[stage][-1] if stage in AFTER else SECTIONS[stage]
    if "window" in sections and settings["instrument"]["correct"]:  # the window is corrected by it
        sections = tuple(dict.fromkeys([*sections, "instrument"]))
    subset = {section: settings[section] for section in sections}
    for later, names in facts_of_settings(settings).own_settings.items():
        for section, _, key in (name.partition(".") for name in names if later in sections):
            subset.setdefault(section, {key: settings[section][key]} if key else settings[section])
    # uncertainty.nc is the same with and without fields
    exclusions = {"residual": (), "uncertainty": ("unload", "keep_fields")}.get(stage, ("unload",))
    if "contact" in subset:
        subset["contact"] = {k: value for k, value in subset["contact"].items() if k not in exclusions}
    return subset


def origin_id(settings: str, source_sha256: str) -> str:
    """Return a short form of what a file records of its origin: its settings as JSON, and that checksum."""
    return hashlib.sha256(f"{settings} {source_sha256}".encode()).hexdigest()[:16]


def owner(cases: Mapping[str, Mapping[str, Any]], case: str, stage: str) -> str:
    """Return the case that computes a stage of a case: the first whose stage depends on the same settings."""
    settings_of_stage = stage_settings(cases[case], stage)
    # a case is its own owner, or an earlier one is
    return next(name for name in cases if stage_settings(cases[name], stage) == settings_of_stage)
