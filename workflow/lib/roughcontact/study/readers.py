"""Which reader reads a measured file, so that a change of another one concerns no job."""

import hashlib
from contextlib import suppress
from functools import cache
from pathlib import Path

from roughcontact.study.checksums import checksum
from roughcontact.study.dependencies import PACKAGE, source_digest
from roughcontact.study.notes import note, noted

NOTED = Path(".snakemake/roughcontact-readers")


def reader_digest(path: str | Path) -> str:
    """Return the checksum of the code of the reader that recognises a file; empty if that is unreadable.

    Recognising imports all readers, so it is noted by the content of the file.
    """
    content, readers = checksum(path), _all_readers()
    if not content:
        return ""
    if (key := f"{content} {readers}") not in noted(NOTED):
        note(NOTED, key, _recognised(Path(path)))
    return _digest(noted(NOTED)[key])


@cache
def _digest(name: str) -> str:
    module = PACKAGE / f"io/readers/{name}.py"
    return f"{name} {source_digest(module)}" if module.is_file() else name


@cache
def _all_readers() -> str:
    """Return the checksum of the code by which readers recognise files, of all of them."""
    code = b"".join(path.read_bytes() for path in sorted((PACKAGE / "io/readers").glob("*.py")))
    return hashlib.sha256(code).hexdigest()[:16]


def _recognised(path: Path) -> str:
    """Return the name of the reader of a file; empty where none takes it, of which its job complains."""
    from roughcontact.io.registry import recognised

    with suppress(Exception):  # a damaged file fails in any way
        return recognised(path)[0]
    return ""
