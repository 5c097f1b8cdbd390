"""A study folder as the page sees it: settings and table, as texts of its form, and measured files."""

import re
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

import yaml

from roughcontact.app.fields import settings_of, texts_of
from roughcontact.configuration.generated import in_words
from roughcontact.configuration.models import Body, Settings
from roughcontact.configuration.study import read_study
from roughcontact.configuration.surfaces import COLUMNS, REQUIRED, read_table
from roughcontact.configuration.yaml_text import check_yaml
from roughcontact.errors import RoughContactError, SettingsError
from roughcontact.named_materials import named_bodies
from roughcontact.results.storage import write_text

CONFIG = Path("config/config.yaml")
MEASURED = Path("measured")  # where dropped files go
_HEAD = (
    "# Settings of roughcontact, written by its page; a missing key has its default, see config/README.md\n"
)
_KEPT = ".before-page"  # ends the name of a file that the page has not written and writes over
Rows = list[dict[str, str]]


def read_folder() -> tuple[dict[str, str], Rows]:
    """Return the settings of the working directory as texts, and the rows of its table."""
    texts: dict[str, str] = {}
    if CONFIG.is_file():
        check_yaml(CONFIG)
        texts = texts_of(yaml.safe_load(CONFIG.read_text(encoding="utf-8")) or {})
    table = Path(texts.pop("surfaces", "") or Settings.model_fields["surfaces"].default)
    if not table.is_file():
        return texts, []
    header, rows = read_table(table)
    return texts, [dict(zip(header, cells, strict=False)) for _, cells in rows]


def table_path() -> Path:
    """Return the path of the table: the one that the settings name."""
    stated = yaml.safe_load(CONFIG.read_text(encoding="utf-8")) if CONFIG.is_file() else None
    return Path((stated or {}).get("surfaces") or Settings.model_fields["surfaces"].default)


def files_of(texts: Mapping[str, str], rows: Rows) -> dict[Path, str]:
    """Return the text of the settings and of the table that stand for a form."""
    table = table_path()
    config = settings_of(texts)
    if str(table) != Settings.model_fields["surfaces"].default:
        config = {"surfaces": str(table), **config}
    settings = (
        yaml.safe_dump(config, sort_keys=False, allow_unicode=True, default_flow_style=None, width=100)
        if config
        else ""
    )
    used = {key for row in rows for key, cell in row.items() if cell.strip()} - {*REQUIRED}
    header = [*REQUIRED, *(name for name in (*COLUMNS, *sorted(used - {*COLUMNS})) if name in used)]
    cells = [[re.sub(r"\s+", " ", row.get(name, "")).strip() for name in header] for row in rows]
    return {CONFIG: _HEAD + settings, table: "".join("\t".join(line) + "\n" for line in (header, *cells))}


def check(texts: Mapping[str, str], rows: Rows) -> dict[str, Any]:
    """Return the files of a form, the mistakes in it by field, and the numbers of named materials."""
    try:
        files = files_of(texts, rows)
        config = settings_of(texts)
    except SettingsError as error:
        return {"files": {}, "mistakes": _by_field(str(error)), "defaults": {}}
    mistakes: dict[str, list[str]] = {}
    with tempfile.TemporaryDirectory() as folder:
        draft, table = Path(folder, "surfaces.tsv"), table_path()
        draft.write_text(files[table], encoding="utf-8")
        try:
            read_study(config | {"surfaces": str(draft)}, ["."], measured_in=["."], origin=str(CONFIG))
        except SettingsError as error:
            mistakes = _by_field(str(error).replace(str(draft), str(table)))
    return {
        "files": {str(path): text for path, text in files.items()},
        "mistakes": mistakes,
        "defaults": _of_materials(config),
    }


def write(texts: Mapping[str, str], rows: Rows) -> dict[str, Any]:
    """Write settings and table if they have no mistakes; return what `check` returns, and what was kept."""
    checked = check(texts, rows)
    kept = []
    if not checked["mistakes"]:
        for path, text in ((Path(name), text) for name, text in checked["files"].items()):
            before = path.read_text(encoding="utf-8") if path.is_file() else text
            if before != text and "#" in before.removeprefix(_HEAD):  # what somebody noted there
                spare = path.with_name(path.name + _KEPT)
                write_text(before, spare)
                kept.append(str(spare))
            if before != text or not path.is_file():
                write_text(text, path)
    return checked | {"kept": kept}


