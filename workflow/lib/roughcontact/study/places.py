"""The folders that a run writes to, and the dates of the files that a job reads."""

import os
import time
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path

from roughcontact.errors import InputFileError, SettingsError

# when the last partial report was written: a param of the report, so that the next run makes it again
PARTIAL = Path(".snakemake/roughcontact-partial")
_SKEW = 60  # s by which clocks of file servers may be ahead


def check_places(folder: Path) -> None:
    """Raise a SettingsError where something else is in the place of a folder of a run."""
    for name in ("results", "logs", ".snakemake"):
        path = folder / name
        if not os.path.lexists(path) or path.is_dir():
            continue
        obstacle = f"a link to {path.readlink()}, where no folder is" if path.is_symlink() else "a file"
        raise SettingsError(
            f"{path.absolute()}: is {obstacle}, but a run needs a folder there; rename or delete it"
        )


def check_writable(folder: Path) -> None:
    """Raise a SettingsError where nothing can be written to a working directory, or to its results."""
    existing = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.is_dir())
    for path in (existing, folder.absolute() / "results", folder.absolute() / "logs"):
        if path.is_dir() and not os.access(path, os.W_OK):
            raise SettingsError(
                f"{path} is read-only, results cannot be written there: choose another folder with "
                "--directory"
            )


def stale_results(results: Iterable[str], root: str | Path = "results") -> list[str]:
    """Return the folders with results below `root` that are not among the `results` of this run."""
    folders = {path.parent for depth in ("*", "*/*") for path in Path(root).glob(f"{depth}/panel.html")}
    return sorted(folder.as_posix() for folder in folders - {Path(root, result) for result in results})


def check_dates(paths: Iterable[str]) -> None:
    """Raise an InputFileError where a file is from the future: what is made of it would count as older."""
    present_time = time.time()
    for path in map(Path, paths):
        if path.exists() and (mtime := path.stat().st_mtime) > present_time + _SKEW:
            date, present = (
                f"{datetime.fromtimestamp(time_):%Y-%m-%d %H:%M}" for time_ in (mtime, present_time)
            )
            raise InputFileError(
                f"{path}: is dated {date}, by a clock that was ahead, or that of this computer is behind "
                f"({present}): set the clock right, or date such files of today: "
                f"find {path.parent} -newermt now -exec touch {{}} +"
            )


def find_file(path: str | Path, folders: Iterable[str | Path]) -> Path | None:
    """Return the first existing file among `folder / path`, None where there is none."""
    # relative in the working directory: recorded paths do not depend on where that is
    candidates = (Path(folder) / path for folder in folders)
    # false also of a path that is too long
    return next((candidate for candidate in candidates if os.path.isfile(candidate)), None)  # noqa: PTH113
