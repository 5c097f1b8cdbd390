"""What a run shows: a line for each result that is done, and below them how much of the run is done.

All else that Snakemake and the jobs report is in their logs. Of a job that has failed the sentence follows in
which its record says why, else how it was ended. Other warnings and errors are shown in full.
"""

import html
import json
import logging
import re
import shutil
import signal
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TextIO

from .clock import REPORT, Clock, duration

VARIABLE = "ROUGHCONTACT_SCREEN"  # tells the jobs that their progress is not wanted on the screen
BAR = "ROUGHCONTACT_BAR"  # tells a run that the bar is wanted though its screen is no terminal
ERASE = "\r\x1b[K"  # the line of the bar
_PREAMBLE = ("Assuming unrestricted shared filesystem", "Building DAG of jobs", "host: ")
_TURNING = re.compile("[\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")  # as in the program's own output
_BAR = 20  # characters
_PAGE = Path("results/report.html")  # which a run of single results leaves as it is
_LAST = ("panel",)  # the rule whose job is the last one of a result
_STEPS = {
    "prepare_with_overview": "prepare",
    "prepare_face": "prepare",
    "panel": "draw",
}  # of a plan, by rule


class Screen:
    """The screen of one run, fed with the records of Snakemake's logger.

    With a `bar` the last line may be written over, as on a terminal; of a dry run (`planned`) each result
    has a line of what would be done.
    """

    def __init__(self, stream: TextIO, *, bar: bool, planned: bool = False):
        self.stream, self.bar, self.planned = stream, bar and not planned, planned
        self.begun = self.announced = self.failed = False
        self.results = self.done = 0
        self.jobs: dict[int, dict[str, Any]] = {}  # the records of those that have begun
        self.failed_jobs: set[int] = set()
        self.endings: dict[int | None, str] = {}  # how the script of a job has ended, by thread
        self.clock = Clock()
        self.logs: dict[str, list[str]] = {}
        self.plans: dict[str, dict[str, None]] = {}  # steps of each result, in order
        self.page = ""

    def show(self, record: logging.LogRecord, text: str) -> None:
        """Show what one record changes; `text` is what Snakemake would show."""
        fields: dict[str, Any] = vars(record)
        event = str(fields.get("event") or "")
        if self.planned and event == "job_info":
            self._plan(fields)
        elif expected := fields.get("expected_minutes"):  # the Snakefile reports it
            self.clock.expected = dict(expected)
        elif event == "error" and "CalledProcessError" in text:
            self.endings[record.thread] = text  # the record of its job comes next, from the same thread
        elif event == "job_error":
            self._job_failed(fields)
        elif self.failed and record.levelno == logging.ERROR and _is_closing_word(fields):
            pass
        elif record.levelno >= logging.WARNING:
            self._line(text)
        elif event == "workflow_started":
            self.begun = True
        elif self.planned and text.startswith("This was a dry-run"):
            self._end_plan()
        elif event == "run_info":
            self._announce(fields.get("stats", {}))
        elif event:
            self._follow(event, fields, record.created)
        elif text.startswith("Nothing to be done") or not (self.begun or text.startswith(_PREAMBLE)):
            self._line(text.rstrip())

    def clear(self) -> None:
        """Take the bar off the screen."""
        if self.bar:
            self._write(ERASE)

    def _announce(self, stats: Mapping[str, int]) -> None:
        """Show how many jobs of each rule there are, once."""
        if self.announced:
            return
        self.announced = True
        self.clock.plan({rule: jobs for rule, jobs in stats.items() if rule != "total"})
        self.results = sum(stats.get(rule, 0) for rule in _LAST)
        results = f"{self.results} result{'s' * (self.results != 1)}, " if self.results else ""
        self._line(f"{results}{self.clock.total} job{'s' * (self.clock.total != 1)}")

    def _plan(self, fields: Mapping[str, Any]) -> None:
        """Note a job of a plan."""
        rule = fields["rule_name"]
        self.plans.setdefault(_owner(fields), {})[_STEPS.get(rule, rule)] = None

    def _end_plan(self) -> None:
        """Show what would be done for each result, its faces included, and that nothing was."""
        faces = {result: _faces(result) for result in self.plans}
        shared = {owner for result, owner in faces.items() if owner != result}
        for result, steps in self.plans.items():
            if result and result not in shared:
                self._line(f"{result}: {', '.join(self.plans.get(faces[result], {}) | steps)}")
        self._line("This is a plan: nothing was done.")

    def _follow(self, event: str, fields: dict[str, Any], now: float) -> None:
        """Show the progress of the run after an event of one of its jobs."""
        if event == "job_info":
            self._begin(fields, now)
        elif event == "job_finished":
            self.clock.finish(fields["job_id"], now)
            self._finished(self.jobs.pop(fields["job_id"], {}), now)
        elif event == "progress" and fields["done"] == fields["total"]:
            taken = duration(now - self.clock.begin)
            page = f": {self.page}" if self.page else ""
            if self.done and not page and _PAGE.exists():
                page = f"; {_PAGE} is of an earlier run: `roughcontact run` makes it anew"
            if self.done > 1 and (answer := _answer_of(self.page)):
                self._line(answer)
            self._line(f"done in {taken}{page}")
        if self.bar and self.clock.total:
            self._write(ERASE + self._bar(now))

    def _begin(self, fields: dict[str, Any], now: float) -> None:
        """Note a job that begins; of one that had failed show what it requests now."""
        number, threads = fields["jobid"], fields.get("threads") or 1
        self.jobs[number] = fields
        self.clock.start(number, fields["rule_name"], now, result=_result(fields), threads=threads)
        self.logs.setdefault(_owner(fields), []).extend(fields["log"] or [])
        self.page = next(
            (path for path in fields["output"] or [] if path.endswith("/report.html")), self.page
        )
        if number in self.failed_jobs:
            self.failed_jobs.remove(number)
            requested = _requested(fields)
            self._line(f"[{_name(fields)}] is tried again" + (f" with {requested}" if requested else ""))

    def _finished(self, fields: dict[str, Any], now: float) -> None:
        """Show the line of a result whose last job has ended; of the report only that it has warnings."""
        if not fields or fields["rule_name"] not in (*_LAST, REPORT):
            return
        result = _result(fields)
        logs = self.logs.pop(result, []) + self.logs.pop(_faces(result), [])
        warnings = sum(read_record(log).get("warnings", 0) for log in logs)
        warned = (
            f", {warnings} warning{'s' * (warnings != 1)} in its logs and in the report" if warnings else ""
        )
        if fields["rule_name"] == REPORT:
            if warned:
                self._line(f"{REPORT}: done{warned}")
            return
        self.done += 1
        left = "" if self.bar else self.clock.words(now)
        summaries = [path for path in fields["output"] or [] if path.endswith(".json")]
        answer = _json(summaries[0]).get("answer") if summaries else None
        self._line(
            f"{result}: done{warned} ({self.done} of {self.results}{left}){f'. {answer}' if answer else ''}"
        )

    def _job_failed(self, failed: dict[str, Any]) -> None:
        """Show why a job has failed: what its record says, else how it was ended, which is added to it.

        The temporary files of a killed job are removed.
        """
        self.failed = True
        number = failed["jobid"]
        if number in self.failed_jobs:  # Snakemake 9.22 lists the failed jobs once more at its end
            return
        fields = self.jobs.pop(number, failed)
        self.clock.fail(number)
        self.failed_jobs.add(number)
        for path in map(Path, failed["output"] or []):
            with suppress(OSError):
                path.with_name(f".{path.name}.partial").unlink(missing_ok=True)
        logs = fields["log"] or []
        recorded = read_record(logs[0]) if logs else {}
        if "error" in recorded:
            self._line(f"[{_name(fields)}] ERROR: {recorded['error']}")
            return
        of_cluster = [log for log in failed["log"] or [] if log not in logs]
        why = why_killed("\n".join(map(_text, of_cluster)), fields) or why_ended(
            self.endings.pop(failed["thread"], ""), fields
        )
        if why is None:
            return
        self._line(f"[{_name(fields)}] ERROR: {why}")
        for log in logs[:1]:
            with suppress(OSError):
                _record_of(log).write_text(json.dumps(recorded | {"done": False, "error": why}), "utf-8")

    def _bar(self, now: float) -> str:
        """Return the last line of a terminal: the share that is done, the time left, and the running jobs."""
        full = _BAR * self.clock.done // self.clock.total
        progress = f"{self.clock.done} of {self.clock.total} jobs{self.clock.words(now)}"
        running = ", ".join(_name(self.jobs[job]) for job in self.clock.running if job in self.jobs)
        text = f"[{'#' * full}{'-' * (_BAR - full)}] {progress}" + (f": {running}" if running else "")
        return text[: shutil.get_terminal_size().columns - 1]

    def _line(self, text: str) -> None:
        """Write a line that stays."""
        self._write(f"{ERASE if self.bar else ''}{text}\n")

    def _write(self, text: str) -> None:
        self.stream.write(_TURNING.sub(lambda mark: f"\\u{ord(mark[0]):04x}", text))
        self.stream.flush()