def _by_field(message: str) -> dict[str, list[str]]:
    """Return the sentences of a message by the name of the field they are about, else under an empty name."""
    sentences: dict[str, list[str]] = {}
    for line in message.splitlines():
        if line.startswith("mistakes in "):
            continue
        sentence = line.strip()
        row = re.match(r"(?:.*, )?line (\d+), (\w+)", sentence)
        setting = re.match(r"[\w.\[\]]+(?=:| = )", sentence)
        name = f"rows.{int(row[1]) - 2}.{row[2]}" if row else setting[0] if setting else ""
        sentences.setdefault(re.sub(r"\[(\d+)\]", r".\1", name), []).append(sentence)
    return sentences


def _of_materials(config: Mapping[str, Any]) -> dict[str, str]:
    """Return the numbers that named materials bring, by the names of their fields."""
    contact = config.get("contact", {})
    bodies = contact.get("bodies", ()) if isinstance(contact, dict) else ()
    try:
        full = named_bodies(bodies)
    except RoughContactError:
        return {}
    return {
        f"contact.bodies.{index}.{key}": in_words(value, Body.model_fields[key])
        for index, (body, stated) in enumerate(zip(full, bodies, strict=True))
        for key, value in (body.items() if isinstance(body, dict) else ())
        if key in Body.model_fields and key not in stated
    }


def add(paths: Sequence[str], rows: Rows) -> dict[str, Any]:
    """Return rows for files, and for those of folders that can be measurements, and the files left out."""
    from roughcontact.command_line.project import files_in, surface_names

    missing = [path for path in paths if not Path(path).exists()]
    if missing:
        raise SettingsError(f"{missing[0]}: no such file or folder")
    files, skipped = files_in(paths)
    present = {row.get("path") for row in rows}
    added = [path for path in map(_relative, files) if path not in present]
    names = surface_names([*(row.get("surface", "") + ".x" for row in rows), *added])[len(rows) :]
    new = [{"surface": name, "path": path} for name, path in zip(names, added, strict=True)]
    return {"rows": new, "skipped": skipped}


def _relative(path: str) -> str:
    """Return a path as seen from the study folder if it lies in it."""
    absolute = Path(path).resolve()
    return str(absolute.relative_to(Path.cwd()) if absolute.is_relative_to(Path.cwd()) else absolute)


def free_path(name: str) -> Path:
    """Return where a dropped file goes; a SettingsError for a name that is taken or none."""
    plain = PurePosixPath(name.replace("\\", "/")).name
    if plain in ("", ".", ".."):
        raise SettingsError(f"{name!r}: is no name of a file; rename it")
    path = MEASURED / plain
    if path.exists():
        raise SettingsError(f"{path} is there already: name its path instead, or rename the new file")
    return path


def inspect(row: Mapping[str, str]) -> dict[str, Any]:
    """Return what `roughcontact inspect` says of the file of a row, its channels, and a small map."""
    from roughcontact.command_line.describe import inspection
    from roughcontact.command_line.program import FILE_OPTIONS
    from roughcontact.configuration.surfaces import find
    from roughcontact.io.inspection import inspect_file
    from roughcontact.io.read import read_height_map
    from roughcontact.report.map_plots import height_map

    path = row.get("path", "")
    options = {name.replace("-", "_"): name for name in FILE_OPTIONS}
    stated: dict[str, Any] = {key: row[key] for key in options if row.get(key)}
    command = ["roughcontact", "inspect", path]
    command += [word for key, value in stated.items() for word in (f"--{options[key]}", value)]
    picture, problem, channels = "", None, []
    try:
        if find(path, ["."]) is None:
            raise SettingsError(f"{path}: no such file")
        content = inspect_file(path, **stated)
        text, problem = inspection(content, path), content["problem"]
        channels = [entry["name"] for entry in content["channels"] if entry["is_height"]]
        if content["map"]:
            picture = height_map(read_height_map(path, **stated)).source()
    except RoughContactError as error:
        text = problem = str(error)
    return {"text": text, "problem": problem, "channels": channels, "map": picture, "command": command}
