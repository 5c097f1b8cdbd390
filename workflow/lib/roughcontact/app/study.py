"""A study as the texts of a form, by dotted names (contact.bodies.0.material), and its two files."""

import re
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import yaml

from roughcontact.configuration.fields import field_at, grouped, is_list
from roughcontact.configuration.models import Settings
from roughcontact.configuration.plan import Plan
from roughcontact.configuration.study import read_study
from roughcontact.configuration.surfaces import read_table, table_text
from roughcontact.configuration.yaml_text import check_yaml
from roughcontact.errors import RoughContactError, SettingsError
from roughcontact.named_materials import named_bodies
from roughcontact.results.storage import write_text

CONFIG = Path("config/config.yaml")
_TABLE = Settings.model_fields["surfaces"].default
_HEAD = "# written by the page of roughcontact, see config/README.md\n"
_BACKUP = ".before-page"  # ends the name of a file that the page has not written and writes over
_STYLE: dict[str, Any] = {"sort_keys": False, "allow_unicode": True, "width": 100, "default_flow_style": None}
Row = dict[str, str]


class _Typed(str):
    """A text that stands in YAML as it was typed: 3 is a number, true a truth value."""


class _Dumper(yaml.SafeDumper):
    """A dumper of such texts."""


def _as_typed(dumper: yaml.SafeDumper, text: _Typed) -> yaml.ScalarNode:
    """Return the node of a text, of the type that YAML reads."""
    return dumper.represent_scalar(dumper.resolve(yaml.ScalarNode, text, (True, False)), str(text))


_Dumper.add_representer(_Typed, _as_typed)


def read_folder() -> tuple[dict[str, Any], list[Row]]:
    """Return the settings in the working directory, their values as written, and the rows of the table."""
    config: dict[str, Any] = {}
    if CONFIG.is_file():
        check_yaml(CONFIG)
        content = CONFIG.read_text(encoding="utf-8")
        config = yaml.load(content, yaml.BaseLoader)
        if cases := yaml.safe_load(content).get("cases"):
            config["cases"] = yaml.safe_dump(cases, **_STYLE)
    table = Path(config.get("surfaces", _TABLE))
    header, rows = read_table(table) if table.is_file() else ([], [])
    return config, [dict(zip(header, cells, strict=False)) for _, cells in rows]


def _value(name: str, text: str) -> Any:
    """Return the value of a field, its texts as they were typed."""
    field = field_at(name.split("."))
    if name == "cases":
        with suppress(yaml.YAMLError):
            return yaml.safe_load(text)
    if field and is_list(field.annotation):
        return [_Typed(entry.strip()) for entry in text.strip("[]").split(",") if entry.strip()]
    return _Typed(text) if field and field.annotation not in (str, str | None) else text


def check(texts: Mapping[str, str], rows: Sequence[Row]) -> dict[str, Any]:
    """Return the files of a form, mistakes by field, the bodies with all numbers, and the names of results.

    `texts` are those of the settings by dotted names.
    """
    config = grouped({name: _value(name, text.strip()) for name, text in texts.items() if text.strip()})
    settings = yaml.dump(config, Dumper=_Dumper, **_STYLE) if config else ""
    table = Path(texts.get("surfaces") or _TABLE)
    files, message = {CONFIG: _HEAD + settings, table: _HEAD + table_text(rows)}, ""
    results: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        drafts = {path: Path(folder, *path.parts[-2:]) for path in files}
        for path, draft in drafts.items():
            write_text(files[path], draft)
        try:
            if config:
                check_yaml(drafts[CONFIG])
            loaded = (yaml.safe_load(settings) or {}) | {"surfaces": str(drafts[table])}
            study = read_study(loaded, ["."], measured_in=["."], origin=str(CONFIG))
            results = Plan(*study).results
        except SettingsError as error:
            message = str(error).replace(f"{folder}/", "")
    try:
        bodies = named_bodies(config["contact"]["bodies"])
    except (RoughContactError, LookupError, TypeError):  # none is stated, or one that does not exist
        bodies = []
    mistakes = _by_field(message)
    return {"files": files, "mistakes": mistakes, "bodies": bodies, "results": results}


def write(files: Mapping[Path, str]) -> str:
    """Write the files that differ, and return what was done; what others had noted in them is kept."""
    summary = f"written: {', '.join(map(str, files))}"
    for path, text in files.items():
        before = path.read_bytes() if path.is_file() else b""
        if before == text.encode():
            continue
        if before and (not before.startswith(_HEAD.encode()) or b"\n#" in before):
            path.replace(spare := path.with_name(path.name + _BACKUP))
            summary += f"; what was there is kept as {spare}"
        write_text(text, path)
    return summary


def _by_field(message: str) -> dict[str, list[str]]:
    """Return the sentences of a message by the name of the field that they begin with."""
    sentences: dict[str, list[str]] = {}
    for sentence in map(str.strip, message.splitlines()):
        row = re.match(r"(?:.*, )?line (\d+), (\w+)", sentence)
        name = f"rows.{int(row[1]) - 3}.{row[2]}" if row else re.split(r"[^\w.\[\]]", sentence)[0]
        if not sentence.startswith("mistakes in "):
            name = "cases" if name.startswith("cases.") else re.sub(r"\[(\d+)\](?=.)", r".\1", name)
            sentences.setdefault(name.partition("[")[0], []).append(sentence)
    return sentences
