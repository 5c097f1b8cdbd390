"""What a run shows: a line for each surface that is done, and below them how far the whole has come.

All else that Snakemake and the jobs say is in their logs. Of a job that has failed the sentence comes in
which its log says why, else how it was ended. Other warnings and errors come in full.
"""

import logging
import re
import shutil
import signal
import time
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TextIO

VARIABLE = "ROUGHCONTACT_SCREEN"  # tells the jobs that their progress is not wanted on the screen
ERASE = "\r\x1b[K"  # the line of the bar
_PREAMBLE = ("Assuming unrestricted shared filesystem", "Building DAG of jobs", "host: ")
_BAR = 20  # characters
_LAST = "contact"  # what the last job of a surface does
# seconds of a job, and those by minute of the plan and thread, as measured; the plan has upper limits
_START = {"prepare": 3.0}
_START_OF_OTHERS, _PER_MINUTE = 6.0, 1.0
# (kind, surface, case) -> minutes of the plan, threads: the Snakefile tells it, in the process of the screen
EXPECTED: dict[tuple[str, str, str], tuple[float, int]] = {}


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


def _usual(kind: str, minutes: float) -> float:
    """Return the time that a job usually takes, s."""
    return _START.get(kind, _START_OF_OTHERS) + _PER_MINUTE * minutes


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
        self.begun = self.told = self.failed = False
        self.results = self.done = 0  # of surfaces, under each case where there are cases
        self.jobs: dict[int, dict[str, Any]] = {}  # what was said of those that have begun
        self.again: set[int] = set()  # jobs that have failed
        self.ended: dict[int | None, str] = {}  # how the script of a job has ended, by thread
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
        if event == "error" and "CalledProcessError" in text:
            self.ended[record.thread] = text  # the record of its job comes next, from the same thread
        elif event == "job_error":
            self._job_failed(record)
        elif self.failed and record.levelno == logging.ERROR and _is_closing_word(record):
            pass
        elif record.levelno >= logging.WARNING:
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
        stats: dict[str, int] = getattr(record, "stats", {})
        self.clock.plan({name: jobs for name, jobs in stats.items() if name != "total"})
        self.results = sum(jobs for name, jobs in stats.items() if _kind(name) == _LAST)
        if self.planned:
            self._line(text.rstrip())
        results = f"{self.results} result{'s' * (self.results != 1)}, " if self.results else ""
        self._line(f"{results}{self.clock.total} jobs")

    def _follow(self, event: str, record: logging.LogRecord) -> None:
        """Show how far the run has come after an event of one of its jobs."""
        fields: dict[str, Any] = vars(record)
        if event == "job_info":
            self._begin(fields, record.created)
        elif event == "job_finished":
            self.clock.finish(fields["job_id"], record.created)
            self._finished(self.jobs.pop(fields["job_id"], {}), record.created)
        elif event == "progress" and fields["done"] == fields["total"]:
            taken = duration(record.created - self.clock.begin)
            self._line(f"done in {taken}" + (f": {self.page}" if self.page else ""))
        if self.bar and self.clock.total:
            self._write(ERASE + self._bar(record.created))

    def _begin(self, fields: dict[str, Any], now: float) -> None:
        """Take note of a job that begins; of one that had failed show what it asks for now."""
        number = fields["jobid"]
        self.jobs[number] = fields
        of = fields["wildcards"] or {}
        which = {name: str(of.get(name, "")) for name in ("surface", "case")}
        self.clock.start(number, fields["rule_name"], now, threads=fields.get("threads") or 1, **which)
        self.logs.setdefault(_row(fields), []).extend(fields["log"] or [])
        self.page = next(
            (path for path in fields["output"] or [] if path.endswith("/report.html")), self.page
        )
        if number in self.again:
            self.again.remove(number)
            asked = _asked(fields)
            self._line(f"[{_name(fields)}] is tried again" + (f" with {asked}" if asked else ""))

    def _finished(self, fields: dict[str, Any], now: float) -> None:
        """Show the line of a surface whose last job has ended."""
        if not fields or _kind(fields["rule_name"]) != _LAST:
            return
        self.done += 1
        said = sum(_warnings(path) for path in self.logs.pop(_row(fields), []))
        warned = f", {said} warning{'s' * (said != 1)} in its logs and in the report" if said else ""
        left = "" if self.bar else self.clock.words(now)
        self._line(f"{_of(fields)}: done{warned} ({self.done} of {self.results}{left})")

    def _job_failed(self, record: logging.LogRecord) -> None:
        """Show why a job has failed: what its log says, else how it was ended, which is written there.

        What it was writing when it was killed is taken away.
        """
        self.failed = True
        failed: dict[str, Any] = vars(record)
        number = failed["jobid"]
        if number in self.again:  # Snakemake 9.22 lists the failed jobs once more at its end
            return
        fields = self.jobs.pop(number, failed)
        self.clock.fail(number)
        self.again.add(number)
        for path in map(Path, failed["output"] or []):
            with suppress(OSError):
                path.with_name(f".{path.name}.partial").unlink(missing_ok=True)
        own = fields["log"] or []
        if said := [line for log in own for line in _errors(_text(log))]:
            self._line("\n".join(said))
            return
        aside = [log for log in failed["log"] or [] if log not in own]  # those that a cluster keeps
        why = why_killed("\n".join(map(_text, aside)), fields) or why_ended(
            self.ended.pop(record.thread, ""), fields
        )
        if why is None:
            return
        line = f"[{_name(fields)}] ERROR: {why}"
        self._line(line)
        for log in own[:1]:
            with suppress(OSError), Path(log).open("a", encoding="utf-8") as file:
                file.write(f"{line}\n")

    def _bar(self, now: float) -> str:
        """Return the last line of a terminal: what share is done, the time left, and what is at work."""
        full = _BAR * self.clock.done // self.clock.total
        far = f"{self.clock.done} of {self.clock.total} jobs{self.clock.words(now)}"
        at_work = ", ".join(
            f"{kind} {_of(self.jobs.get(job, {}))}".strip() for job, (kind, _) in self.clock.running.items()
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
        self.taken: dict[str, list[tuple[float, float]]] = {}  # minutes of the plan by thread, seconds
        self.running: dict[int, tuple[str, float]] = {}
        self.minutes: dict[int, float] = {}  # of the plan by thread, of those that have begun
        self.threads: dict[int, int] = {}
        self.open = dict[tuple[str, str, str], tuple[float, int]]()  # both, of those that have not begun

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

    def start(
        self, job: int, rule: str, now: float, *, surface: str = "", case: str = "", threads: int = 1
    ) -> None:
        """Take note of a job that begins.

        Parameters
        ----------
        job : int
            its number.
        rule : str
            what it does.
        now : float, s
        surface, case : str
            of what.
        threads : int
            that it takes.
        """
        if not self.minutes:
            self.open = dict(EXPECTED)
        self.running[job], self.threads[job] = (_kind(rule), now), threads
        known = self.minutes.get(job, 0.0) * threads, 1  # of one that is tried again
        self.minutes[job] = self.open.pop((_kind(rule), surface, case), known)[0] / threads
        self.width = max(self.width, sum(self.threads[each] for each in self.running))

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
        self.taken.setdefault(kind, []).append((self.minutes[job], now - begin))

    def fail(self, job: int) -> None:
        """Take note of a job that has failed: it is to be done still, or never.

        Parameters
        ----------
        job : int
            its number.
        """
        self.running.pop(job, None)

    def seconds(self, now: float) -> float | None:
        """Return the time that is left, from the jobs that have ended.

        Of each kind by a line of time over minutes of the plan, which is near the usual one, scaled to this
        computer, as long as few have ended.

        Parameters
        ----------
        now : float, s

        Returns
        -------
        float or None, s
            None where none has ended.
        """
        ended = [(kind, *each) for kind, times in self.taken.items() for each in times]
        if not ended:
            return None
        slower = sum(took for *_, took in ended) / sum(_usual(kind, minutes) for kind, minutes, _ in ended)
        share = longest = alone = 0.0
        for kind, jobs in self.left.items():
            line = self._line(kind, slower)
            begun = {job: now - begin for job, (of, begin) in self.running.items() if of == kind}
            # one that takes longer than expected is not said to end at once; time, threads
            rest = [
                (max(line(self.minutes[job]) - so_far, so_far / 4), self.threads[job])
                for job, so_far in begun.items()
            ]
            known = [each for (of, *_), each in self.open.items() if of == kind] or [(0.0, 1)]
            waiting = max(jobs - len(begun), 0)
            few = [(minutes, max(min(threads, self.width), 1)) for minutes, threads in known]
            each_of_them = [(line(minutes / threads), threads) for minutes, threads in few]
            used = sum(t * n for t, n in rest)
            used += waiting * sum(t * n for t, n in each_of_them) / len(known)
            most = max(t for t, _ in [(0.0, 1), *rest, *(each_of_them if waiting else ())])
            if kind in ("prepare", _LAST):
                share, longest = share + used, max(longest, most)
            else:  # one for all surfaces, at the end
                alone += most
        return max(share / max(self.width, 1), longest) + alone

    def _line(self, kind: str, slower: float) -> Callable[[float], float]:
        """Return the function from minutes of the plan to the seconds that a job takes here."""
        start, rise = slower * _START.get(kind, _START_OF_OTHERS), slower * _PER_MINUTE
        # least squares: times scatter by a quarter; usual values within a half (start) and all (rise)
        # by what was expected: weights of the times themselves would favour those that are short by chance
        ended = [
            (16 / max(slower * _usual(kind, minutes), 1.0) ** 2, minutes, took)
            for minutes, took in self.taken.get(kind, ())
        ]
        of_start, of_rise = 4 / start**2, 1 / rise**2
        ones, minutes = of_start + sum(w for w, *_ in ended), sum(w * m for w, m, _ in ended)
        squares = of_rise + sum(w * m * m for w, m, _ in ended)
        times = of_start * start + sum(w * took for w, _, took in ended)
        products = of_rise * rise + sum(w * m * took for w, m, took in ended)
        slope = max((products * ones - times * minutes) / (ones * squares - minutes**2), 0.0)
        begin = max((times - slope * minutes) / ones, 0.0)
        return lambda minutes: begin + slope * minutes

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


def why_killed(text: str, fields: Mapping[str, Any]) -> str | None:
    """Return why a cluster has killed a job.

    Parameters
    ----------
    text : str
        the log that the cluster keeps of it.
    fields : mapping
        what Snakemake said of the job when it began.

    Returns
    -------
    str or None
        None where the cluster has not killed it.

    Examples
    --------
    >>> why_killed("error: StepId=1.0 exceeded memory limit", {"resources": {"mem_mb": 900}})
    'killed, took more memory than the 900 MB it had asked for'
    """
    asked = fields.get("resources") or {}
    if re.search("exceeded .*memory limit|oom.kill", text, re.IGNORECASE):
        return f"killed, took more memory than the {asked.get('mem_mb')} MB it had asked for"
    if "DUE TO TIME LIMIT" in text:
        return f"killed, took longer than the {asked.get('runtime')} minutes it had asked for"
    return None


def why_ended(how: str, fields: Mapping[str, Any]) -> str | None:
    """Return why a script was ended that has not said it itself.

    Parameters
    ----------
    how : str
        the error that Python raised for its process.
    fields : mapping
        what Snakemake said of the job when it began.

    Returns
    -------
    str or None
        None where it has ended by an error of Python, or nobody knows how.

    Examples
    --------
    >>> why_ended("died with <Signals.SIGTERM: 15>.", {})
    'was ended from outside (SIGTERM); run again to go on'
    """
    status = re.search(r"<Signals\.(\w+)|exit status (\d+)", how)
    if status is None or status[2] == "1":
        return None
    by = status[1] or f"status {status[2]}"
    if status[2] and int(status[2]) > 128:  # a shell in between reports a signal
        with suppress(ValueError):
            by = signal.Signals(int(status[2]) - 128).name
    if by == "SIGKILL":
        asked = (fields.get("resources") or {}).get("mem_mb")
        return (
            "killed; probably out of memory"
            + (f": it had asked for {asked} MB" if asked else "")
            + ". Free some memory, or run fewer jobs at once (--cores 1), and run again"
        )
    if by in ("SIGTERM", "SIGINT", "SIGHUP"):
        return f"was ended from outside ({by}); run again to go on"
    logs = ", ".join(fields.get("log") or [])
    return f"ended without a word ({by}); run again, and where it comes back please report it with {logs}"


def _is_closing_word(record: logging.LogRecord) -> bool:
    """Return whether Snakemake says no more than that jobs have failed, each of which was shown."""
    return getattr(record, "event", None) is None or getattr(record, "exception", "") == "WorkflowError"


def _name(fields: Mapping[str, Any]) -> str:
    """Return rule and wildcards of a job, as its script names it."""
    return " ".join([fields["rule_name"], *map(str, (fields.get("wildcards") or {}).values())])


def _of(fields: Mapping[str, Any]) -> str:
    """Return the surface of a job, and its case where there are cases."""
    wildcards = fields.get("wildcards") or {}
    return " ".join(str(wildcards[name]) for name in ("surface", "case") if name in wildcards)


def _row(fields: Mapping[str, Any]) -> str:
    """Return the row of the table that a job works for: of parts of a pair the pair."""
    name = str((fields.get("wildcards") or {}).get("surface", ""))
    if fields["rule_name"].endswith("_face"):
        return re.sub("-(counter-)?face$", "", name)
    return re.sub(r"-\d+$", "", name) if fields["rule_name"].endswith("_member") else name


def _asked(fields: Mapping[str, Any]) -> str:
    """Return what a job asks for of a cluster."""
    asked = fields.get("resources") or {}
    units = {"mem_mb": "MB", "runtime": "minutes"}
    return " and ".join(f"{asked.get(name)} {unit}" for name, unit in units.items() if asked.get(name))


def _kind(rule: str) -> str:
    """Return what a rule does, without what it does it for."""
    return rule.partition("_")[0]


def _text(log: str | Path) -> str:
    """Return what a log says, nothing where there is none."""
    try:
        return Path(log).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def _warnings(log: str) -> int:
    """Return how often a job has warned the user."""
    return len(re.findall(r"^\[.*?\] warning: ", _text(log), re.MULTILINE))


def _errors(text: str) -> list[str]:
    """Return the lines by which a script has said why it failed."""
    return re.findall(r"^\[.*?\] ERROR: .+$", text, re.MULTILINE)
