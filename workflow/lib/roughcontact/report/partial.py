"""Partial results after failures: of the finished surfaces, with the reasons for the others."""

import json
import os
import re
import shutil
import time
from contextlib import suppress
from pathlib import Path

from roughcontact.configuration.places import PARTIAL
from roughcontact.configuration.plan import Plan, split
from roughcontact.errors import InputFileError
from roughcontact.io.checksums import checksum
from roughcontact.report.gather import remove_earlier, write_results
from roughcontact.results.collect import Entry, Failure, entry_of
from roughcontact.results.storage import read_arrays

# older than the script that makes it: of a first report Snakemake has no record whose params it compares
_LONG_AGO = 315_532_800  # 1980-01-01, s


def write_partial_results(plan: Plan, folder: str | Path = "results") -> list[Failure]:
    """Write the results of the finished surfaces, if any, and return a `Failure` for each of the others.

    Finished are those whose files exist, are not older than what they are made of, record the settings and
    checksums of this run, and whose jobs have logged that they are done. Of all or none nothing is written.
    """
    # complete before they are moved there
    folder = Path(folder)
    finished: list[Entry] = []
    failures: list[Failure] = []
    for result in plan.results:
        entry = entry_of(result, f"results/{result}/statistics.nc")
        reason = _reason(plan, result)
        if reason is None and _is_of_this_run(plan, result):
            finished.append(entry)
        else:
            surface, case = entry["surface"], entry["case"]
            failures.append(Failure(surface=surface, case=case, reason=reason or "not finished"))
    if not (finished and failures):
        return failures
    staging = Path(".snakemake/partial")
    shutil.rmtree(staging, ignore_errors=True)
    staging.mkdir(parents=True)
    write_results(
        staging,
        finished=finished,
        **plan.report_arguments(),
        failures=failures,
        link_folder=folder,
    )
    PARTIAL.write_text(f"{time.time_ns()}\n", encoding="utf-8")
    remove_earlier(folder)
    for path in staging.iterdir():
        path.replace(folder / path.name)
    os.utime(folder / "uncertainty.csv", (_LONG_AGO, _LONG_AGO))
    staging.rmdir()
    return failures


def _is_of_this_run(plan: Plan, result: str) -> bool:
    """Return whether all files of a result are there, and of this run."""
    folder, statistics = Path("results", result), Path("results", result, "statistics.nc")
    prepared = [Path(plan.file(stage, result)) for stage in ("height", "levelled", "window")]
    files = [*prepared, statistics, folder / "panel.html", folder / "panel.json"]
    if result in plan.unloaded:
        files.append(folder / "residual.nc")
    try:
        dates = [file.stat().st_mtime_ns for file in files]
        _, attrs = read_arrays(statistics)
        recorded = json.loads(attrs["settings"]), attrs["source_sha256"]
        expected = plan.settings("statistics", result), _checksum(plan, split(result)[1])
    except (OSError, InputFileError, KeyError):
        return False
    logs = "".join(map(_text_of, plan.log_files(result)))
    if not all(f"has read {path}, SHA-256 {checksum(path)}\n" in logs for path in plan.all_sources(result)):
        return False
    return dates == sorted(dates) and recorded == (json.loads(json.dumps(expected[0])), expected[1])


def _checksum(plan: Plan, surface: str) -> str:
    """Return the recorded checksum of the measured files of a surface, of both faces of a pair."""
    pair = plan.placements.get(surface)
    names = [surface] if pair is None else [pair.face, pair.counter_face]
    return " + ".join(checksum(plan.measured[name].path) for name in names)


def _reason(plan: Plan, result: str) -> str | None:
    """Return why its first job failed, or which file is gone; None where all is well."""
    for log in plan.log_files(result):
        if not Path(log).is_file():
            continue
        text = _text_of(log)
        if errors := re.findall(r"^\[.*?\] ERROR: (.+)$", text, re.MULTILINE):
            return errors[-1]
        if not text.endswith("] done\n"):
            return f"ended without a word, as a job does that is killed: {log}"
    missing = [path for path in plan.all_sources(result) if not Path(path).exists()]
    return f"{missing[0]}: is gone since the run began; put it back and run again" if missing else None


def _text_of(log: str) -> str:
    """Return the text of a log, empty where there is none."""
    with suppress(OSError):
        return Path(log).read_text(encoding="utf-8", errors="replace")
    return ""
