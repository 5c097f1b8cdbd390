"""Files of a folder that can be measurements."""

from pathlib import Path
from typing import Any

from roughcontact.errors import InputFileError, RoughContactError
from roughcontact.io.guards import naming
from roughcontact.io.inspection import inspect_file
from roughcontact.io.registry import recognised
from roughcontact.io.text.table import split_header

_DOCUMENTS = {
    *(".md", ".rst", ".tex", ".bib", ".html", ".htm", ".pdf", ".doc", ".docx", ".odt", ".ppt", ".pptx"),
    *(".json", ".yaml", ".yml", ".toml", ".ini", ".cfg", ".log", ".py", ".ipynb", ".m", ".r", ".sh", ".bat"),
    *(".png", ".jpg", ".jpeg", ".gif", ".svg"),
}
_EXAMINED = 2**20  # bytes


def contents_of(path: str | Path, **arguments: Any) -> dict[str, Any]:
    """Return what `inspect_file` says of a file, of one that cannot be read its name and the reason."""
    try:
        return inspect_file(path, **arguments)
    except RoughContactError as error:
        return {
            "file": Path(path).name,
            "format": None,
            "map": None,
            "problem": str(error),
            "warnings": [],
        }


def list_measurements(folder: Path) -> tuple[list[Path], list[Path]]:
    """Return the files of a folder that can be measurements, by name, and the others but for hidden ones."""
    files = sorted(path for path in folder.iterdir() if path.is_file() and not path.name.startswith("."))
    candidates = [path for path in files if _can_be_measured(path)]
    return candidates, [path for path in files if path not in candidates]


def _can_be_measured(path: Path) -> bool:
    """Return whether a file can hold heights."""
    if path.suffix.lower() in _DOCUMENTS or path.stat().st_size == 0:
        return False
    try:
        with naming(path):
            if recognised(path)[0] != "text":
                return True
    except InputFileError:  # a damaged container
        return True
    with path.open("rb") as stream:
        text = stream.read(_EXAMINED).replace(b"\0", b"").decode("latin-1")  # also in UTF-16
    try:
        split_header(text.splitlines())
    except InputFileError:  # no table of numbers
        return False
    return True
