"""One run at a time in a folder, and whether the last one was killed.

A run, or its Snakemake, locks .snakemake/running; the system releases the lock when both have ended, by which
a job knows it. The file names computer, process and run, and is empty unless the run was killed.
"""

import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from roughcontact.errors import SettingsError

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
        free, this_host = lock_file(file.fileno()), socket.gethostname()
        host, process = _last_run(path)
        if free is None:
            yield RunLock()
            return
        if not free:
            run = f"process {process} on {host}" if host else "of another program"
            raise SettingsError(
                f"{folder.absolute()}: a run is at work there ({run}): wait for its end, or end it first; "
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
    """Return computer and process of the run that a file names; empty where there is none."""
    try:
        fields = path.read_text(encoding="utf-8", errors="replace").split()
    except OSError:
        return "", ""
    host, run = (*fields, "", "")[:2]
    return host, run.partition("-")[0]


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
