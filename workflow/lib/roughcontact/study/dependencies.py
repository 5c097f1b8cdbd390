"""The source files on which a script depends, so that an edit reruns only the affected jobs.

By their content: dates, by which Snakemake compares scripts, are those of an installation.
"""

import hashlib
import os
import re
from contextlib import suppress
from functools import cache
from itertools import accumulate
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
# import statements anywhere in the source: parsing it takes five times as long, searching for `^` twice
_FROM_IMPORT = re.compile(r"\n[ \t]*from[ \t]+([\w.]+)[ \t]+import[ \t]*(\([^)]*\)|[^\n]*)")
_IMPORT = re.compile(r"\n[ \t]*import[ \t]+([^\n]*)")
_STRING = re.compile(r"""(["'])([A-Za-z_][\w.]*)\1""")
_COMMENT = re.compile(r"#[^\n]*")
READERS = (
    "roughcontact.io.readers"  # of each file only the reader that recognises it counts (`study.readers`)
)
_WORDS = "tables.tsv"  # headings, which concern what is drawn


def source_digest(script: str | Path) -> str:
    """Return a checksum, 16 hexadecimal digits, of a script and the modules that it imports, also indirectly.

    Modules of this package count, those beside the script whose names start with _, files beside a module
    that names them or their folder ("variables.tsv", "templates"), and all modules of a folder named in a
    string, found at run time; not the readers, and words of tables only where the report is drawn.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     script = Path(folder) / "script.py"
    ...     _ = script.write_text("from roughcontact import errors")
    ...     len(source_digest(script))
    16
    """
    script = str(Path(script).resolve())
    paths = _closure(script)
    draws = any(path.startswith(os.path.join(PACKAGE, "report", "")) for path in paths)
    digest = hashlib.sha256()
    for path in sorted(path for path in paths if draws or os.path.basename(path) != _WORDS):
        digest.update(os.path.basename(path).encode() + b"\0" + _read(path)[1])
    return digest.hexdigest()[:16]


@cache
def _read(path: str) -> tuple[bytes, bytes]:
    """Return the content of a file, and its checksum."""
    content = Path(path).read_bytes()
    return content, hashlib.sha256(content).digest()


def _closure(script: str) -> set[str]:
    """Return the script and all the source files it depends on."""
    paths: set[str] = set()
    waiting = [script]
    while waiting:
        path = waiting.pop()
        if path not in paths:
            paths.add(path)
            waiting += _imported(path) if path.endswith(".py") else ()
    return paths


@cache
def _imported(path: str) -> tuple[str, ...]:
    """Return the files of the modules that `path` imports itself, and those of the folders it names."""
    text, folder = "\n" + _read(path)[0].decode(), os.path.dirname(path)
    names = [name for names_text in _IMPORT.findall(text) for name in _listed(names_text)]
    for module, names_text in _FROM_IMPORT.findall(text):
        names += [module, *(f"{module}.{name}" for name in _listed(names_text))]
    files = [file for name in dict.fromkeys(names) for file in _modules(name) or _beside(name, folder)]
    for string in dict.fromkeys(string for _, string in _STRING.findall(text)):
        files += _named(string, folder)
    return tuple(dict.fromkeys(files))


def _listed(text: str) -> list[str]:
    """Return the names in the list of an import, without their aliases."""
    entries = _COMMENT.sub("", text).strip().strip("()").split(",")
    return [fields[0] for entry in entries if (fields := entry.split())]


def _named(text: str, folder: str) -> list[str]:
    """Return the files that a string names: data beside its module, or above, or a folder of the package.

    A folder is named by a string where its modules are found at run time, so that all of them are imported.
    """
    if "." not in text:
        data = _entries(os.path.join(folder, text)) if _entries(folder).get(text) else ()
        return [os.path.join(folder, text, name) for name in data if "." in name and not name.endswith(".py")]
    for existing in (folder, os.path.dirname(folder)):
        if _entries(existing).get(text) is False:
            return [os.path.join(existing, text)]
    package, name = os.path.split(_sources().get(text, ""))
    if name != "__init__.py" or text == READERS:
        return []
    return [*_modules(text), *(path for path in _sources().values() if os.path.dirname(path) == package)]


@cache
def _entries(folder: str) -> dict[str, bool]:
    """Return the names in a folder and whether each is a folder; none where there is no such folder."""
    with suppress(OSError), os.scandir(folder) as entries:
        return {entry.name: entry.is_dir() for entry in entries}
    return {}


def _beside(name: str, folder: str) -> list[str]:
    """Return the file of a module beside a script, whose name starts with _."""
    file = f"{name.partition('.')[0]}.py"
    return [os.path.join(folder, file)] if file.startswith("_") and file in _entries(folder) else []


@cache
def _sources() -> dict[str, str]:
    """Return the file of each module of the package by its name with dots, of a package its `__init__.py`."""
    paths = {path.relative_to(PACKAGE.parent).with_suffix(""): path for path in PACKAGE.rglob("*.py")}
    return {".".join(name.parts).removesuffix(".__init__"): str(path) for name, path in paths.items()}


@cache
def _modules(name: str) -> tuple[str, ...]:
    """Return the files of a module of the package, and of the packages that hold it; none of others."""
    names = accumulate(name.split("."), "{}.{}".format)
    return tuple(_sources()[above] for above in names if above in _sources())
