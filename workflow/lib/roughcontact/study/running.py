"""Runs of the workflow by Snakemake from the command line."""

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from contextlib import nullcontext, suppress
from pathlib import Path

from roughcontact.errors import SettingsError
from roughcontact.study.places import check_places, check_writable
from roughcontact.study.run_lock import VARIABLE, RunLock, end_processes, run_lock
from roughcontact.study.yaml_text import check_yaml

PACKAGE = Path(__file__).parents[1]
_PROFILES = {"--profile", "--workflow-profile", "--executor", "-e"}
_CORES = {"--cores", "-c", "--jobs", "-j", *_PROFILES}
# all but that of code, which compares dates of scripts: an installation would make every result again
CONTENT_TRIGGERS = ("--rerun-triggers", "input", "mtime", "params", "software-env")
# with one of these the screen is Snakemake's own
_SHOW = {"--logger", "--quiet", "-q", "--verbose", "--printshellcmds", "-p", "--debug-dag"}
# with one of these Snakemake runs nothing, and asks for no lock
_DRY = re.compile(
    r"-[npqkFr]*[nSDv]|-n[npqkFr]*|--(dry-?run|summary|detailed-summary|list.*|lint|report|version"
    r"|dag|rulegraph|filegraph|d3dag)(=.*)?"
)
_CONFIGURATION = Path("config/config.yaml")
# as `python -m snakemake`; looking for garbage among what it imports takes a seventh of an idle run. A signal
# to exit waits in a thread for the lock of the scheduler, which may be held where it is heard
_SNAKEMAKE = """\
import gc, sys, threading
gc.disable()
sys.argv[0] = "snakemake"
from snakemake.cli import main
from snakemake.scheduling.job_scheduler import JobScheduler
exit_gracefully = JobScheduler.exit_gracefully
JobScheduler.exit_gracefully = lambda *of: threading.Thread(target=exit_gracefully, args=of).start()
main()
"""


def workflow_file() -> Path:
    """Return the Snakefile: that inside the installed package, otherwise that of the checkout.

    Returns
    -------
    Path

    Examples
    --------
    >>> workflow_file().name
    'Snakefile'
    """
    packaged = PACKAGE / "_workflow/workflow/Snakefile"
    return packaged if packaged.is_file() else PACKAGE.parents[1] / "Snakefile"


def run_workflow(arguments: Sequence[str]) -> int:
    """Run the workflow in the working directory with arguments for Snakemake; return its exit status.

    On all cores by default; a killed run is continued; a bad file stops only its own surface.
    """
    options, names = stated_options(arguments), {argument.split("=")[0] for argument in arguments}
    _check_start(options)
    dry = any(map(_DRY.fullmatch, arguments)) and "--report-after-run" not in arguments
    command = [sys.executable, "-c", _SNAKEMAKE, "--snakefile", str(workflow_file())]
    if not names & _SHOW:
        command += ["--logger", "roughcontact"]
    # as in the default profile, which Snakemake would announce each time
    command += ["--rerun-incomplete", "--keep-going"]
    # the other one starts a process for each choice, to weigh temporary files, of which there are none
    command += ["--scheduler", "greedy"]
    if not names & _PROFILES:
        command += ["--workflow-profile", "none", *CONTENT_TRIGGERS]
        if sys.platform == "linux":  # elsewhere libraries do not survive a fork
            command += ["--executor", "roughcontact"]
    unlocks, folder = "--unlock" in arguments, options.directory
    with nullcontext(RunLock()) if dry else run_lock(folder, unlocks=unlocks) as lock:
        if lock.killed and not unlocks:
            print("The last run in this folder was killed: it is continued.", file=sys.stderr, flush=True)
            if code := _wait([*command, "--unlock", *arguments, "--quiet"], folder, lock):
                return code
        if not names & _CORES:
            command += ["--cores", "all"]
        code = _wait([*command, *arguments], folder, lock)
    if code == 128 + signal.SIGINT:
        print("Interrupted: what is finished is kept; run again to go on.", file=sys.stderr)
        return code
    if code and folder.is_dir() and shutil.disk_usage(folder).free < 1e6:
        print(f"The disk of {folder.absolute()} is full: make room and run again.", file=sys.stderr)
    return code


