"""Checks before anything is unpacked or parsed: kind and size of a file, content of an archive."""

import hashlib
import os
import re
import traceback
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from roughcontact.errors import InputFileError, RoughContactError
from roughcontact.io.vocabulary import rows_of

MAX_FILE_BYTES = 4 * 2**30
MAX_UNPACKED_BYTES = 2**30
MAX_XML_BYTES = 2**28
# errors of zipfile for archives that are damaged; a compression that it does not know raises
# NotImplementedError, a member with a password RuntimeError
ARCHIVE_ERRORS = (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, OSError)
_MAX_PATH_LENGTH = 4095  # characters; limit of operating systems
_MAX_NAME_LENGTH = 255
_LONG_NAME = 40
_PROLOG = 2**20  # bytes within which the root of XML must begin
_PADDED = 100  # compression ratio above which XML of 16 MiB and more is only padding
MAX_POINTS = 2**27  # 1 GiB as float64; a solution needs about ten such arrays
MAX_CHANNELS = 10_000  # of one file
_EXAMINED = 2**20  # bytes behind a map that are compared with each other
BYTES_PER_POINT = 32  # while a map is read: as stored, in double precision, and a copy
# name of a refusal -> the keys that it asks for, and its sentence
_REFUSALS = {name: (keys.split(), sentence) for name, keys, sentence in rows_of("refusals.tsv")}


def refusal(name: str, kind: type[RoughContactError] = InputFileError, /, **facts: Any) -> RoughContactError:
    """Return the error of some name in the table of refusals, with facts in its sentence.

    Examples
    --------
    >>> error = refusal("no such channel", choice="z", listing="'height'", together="")
    >>> str(error), error.keys
    ("no channel is named 'z'; the file has 'height'", ('channel',))
    """
    keys, sentence = _REFUSALS[name]
    return kind(sentence.format(**facts), keys=keys)


def sentence(name: str, /, **facts: Any) -> str:
    """Return a sentence of the table of refusals with its facts, for a warning."""
    return str(refusal(name, **facts))


def brief(error: Exception) -> str:
    r"""Return the message of a library's error on one line of at most 160 characters.

    Examples
    --------
    >>> brief(ValueError("no header\n  in line 3")), brief(EOFError())
    ('no header in line 3', 'EOFError')
    """
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= 160 else text[:157] + "..."