def why_killed(text: str, fields: Mapping[str, Any]) -> str | None:
    """Return why a cluster has killed a job, by the `text` of its log; None where it has not.

    Examples
    --------
    >>> why_killed("error: StepId=1.0 exceeded memory limit", {"resources": {"mem_mb": 900}})
    'killed, took more memory than the 900 MB it had asked for'
    """
    requested = fields.get("resources") or {}
    if re.search("exceeded .*memory limit|oom.kill", text, re.IGNORECASE):
        return f"killed, took more memory than the {requested.get('mem_mb')} MB it had asked for"
    if "DUE TO TIME LIMIT" in text:
        return f"killed, took longer than the {requested.get('runtime')} minutes it had asked for"
    return None


def why_ended(how: str, fields: Mapping[str, Any]) -> str | None:
    """Return why a script was ended that logged no error, by the error `how`; None if by Python itself.

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
        requested = (fields.get("resources") or {}).get("mem_mb")
        return (
            "killed; probably out of memory"
            + (f": it had asked for {requested} MB" if requested else "")
            + ". Free some memory, or run fewer jobs at once (--cores 1), and run again"
        )
    if by in ("SIGTERM", "SIGINT", "SIGHUP"):
        return f"was ended from outside ({by}); run again to go on"
    logs = ", ".join(fields.get("log") or [])
    return f"ended without a word ({by}); run again, and where it comes back please report it with {logs}"


def _is_closing_word(fields: Mapping[str, Any]) -> bool:
    """Return whether Snakemake reports no more than that jobs have failed, each of which was shown."""
    return fields.get("event") is None or fields.get("exception") == "WorkflowError"


def _name(fields: Mapping[str, Any]) -> str:
    """Return rule and wildcards of a job, as its script names it."""
    return " ".join([fields["rule_name"], *map(str, (fields.get("wildcards") or {}).values())])


def _result(fields: Mapping[str, Any]) -> str:
    """Return the folder of the result of a job: "soft/ground"."""
    return str((fields.get("wildcards") or {}).get("result", ""))


def _owner(fields: Mapping[str, Any]) -> str:
    """Return the result with which a job is shown: those of faces belong to the placements of the pair."""
    result = _result(fields)
    return re.sub("-(counter-)?face$", " faces", result) if fields["rule_name"] == "prepare_face" else result


def _faces(result: str) -> str:
    """Return the owner of the jobs of the faces whose placement a result may be, by the number at its end."""
    return re.sub(r"-\d+$", " faces", result)


def _requested(fields: Mapping[str, Any]) -> str:
    """Return what a job requests from a cluster."""
    resources, units = fields.get("resources") or {}, {"mem_mb": "MB", "runtime": "minutes"}
    return " and ".join(f"{resources[name]} {unit}" for name, unit in units.items() if resources.get(name))


def _text(log: str | Path) -> str:
    """Return the text of a log, empty where there is none."""
    with suppress(OSError):
        return Path(log).read_text(encoding="utf-8", errors="replace")
    return ""


def _answer_of(page: str) -> str:
    """Return the line in which a page answers for all its results; empty without one."""
    line = re.search('<p class="answer">(.*?)</p>', _text(page) if page else "")
    return html.unescape(line[1]) if line else ""


def read_record(log: str | Path) -> dict[str, Any]:
    """Return the record that a job leaves beside its log, empty where there is none."""
    return _json(_record_of(log))


def _json(path: str | Path) -> dict[str, Any]:
    """Return the object in a JSON file, empty where there is none."""
    with suppress(OSError, ValueError):
        return dict(json.loads(Path(path).read_text(encoding="utf-8")))
    return {}


def _record_of(log: str | Path) -> Path:
    return Path(log).with_suffix(".json")
