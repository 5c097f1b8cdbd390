"""One run at a time in a folder: who holds it, and what a killed run has left there.

A run locks .snakemake/running as long as it or the Snakemake that it starts lives. The system releases the
lock when both have ended, in whatever way: by this a job knows that its run has ended (`_job.py`), and the
next run that the locks of Snakemake are those of a killed run. The file names computer, process and run. A
completed run leaves it empty.
"""

import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from roughcontact.errors import SettingsError

_TRIES = 20  # tenths of a second in which jobs notice that their run has ended
_LOCKS = ".snakemake/locks/*.lock"  # those of Snakemake, while a run is at work
_SCRIPTS = ".snakemake/scripts/tmp*"  # of jobs, which Snakemake removes at their end


class Hold(NamedTuple):
    """What a run has of its folder.

    Attributes
    ----------
    files : list of int
        file descriptors that Snakemake has to inherit.
    run : str
        computer, process and time, as the locked file has them; empty without a lock.
    killed : bool
        whether the locks of Snakemake are those of a killed run.
    """

    files: list[int]
    run: str
    killed: bool


@contextmanager
def held(folder: Path, *, unlocks: bool = False) -> Iterator[Hold]:
    """Hold a folder for one run.

    Where a folder or a system has no locks the run begins without.

    Parameters
    ----------
    folder : Path
        the working directory.
    unlocks : bool
        whether the user says that no run is at work there; a lock that is held says otherwise.

    Yields
    ------
    Hold

    Raises
    ------
    SettingsError
        where another run is at work there.
    """
    path = folder / ".snakemake/running"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = None if os.name == "nt" else path.open("a+b", buffering=0)
    except OSError:  # a folder that cannot be written
        file = None
    if file is None:
        yield Hold([], "", killed=False)
        return
    with file:
        free = _locked(file.fileno())
        host, process = _last(path)
        if free is None:
            yield Hold([], "", killed=False)
            return
        if not free:
            raise SettingsError(_at_work(folder, host, process))
        left, here = any(folder.glob(_LOCKS)), host == socket.gethostname()
        # jobs of a killed run of this program end by themselves, those of plain Snakemake do not
        if left and not here and (others := _snakemakes(folder)):
            raise SettingsError(_at_work(folder, socket.gethostname(), others[0]))
        if left and host and not here and not unlocks:
            raise SettingsError(
                f"{folder.absolute()}: a run on the computer {host} (process {process}) may be at work "
                "there, which cannot be seen from here: wait for its end or, if it has been killed, take its "
                "locks away with --unlock and run again"
            )
        run = f"{socket.gethostname()} {os.getpid()}-{time.time_ns()}"
        line = f"{run}\n".encode()
        # in place, then truncated: after a kill in between the computer's name is there
        with path.open("r+b", buffering=0) as content:
            content.write(line)
            content.truncate(len(line))
        yield Hold([file.fileno()], run, killed=left and here)
        if not any(folder.glob(_LOCKS)):  # else Snakemake was killed
            file.truncate(0)


def left_locked(folder: Path) -> bool:
    """Return whether Snakemake's locks in a folder are those of a killed run, without holding the folder.

    After a run on another computer this cannot be known.
    """
    path = folder / ".snakemake/running"
    if os.name == "nt" or not any(folder.glob(_LOCKS)) or _last(path)[0] != socket.gethostname():
        return False
    with suppress(OSError), path.open(encoding="utf-8") as file:
        return _locked(file.fileno()) is True
    return False


def remove_scripts(folder: Path) -> None:
    """Remove what killed jobs have left of their scripts: those that no job holds (`_job.py`).

    To be called while the folder is held, and not for runs on a cluster, whose jobs outlive them.
    """
    import fcntl

    for path in folder.glob(_SCRIPTS):
        with suppress(OSError), path.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            path.unlink()


def _at_work(folder: Path, host: str, process: str) -> str:
    """Return the sentence about another run."""
    who = f"process {process} on {host}" if host else "of another program"
    return (
        f"{folder.absolute()}: a run is at work there ({who}): wait for its end, or end it first; what it "
        "has finished is kept, and --unlock is not needed"
    )


def _last(path: Path) -> tuple[str, str]:
    """Return computer and process of the run that is named in a file; empty where there is none."""
    try:
        words = path.read_text(encoding="utf-8", errors="replace").split()
    except OSError:
        return "", ""
    host, run = (*words, "", "")[:2]
    return host, run.partition("-")[0]


def _snakemakes(folder: Path) -> list[str]:
    """Return the processes on this computer of other Snakemakes in a folder, and of their jobs."""
    import psutil  # comes with Snakemake

    own = {os.getpid(), *(each.pid for each in psutil.Process().parents())}
    found = []
    for process in psutil.process_iter():
        with suppress(psutil.Error, OSError):
            words = process.cmdline()[:4]
            of_snakemake = any(
                Path(word).name == "snakemake" or ".snakemake/scripts/" in word for word in words
            )
            if of_snakemake and process.pid not in own and Path(process.cwd()) == folder.resolve():
                found.append(str(process.pid))
    return found


def _locked(file: int) -> bool | None:
    """Lock a file, if necessary after a moment: the jobs of a run that was just killed have to notice it.

    None where the folder has no locks.
    """
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
