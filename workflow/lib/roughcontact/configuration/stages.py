"""The stages of one surface, and which settings each one depends on.

A stage depends on its own section of the settings and on those of the stages before it. Where two cases agree
in all of them the stage is computed once, by the case that comes first. Where the fields of the contact are
not kept, contact and statistics are one stage.
"""

SECTIONS = {
    "height": (),
    "levelled": ("level",),
    "window": ("level", "window"),
    "contact": ("level", "window", "contact"),
    "uncertainty": ("level", "window", "contact", "uncertainty"),
    "statistics": ("level", "window", "contact", "uncertainty", "statistics"),
}


def settings_of(settings: dict, stage: str) -> dict:
    """Return the part of `settings` that `stage` depends on."""
    if stage == "contact" and not settings["contact"]["keep_fields"]:
        stage = "statistics"
    found = {section: settings[section] for section in SECTIONS[stage]}
    if stage == "uncertainty":  # the same with and without fields
        found["contact"] = {key: value for key, value in found["contact"].items() if key != "keep_fields"}
    return found


def owner(cases: dict[str, dict], case: str, stage: str) -> str:
    """Return the first case whose `stage` is the same as that of `case`."""
    wanted = settings_of(cases[case], stage)
    return next(name for name in cases if settings_of(cases[name], stage) == wanted)
