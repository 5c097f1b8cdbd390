"""The workflow from the command line: initial settings and table, and runs of it by Snakemake."""

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any

from roughcontact.command_line.run_lock import RunLock, run_lock
from roughcontact.configuration.places import check_places, check_writable
from roughcontact.configuration.yaml_text import check_yaml
from roughcontact.errors import InputFileError, SettingsError
from roughcontact.io.folder import is_folder, measurements_in
from roughcontact.io.seal import check_seal

PACKAGE = Path(__file__).parents[1]
_PROFILES = ("--profile", "--workflow-profile", "--executor", "-e")
_CORES = ("--cores", "-c", "--jobs", "-j", *_PROFILES)
_PR_SET_PDEATHSIG = 1  # of prctl(2)
_RUN = "ROUGHCONTACT_RUN"  # tells the jobs of which run they are
_LONGEST_STEM = 56  # letters of a name made of that of a file; a number may follow
# with one of these the screen is Snakemake's own
_SHOW = ("--logger", "--quiet", "-q", "--verbose", "--printshellcmds", "-p", "--debug-dag")
# with one of these Snakemake runs nothing, and asks for no lock
_DRY = re.compile(
    r"-[npqkFr]*[nSDv]|-n[npqkFr]*|--(dry-?run|summary|detailed-summary|list.*|lint|report|version"
    r"|dag|rulegraph|filegraph|d3dag)(=.*)?"
)
_OF_CHECKOUT = ("validation", "crosscheck", "cost")  # programs beside the package, by their names in run.py
_FILES = Path("config/config.yaml"), Path("config/surfaces.tsv")

_SETTINGS_HEAD = """\
# Settings of roughcontact with their defaults. A missing key has its default.
# State your materials and loads under `contact`, where there is no default; list your files in
# config/surfaces.tsv; then run `roughcontact run`.
"""
_TABLE_HEAD = """\
# One row for each surface: a name (letters, digits, -) and the file, separated by a tab.
# A row that starts with # is ignored. Further columns complete the files: dx and dy (steps
# between points) and unit (theirs), height_unit, channel.
surface\tpath
"""
_TABLE_EXAMPLE = "# ground\tmeasured/ground.x3p\n"


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
    installed = PACKAGE / "_workflow/workflow/Snakefile"
    return installed if installed.is_file() else PACKAGE.parents[1] / "Snakefile"


def write_project(files: Sequence[str | Path], *, contact: Mapping[str, Any] | None = None) -> list[Path]:
    r"""Write settings and a table of surfaces into the folder `config` of the working directory.

    `files`: measured files; each becomes a row of the table, named after the file; `contact`: `bodies` and
    `mean_pressure`, as far as they are known; otherwise examples stand there as comments. Returns the written
    files. Raises `SettingsError` where one of them already exists, a measured file is missing, or for bodies
    that are not accepted.

    Examples
    --------
    >>> import contextlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
    ...     _ = Path("Ground 2.txt").write_text("1 2")
    ...     _ = write_project(["Ground 2.txt"])
    ...     Path("config/surfaces.tsv").read_text().splitlines()[-1]
    'Ground-2\tGround 2.txt'
    """
    from roughcontact.configuration.generated import default_yaml
    from roughcontact.configuration.resolve import resolve
    from roughcontact.results.storage import write_text

    for path in _FILES:
        if path.exists():
            raise SettingsError(f"{path} already exists: change it, or go to another folder")
    for file in files:
        if not Path(file).is_file():
            raise SettingsError(f"{file}: no such file")
    rows = [f"{name}\t{file}\n" for name, file in zip(surface_names(files), files, strict=True)]
    if contact:
        resolve({"contact": contact})
    texts = (
        default_yaml(head=_SETTINGS_HEAD, contact=contact or {}),
        _TABLE_HEAD + ("".join(rows) or _TABLE_EXAMPLE),
    )
    for path, text in zip(_FILES, texts, strict=True):
        write_text(text, path)
    return list(_FILES)


