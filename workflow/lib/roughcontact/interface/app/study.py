"""A study as the texts of a form, by dotted names (contact.bodies.0.material), and its two files."""

import os
import re
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import chain, count
from pathlib import Path
from typing import Any

import yaml

from roughcontact.arguments.named_materials import named_bodies
from roughcontact.arguments.settings.fields import field_at, grouped, is_list, section_model
from roughcontact.arguments.settings.models import Settings
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.errors import RoughContactError, SettingsError
from roughcontact.io.guards import brief
from roughcontact.results.storage import write_text
from roughcontact.study.plan import Plan
from roughcontact.study.study import read_study
from roughcontact.study.table.columns import REQUIRED
from roughcontact.study.table.read import read_surfaces
from roughcontact.study.table.text import read_table, table_text
from roughcontact.study.yaml_text import check_yaml

CONFIG = Path("config/config.yaml")
_TABLE = Settings.model_fields["surfaces"].default
_HEAD = "# written by the page of roughcontact, see config/README.md"
_JOB = re.compile(rf"{re.escape(_HEAD)}; asked: (\w+)\n")
_BACKUP = ".before-page"  # ends the name of a file that the page has not written and writes over
_STYLE: dict[str, Any] = {"sort_keys": False, "allow_unicode": True, "width": 100, "default_flow_style": None}
Row = dict[str, str]


class _Typed(str):
    """A text that stands in YAML as it was typed: 3 is a number, true a truth value."""


class _Dumper(yaml.SafeDumper):
    """A dumper of such texts."""


_Dumper.add_representer(
    _Typed,
    lambda dumper, text: dumper.represent_scalar(
        dumper.resolve(yaml.ScalarNode, text, (True, False)), str(text)
    ),
)


def read_folder() -> tuple[dict[str, Any], list[Row], str]:
    """Return the settings in the working directory, their values as written, the rows, and the question."""
    config: dict[str, Any] = {}
    job = ""
    if CONFIG.is_file():
        check_yaml(CONFIG)
        content = CONFIG.read_text(encoding="utf-8")
        job = match[1] if (match := _JOB.match(content)) else "area"
        config, values = yaml.load(content, yaml.BaseLoader), yaml.safe_load(content)
        # neither a name, nor settings that the form could hold: it has fields of these names
        if not isinstance(config.get("surfaces", ""), str) or {"rows", "page"} & config.keys():
            resolve(values, origin=str(CONFIG))
        if cases := values.get("cases"):
            config["cases"] = yaml.safe_dump(cases, **_STYLE)
    table = Path(config.get("surfaces", _TABLE))
    header, rows = read_table(table) if table.is_file() else ([], [])
    if "." in "".join(header) or len(header) > len({*header}):  # no fields of the form
        read_surfaces(table)
    named_cells = [zip(header, cells, strict=False) for _, cells in rows]
    # an empty cell asks for no field
    table_rows = [{name: cell for name, cell in row if cell or name in REQUIRED} for row in named_cells]
    return config, table_rows, job


def error_in_words(error: Exception) -> str:
    """Return what is wrong in a sentence, whatever was raised: an own one, or that it is to be reported."""
    if isinstance(error, RoughContactError | OSError):
        return str(error)
    return f"{type(error).__name__}: {brief(error)} (unexpected, please report it)"


def check_within_study(*paths: Path) -> None:
    """Raise a SettingsError for a path, or a link below it, that leads out of the working directory."""
    links = [link for path in paths for link in path.rglob("*") if link.is_symlink()]
    for path in (*paths, *links):
        if not Path(target := os.path.realpath(path)).is_relative_to(Path.cwd().resolve()):
            raise SettingsError(
                f"{path}: outside the study ({target}) the page writes nothing: use a terminal"
            )


