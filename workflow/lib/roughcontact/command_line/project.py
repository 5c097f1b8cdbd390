"""The initial settings and table of surfaces of a study."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from roughcontact.errors import SettingsError
from roughcontact.io.folder import is_folder, measurements_in

_LONGEST_STEM = 56  # letters of a name made of that of a file; a number may follow
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
    contact: Mapping[str, Any] | None = None,
    statistics: Mapping[str, Any] | None = None,
) -> list[Path]:
    r"""Write settings and a table of the measured files into the folder `config`; return the written files.

    `contact` (`bodies`, `mean_pressure`) and `statistics` (`seal`, `joint`, `friction`) may be known; else
    examples stand there as comments.

    Examples
    --------
    >>> import contextlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
    ...     _ = Path("Ground 2.txt").write_text("1 2")
    ...     _ = write_project(["Ground 2.txt"])
    ...     Path("config/surfaces.tsv").read_text().splitlines()[-1]
    'Ground-2\tGround 2.txt'
    """
    from roughcontact.configuration.generated import default_yaml
    from roughcontact.configuration.resolve import resolve
    from roughcontact.configuration.surfaces import table_text
    from roughcontact.results.storage import write_text

    for path in _FILES:
        if path.exists():
            raise SettingsError(f"{path} already exists: change it, or go to another folder")
    for file in files:
        if not Path(file).is_file():
            raise SettingsError(f"{file}: no such file")
    rows = rows_of(files)
    sections = {"contact": contact or {}, "statistics": statistics or {}}
    if any(sections.values()):
        resolve(sections)
    texts = (
        default_yaml(head=_SETTINGS_HEAD, stated=sections),
        _TABLE_HEAD + table_text(rows) + ("" if rows else _TABLE_EXAMPLE),
    )
    for path, text in zip(_FILES, texts, strict=True):
        write_text(text, path)
    return list(_FILES)


def files_in(paths: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the files, of folders those that can be measurements, and those left out but for hidden ones."""
    files: list[Path] = []
    skipped: list[str] = []
    for path in map(Path, paths):
        if is_folder(path):
            measured, unmeasured = measurements_in(path)
            files += measured
            skipped += map(str, unmeasured)
        else:
            files.append(path)
    working_folder = Path.cwd()
    relative_paths = [
        file.relative_to(working_folder) if file.is_relative_to(working_folder) else file for file in files
    ]
    return list(dict.fromkeys(map(str, relative_paths))), skipped


def rows_of(
    files: Sequence[str | Path], *, present: Sequence[Mapping[str, str]] = ()
) -> list[dict[str, str]]:
    """Return a row of the table for each file, under a name that no row has that is `present`."""
    names = surface_names([*(f"{row.get('surface', '')}.x" for row in present), *files])[len(present) :]
    return [{"surface": name, "path": str(file)} for name, file in zip(names, files, strict=True)]


def surface_names(files: Sequence[str | Path]) -> list[str]:
    """Return a different admitted name of a surface for each file."""
    from roughcontact.configuration.messages import name_mistake

    names: list[str] = []
    for file in files:
        stem = re.sub(r"[^A-Za-z0-9]+", "-", Path(file).stem)[:_LONGEST_STEM].strip("-")
        stem = "surface" if name_mistake(stem) else stem
        further = (f"{stem}-{number}" for number in range(2, len(files) + 2))
        names.append(stem if stem not in names else next(name for name in further if name not in names))
    return names
