"""What all scripts share: import path, log, short error messages, provenance of what is written.

A script is run by Snakemake, which puts the object `snakemake` among its globals. Importing this module first
opens the log of the job; an error then ends there with its traceback, and on the screen as one sentence. A
job whose run was killed ends as well, so that two runs never write to one file.
"""

import errno
import os
import socket
import sys
import threading
import time
import traceback
import warnings
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace, TracebackType
from typing import TYPE_CHECKING, Any, TextIO

from __main__ import snakemake  # the global of the script; `snakemake.script` has it in few versions only

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "lib"))

from roughcontact.errors import RoughContactError
from roughcontact.garbage import collect_rarely

if TYPE_CHECKING:
    import xarray as xr

    from roughcontact.results.storage import LoadByLoad

_log: int
_name: str
_SCREEN = os.environ.get(
    "ROUGHCONTACT_SCREEN"
)  # how a run shows itself: snakemake_logger_plugin_roughcontact
_ERASE = "\r\x1b[K" if _SCREEN == "bar" else ""

_MEMORY = snakemake.resources.get("mem_mb")  # jobs that only link ask for none
_ASKED = (f"it had asked for {_MEMORY} MB; " if _MEMORY else "") + (
    "run fewer jobs at once (--cores 1), cut the map or measure it coarser, and run again"
)
_DISK = {
    errno.ENOSPC: "the disk is full; make room and run again, what is done is not done again",
    errno.EDQUOT: "your share of the disk is used up; make room and run again",
    errno.EROFS: "the folder is read-only; choose another one with --directory",
    errno.EACCES: "you may not read or write it; change its permissions",
}


def _record(text: str) -> None:
    """Write to the log; a job does not fail for its log."""
    with suppress(OSError):
        os.write(_log, text.encode("utf-8", "replace"))


def begin(job: Any) -> None:
    """Open the log of a job, and make it the one that what follows is part of.

    Parameters
    ----------
    job : object
        with the attributes of the object `snakemake` of a script.
    """
    global snakemake, _log, _name  # noqa: PLW0603 - a process does one job after another
    snakemake = job
    _name = " ".join([job.rule, *map(str, job.wildcards)])
    try:  # a descriptor, not a file: nothing is kept back that a full disk refuses again when the job ends
        _log = os.open(job.log[0], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    except OSError as cause:
        sys.exit(f"[{_name}] ERROR: {job.log[0]}: cannot be written ({cause.strerror})")


def of_step(job: Any, name: str, step: Any) -> SimpleNamespace:
    """Return one of the steps of a job that takes several, as a job.

    Parameters
    ----------
    job : object
        the object `snakemake` of the script.
    name : str
        of the step.
    step : Step
        which files it reads and leaves (`roughcontact.configuration.stages`).

    Returns
    -------
    SimpleNamespace
        with the attributes of the object `snakemake` that the step's own script looks at.
    """
    files = dict(job.input.items()) | dict(job.output.items())
    named = type(job.input)  # a list whose entries have names
    return SimpleNamespace(
        rule=name,
        input=named(fromdict={key: files[key] for key in step.inputs if files.get(key)}),
        output=named(fromdict={key: files[key] for key in step.outputs}),
        log=[job.log[name]],
        params=SimpleNamespace(settings=job.params.settings[name], file=job.params.get("file")),
        wildcards=job.wildcards,
        threads=job.threads,
    )


def say(text: str) -> None:
    """Write one line to the log, and to the screen unless that has a line for each surface alone."""
    _record(f"[{_name}] {text}\n")
    if not _SCREEN:
        print(f"[{_name}] {text}", file=sys.stderr, flush=True)


def progress(done: int, total: int, text: str) -> None:
    """Say how far a sweep over loads has come."""
    say(f"load {done} of {total}: {text}")


def save(
    result: "xr.DataArray | xr.Dataset",
    path: str,
    settings: dict,
    *,
    source: dict,
    into: "LoadByLoad | None" = None,
) -> None:
    """Write a result with the settings behind it, the versions, and the checksum of the measured file.

    Parameters
    ----------
    result : DataArray or Dataset
        what the job computed.
    path : str
        where to write.
    settings : dict
        those that had a part in the result.
    source : dict
        attributes of the height map it was computed from, with `source_sha256`.
    into : LoadByLoad, optional
        the file of that name, where it is being written already.
    """
    from roughcontact.results.storage import provenance, write_dataset

    if hasattr(result, "to_dataset"):  # a single labelled array
        result = result.to_dataset()
    wildcards = snakemake.wildcards
    origin = provenance(
        settings,
        source_sha256=source["source_sha256"],
        stage=Path(path).stem,
        of=", ".join(filter(None, map(wildcards.get, ("surface", "case")))),
        history=source.get("history", ""),
    )
    result = result.assign_attrs(origin)
    if into is not None:
        into.complete(result)
    else:
        write_dataset(result, path)


def _report_error(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """Write the traceback to the log, and to the screen the one sentence that helps."""
    _record("".join(traceback.format_exception(kind, error, trace)))
    if kind is KeyboardInterrupt:  # by the user, who knows
        return
    if isinstance(error, RoughContactError):
        text = str(error)
    elif isinstance(error, MemoryError):
        text = f"out of memory ({error or 'no room for more arrays'}): {_ASKED}"
    elif isinstance(error, OSError) and error.errno in _DISK:
        text = f"{error.filename or 'a file'}: {_DISK[error.errno]}"
    else:
        text = f"{kind.__name__}: {error} (not foreseen, please report it with {snakemake.log[0]})"
    line = f"[{_name}] ERROR: {text}"
    _record(f"{line}\n")  # for the report of the rest as well
    print(f"{_ERASE}{line}", file=sys.stderr, flush=True)


def _log_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Write a warning to the log."""
    _record(warnings.formatwarning(message, category, filename, lineno, line))


def _end_with_the_run() -> None:
    """End this job as soon as the run that started it is gone: by the file it holds, see runs.smk."""
    try:
        import fcntl

        file = Path(".snakemake/running").open(encoding="utf-8")  # noqa: SIM115 - open until the job ends
    except (ImportError, OSError):  # a system or a folder without locks
        return
    own = os.environ.get("ROUGHCONTACT_RUN")  # none on a cluster that hands no variables on

    def run_at_work() -> bool:
        """Tell whether the run that holds the file is there, and is the one that started this job."""
        file.seek(0)
        if own not in (None, *file.read().split()[1:]):  # the next run has begun
            return False
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        return False

    def watch() -> None:
        with suppress(OSError):
            while run_at_work():
                time.sleep(0.2)
            os._exit(1)

    if file.read().split()[:1] == [socket.gethostname()]:  # on a cluster jobs outlive the run
        threading.Thread(target=watch, daemon=True).start()


begin(snakemake)
collect_rarely()
_end_with_the_run()
sys.excepthook = _report_error
warnings.showwarning = _log_warning
