"""The run of a study from the page: the command of the terminal, its screen read from a file."""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

from roughcontact.app.study import CONFIG, table_path
from snakemake_logger_plugin_roughcontact.screen import BAR, ERASE

COMMAND = ["roughcontact", "run"]
_SCREEN = Path("logs/page.log")
_WIDEST = "400"  # characters of the bar
_DONE = re.compile(r"^(\S+): done", re.MULTILINE)


class Run:
    """The run that the page has started, if any."""

    def __init__(self) -> None:
        self.process: subprocess.Popen | None = None
        self.cancelled = False

    def start(self) -> None:
        """Start the command, unless it is at work."""
        if self.at_work():
            return
        self.cancelled = False
        _SCREEN.parent.mkdir(exist_ok=True)
        variables = os.environ | {BAR: "1", "COLUMNS": _WIDEST, "PYTHONUNBUFFERED": "1"}
        inputs = [CONFIG.stat().st_mtime, table_path().stat().st_mtime]
        resumed = _SCREEN.exists() and _SCREEN.stat().st_mtime > max(inputs)  # what was done still holds
        with _SCREEN.open("ab" if resumed else "wb") as screen:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "roughcontact.command_line", *COMMAND[1:]],
                stdin=subprocess.DEVNULL,
                stdout=screen,
                stderr=subprocess.STDOUT,
                env=variables,
            )

    def cancel(self) -> None:
        """Terminate the command, which ends its jobs; what is finished stays."""
        if self.process and self.at_work():
            self.cancelled = True
            self.process.terminate()

    def at_work(self) -> bool:
        """Return whether the command runs."""
        return self.process is not None and self.process.poll() is None

    def state(self) -> dict[str, Any]:
        """Return the lines of the screen, the bar with the time left, and the state of each surface."""
        written = _SCREEN.read_bytes().decode(errors="replace") if _SCREEN.is_file() else ""
        *_, bar = written.rpartition("\n")
        bar = bar.rpartition(ERASE)[2].strip()
        lines = [line.rpartition(ERASE)[2] for line in written.split("\n")[:-1]]
        text = "\n".join(lines)
        jobs = re.search(r"(\d+) of (\d+) jobs", bar)
        return {
            "running": self.at_work(),
            "code": self.process.poll() if self.process else None,
            "cancelled": self.cancelled,
            "text": text,
            "bar": bar,
            "share": int(jobs[1]) / int(jobs[2]) if jobs else None,
            "done": _DONE.findall(text),
            "failed": re.findall(r"^\[\w+ ([^\]]+)\] ERROR", text, re.MULTILINE),
        }
