"""A study as the texts of a form, by dotted names (contact.bodies.0.material): its question and two files."""

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from itertools import chain, count
from pathlib import Path
from typing import Any

import yaml

from roughcontact.arguments.kinds import SETTINGS_OF_KIND
from roughcontact.arguments.named_materials import named_bodies
from roughcontact.arguments.rows import rows_beside
from roughcontact.arguments.settings.fields import field_at, flattened, grouped, is_list, section_model
from roughcontact.arguments.settings.models import Settings
from roughcontact.errors import RoughContactError, SettingsError
from roughcontact.io.guards import brief
from roughcontact.results.storage import write_text
from roughcontact.study.places import find_file
from roughcontact.study.plan import Plan
from roughcontact.study.study import read_study
from roughcontact.study.table.columns import REQUIRED
from roughcontact.study.table.text import read_table, table_text
from roughcontact.study.yaml_text import check_yaml

CONFIG = Path("config/config.yaml")
TICKED = "ticked"  # the cell of a row of the form that is chosen, which is in no file
FOLDER = Path(__file__).with_name("page")
_MATERIALS = ["contact.bodies.0.material", "contact.bodies.1.material"]
JOBS: dict[str, Any] = {
    key: {
        "question": question,
        "settings": [*_MATERIALS, *settings.split()],
        "columns": columns.split(),
        "made": dict(setting.split("=") for setting in presets.split()),
    }
    for key, question, columns, presets, settings in rows_beside(__file__, "jobs.tsv")
}
_TABLE = Settings.model_fields["surfaces"].default
_HEAD = "# written by the page of roughcontact, see config/README.md"
_JOB = re.compile(rf"{re.escape(_HEAD)}; asked: (\w+)\n")
_BACKUP = ".before-page"  # ends the name of a file that the page has not written and writes over
_STYLE: dict[str, Any] = {"sort_keys": False, "allow_unicode": True, "width": 100, "default_flow_style": None}
Row = dict[str, str]


class _Typed(str):
    """A text that stands in YAML as it was typed: 3 is a number, true a truth value."""


yaml.SafeDumper.add_representer(
    _Typed,
    lambda dumper, text: dumper.represent_scalar(dumper.resolve(yaml.ScalarNode, text, (True, False)), text),
)


def names_of(job: str) -> list[str]:
    """Return the settings of a question by dotted names, first the materials; none without a question."""
    return JOBS[job]["settings"] if job in JOBS else []


def texts_for(job: str, texts: Mapping[str, str], aside: dict[str, str]) -> dict[str, str]:
    """Return the texts of a form for a question.

    Loads and forms of another question, a study having one kind of them, are kept `aside` until it is back.
    """
    aside |= {name: text for name, text in texts.items() if text and name.startswith(SETTINGS_OF_KIND)}
    of_job = [name for name in aside if name.startswith(tuple(names_of(job)))]
    remaining_texts = {name: text for name, text in texts.items() if not name.startswith(SETTINGS_OF_KIND)}
    return remaining_texts | {name: aside.pop(name) for name in of_job} | JOBS[job]["made"]


def read_folder() -> tuple[dict[str, str], list[Row], str]:
    """Return the texts of the settings in the working directory by dotted names, rows, and question."""
    texts, values, job = dict[str, str](), dict[str, Any](), ""
    if CONFIG.is_file():
        values, content = check_yaml(CONFIG), CONFIG.read_text(encoding="utf-8")
        job = match[1] if (match := _JOB.match(content)) else "area"
        texts = flattened(yaml.load(content, yaml.BaseLoader) | {"cases": ""})
        texts = {name_of_field(name): text for name, text in texts.items()}
        texts["cases"] = yaml.safe_dump(values["cases"], **_STYLE) if values.get("cases") else ""
    table = _table(values)
    header, rows = read_table(table) if table.is_file() else ([], [])
    named_cells = [zip(header, cells, strict=False) for _, cells in rows]
    # an empty cell asks for no field
    return texts, [{name: cell for name, cell in row if cell or name in REQUIRED} for row in named_cells], job


def name_of_field(name: str) -> str:
    """Return how the form has a value: one for a list is its first entry, a word for a body its material."""
    field = field_at(name.split("."))
    if not field or not is_list(field.annotation):
        return name
    is_section, is_entry = bool(section_model(field)), name.rpartition(".")[2].isdecimal()
    return name if is_section != is_entry else f"{name}.material" if is_section else f"{name}.0"


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


def save(texts: Mapping[str, str], rows: Sequence[Row], *, job: str, keep: bool) -> str:
    """Write the files of a form where they differ, and return what was done.

    `texts` are those of the settings by dotted names, `job` is the question. What others had noted in the
    files is kept; with `keep` that of the page is, too: it could not be read.
    """
    values = {"surfaces": _TABLE} | _values(texts)
    settings = yaml.safe_dump(grouped(values), **_STYLE)
    cells = [{name: cell for name, cell in row.items() if name != TICKED} for row in rows]
    table, head = Path(values["surfaces"]), f"{_HEAD}; asked: {job}" if job else _HEAD
    files = {CONFIG: f"{head}\n{settings}", table: f"{_HEAD}\n{table_text(cells)}"}
    check_within_study(*files)
    summary = f"saved in {CONFIG} and {table}"
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


def contents(paths: Iterable[Path]) -> dict[Path, str]:
    """Return what files hold, by their paths; an empty text where there is none."""
    return {
        path: path.read_text(encoding="utf-8", errors="replace") if find_file(path, ["."]) else ""
        for path in paths
    }


def check() -> dict[str, Any]:
    """Return what the files hold: texts, mistakes by field, bodies with all numbers, the plan of a run."""
    config: dict[str, Any] = {}
    report: dict[str, Any] = {"mistakes": {}, "bodies": [], "plan": None, "files": contents([CONFIG])}
    try:
        if CONFIG.is_file():
            config = check_yaml(CONFIG)
        report["files"] |= contents([_table(config)])
        report["plan"] = Plan(*read_study(config, ["."], measured_in=["."], origin=str(CONFIG)))
    except SettingsError as error:
        for mistake in error.mistakes or (error,):
            report["mistakes"].setdefault(_field_of(mistake, config), []).append(str(mistake))
    with suppress(RoughContactError, LookupError, TypeError):  # none is stated, or one that does not exist
        report["bodies"] = named_bodies(config["contact"]["bodies"])
    return report


def _field_of(mistake: SettingsError, config: Mapping[str, Any]) -> str:
    """Return the name of the field of a mistake, as the form has it; empty where there is none."""
    head, *keys = mistake.place.split(".")
    if head == "rows" and keys:  # by their lines
        lines = [line for line, _ in read_table(_table(config))[1]]
        return f"rows.{lines.index(int(keys[0]))}.{keys[1]}"
    # contact.bodies[0].hardness is a field of its own, an entry of a list belongs to that of the list
    return "cases" if head == "cases" else re.sub(r"\[(\d+)\](?=.)", r".\1", mistake.place).partition("[")[0]


def _table(config: Mapping[str, Any]) -> Path:
    """Return the path of the table of surfaces."""
    return Path(str(config.get("surfaces", _TABLE)))