def files_in(paths: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the given files, and in the place of a folder those in it that can be measurements, by name.

    `paths`: files and folders. Returns these files, and those of the folders that were left out, but for
    hidden ones.
    """
    files: list[str] = []
    skipped: list[str] = []
    for path in paths:
        if is_folder(path):
            measured, unmeasured = measurements_in(Path(path))
            files += map(str, measured)
            skipped += map(str, unmeasured)
        else:
            files.append(path)
    return files, skipped


def surface_names(files: Sequence[str | Path]) -> list[str]:
    """Return a different admitted name of a surface for each file."""
    from roughcontact.configuration.messages import name_mistake

    names: list[str] = []
    for file in files:
        stem = re.sub(r"[^A-Za-z0-9]+", "-", Path(file).stem)[:_LONGEST_STEM].strip("-")
        stem = "surface" if name_mistake(stem) else stem
        further = (f"{stem}-{number}" for number in range(2, len(files) + 2))
        names.append(stem if stem not in names else next(name for name in further if name not in names))
    return names


def run_workflow(arguments: Sequence[str]) -> int:
    """Run the workflow in the working directory, on all cores unless the arguments say otherwise.

    A run that was killed is continued; a bad file stops only its own surface.

    `arguments`: for Snakemake. Returns the exit status of Snakemake. Raises `SettingsError` where a run
    cannot begin: Snakemake, a configuration file or the right to write is missing. Raises `InputFileError`
    for results that are not as they were written; a run would leave them as they are.
    """
    options = stated_options(arguments)
    _check_start(options)
    dry = any(map(_DRY.fullmatch, arguments)) and "--report-after-run" not in arguments
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(workflow_file())]
    if not any(option.split("=")[0] in _SHOW for option in arguments):
        command += ["--logger", "roughcontact"]
    # as in the default profile, which Snakemake would announce each time
    command += ["--rerun-incomplete", "--keep-going"]
    if not any(option.split("=")[0] in _PROFILES for option in arguments):
        command += ["--workflow-profile", "none"]
    unlocks, folder = "--unlock" in arguments, options.directory
    with nullcontext(RunLock()) if dry else run_lock(folder, unlocks=unlocks) as lock:
        if not (dry or unlocks):
            _check_results(folder / "results")
        if lock.killed and not unlocks:
            print("The last run in this folder was killed: it is continued.", file=sys.stderr, flush=True)
            if code := _wait([*command, "--unlock", *arguments, "--quiet"], folder, lock):
                return code
        if not any(option.split("=")[0] in _CORES for option in arguments):
            command += ["--cores", "all"]
        code = _wait([*command, *arguments], folder, lock)
    if code and folder.is_dir() and shutil.disk_usage(folder).free < 1e6:
        print(f"The disk of {folder.absolute()} is full: make room and run again.", file=sys.stderr)
    return code


def stated_options(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the arguments of Snakemake that are also used here: folder, configuration, targets.

    `arguments`: of the command line; others are left alone. Returns `directory` and `configfile` (paths),
    `targets` (str).

    Examples
    --------
    >>> stated_options(["--configfile", "my.yaml", "-n"]).configfile[0].name
    'my.yaml'
    """
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--directory", "-d", type=Path, default=Path())
    parser.add_argument("--configfile", "--configfiles", type=Path, nargs="+", default=[])
    options, targets = parser.parse_known_args(arguments)
    return argparse.Namespace(**vars(options), targets=targets)


def _check_start(options: argparse.Namespace) -> None:
    """Raise an error where it is known beforehand that a run cannot begin."""
    from importlib.util import find_spec

    for target in set(_OF_CHECKOUT) & set(options.targets):
        raise SettingsError(
            f"{target} is no target of a run but a command of the checkout: `python3 run.py {target} --help`"
        )
    if find_spec("snakemake") is None:
        raise SettingsError("Snakemake is not installed: pip install 'roughcontact[workflow]'")
    for file in options.configfile:
        if not file.is_file():
            raise SettingsError(
                f"--configfile {file}: no such file; `roughcontact init` writes one to change"
            )
        check_yaml(file)
    homes = options.directory, workflow_file().parent, workflow_file().parents[1]
    if not options.configfile:
        configurations = [home / _FILES[0] for home in homes if (home / _FILES[0]).is_file()]
        if not configurations:
            folder = options.directory.absolute()
            raise SettingsError(
                f"there is no {_FILES[0]} in {folder}: `roughcontact init` writes one to change"
            )
        check_yaml(configurations[0])
    check_places(options.directory)
    check_writable(options.directory)


def _check_results(folder: Path) -> None:
    """Raise an error that names every result which is not as it was written: a run would let it stay."""
    damaged = []
    for path in sorted(folder.rglob("*.nc")):
        try:
            if not check_seal(path):
                from roughcontact.results.storage import opened_dataset

                with opened_dataset(path):
                    pass
        except InputFileError as error:
            damaged.append(str(error))
    if damaged:
        raise InputFileError("\n".join(damaged))


def _cache(folder: Path) -> dict[str, str]:
    """Return the variable that puts caches into the working directory if there is no writable home."""
    try:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        Path(home).mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return {"XDG_CACHE_HOME": str(folder.absolute() / ".snakemake/cache")}
    return {}


def _wait(command: Sequence[str], folder: Path, lock: RunLock) -> int:
    """Run a command to its end, even after an interruption, which the command has received as well.

    A termination has reached this process alone: it interrupts the command and ends its jobs. The exit status
    is then that of a terminated program.
    """
    run = lock.name or str(os.getpid())
    variables = os.environ | _cache(folder) | {_RUN: run}  # for its jobs
    variables["PYTHONSAFEPATH"] = "1"  # nothing in the working folder is code, for this command and its jobs
    process: subprocess.Popen | None = None
    terminated = False

    def terminate(*_: object) -> None:
        nonlocal terminated
        if process and not terminated:
            threading.Thread(target=_interrupt, args=(process.pid, run)).start()
        terminated = True

    in_main_thread = threading.current_thread() is threading.main_thread()  # only there are signals handled
    before = signal.signal(signal.SIGTERM, terminate) if in_main_thread else None
    try:
        prepare = _end_with_this_process()
        process = subprocess.Popen(command, env=variables, pass_fds=lock.files, preexec_fn=prepare)  # noqa: PLW1509 - no threads
        if terminated:  # while it was started
            _interrupt(process.pid, run)
        while True:
            try:
                code = process.wait()
            except KeyboardInterrupt:
                continue
            lock.ended = code >= 0
            while terminated and _end_jobs(run):
                pass
            return 128 + signal.SIGTERM if terminated else code
    finally:
        if in_main_thread:
            signal.signal(signal.SIGTERM, before)


def _interrupt(started: int, run: str) -> None:
    """Interrupt Snakemake as Ctrl-C does, so that it cleans up, and end its jobs, which it would wait for."""
    import psutil  # comes with Snakemake

    # shells let what they start in the background ignore interruptions
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    with suppress(psutil.NoSuchProcess):
        snakemake = psutil.Process(started)
        snakemake.send_signal(signal.SIGTERM if ignored else signal.SIGINT)
        while snakemake.is_running() and snakemake.status() != psutil.STATUS_ZOMBIE:
            _end_jobs(run, besides=started)  # also those that it starts until it notices


def _end_jobs(run: str, *, besides: int = 0) -> bool:
    """End the processes of a run, also those whose parents have ended, and return whether there were any."""
    import psutil

    jobs = []
    for process in psutil.process_iter():
        with suppress(psutil.Error, OSError):
            if process.pid != besides and process.environ().get(_RUN) == run:
                process.terminate()
                jobs.append(process)
    psutil.wait_procs(jobs, timeout=0.2)
    return bool(jobs)


def _end_with_this_process() -> Callable[[], None] | None:
    """Return a function for a child to run first, so that the system kills it when this process ends.

    Only Linux offers this. Jobs notice by themselves that the killed command no longer holds its file.
    """
    if sys.platform != "linux":
        return None
    import ctypes

    library, parent = ctypes.CDLL(None), os.getpid()

    def prepare() -> None:
        library.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it has ended before
            os._exit(1)

    return prepare