def _values(texts: Mapping[str, str]) -> dict[str, Any]:
    """Return the values of fields by their names, of a list under one, texts as they were typed."""
    values: dict[str, Any] = {}
    for name, text in ((name, text.strip()) for name, text in texts.items() if text.strip()):
        field = field_at(name.split("."))
        if name == "cases":
            values[name] = text
            with suppress(yaml.YAMLError):
                values[name] = yaml.safe_load(text)
        elif field and is_list(field.annotation) and not section_model(field):
            # a comma between digits is a decimal one, which the settings refuse
            entries = re.split(r",(?!\d)|(?<!\d),", text.strip("[]"))
            listed = values.setdefault(re.sub(r"\.\d+$", "", name), [])
            listed.extend(_Typed(entry.strip()) for entry in entries if entry.strip())
        else:
            values[name] = _Typed(text) if field and field.annotation not in (str, str | None) else text
    return values


def check(texts: Mapping[str, str], rows: Sequence[Row], *, job: str = "") -> dict[str, Any]:
    """Return the files of a form, mistakes by field, bodies with all numbers, and the plan of a run.

    `texts` are those of the settings by dotted names, `job` is the question.
    """
    config = grouped(_values(texts))
    settings = yaml.dump(config, Dumper=_Dumper, **_STYLE) if config else ""
    table, mistakes = Path(texts.get("surfaces") or _TABLE), dict[str, list[str]]()
    files = {CONFIG: f"{_HEAD}; asked: {job}\n{settings}" if job else f"{_HEAD}\n{settings}"}
    plan = None
    with tempfile.TemporaryDirectory() as folder:
        drafts = {CONFIG: Path(folder, CONFIG), table: Path(folder, "surfaces.tsv")}
        try:
            check_within_study(CONFIG, table)
            files[table] = f"{_HEAD}\n{table_text(rows)}"
            for path, text in files.items():
                write_text(text, drafts[path])
            if config:
                check_yaml(drafts[CONFIG])
            content = (yaml.safe_load(settings) or {}) | {"surfaces": str(drafts[table])}
            plan = Plan(*read_study(content, ["."], measured_in=[".", table.parent], origin=str(CONFIG)))
        except SettingsError as error:
            for mistake in error.mistakes or (error,):
                sentence = str(mistake).replace(str(drafts[table]), str(table)).replace(f"{folder}/", "")
                mistakes.setdefault(_field_of(mistake), []).append(sentence)
    bodies = []
    with suppress(RoughContactError, LookupError, TypeError):  # none is stated, or one that does not exist
        bodies = named_bodies(config["contact"]["bodies"])
    return {"files": files, "mistakes": mistakes, "bodies": bodies, "plan": plan}


def write(files: Mapping[Path, str], *, keep: bool) -> str:
    """Write the files that differ, and return what was done; what others had noted in them is kept.

    With `keep` that of the page is, too: it could not be read.
    """
    check_within_study(*files)
    summary = f"saved in {' and '.join(map(str, files))}"
    for path, text in files.items():
        previous = path.read_bytes() if path.is_file() else b""
        if previous == text.encode():
            continue
        if previous and (keep or not previous.startswith(_HEAD.encode()) or b"\n#" in previous):
            spares = (path.with_name(f"{path.name}{_BACKUP}{number}") for number in chain([""], count(2)))
            # an earlier one stays, what it holds is nowhere else
            path.replace(spare := next(spare for spare in spares if not os.path.lexists(spare)))
            summary += f"; what was there is kept as {spare}"
        write_text(text, path)
    return summary


def _field_of(mistake: SettingsError) -> str:
    """Return the name of the field of a mistake, as the form has it; empty where there is none."""
    head, *keys = mistake.place.split(".")
    if head == "rows":  # by their lines, which begin with those of the head of the file and of the columns
        return f"rows.{int(keys[0]) - 3}.{keys[1]}"
    # contact.bodies[0].hardness is a field of its own, an entry of a list belongs to that of the list
    return "cases" if head == "cases" else re.sub(r"\[(\d+)\](?=.)", r".\1", mistake.place).partition("[")[0]
