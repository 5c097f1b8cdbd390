"""What a run shows: a line for each surface that is done, and below them how far the whole has come.

All else that Snakemake and the jobs say is in their logs. Warnings and errors come in full.
"""

import logging
import re
import shutil
import time
from collections import Counter
from pathlib import Path
from typing import Any, TextIO

VARIABLE = "ROUGHCONTACT_SCREEN"  # tells the jobs that their progress is not wanted on the screen
ERASE = "\r\x1b[K"  # the line of the bar
_PREAMBLE = ("Assuming unrestricted shared filesystem", "Building DAG of jobs", "host: ")
_BAR = 20  # characters


def duration(seconds: float) -> str:
    """Return a time as people say it.

    Parameters
    ----------
    seconds : float, s

    Returns
    -------
    str

    Examples
    --------
    >>> duration(0.2), duration(44.0), duration(100.0), duration(3000.0), duration(9000.0)
    ('1 s', '44 s', '2 min', '50 min', '2.5 h')
    """
    if seconds < 60:
        return f"{max(seconds, 1):.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


class Screen:
    """The screen of one run, fed with the records of Snakemake's logger.

    Parameters
    ----------
    stream : TextIO
        where to write.
    bar : bool
        whether the last line may be written over, as on a terminal.
    planned : bool
        whether this is a dry run, which shows what would be done and why.
    """

    def __init__(self, stream: TextIO, *, bar: bool, planned: bool = False):
        self.stream, self.bar, self.planned = stream, bar, planned
        self.begun = self.told = False
        self.surfaces: dict[int, str] = {}  # of jobs
        self.waiting: Counter[str] = Counter()  # jobs of each surface
        self.count = 0  # of surfaces that have any
        self.clock = Clock()
        self.logs: dict[str, list[str]] = {}
        self.page = ""

    def show(self, record: logging.LogRecord, text: str) -> None:
        """Show what one record changes.

        Parameters
        ----------
        record : LogRecord
            of Snakemake's logger.
        text : str
            as Snakemake would show it.
        """
        event = str(getattr(record, "event", None) or "")
        if record.levelno >= logging.WARNING:
            self._line(text)
        elif event == "workflow_started":
            self.begun = True
        elif event == "run_info":
            self._plan(record, text)
        elif not event:
            self._say(text)
        elif not self.planned:
            self._follow(event, record)

    def clear(self) -> None:
        """Take the bar off the screen."""
        if self.bar:
            self._write(ERASE)

    def _say(self, text: str) -> None:
        """Show a word without an event: before the run begins what was asked for, then little."""
        wanted = text.startswith("Nothing to be done") or (self.planned and text.startswith("Reasons:"))
        if wanted or not (self.begun or text.startswith(_PREAMBLE)):
            self._line(text.rstrip())

    def _plan(self, record: logging.LogRecord, text: str) -> None:
        """Take note of what there is to do; a dry run shows it."""
        if self.told:  # a dry run says it before and after
            return
        self.told = True
        self.surfaces = getattr(record, "surfaces", {})
        self.waiting = Counter(self.surfaces.values())
        self.count = len(self.waiting)
        stats: dict[str, int] = getattr(record, "stats", {})
        self.clock.plan({name: jobs for name, jobs in stats.items() if name != "total"})
        if self.planned:
            self._line(text.rstrip())
        surfaces = f"{self.count} surface{'s' * (self.count != 1)}, " if self.count else ""
        self._line(f"{surfaces}{self.clock.total} jobs")

    def _follow(self, event: str, record: logging.LogRecord) -> None:
        """Show how far the run has come after an event of one of its jobs."""
        fields: dict[str, Any] = vars(record)
        if event == "job_info":
            self.clock.start(fields["jobid"], fields["rule_name"], record.created)
            name = self.surfaces.get(fields["jobid"], "")
            self.logs.setdefault(name, []).extend(fields["log"] or [])
            self.page = next(
                (path for path in fields["output"] or [] if path.endswith("/report.html")), self.page
            )
        elif event == "job_finished":
            self.clock.finish(fields["job_id"], record.created)
            self._finished(self.surfaces.pop(fields["job_id"], ""), record.created)
        elif event == "progress" and fields["done"] == fields["total"]:
            taken = duration(record.created - self.clock.begin)
            self._line(f"done in {taken}" + (f": {self.page}" if self.page else ""))
        if self.bar and self.clock.total:
            self._write(ERASE + self._bar(record.created))

    def _finished(self, name: str, now: float) -> None:
        """Show the line of a surface whose last job has ended."""
        if not name:  # a job for all surfaces
            return
        self.waiting[name] -= 1
        if self.waiting[name]:
            return
        del self.waiting[name]
        said = sum(_warnings(path) for path in self.logs.pop(name, []))
        warned = f", {said} warning{'s' * (said != 1)} in its logs and in the report" if said else ""
        far = f"{self.count - len(self.waiting)} of {self.count}"
        left = "" if self.bar else self.clock.words(now)
        self._line(f"{name}: done{warned} ({far}{left})")

    def _bar(self, now: float) -> str:
        """Return the last line of a terminal: what share is done, the time left, and what is at work."""
        full = _BAR * self.clock.done // self.clock.total
        far = f"{self.clock.done} of {self.clock.total} jobs{self.clock.words(now)}"
        at_work = ", ".join(
            f"{stem} {self.surfaces.get(job, '')}".strip() for job, (stem, _) in self.clock.running.items()
        )
        text = f"[{'#' * full}{'-' * (_BAR - full)}] {far}" + (f": {at_work}" if at_work else "")
        return text[: shutil.get_terminal_size().columns - 1]

    def _line(self, text: str) -> None:
        """Write a line that stays."""
        self._write(f"{ERASE if self.bar else ''}{text}\n")

    def _write(self, text: str) -> None:
        self.stream.write(text)
        self.stream.flush()


