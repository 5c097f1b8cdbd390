"""Comparison of the size of a file with the size that its header states."""

from pathlib import Path

from roughcontact.errors import InputFileError

_EXAMINED = 2**20  # bytes of an excess that are compared with each other


def refuse_cut_off(size: int, required_size: int) -> None:
    """Refuse a file with fewer bytes than it needs."""
    if size < required_size:
        raise InputFileError(
            f"{size} bytes where its header needs {required_size}: it was cut off, or lost bytes on "
            "the way; copy or export it again"
        )


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
    if excess.count(excess[:1]) == size - required_size:
        note = (
            f"the file has {size} bytes where its header needs {required_size}; the last "
            f"{size - required_size} of them are all {excess[0]} and are taken for padding behind the heights"
        )
        return "", [note]
    return f"{size} bytes where its header needs {required_size}", []
