"""Checksums of the files that are read from outside, by which a replaced file is noticed whatever its date.

They are noted with size, dates and place on the disk, and computed anew where one has changed; ctime is among
them, which no program can set as those that copy, unpack and synchronise set the date of the content.
"""

import os
import time
from pathlib import Path

from roughcontact.io.guards import file_state, sha256
from roughcontact.study.notes import note, noted

NOTED = Path(".snakemake/roughcontact-checksums")
# ns without a change after which the dates of the next change differ: FAT counts them by two seconds
_SETTLED = 3_000_000_000


def checksum(path: str | Path, *, memo: Path = NOTED) -> str:
    """Return the SHA-256 of a file, as noted in `memo` if it has not changed since; empty if unreadable."""
    state = file_state(path)
    record = noted(memo).get(str(path))
    if record and record[0] == state:
        return record[1]
    try:
        digest = sha256(Path(path))
    except OSError:
        return ""
    if state and state == file_state(path) and _is_settled(state):
        note(memo, str(path), (state, digest))
    return digest


def _is_settled(state: list[int]) -> bool:
    """Return whether the next change of a file will show in its dates."""
    _, modification, status_change, _ = state
    return time.time_ns() - (modification if os.name == "nt" else status_change) > _SETTLED
