"""What a study may ask: the fields of each question, by the names of settings and of columns of the table."""

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
_LOADS = ("contact.mean_pressure", "contact.force", "contact.boundary", "form.radius")


def texts_for(job: str, texts: Mapping[str, str], aside: dict[str, str]) -> dict[str, str]:
    """Return the texts of a form for a job: those of another are kept `aside` until it is back."""
    aside |= {name: text for name, text in texts.items() if text and name.startswith(_LOADS)}
    of_job = [name for name in aside if name.startswith(tuple(JOBS[job].settings))]
    others = {name: text for name, text in texts.items() if not name.startswith(_LOADS)}
    return others | {name: aside.pop(name) for name in of_job} | JOBS[job].made
