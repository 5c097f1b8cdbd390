"""The commands of the terminal that the page starts: the run, whose screen is a file, and exports."""

import os
import shlex
import sys
from collections.abc import Collection
from pathlib import Path
from subprocess import DEVNULL, STDOUT, Popen, run
from typing import Any

from roughcontact.command_line.saving import EXPORTS
from roughcontact.errors import SettingsError
from roughcontact.report.summary import Summary, read_summary
from snakemake_logger_plugin_roughcontact.screen import BAR, ERASE

RESULTS = Path("results")
_PROGRAM = [sys.executable, "-m", "roughcontact.command_line"]
_SCREEN = Path("logs/page.log")
_WIDEST = "400"  # characters of the bar


class Run:
    """The run that the page has started, if any."""

    process: Popen | None = None

    def start(self) -> None:
        """Start the command, unless it is at work."""
        if self.running():
            return
        _SCREEN.parent.mkdir(exist_ok=True)
        with _SCREEN.open("wb") as screen:
            env = os.environ | {BAR: "1", "COLUMNS": _WIDEST, "PYTHONUNBUFFERED": "1"}
            self.process = Popen([*_PROGRAM, "run"], env=env, stdin=DEVNULL, stdout=screen, stderr=STDOUT)

    def cancel(self) -> None:
        """Terminate the command, which ends its jobs, and wait for its end; what is finished stays."""
        if self.process and self.running():
            self.process.terminate()
            self.process.wait()

    def running(self) -> bool:
        """Return whether the command is at work."""
        return self.process is not None and self.process.poll() is None

    def state(self) -> dict[str, Any]:
        """Return how the run stands, the lines of its screen, and the last one with the time left."""
        code = self.process.poll() if self.process else None
        written = _SCREEN.read_bytes().decode(errors="replace") if _SCREEN.is_file() else ""
        *lines, bar = [line.rpartition(ERASE)[2] for line in written.split("\n")]
        return {"running": self.running(), "code": code, "lines": lines, "bar": bar}


def results(names: Collection[str] | None) -> dict[str, Summary]:
    """Return the summary of each result that has one of some names; of any where these are not known."""
    panels = {
        panel.parent.relative_to(RESULTS).as_posix(): panel for panel in sorted(RESULTS.rglob("panel.json"))
    }
    return {name: read_summary(panel) for name, panel in panels.items() if names is None or name in names}


def export(result: str, form: str, before: str, *, names: Collection[str] | None) -> tuple[str, str]:
    """Make one of `EXPORTS` of one of the results; return the command that does it, and what it says."""
    if not {result, before} <= {*results(names)} or form not in EXPORTS:
        raise SettingsError(f"{result}, {before}, {form}: are no results of this study, or no form of them")
    names = {"folder": RESULTS / result, "before": RESULTS / before}
    arguments = EXPORTS[form][1].format(**names, output=f"exports/{result.replace('/', '-')}").split()
    process = run([*_PROGRAM, *arguments], capture_output=True, text=True, check=False)
    return shlex.join(["roughcontact", *arguments]), (process.stdout + process.stderr).strip()