def stated_options(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the arguments of Snakemake that are also used here: `directory` and `configfile` (paths).

    Examples
    --------
    >>> stated_options(["--configfile", "my.yaml", "-n"]).configfile[0].name
    'my.yaml'
    """
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--directory", "-d", type=Path, default=Path())
    parser.add_argument("--configfile", "--configfiles", type=Path, nargs="+", default=[])
    return parser.parse_known_args(arguments)[0]


def _check_start(options: argparse.Namespace) -> None:
    """Raise an error where it is known beforehand that a run cannot begin."""
    from importlib.util import find_spec

    if find_spec("snakemake") is None:
        raise SettingsError("Snakemake is not installed: pip install 'roughcontact[workflow]'")
    for file in options.configfile or [options.directory / _CONFIGURATION]:
        if not file.is_file():
            raise SettingsError(
                f"--configfile {file}: no such file; `roughcontact init` writes one to change"
                if options.configfile
                else f"there is no study in {options.directory.absolute()} (no {_CONFIGURATION}): "
                "`roughcontact init FILE ...` begins one with your measured files"
            )
        check_yaml(file)
    check_places(options.directory)
    check_writable(options.directory)


def _cache(folder: Path) -> dict[str, str]:
    """Return the variable that puts caches into the working directory if there is no writable home."""
    try:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        Path(home).mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return {"XDG_CACHE_HOME": str(folder.absolute() / ".snakemake/cache")}
    return {}


def _wait(command: Sequence[str], folder: Path, lock: RunLock) -> int:
    """Run a command to its end, which a signal to this process may bring; return its exit status."""
    run = lock.name or str(os.getpid())
    variables = os.environ | _cache(folder) | {VARIABLE: run}  # for its jobs
    variables["PYTHONSAFEPATH"] = "1"  # nothing in the working folder is code, for this command and its jobs
    process: subprocess.Popen | None = None
    stopped_by = 0

    def stop(number: int, _: object) -> None:
        nonlocal stopped_by
        if process and not stopped_by:
            threading.Thread(target=_terminate, args=(process.pid, run)).start()
        stopped_by = stopped_by or number

    previous_handlers = {}
    if threading.current_thread() is threading.main_thread():  # only there are signals handled
        previous_handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
        signal.signal(signal.SIGTERM, stop)
        # the command does not hear it, even from a terminal, which tells both: it is told by this process
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        process = subprocess.Popen(command, env=variables, pass_fds=lock.files)
        # shells let what they start in the background ignore interruptions
        if previous_handlers.get(signal.SIGINT, signal.SIG_IGN) is not signal.SIG_IGN:
            signal.signal(signal.SIGINT, stop)
        if stopped_by:  # while it was started
            _terminate(process.pid, run)
        code = process.wait()
        lock.ended = code >= 0
        # what Snakemake has left, which ends its jobs itself unless it was killed
        while (stopped_by or code < 0) and end_processes(run):
            pass
        return 128 + stopped_by if stopped_by else code
    finally:
        for number, handler in previous_handlers.items():
            signal.signal(number, handler)


def _terminate(process_id: int, run: str) -> None:
    """Terminate Snakemake, so that it cleans up, and end its jobs, which it would wait for."""
    import psutil  # comes with Snakemake

    with suppress(psutil.NoSuchProcess):
        snakemake = psutil.Process(process_id)
        snakemake.send_signal(signal.SIGTERM)
        while snakemake.is_running() and snakemake.status() != psutil.STATUS_ZOMBIE:
            end_processes(run, besides=process_id)  # also those that it starts until it notices
