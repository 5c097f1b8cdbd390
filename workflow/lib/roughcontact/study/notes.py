"""What is noted of files from run to run, in Snakemake's folder: lines of JSON that hold a key and a value.

Planning notes in memory; `write_notes` writes, so that a dry run leaves nothing on the disk.
"""

import json
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

_UNWRITTEN: dict[Path, dict[str, Any]] = {}


@cache
def noted(file: Path) -> dict[str, Any]:
    """Return what a file has noted, by key; damaged lines, as of a killed run, are left out."""
    notes: dict[str, Any] = {}
    with suppress(OSError, UnicodeDecodeError):
        for line in file.read_text(encoding="utf-8").splitlines():
            with suppress(ValueError, TypeError):
                notes.update([json.loads(line)])
    return notes


def note(file: Path, key: str, value: Any) -> None:
    """Note a value for this process, and for others once the notes are written."""
    noted(file)[key] = value
    _UNWRITTEN.setdefault(file, {})[key] = value


def write_notes() -> None:
    """Add all new notes to their files, where the folders of these exist."""
    while _UNWRITTEN:
        path, notes = _UNWRITTEN.popitem()
        with suppress(OSError), path.open("a", encoding="utf-8") as file:
            file.writelines(json.dumps(pair) + "\n" for pair in notes.items())
