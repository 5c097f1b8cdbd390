"""Common parts of all scripts: import path, log, short error messages, provenance of results.

A script is run by Snakemake, which adds the object `snakemake` to its globals. Importing this module first
opens the log of the job, which receives the traceback of an error; the screen shows one sentence.
"""

import atexit
import json
import os
import sys
import traceback
import warnings
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from __main__ import snakemake  # the global of the script; only few versions have it in `snakemake.script`

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "lib"))

from roughcontact.errors import HeightMapError, InputFileError, RoughContactError, SettingsError, path_message
from roughcontact.study.checksums import checksum
from roughcontact.study.garbage import collect_rarely
from roughcontact.study.notes import write_notes
from roughcontact.study.places import check_dates

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr

    from roughcontact.results.storage import LoadByLoad

_NAME = " ".join([snakemake.rule, *map(str, snakemake.wildcards)])
# whether a screen shows the log: snakemake_logger_plugin_roughcontact
_SCREEN = "ROUGHCONTACT_SCREEN" in os.environ

_MEMORY = snakemake.resources.get("mem_mb")
_ASKED = (f"it had asked for {_MEMORY} MB; " if _MEMORY else "") + (
    "run fewer jobs at once (--cores 1), cut the map or measure it coarser, and run again"
)


try:  # a descriptor, not a file: no buffer whose flush fails on a full disk when the job ends
    _LOG_FILE = os.open(snakemake.log[0], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
except OSError as cause:
    sys.exit(f"[{_NAME}] ERROR: {snakemake.log[0]}: cannot be written ({cause.strerror})")


# what the screen and the report of a run in which jobs fail read of this one
_RECORD: dict[str, Any] = {"job": _NAME, "done": False, "warnings": 0, "sources": {}}


def _log(text: str) -> bool:
    """Write to the log, and return whether that succeeded; a job does not fail because of its log."""
    content = text.encode("utf-8", "replace")
    with suppress(OSError):
        return os.write(_LOG_FILE, content) == len(content)
    return False


def _write_record(**fields: Any) -> bool:
    """Add to the record of this job, beside its log, and return whether that succeeded."""
    _RECORD.update(fields)
    with suppress(OSError):
        Path(snakemake.log[0]).with_suffix(".json").write_text(json.dumps(_RECORD), encoding="utf-8")
        return True
    return False


def result_of_job() -> str:
    """Return the folder of the result for which this job works: "soft/ground"."""
    return snakemake.wildcards.get("result", "")


def earlier_cases() -> dict[str, str]:
    """Return the attribute that names the earlier case of each file that is not of this result, as JSON."""
    case, _, _ = result_of_job().rpartition("/")
    files = {name: path for name, path in snakemake.input.items() if case and path and name != "sources"}
    cases = {name: path.split("/")[-3] for name, path in files.items()}
    used = {name: earlier for name, earlier in cases.items() if earlier != case}
    return {"files_of_cases": json.dumps(used, sort_keys=True)} if used else {}


def remove_superseded(output: str) -> None:
    """Remove files beside an output from before this result used those of an earlier case."""
    for name in snakemake.input.keys() - {"sources"}:
        path = Path(output).with_name(f"{name}.nc")
        if snakemake.input[name] and str(path) not in {*snakemake.input, *snakemake.output}:
            path.unlink(missing_ok=True)


def say(text: str) -> None:
    """Write one line to the log, and to the screen unless that shows only a line for each surface."""
    _log(f"[{_NAME}] {text}\n")
    if not _SCREEN:
        print(f"[{_NAME}] {text}", file=sys.stderr, flush=True)


def warn(text: str) -> None:
    """Write a warning to the log, and count it in the record."""
    _RECORD["warnings"] += 1
    say(f"warning: {text}")


def progress(done: int, total: int, text: str) -> None:
    """Report the progress of a sweep over loads."""
    say(f"load {done} of {total}: {text}")


def check_sources() -> None:
    """Raise an error where a file from outside has changed since the plan; record the checksum of each."""
    for path, expected in snakemake.params.sources.items():
        if checksum(path) != expected:
            raise InputFileError(f"{path}: changed while the run was at work; run again")
        _RECORD["sources"][path] = expected
    write_notes()


def save(
    result: "xr.DataArray | xr.Dataset",
    path: str,
    settings: dict,
    *,
    source: dict,
    into: "LoadByLoad | None" = None,
) -> None:
    """Write a result with its settings, the versions, and the checksum of the measured file.

    `source` are the attributes of the height map from which it was computed, with `source_sha256`; `into` is
    the file at `path`, if it is being written already.
    """
    from roughcontact.results.storage import provenance, write_dataset

    if hasattr(result, "to_dataset"):  # a single labelled array
        result = result.to_dataset()
    origin = provenance(
        settings,
        source_sha256=source["source_sha256"],
        stage=Path(path).stem,
        subject=", ".join(reversed(result_of_job().split("/"))),
        history=source.get("history", ""),
    )
    read = dict.fromkeys(snakemake.params.get("sources", {}).values())
    if further := [digest for digest in read if digest not in source["source_sha256"]]:
        origin["further_sha256"] = " ".join(further)  # of repeats, profiles along a lay, relaxations
    result = result.assign_attrs(origin)
    if into is not None:
        into.complete(result)
    else:
        write_dataset(result, path)


def save_course(
    course: "Callable[[], xr.Dataset]", path: str, settings: dict, *, source: dict[str, Any]
) -> None:
    """Write what a course comes to, or why it comes to nothing, so that what precedes it is not lost."""
    from xarray import Dataset

    from roughcontact.results.storage import FAILURE

    try:
        result = course()
    except RoughContactError as error:
        warn(str(error))
        result = Dataset(attrs={FAILURE: str(error)})
    save(result, path, settings, source=source)


def _check_inputs() -> None:
    """Refuse files from the future, and a window of other settings or measured files."""
    from roughcontact.results.storage import check_origin, opened_dataset

    check_dates(snakemake.input)
    if window := snakemake.input.get("window"):
        with opened_dataset(window) as file:
            check_origin(file.attrs, window, snakemake.params.origin)


def _report_error(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """Write the traceback to the log, and one sentence to the screen."""
    sys.excepthook = sys.__excepthook__
    _log("".join(traceback.format_exception(kind, error, trace)))
    if kind is KeyboardInterrupt:  # by the user, who knows
        return
    row = snakemake.params.get("row")
    if isinstance(error, HeightMapError | SettingsError) and row:
        text = path_message(error, row["path"], row["origin"])
    elif isinstance(error, RoughContactError):
        text = str(error)
    elif isinstance(error, MemoryError):
        text = f"out of memory ({error or 'no room for more arrays'}): {_ASKED}"
    else:
        text = f"{kind.__name__}: {error} (unexpected, please report it with {snakemake.log[0]})"
    line = f"[{_NAME}] ERROR: {text}"
    recorded = _write_record(error=text) and _log(f"{line}\n")
    if not (_SCREEN and recorded):
        print(line, file=sys.stderr, flush=True)


def _finish() -> None:
    """Record that the job has come to its end, which a killed one has not."""
    if sys.excepthook is _report_error:
        _write_record(done=True)


collect_rarely()
_write_record()
atexit.register(_finish)
sys.excepthook = _report_error
warnings.showwarning = lambda *warning, **_: _log(warnings.formatwarning(*warning[:4]))
_check_inputs()