def listed(names: Sequence[str], max_count: int = 8) -> str:
    """Return the first names of a sequence, in quotes, for a message; fewer of long ones."""
    max_count = max_count if max(map(len, names[:max_count]), default=0) <= _LONG_NAME else 2
    return ", ".join(map(repr, names[:max_count])) + (", ..." if len(names) > max_count else "")


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Raise every error as one of this package, whose message begins with the path."""
    try:
        yield
    except RoughContactError as error:
        if not str(error).startswith(str(path)[:60]):
            error.args = (f"{path}: {error}",)
        raise
    except Exception as error:  # whatever a reader, or a library, did not foresee
        raise InputFileError(f"{path}: {_reason(error)}") from error


def _reason(error: Exception) -> str:
    """Return why a file cannot be read, for an error that its reader did not foresee."""
    if isinstance(error, MemoryError):
        return "needs more memory than there is; crop the map, or read it on a larger computer"
    if isinstance(error, ImportError):
        *_, (frame, _) = traceback.walk_tb(error.__traceback__)
        package = frame.f_globals["__name__"].partition(".")[0]
        return f"cannot be read, as the package {package} is not complete ({brief(error)}); install it again"
    if isinstance(error, OSError) and error.strerror:
        return f"cannot be read ({error.strerror})"
    message = "" if brief(error) == type(error).__name__ else f": {brief(error)}"
    return str(refusal("unforeseen", error=f"{type(error).__name__}{message}"))


@contextmanager
def refusing(message: str, way_out: str = "") -> Iterator[None]:
    """Raise errors of a library as `InputFileError` with a message and their own."""
    try:
        yield
    except (RoughContactError, ImportError, MemoryError):
        raise
    except Exception as error:  # libraries fail on damaged files in any way
        raise InputFileError(f"{message} ({brief(error)}){way_out}") from error


def check_file(path: Path) -> None:
    """Refuse a path that is no regular file, and a file that is empty, too large, or a ZIP bomb."""
    if len(name := str(path)) > _MAX_PATH_LENGTH or max(map(len, path.parts), default=0) > _MAX_NAME_LENGTH:
        raise refusal("long path", path=name[:60], length=len(name))
    try:
        status = path.stat()
    except PermissionError as error:
        raise InputFileError("its folder may not be read by this user") from error
    except (OSError, ValueError) as error:
        raise refusal("no file") from error
    if path.is_dir():
        raise InputFileError("is a folder; name one file in it (roughcontact inspect lists them)")
    if not path.is_file():
        raise InputFileError("is no regular file")
    if status.st_size == 0:
        raise InputFileError("the file is empty")
    refuse_more(f"{status.st_size} bytes", status.st_size, MAX_FILE_BYTES)
    _check_archive(path)


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file, 64 hexadecimal digits, read in pieces."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def file_state(path: str | Path) -> list[int] | None:
    """Return what changes when a file is written or replaced: size, dates (ns), inode; None without it."""
    try:
        status = Path(path).stat()
    except (OSError, ValueError):
        return None
    return [status.st_size, status.st_mtime_ns, status.st_ctime_ns, status.st_ino]


@contextmanager
def unchanged(path: Path) -> Iterator[None]:
    """Refuse a file that changes within the block, also instead of the error of a reader of half a file."""
    # without the content: to read a large file twice would take as long as to open it
    initial_state = file_state(path)
    try:
        yield
    finally:
        if file_state(path) != initial_state:
            raise InputFileError("changed while it was read; wait until it is complete, and read it again")


def refuse_more(description: str, count: float, limit: int, way_out: str = "crop the map") -> None:
    """Refuse to read more than a limit of something that a file has so many of."""
    if count > limit:
        raise InputFileError(f"{description}, more than the {limit} that are read; {way_out}")


def check_points(shape: tuple[int, int], *, maps: int = 1) -> None:
    """Refuse maps (ny, nx) of more than 2²⁷ points, or than this computer can hold, before they are read."""
    (ny, nx), total = shape, maps * shape[0] * shape[1]
    points = f"{maps} maps of {ny} x {nx} points" if maps > 1 else f"{ny} x {nx} points"
    refuse_more(points, total, MAX_POINTS)
    check_memory(total * BYTES_PER_POINT, points)


def check_count(channels: int) -> None:
    """Refuse a file of more than 10 000 maps, profiles or tables."""
    refuse_more(f"{channels} channels", channels, MAX_CHANNELS, "save some in a file of their own")


def check_memory(size: float, data_name: str) -> None:
    """Refuse to read data that need more memory (bytes) than this computer has."""
    if (total := memory_bytes()) is not None and size > total:
        raise refusal("memory", data=data_name, required=size / 2**30, total=total / 2**30)


def memory_bytes() -> float | None:
    """Return the memory (bytes) that this process may use, by computer and container; None where unknown."""
    limits: list[float] = []
    with suppress(AttributeError, ValueError, OSError):
        limits.append(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    with suppress(OSError, ValueError):  # limit of a container or a batch job; "max": none
        limits.append(int(Path("/sys/fs/cgroup/memory.max").read_text()))
    return min(limits, default=None)


def refuse_cut_off(size: int, required_size: int) -> None:
    """Refuse a file with fewer bytes than it needs."""
    if size < required_size:
        raise refusal("cut off", size=size, required=required_size)


def compare_size(path: Path, required_size: int) -> tuple[str, list[str]]:
    """Return how the size of a file differs from the bytes needed, as in `MeasuredFile.stale`, and a warning.

    Equal excess bytes are padding at the end; others may have moved the heights. A file too short is refused.
    """
    size = path.stat().st_size
    refuse_cut_off(size, required_size)
    if size == required_size:
        return "", []
    with path.open("rb") as stream:
        stream.seek(required_size)
        excess = stream.read(_EXAMINED)
    sizes = f"{size} bytes where its header needs {required_size}"
    if excess.count(excess[:1]) != size - required_size:
        return sizes, []
    last = f"the last {size - required_size} of them are all {excess[0]}"
    return "", [f"the file has {sizes}; {last} and are taken for padding behind the heights"]


def check_line_ends(path: Path) -> None:
    """Refuse a binary file after a text-mode transfer: every line feed follows a carriage return."""
    size = path.stat().st_size
    with path.open("rb") as stream:
        # only the end, which has no header
        stream.seek(max(size // 2, size - 2**24))
        data = stream.read()
    feeds = data.count(b"\n")
    # one byte in 256 of binary data is a line feed: no coincidence
    if feeds > 50 and feeds == data.count(b"\r\n"):
        raise refusal("line ends")


def _check_archive(path: Path) -> None:
    """Refuse a ZIP archive that unpacks to more than 1 GiB or whose XML declares entities (expansion bombs).

    Any document type declaration is refused: no instrument format needs one. Other files pass.
    """
    if not zipfile.is_zipfile(path):
        with path.open("rb") as stream:
            if stream.read(4) == b"PK\x03\x04":
                raise InputFileError("a ZIP archive (X3P, PLUX, ...) without its end: the file was cut off")
        return
    try:
        # sizes of the directory: `zipfile` never unpacks more of a member
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            total = sum(entry.file_size for entry in entries)
            refuse_more(f"the archive would unpack to {total} bytes", total, MAX_UNPACKED_BYTES)
            for entry in entries:
                if entry.filename.lower().endswith(".xml"):
                    _check_xml(archive, entry)
    except ARCHIVE_ERRORS as error:
        if isinstance(error, RuntimeError) and "password" in str(error):
            raise InputFileError("the ZIP archive asks for a password; unpack it first") from error
        raise InputFileError(f"the ZIP archive is damaged or encrypted ({brief(error)})") from error


def _check_xml(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> None:
    """Refuse XML that is larger than 256 MiB or declares a document type or entities."""
    name = f"{entry.filename} in the archive"
    large = entry.file_size > _PROLOG * 16 and entry.file_size > _PADDED * entry.compress_size
    if entry.file_size > MAX_XML_BYTES or large:
        raise refusal("large XML", name=name, size=entry.file_size, packed=entry.compress_size)
    tail = b""
    with archive.open(entry) as stream:
        while block := stream.read(_PROLOG):
            text = tail + block.replace(b"\0", b"").upper()  # makes UTF-16 searchable
            if declaration := re.search(rb"<!(DOCTYPE|ENTITY)", text):
                raise refusal("declaration in XML", name=name, declaration=declaration[1].decode())
            if not tail and len(block) == _PROLOG and not text.strip():
                raise InputFileError(f"{name} begins with {_PROLOG} bytes of blanks: it is no XML")
            tail = text[-16:]
