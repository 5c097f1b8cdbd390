"""What a study may ask: the fields of each question, by the names of settings and of columns of the table."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import NamedTuple

_TABLE = Path(__file__).with_name("page") / "jobs.tsv"


class Job(NamedTuple):
    """A question, in words, with what it needs."""

    question: str
    settings: list[str]  # dotted names
    columns: list[str]
    made: dict[str, str]  # settings that follow from the question


def _jobs() -> dict[str, Job]:
    """Return the jobs of the table."""
    jobs = {}
    for line in _TABLE.read_text(encoding="utf-8").splitlines()[1:]:
        key, question, names = line.split("\t")
        plain = [name for name in names.split() if "=" not in name]
        made = dict(name.split("=") for name in names.split() if "=" in name)
        settings = [name for name in plain if "." in name]
        jobs[key] = Job(question, settings, [name for name in plain if "." not in name], made)
    return jobs


JOBS = _jobs()
# loads and forms, of which a study has one kind: those of another job are set aside
_LOADS = {
    name for job in JOBS.values() for name in (*job.settings, *job.made) if not name.startswith("statist")
}


def texts_for(job: str, texts: Mapping[str, str], aside: dict[str, str], *, former: str) -> dict[str, str]:
    """Return the texts of a form for a job: loads of a former one are kept `aside` until it is back."""

    def is_among(name: str, names: Collection[str]) -> bool:
        """Return whether a field is one of these, or an entry of one that is a list."""
        return name in names or name.rpartition(".")[0] in names

    own = JOBS[job].settings
    others = [name for name in _LOADS if name not in own and ".bodies." not in name and former]
    kept = {name: text for name, text in texts.items() if not is_among(name, others)}
    aside.update({name: text for name, text in texts.items() if name not in kept and text})
    returned = {name: aside.pop(name) for name in [*aside] if is_among(name, own)}
    return kept | returned | JOBS[job].made
