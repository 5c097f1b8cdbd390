"""What all scripts share: import path, log, short error messages, provenance of what is written.

A script is run by Snakemake, which puts the object `snakemake` among its globals. Importing this module first
opens the log of the job; an error then ends there with its traceback, and on the screen as one sentence. A
job whose run was killed ends as well, so that two runs never write to one file.
"""

import atexit
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
from types import TracebackType
from typing import TYPE_CHECKING, TextIO

from __main__ import snakemake  # the global of the script; `snakemake.script` has it in few versions only

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "lib"))

from roughcontact.errors import RoughContactError
from roughcontact.garbage import collect_rarely

if TYPE_CHECKING:
    import xarray as xr

    from roughcontact.results.storage import LoadByLoad

_NAME = " ".join([snakemake.rule, *map(str, snakemake.wildcards)])
# name -> path of all that a job of the chain reads and makes
FILES = dict(snakemake.output.items()) | dict(snakemake.input.items())
# whether a screen shows what the log says: snakemake_logger_plugin_roughcontact
_SCREEN = "ROUGHCONTACT_SCREEN" in os.environ

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


try:  # a descriptor, not a file: nothing is kept back that a full disk refuses again when the job ends
    _LOG = os.open(snakemake.log[0], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
except OSError as cause:
    sys.exit(f"[{_NAME}] ERROR: {snakemake.log[0]}: cannot be written ({cause.strerror})")


def _record(text: str) -> bool:
    """Write to the log, and return whether that went well; a job does not fail for its log."""
    content = text.encode("utf-8", "replace")
    with suppress(OSError):
        return os.write(_LOG, content) == len(content)
    return False


def link() -> None:
    """Link what another case has computed into this case's folder."""
    for name in snakemake.params.links:
        here = Path(snakemake.output[name])
        here.symlink_to(os.path.relpath(snakemake.input[name], here.parent))


def say(text: str) -> None:
    """Write one line to the log, and to the screen unless that has a line for each surface alone."""
    _record(f"[{_NAME}] {text}\n")
    if not _SCREEN:
        print(f"[{_NAME}] {text}", file=sys.stderr, flush=True)


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
    sys.excepthook = sys.__excepthook__
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
    line = f"[{_NAME}] ERROR: {text}"
    recorded = _record(f"{line}\n")  # for the partial report and the screen as well
    if not (_SCREEN and recorded):
        print(line, file=sys.stderr, flush=True)


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
    """End this job as soon as the run that started it is gone: by the file that `roughcontact run` holds."""
    own = os.environ.get(
        "ROUGHCONTACT_RUN"
    )  # none of Snakemake by itself, or where no variables are handed on
    try:
        import fcntl

        file = Path(".snakemake/running").open(encoding="utf-8")  # noqa: SIM115 - open until the job ends
    except (ImportError, OSError):  # a system or a folder without locks
        return

    def run_at_work() -> bool:
        """Tell whether the run that holds the file is there, and is the one that started this job."""
        file.seek(0)
        if own not in file.read().split()[1:]:  # the next run has begun
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

    if own and file.read().split()[:1] == [socket.gethostname()]:  # on a cluster jobs outlive the run
        threading.Thread(target=watch, daemon=True).start()


def _say_done() -> None:
    """Write the last line of a log, which that of a job that was killed does not have."""
    if sys.excepthook is _report_error:
        _record(f"[{_NAME}] done\n")


collect_rarely()
atexit.register(_say_done)
_end_with_the_run()
sys.excepthook = _report_error
warnings.showwarning = _log_warning
