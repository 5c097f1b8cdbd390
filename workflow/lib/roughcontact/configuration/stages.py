"""The stages of one surface, and the settings on which each one depends.

If two cases agree in those of a stage and of the stages before it, the first computes it for both. Where the
fields of the contact are not kept, contact and statistics are one stage.
"""

from collections.abc import Mapping
from typing import Any

SECTIONS: dict[str, tuple[str, ...]] = {
    "height": (),
    "levelled": ("level",),
    "window": ("level", "window"),
    "contact": ("level", "window", "contact"),
    "uncertainty": ("level", "window", "contact", "uncertainty", "instrument"),
    "statistics": ("level", "window", "contact", "uncertainty", "instrument", "statistics"),
}
_RESIDUAL = ("level", "window", "contact", "statistics")  # of residual.nc, which no other case shares


def settings_of(settings: Mapping[str, Any], stage: str) -> dict[str, Any]:
    """Return the settings (section -> settings) on which a stage, of `SECTIONS` or "residual", depends."""
    if stage == "contact" and not settings["contact"]["keep_fields"]:
        stage = "statistics"
    sections = _RESIDUAL if stage == "residual" else SECTIONS[stage]
    if "window" in sections and settings["instrument"]["correct"]:  # the window is corrected by it
        sections = tuple(dict.fromkeys([*sections, "instrument"]))
    selected = {section: settings[section] for section in sections}
    if "window" in sections and settings["contact"]["boundary"] == "free":
        selected |= {"form": settings["form"], "contact": selected.get("contact", {"boundary": "free"})}
    if "contact" in sections and settings["form"]["local_scale"]:
        selected["form"] = settings["form"]
    # uncertainty.nc is the same with and without fields
    omitted = {"residual": (), "uncertainty": ("unload", "keep_fields")}.get(stage, ("unload",))
    if "contact" in selected:
        selected["contact"] = {k: value for k, value in selected["contact"].items() if k not in omitted}
    return selected


def owner(cases: Mapping[str, Mapping[str, Any]], case: str, stage: str) -> str:
    """Return the case that computes a stage of a case: the first whose stage depends on the same settings."""
    required = settings_of(cases[case], stage)
    return next(name for name in cases if settings_of(cases[name], stage) == required)
