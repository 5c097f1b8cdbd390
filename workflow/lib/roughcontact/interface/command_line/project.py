"""The initial settings and table of surfaces of a study."""

import os
import re
import unicodedata
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

from roughcontact.errors import SettingsError
from roughcontact.interface.command_line.folders import contents_of, list_measurements

_MAX_STEM_LENGTH = 56  # letters of a name made of that of a file; a number may follow
_FILES = Path("config/config.yaml"), Path("config/surfaces.tsv")
_SETTINGS_HEAD = """\
# Settings of roughcontact with their defaults. A missing key has its default.
# State your materials and loads under `contact`, where there is no default; list your files in
# config/surfaces.tsv; then run `roughcontact run`.
"""
_TABLE_HEAD = """\
# One row for each surface: a name (letters, digits, -) and the file, separated by a tab.
# A row that starts with # is ignored. Further columns complete the files: dx and dy (steps
# between points) and unit (theirs), height_unit, channel.
"""
_TABLE_EXAMPLE = "# ground\tmeasured/ground.x3p\n"


def write_project(
    files: Sequence[str | Path],
    *,
    sections: Mapping[str, Mapping[str, Any]] | None = None,
    columns: Mapping[str, str] | None = None,
    groups: Mapping[str, str] | None = None,
    earlier_file: str = "",
) -> list[Path]:
    r"""Write settings and a table of the measured files into the folder `config`; return the written files.

    Settings of `sections` (`contact`, `form`, `statistics`), further `columns`, the same for all files,
    `groups` (file -> name) and the `earlier_file` of the place may be known; other settings are examples in
    comments.

    Examples
    --------
    >>> import contextlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
    ...     _ = Path("Ground 2.txt").write_text("1 2")
    ...     _ = write_project(["Ground 2.txt"])
    ...     Path("config/surfaces.tsv").read_text().splitlines()[-1]
    'Ground-2\tGround 2.txt'
    """
    from roughcontact.arguments.settings.generated import default_yaml
    from roughcontact.arguments.settings.resolve import resolve
    from roughcontact.results.storage import write_text
    from roughcontact.study.table.text import table_text

    for path in _FILES:
        if path.exists():
            raise SettingsError(f"{path} already exists: change it, or go to another folder")
    of_all, groups = dict(columns or {}), groups or {}
    rows = [
        row | ({"group": groups.get(row["path"], "")} if groups else {}) | of_all for row in rows_of(files)
    ]
    for row in rows if earlier_file else ():
        earlier = next(earlier_row["surface"] for earlier_row in rows if earlier_row["path"] == earlier_file)
        row["before"] = "" if row["path"] == earlier_file else earlier
    sections = sections or {}
    if any(sections.values()):
        resolve(sections)
    texts = (
        default_yaml(head=_SETTINGS_HEAD, values=sections),
        _TABLE_HEAD + table_text(rows) + ("" if rows else _TABLE_EXAMPLE),
    )
    for path, text in zip(_FILES, texts, strict=True):
        write_text(text, path)
    return list(_FILES)


def problems(files: Sequence[str | Path]) -> list[tuple[str, str]]:
    """Return the files that cannot be read as they are, each with what has to be given, or is wrong."""
    problems_of_files = {file: contents_of(file)["problem"] for file in map(str, files)}
    return [(file, text.removeprefix(f"{file}: ")) for file, text in problems_of_files.items() if text]


def collect_files(paths: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the files, of folders those that can be measurements, and those left out but for hidden ones."""
    files: list[Path] = []
    omissions: list[str] = []
    for path in map(Path, paths):
        if os.path.isdir(path):  # noqa: PTH112 - false also of a path that is too long
            measurements, other_files = list_measurements(path)
            files += measurements
            omissions += map(str, other_files)
        elif path.is_file():
            files.append(path)
        else:
            raise SettingsError(f"{path}: no such file or folder")
    working_folder = Path.cwd()
    relative_paths = [
        file.relative_to(working_folder) if file.is_relative_to(working_folder) else file for file in files
    ]
    return list(dict.fromkeys(map(str, relative_paths))), omissions


def rows_of(
    files: Sequence[str | Path], *, present: Sequence[Mapping[str, str]] = ()
) -> list[dict[str, str]]:
    """Return a row of the table for each file, under a name that no row has that is `present`."""
    names = surface_names([*(f"{row.get('surface', '')}.x" for row in present), *files])[len(present) :]
    return [{"surface": name, "path": str(file)} for name, file in zip(names, files, strict=True)]


def surface_names(files: Sequence[str | Path]) -> list[str]:
    """Return a different admitted name of a surface for each file, capitals alone being no difference."""
    from roughcontact.arguments.settings.messages import name_mistake

    names: dict[str, str] = {}  # by themselves in small letters
    for file in files:
        letters = unicodedata.normalize("NFC", Path(file).stem)  # macOS writes ü as two
        stem = re.sub(r"[\W_]+", "-", letters)[:_MAX_STEM_LENGTH].strip("-")
        stem = "surface" if name_mistake(stem) else stem
        further = (f"{stem}-{number}" for number in range(2, len(files) + 2))
        name = next(name for name in chain([stem], further) if name.lower() not in names)
        names[name.lower()] = name
    return [*names.values()]
