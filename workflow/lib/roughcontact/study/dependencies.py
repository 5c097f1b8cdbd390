"""The source files on which a script depends, so that an edit reruns only the affected jobs."""

import hashlib
import re
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
# import statements anywhere in the source: parsing it takes five times as long
_FROM_IMPORT = re.compile(r"^[ \t]*from[ \t]+([\w.]+)[ \t]+import[ \t]*(\([^)]*\)|[^\n]*)", re.MULTILINE)
_IMPORT = re.compile(r"^[ \t]*import[ \t]+([^\n]*)", re.MULTILINE)
_STRING = re.compile(r"""(["'])([A-Za-z_][\w.]*)\1""")
_COMMENT = re.compile(r"#[^\n]*")
READERS = (
    "roughcontact.io.readers"  # of each file only the reader that recognises it counts (`study.readers`)
)
_WORDS = "tables.tsv"  # headings, which concern what is drawn


def source_digest(script: str | Path) -> str:
    """Return a checksum, 16 hexadecimal digits, of the modules that a script imports, directly or indirectly.

    Modules of this package count, those beside the script whose names start with _, files beside a module
    that names them or their folder ("variables.tsv", "templates"), and all modules of a folder named in a
    string, found at run time; not the readers, and words of tables only where the report is drawn.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     script = Path(folder) / "script.py"
    ...     _ = script.write_text("from roughcontact import errors")
    ...     first = source_digest(script)
    ...     _ = script.write_text("from roughcontact.errors import SettingsError")
    ...     first == source_digest(script), len(first)
    (True, 16)
    """
    script = Path(script)
    digest, paths = hashlib.sha256(), _closure(script.resolve()) - {script.resolve()}
    draws = any(PACKAGE / "report" in path.parents for path in paths)
    for path in sorted(path for path in paths if draws or path.name != _WORDS):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _closure(script: Path) -> set[Path]:
    """Return the script and all the source files it depends on."""
    paths: set[Path] = set()
    waiting = [script]
    while waiting:
        path = waiting.pop()
        if path not in paths:
            paths.add(path)
            waiting += _imported(path) if path.suffix == ".py" else ()
    return paths


@cache
def _imported(path: Path) -> tuple[Path, ...]:
    """Return the files of the modules that `path` imports itself, and those of the folders it names."""
    text = path.read_text(encoding="utf-8")
    names = [name for names_text in _IMPORT.findall(text) for name in _listed(names_text)]
    for module, names_text in _FROM_IMPORT.findall(text):
        names += [module, *(f"{module}.{name}" for name in _listed(names_text))]
    files = [file for name in dict.fromkeys(names) for file in _files(name, path.parent)]
    for string in dict.fromkeys(string for _, string in _STRING.findall(text)):
        files += _named(string, path.parent)
    return tuple(files)


def _listed(text: str) -> list[str]:
    """Return the names in the list of an import, without their aliases."""
    entries = _COMMENT.sub("", text).strip().strip("()").split(",")
    return [fields[0] for entry in entries if (fields := entry.split())]


def _named(text: str, folder_of_module: Path) -> list[Path]:
    """Return the files that a string names: data beside its module, or above, or a folder of the package.

    A folder is named by a string where its modules are found at run time, so that all of them are imported.
    """
    head, *names = text.split(".")
    if not names:
        return (
            [file for file in (folder_of_module / text).glob("*.*") if file.suffix != ".py"]
            if text in _folders(folder_of_module)
            else []
        )
    candidates = folder_of_module / text, folder_of_module.parent / text
    if existing := [candidate for candidate in candidates if candidate.is_file()]:
        return existing[:1]
    if head != PACKAGE.name or text == READERS or not all(name.isidentifier() for name in names):
        return []
    folder = PACKAGE.joinpath(*names)
    return [*_modules(text), *folder.glob("*.py")] if (folder / "__init__.py").is_file() else []


@cache
def _folders(folder: Path) -> set[str]:
    """Return the names of the folders in a folder."""
    return {path.name for path in folder.iterdir() if path.is_dir()}


def _files(name: str, folder: Path) -> tuple[Path, ...]:
    """Return the source files of this project that importing the module `name` runs."""
    head = name.partition(".")[0]
    if head == PACKAGE.name:
        return _modules(name)
    path = folder / f"{head}.py"
    return (path,) if head.startswith("_") and path.is_file() else ()


@cache
def _modules(name: str) -> tuple[Path, ...]:
    """Return the files of a module of the package, and of the packages that hold it."""
    folder, files = PACKAGE, [PACKAGE / "__init__.py"]
    for component in name.split(".")[1:]:
        if (module := folder / f"{component}.py").is_file():
            files.append(module)
        folder = folder / component
        if (folder / "__init__.py").is_file():
            files.append(folder / "__init__.py")
    return tuple(files)
