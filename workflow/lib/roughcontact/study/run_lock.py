"""One run at a time in a folder, and whether the last one was killed.

A run and its Snakemake lock .snakemake/running; the system releases the lock when both have ended. The
file names computer, process and run, and is empty unless the run was killed. What goes on of a killed run,
its Snakemake or jobs, would write the files of the next one: that ends it first.
"""

import os
import signal
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from roughcontact.errors import SettingsError

VARIABLE = "ROUGHCONTACT_RUN"  # of the environment: tells processes of which run they are
_TRIES = 20  # tenths of a second in which a run that ends releases its lock


@dataclass
class RunLock:
    """The lock of a run; without one, where a folder or a system has none, there is no `name`."""

    files: list[int] = field(default_factory=list)  # descriptors that Snakemake has to inherit
    name: str = ""  # computer, process and time of the run
    killed: bool = False  # the last run was killed
    ended: bool = True  # this one has ended by itself


@contextmanager
def run_lock(folder: Path, *, unlocks: bool = False) -> Iterator[RunLock]:
    """Lock a folder for one run; a SettingsError where another one is at work there.

    `unlocks`: the user states that no other computer is at work there. Snakemake reports its own lock.
    """
    path = folder / ".snakemake/running"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = None if os.name == "nt" else path.open("a+b", buffering=0)
    except OSError:  # a folder that cannot be written
        file = None
    if file is None:
        yield RunLock()
        return
    with file:
        this_host, (host, run) = socket.gethostname(), _last_run(path)
        process = run.partition("-")[0]
        if host == this_host:
            _end_remains(f"{host} {run}", process)
        free = lock_file(file.fileno())
        if free is None:
            yield RunLock()
            return
        if not free:
            holder = f"process {process} on {host}" if host else "of another program"
            raise SettingsError(
                f"{folder.absolute()}: a run is at work there ({holder}): wait for its end, or end it first; "
                "what it has finished is kept, and --unlock is not needed"
            )
        if host not in ("", this_host) and not unlocks:
            raise SettingsError(
                f"{folder.absolute()}: a run on the computer {host} (process {process}) may be at work "
                "there, which cannot be seen from here: wait for its end or, if it has been killed, take its "
                "locks away with --unlock and run again"
            )
        lock = RunLock(
            [file.fileno()], f"{this_host} {os.getpid()}-{time.time_ns()}", killed=host == this_host
        )
        line = f"{lock.name}\n".encode()
        # in place, then truncated: after a kill in between the computer's name is there
        with path.open("r+b", buffering=0) as content:
            content.write(line)
            content.truncate(len(line))
        yield lock
        if lock.ended:
            file.truncate(0)


def _last_run(path: Path) -> tuple[str, str]:
    """Return computer and run (process and time) that a file names; empty where there is none."""
    try:
        fields = path.read_text(encoding="utf-8").replace("\0", "").split()
    except (OSError, UnicodeDecodeError):  # unreadable, or what a failing disk has left of it
        return "", ""
    host, run = (*fields, "", "")[:2]
    return host, run


def _end_remains(run: str, process: str) -> None:
    """End what goes on of a run of this computer whose first process, by its number, was killed."""
    import psutil  # comes with Snakemake

    if process.isdecimal() and not psutil.pid_exists(int(process)):
        while end_processes(run, by=signal.SIGKILL if os.name != "nt" else signal.SIGTERM):
            pass


def end_processes(run: str, *, besides: int = 0, by: int = signal.SIGTERM) -> bool:
    """End the processes of a run, also those whose parents have ended, and return whether there were any."""
    import psutil

    ended = []
    for process in psutil.process_iter():
        with suppress(psutil.Error, OSError):
            if process.pid != besides and process.environ().get(VARIABLE) == run:
                process.send_signal(by)
                ended.append(process)
    psutil.wait_procs(ended, timeout=0.2)
    return bool(ended)


def lock_file(file: int) -> bool | None:
    """Lock a file, if necessary after a moment; None where the folder has no locks."""
    import fcntl

    for _ in range(_TRIES):
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            time.sleep(0.1)
        except OSError:
            return None
        else:
            return True
    return False
