"""What a run has left: its results, and the commands that compare and export them."""

import json
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

from roughcontact.command_line.saving import CONTENT_BY_COMMAND, exports
from roughcontact.errors import SettingsError
from roughcontact.statistics.outcome import VERDICTS

_RESULTS = Path("results")
FORMATS = CONTENT_BY_COMMAND | exports()


def results() -> dict[str, Any]:
    """Return the results by name, with verdict and what would halve the ±, the report and the tables."""
    panels = {}
    for path in sorted(_RESULTS.rglob("panel.json")):
        summary = json.loads(path.read_text(encoding="utf-8"))
        name = path.parent.relative_to(_RESULTS).as_posix()
        panels[name] = summary | {"verdict": VERDICTS.get(summary["verdict"], summary["verdict"])}
    report = _RESULTS / "report.html"
    files = [path for path in sorted(_RESULTS.glob("*")) if path.is_file()]
    return {
        "results": panels,
        "report": report.stat().st_mtime if report.is_file() else None,
        "files": [path.name for path in files],
        "formats": FORMATS,
    }


def compare(before: str, after: str) -> dict[str, Any]:
    """Return what `roughcontact compare` says of two results."""
    return _said("compare", str(_file(before, "statistics.nc")), str(_file(after, "statistics.nc")))


def export(result: str, form: str) -> dict[str, Any]:
    """Write a result in another form, or all of them, and return the command that does it."""
    if form == "crate":
        return _said("crate", str(_RESULTS), "--configfile", "config/config.yaml")
    if form == "methods":
        return _said("methods", str(_file(result, "statistics.nc")))
    if form not in FORMATS:
        raise SettingsError(f"{form}: is none of {', '.join(FORMATS)}")
    name = result.replace("/", "-")
    target = Path("exports", f"{name}-table.csv" if form == "table" else f"{name}{form}")
    if form == "table":
        return _said("table", str(_file(result, "statistics.nc")), "-o", str(target))
    return _said("export", str(_file(result, "statistics.nc").parent), "-o", str(target))


def _file(result: str, name: str) -> Path:
    """Return a file of a result; a SettingsError where there is none."""
    path = _RESULTS / result / name
    if result not in results()["results"] or not path.is_file():
        raise SettingsError(f"{path}: no such file; run the study first (contact.keep_fields keeps the maps)")
    return path


def _said(*arguments: str) -> dict[str, Any]:
    """Return what the program says, with the command."""
    command = ["roughcontact", *arguments]
    process = subprocess.run(
        [sys.executable, "-m", "roughcontact.command_line", *arguments],
        capture_output=True,
        text=True,
        check=False,
    )
    text = (process.stdout + process.stderr).strip()
    return {"command": shlex.join(command), "text": text, "code": process.returncode}
