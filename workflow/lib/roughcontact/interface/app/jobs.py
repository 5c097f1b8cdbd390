"""What a study may ask: the fields of each question, by the names of settings and of columns of the table."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import yaml


@dataclass(frozen=True)
class Job:
    """A question, in words, with what it needs."""

    question: str
    settings: list[str]  # dotted names
    columns: list[str] = field(default_factory=list)
    made: dict[str, str] = field(default_factory=dict)  # settings that follow from the question


_MATERIALS = ["contact.bodies.0.material", "contact.bodies.1.material"]
_FILE = Path(__file__).with_name("page") / "jobs.yaml"
JOBS = {
    key: Job(**(job | {"settings": _MATERIALS + job["settings"]}))
    for key, job in yaml.safe_load(_FILE.read_text(encoding="utf-8")).items()
}
# loads and forms, of which a study has one kind: those of another job are set aside
_LOADS = {
    name
    for job in JOBS.values()
    for name in (*job.settings, *job.made)
    if "bodies" not in name and not name.startswith("statist")
}


def texts_for(job: str, texts: Mapping[str, str], aside: dict[str, str], *, former: str) -> dict[str, str]:
    """Return the texts of a form for a job: loads of a former one are kept `aside` until it is back."""
    others = _LOADS - {*JOBS[job].settings} if former else {*()}
    aside |= {name: text for name, text in texts.items() if text and _listed(name) in others}
    returned = [name for name in aside if _listed(name) not in others]
    kept_texts = {name: text for name, text in texts.items() if _listed(name) not in others}
    return kept_texts | {name: aside.pop(name) for name in returned} | JOBS[job].made


def _listed(name: str) -> str:
    """Return the name of a field, of an entry of a list that of the list."""
    return re.sub(r"\.\d+$", "", name)
