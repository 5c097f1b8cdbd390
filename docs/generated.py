"""Pages that are written from the code: settings, variables, command line, modules, lines of the validation.

The texts stand once, in the code; `conf.py` has them written into docs/generated/ and docs/reference/api/
before every build.
"""

import ast
import contextlib
import csv
import io
import os
import re
from itertools import groupby
from pathlib import Path
from unittest import mock

import yaml

import roughcontact
from roughcontact.arguments.settings.fields import section_model, setting_choices
from roughcontact.arguments.settings.models import Settings
from roughcontact.arguments.variables import VARIABLES
from roughcontact.interface import program
from validation.lines import Evidence, Line
from validation.page import cells

PACKAGE = Path(roughcontact.__file__).parent
VALIDATION = Path(__file__).parent / "explanation" / "validation.csv"
# the modules that users and authors of readers call, beside the functions of `roughcontact`
MODULES = (
    "report.plot",
    "results.exchange",
    "statistics.contact_statistics",
    "statistics.checks",
    "statistics.theory",
    "surface.roughness.heights",
    "surface.roughness.parameters",
    "surface.roughness.spectrum",
    "surface.roughness.texture",
    "surface.synthetic",
    "arguments.quantities",
    "io.interface",
    "kernels.memory",
)


def write(generated: Path, reference: Path) -> None:
    """Write all generated pages, each only where it has changed, so that Sphinx builds no page twice.

    Pages of the Python interface from earlier versions are removed.
    """
    pages = {
        generated / "settings.md": settings(),
        generated / "variables.md": variables(),
        generated / "materials.md": materials(),
        generated / "command-line.md": command_line_help(),
        generated / "validation.md": validation(),
        **{reference / "api" / f"{name}.md": text for name, text in interface().items()},
    }
    for path in set((reference / "api").glob("*.md")) - set(pages):
        path.unlink()
    for path, text in pages.items():
        path.parent.mkdir(exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def settings() -> str:
    """Return one table for each section of the settings: key, default, what it may be, meaning."""
    parts = []
    for name, field in Settings.model_fields.items():
        section = section_model(field)
        if section is None:
            parts.append(f"## `{name}`\n\n{_sentence(field.description)} Default: {_default(field)}.")
            continue
        rows = [
            (f"`{key}`", _default(entry), _cell(entry.description) + _words(entry))
            for key, entry in section.model_fields.items()
        ]
        parts.append(f"## `{name}`\n\n{section.__doc__}\n\n" + _table(("key", "default", "meaning"), rows))
    return "\n\n".join(parts) + "\n"


def variables() -> str:
    """Return the table of all names that a result file can hold."""
    rows = [(f"`{name}`", unit or "", _cell(meaning)) for name, (unit, meaning) in VARIABLES.items()]
    return _table(("name", "unit", "meaning"), rows) + "\n"


def materials() -> str:
    """Return the table of materials by name, with the range of each property behind its value."""
    text = (PACKAGE / "arguments/materials.tsv").read_text(encoding="utf-8")
    sources = [line.removeprefix("# ") for line in text.splitlines() if line.startswith("#")]
    _, *rows = (line.split("\t") for line in text.splitlines() if not line.startswith("#"))
    shown = [
        (
            name,
            aliases.replace(",", ", "),
            *(re.sub(r" (\S+) (\S+)$", r" (\1–\2)", cell) for cell in cells[:-2]),
            cells[-2].replace(" ", " to "),
            cells[-1],
        )
        for name, aliases, *cells in rows
    ]
    heads = (
        "name",
        "also",
        "E (GPa)",
        "ν",
        "hardness (GPa)",
        "yield (MPa)",
        "k (W/m K)",
        "ρ (nΩ m)",
        "solid or in use (°C)",
        "source",
    )
    return (
        f"{sources[0]}\n\n"
        + _table(heads, shown)
        + "\n\nSources:\n\n"
        + "\n".join(f"- {s}" for s in sources[1:])
        + "\n"
    )


def validation() -> str:
    """Return the lines of the kept validation, one table for each part, rounded as its own page does."""
    with VALIDATION.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    parts = [f"{len(rows)} lines, each within its tolerance."]
    header = ("line", "reference", "roughcontact", "deviation", "tolerance")
    for name, lines in groupby(rows, key=lambda row: row["section"]):
        table = [tuple(map(_cell, validation_line(row))) for row in lines]
        parts.append(f"### {name.replace('_', ' ').capitalize()}\n\n{_table(header, table)}")
    return "\n\n".join(parts) + "\n"


def validation_line(row: dict[str, str]) -> tuple[str, ...]:
    """Return a row of the kept table as the page of the validation shows it."""
    numbers = [float(row[name]) for name in ("reference", "value", "deviation")]
    nowhere = Evidence(formula="", source="", code="", test="")
    line = Line(row["what"], *numbers, row["measure"], float(row["tolerance"]), row["reason"], nowhere)
    if not line.holds:
        raise ValueError(f"{VALIDATION}: a line beyond its tolerance: {row['what']}")
    shown = cells(line)
    return (row["what"], *(shown[name] for name in ("reference", "value", "deviation", "tolerance")))


def command_line_help() -> str:
    """Return what `--help` prints, of the program and of its verbs."""
    parts = []
    for arguments in ([], ["inspect"], ["solve"]):
        printed = io.StringIO()
        with (
            mock.patch.dict(os.environ, {"COLUMNS": "90"}),
            contextlib.redirect_stdout(printed),
            contextlib.suppress(SystemExit),
        ):
            program.main([*arguments, "--help"])
        title = " ".join(["roughcontact", *arguments])
        parts.append(f"## `{title}`\n\n```text\n{printed.getvalue().rstrip()}\n```\n")
    return "\n".join(parts)


def interface() -> dict[str, str]:
    """Return the pages of the Python interface by name: `index`, public functions, other modules."""
    names = [name for name in roughcontact.__all__ if not name.startswith("_")]
    summary = "\n".join(f"   {_home(name)}" for name in names)
    functions = []
    for name in names:
        directive = "autoexception" if isinstance(getattr(roughcontact, name), type) else "autofunction"
        target = _home(name).removeprefix("~")
        functions.append(f"## `{name}`\n\n```{{eval-rst}}\n.. {directive}:: {target}\n```")
    modules = []
    for module in MODULES:
        path = PACKAGE.joinpath(*module.split(".")).with_suffix(".py")
        members = ", ".join(name for name in public_names(path) if name not in names)
        modules.append(
            f"## `roughcontact.{module}`\n\n"
            f"```{{eval-rst}}\n.. automodule:: roughcontact.{module}\n   :members: {members}\n```"
        )
    index = (
        "These are reachable as `roughcontact.NAME`; everything else is imported from its module.",
        f"```{{eval-rst}}\n.. autosummary::\n   :nosignatures:\n\n{summary}\n```",
        "```{toctree}\n:hidden:\n\nfunctions\nmodules\n```",
    )
    pages = {
        "index": ("# Python interface", *index),
        "functions": ("# Public functions", *functions),
        "modules": ("# Other modules for users", *modules),
    }
    return {name: "\n\n".join(parts) + "\n" for name, parts in pages.items()}


def public_names(path: Path) -> list[str]:
    """Return the functions and classes that a module defines for others, in their order."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    kinds = (ast.FunctionDef, ast.ClassDef)
    return [node.name for node in tree.body if isinstance(node, kinds) and not node.name.startswith("_")]


def _home(name: str) -> str:
    """Return the full name of a public verb, where it is defined."""
    return f"~{getattr(roughcontact, name).__module__}.{name}"


def _default(field) -> str:
    """Return the default of a setting, as YAML writes it."""
    value = field.get_default(call_default_factory=True)
    text = yaml.safe_dump(value, default_flow_style=True).removesuffix("\n...\n").strip()
    return f"`{text}`"


def _words(field) -> str:
    """Return the words that a setting may be, as the end of a sentence."""
    words = setting_choices(field)
    return f"; one of {', '.join(f'`{word}`' for word in words)}" if words else ""


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."


def _cell(text: str) -> str:
    """Return text as one cell of a table of Markdown."""
    return text.replace("|", "\\|").replace("*", "\\*").replace("<", "\\<")


def _table(header, rows) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in lines)
