"""Checksums of the files that are read from outside, by which a replaced file is noticed whatever its date.

They are noted with size, dates and place on the disk, and computed anew where one has changed; ctime is among
them, which no program can set as those that copy, unpack and synchronise set the date of the content.
"""

import json
import os
import time
from contextlib import suppress
from functools import cache
from pathlib import Path

from roughcontact.io.guards import file_state, sha256

NOTED = Path(".snakemake/roughcontact-checksums")
# ns without a change after which the dates of the next change differ: FAT counts them by two seconds
_SETTLED = 3_000_000_000


def checksum(path: str | Path, *, memo: Path = NOTED) -> str:
    """Return the SHA-256 of a file, as it was noted if the file has not changed since; empty if unreadable.

    `memo` has a line of JSON for each, the last of a path counts; lines are added where its folder exists.
    """
    state = file_state(path)
    record = _noted(memo).get(str(path))
    if record and record[0] == state:
        return record[1]
    try:
        digest = sha256(Path(path))
    except OSError:
        return ""
    if state and state == file_state(path) and _is_settled(state):
        _noted(memo)[str(path)] = state, digest
        with suppress(OSError), memo.open("a", encoding="utf-8") as file:
            file.write(json.dumps([str(path), state, digest]) + "\n")
    return digest


@cache
def _noted(file: Path) -> dict[str, tuple[list[int], str]]:
    """Return the noted states and checksums by path; damaged lines, as of a killed run, are left out."""
    checksums = {}
    with suppress(OSError, UnicodeDecodeError):
        for line in file.read_text(encoding="utf-8").splitlines():
            with suppress(ValueError):
                path, state, digest = json.loads(line)
                checksums[path] = state, digest
    return checksums


def _is_settled(state: list[int]) -> bool:
    """Return whether the next change of a file will show in its dates."""
    _, modification, status_change, _ = state
    return time.time_ns() - (modification if os.name == "nt" else status_change) > _SETTLED