class Clock:
    """How long the jobs of a run take, and how long those will that are left."""

    def __init__(self) -> None:
        self.begin = time.time()
        self.total = self.done = self.width = 0
        self.left: Counter[str] = Counter()  # jobs of each kind, those at work among them
        self.taken: dict[str, list[float]] = {}
        self.running: dict[int, tuple[str, float]] = {}

    def plan(self, jobs: dict[str, int]) -> None:
        """Take note of how many jobs of each rule there are.

        Parameters
        ----------
        jobs : dict
            rule -> number of its jobs.
        """
        for rule, count in jobs.items():
            self.left[_kind(rule)] += count
        self.total = sum(jobs.values())

    def start(self, job: int, rule: str, now: float) -> None:
        """Take note of a job that begins.

        Parameters
        ----------
        job : int
            its number.
        rule : str
            what it does.
        now : float, s
        """
        self.running[job] = (_kind(rule), now)
        self.width = max(self.width, len(self.running))

    def finish(self, job: int, now: float) -> None:
        """Take note of a job that has ended.

        Parameters
        ----------
        job : int
            its number.
        now : float, s
        """
        self.done += 1
        if job not in self.running:  # a target, which does nothing
            return
        kind, begin = self.running.pop(job)
        self.left[kind] -= 1
        self.taken.setdefault(kind, []).append(now - begin)

    def seconds(self, now: float) -> float | None:
        """Return the time that is left, from the jobs of each kind that have ended.

        Parameters
        ----------
        now : float, s

        Returns
        -------
        float or None, s
            None where none has ended.
        """
        ended = [each for times in self.taken.values() for each in times]
        if not ended:
            return None
        means = {kind: sum(times) / len(times) for kind, times in self.taken.items()}
        usual = sum(ended) / len(ended)
        left = sum(jobs * means.get(kind, usual) for kind, jobs in self.left.items())
        at_work = (min(now - begin, means.get(kind, usual)) for kind, begin in self.running.values())
        return max(left - sum(at_work), 0) / max(self.width, 1)

    def words(self, now: float) -> str:
        """Return the time that is left as part of a line; nothing where it is not known.

        Parameters
        ----------
        now : float, s

        Returns
        -------
        str
        """
        seconds = self.seconds(now)
        return f", about {duration(seconds)} left" if seconds and self.done < self.total else ""


def _kind(rule: str) -> str:
    """Return what a rule does, without the case it does it for."""
    return rule.partition("_")[0]


def _warnings(log: str) -> int:
    """Return how often a job has warned the user."""
    try:
        text = Path(log).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return 0
    return len(re.findall(r"^\[.*?\] warning: ", text, re.MULTILINE))
