"""The commands of the terminal that the page starts: the run, whose screen is a file, and exports."""

import os
import shlex
import sys
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from subprocess import DEVNULL, STDOUT, Popen, run
from typing import Any

from roughcontact.arguments.settings.stages import AFTER, origin_id, stages_after
from roughcontact.errors import InputFileError, SettingsError
from roughcontact.interface.app.measurements import READING
from roughcontact.interface.app.study import check_within_study
from roughcontact.interface.command_line.saving import EXPORTS
from roughcontact.report.summary import Summary, read_summary
from roughcontact.results.storage import read_attributes
from roughcontact.study.checksums import checksum
from roughcontact.study.plan import Plan, split
from snakemake_logger_plugin_roughcontact.screen import BAR, ERASE

RESULTS = Path("results")
_PROGRAM = [sys.executable, "-P", "-m", "roughcontact.interface"]  # -P: the study is data, not code
_SCREEN = Path("logs/page.log")
_WIDEST = "400"  # characters of the bar


class Run:
    """The run that the page has started, if any."""

    process: Popen | None = None

    def start(self) -> None:
        """Start the command, unless it is at work."""
        if self.state()["running"]:
            return
        check_within_study(RESULTS, _SCREEN.parent, Path(".snakemake"))
        _SCREEN.parent.mkdir(exist_ok=True)
        _SCREEN.unlink(missing_ok=True)
        with _SCREEN.open("xb") as screen:
            env = os.environ | {BAR: "1", "COLUMNS": _WIDEST, "PYTHONUNBUFFERED": "1"}
            self.process = Popen([*_PROGRAM, "run"], env=env, stdin=DEVNULL, stdout=screen, stderr=STDOUT)

    def cancel(self) -> None:
        """Terminate the command, if any: it ends its jobs, and wait for its end; what is finished stays."""
        if self.process:
            self.process.terminate()
            self.process.wait()

    def state(self) -> dict[str, Any]:
        """Return how the run stands, the lines of its screen, and the last one with the time left."""
        code = self.process.poll() if self.process else None
        written = _SCREEN.read_bytes().decode(errors="replace") if _SCREEN.is_file() else ""
        *lines, bar = [line.rpartition(ERASE)[2] for line in written.split("\n")]
        is_running = self.process is not None and code is None
        return {"running": is_running, "code": code, "lines": lines, "bar": bar}


def panels(plan: Plan | None) -> dict[str, Path]:
    """Return the panel of each result of a plan, in the order of the table; of no plan, those of all."""
    paths = {panel.parent.relative_to(RESULTS).as_posix(): panel for panel in RESULTS.rglob("panel.json")}
    return {name: paths[name] for name in (sorted(paths) if plan is None else plan.results) if name in paths}


def results(plan: Plan | None) -> dict[str, tuple[Mapping[str, Any], bool]]:
    """Return the summary of each result, and whether it is of the settings and measured files of the plan.

    Of a damaged one, or of another version, what is wrong is the answer.
    """
    values: dict[str, tuple[Mapping[str, Any], bool]] = {}
    for name, panel in panels(plan).items():
        summary: Mapping[str, Any]
        try:
            summary = read_summary(panel)
        except InputFileError as error:
            summary = dict.fromkeys(Summary.__annotations__, "") | {"answer": str(error)}
        values[name] = summary, plan is not None and _is_of_plan(plan, name, panel)
    return values


def _is_of_plan(plan: Plan, name: str, panel: Path) -> bool:
    """Return whether the files of a result that its answer is made of are those of a plan."""
    planned = {"statistics", *stages_after(plan.cases[split(name)[0]])}
    expected = {stage: plan.origin(stage, name, checksum) for stage in planned}
    date = panel.stat().st_mtime_ns
    origins = {stage: _origin(panel.with_name(f"{stage}.nc"), date) for stage in ("statistics", *AFTER)}
    return {stage: origin for stage, origin in origins.items() if origin} == expected


@cache
def _origin(path: Path, _: int) -> str:
    """Return the origin of a result of a given age; empty where it cannot be read."""
    with suppress(OSError, ValueError), READING:
        attrs = read_attributes(path)
        return origin_id(str(attrs.get("settings")), str(attrs.get("source_sha256")))
    return ""


def export(result: str, form: str, previous: str, *, plan: Plan | None) -> tuple[Path, str]:
    """Make one of `EXPORTS` of one of the results; return its file and what a terminal shows.

    The file is the working directory where it has none.
    """
    if not {result, previous} <= panels(plan).keys() or form not in EXPORTS:
        raise SettingsError(f"{result}, {previous}, {form}: are no results of this study, or no form of them")
    paths = {"folder": RESULTS / result, "before": RESULTS / previous}
    paths["output"] = Path("exports", result.replace("/", "-"))
    arguments = [word.format(**paths) for word in EXPORTS[form][1].split()]
    check_within_study(RESULTS, Path("exports"))
    process = run([*_PROGRAM, *arguments], capture_output=True, text=True, check=False)
    command = shlex.join(["roughcontact", *arguments])
    file = Path(*arguments[arguments.index("-o") + 1 :]) if "-o" in arguments else Path()
    return file, f"{command}\n\n{process.stdout}{process.stderr}"
