"""What the documentation says is what the code has: folders, settings, variables, columns, lines."""

import csv
import importlib
import re
import shlex
import sys
import tomllib
from pathlib import Path

import pytest
from PIL import Image

import roughcontact
from roughcontact.arguments.settings.fields import section_model
from roughcontact.arguments.settings.models import Settings
from roughcontact.arguments.variables import VARIABLES
from roughcontact.study.table.columns import COLUMNS

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "workflow/lib/roughcontact"


@pytest.fixture(scope="module")
def generated():
    """The module that writes the pages."""
    sys.path.insert(0, str(ROOT / "docs"))
    yield importlib.import_module("generated")
    sys.path.remove(str(ROOT / "docs"))


@pytest.fixture(scope="module")
def architecture():
    return (ROOT / "docs/architecture.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folders():
    """The folders of the package, and the modules that lie in none."""
    folders = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    return folders | {path.stem for path in PACKAGE.glob("*.py")} - {"__init__"}


def in_picture(architecture):
    """Return the rows of the picture, top first, each a set of folders and modules."""
    picture = re.search(r"```text\n(.*?)```", architecture, re.DOTALL).group(1)
    return [set(line.strip("│ ").split(" | ")) for line in picture.splitlines() if line.startswith("│")]


def test_the_picture_of_the_layout_has_exactly_the_folders_there_are(architecture, folders):
    rows = in_picture(architecture)
    assert set.union(*rows) == folders
    assert sum(map(len, rows)) == len(folders)


def test_the_picture_of_the_layout_is_the_order_that_the_linter_holds(architecture):
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    (layers,) = (contract["layers"] for contract in contracts if contract["type"] == "layers")
    assert in_picture(architecture) == [set(layer.split(" | ")) for layer in layers]


def test_the_table_of_the_layout_explains_every_folder_once(architecture, folders):
    table = architecture.partition("| folder or module | what is in it |")[2].partition("\n\n")[0]
    named = [name for row in table.splitlines() for name in re.findall(r"`(\w+)`", row.split(" | ")[0])]
    assert sorted(named) == sorted(folders)


def test_the_graph_of_the_rules_is_that_of_snakemake(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs/images")
    draw_rules = importlib.import_module("draw_rules")
    drawn = draw_rules.PICTURE.read_text(encoding="utf-8")
    assert drawn == draw_rules.drawing(draw_rules.rule_graph()), "run python docs/images/draw_rules.py"


def test_a_picture_of_the_report_is_told_from_one_of_another_page(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs/images")
    pictures = importlib.import_module("make_pictures")
    words = pictures.words_of('<head>1</head><body><h2 title="2">At a glance</h2><p>8.4 &plusmn; 0.77 %</p>')
    assert words == "At a glance 8.4 ± 0.77 %"
    assert not pictures.difference(words, words)
    assert not pictures.difference(words, words.replace("0.77", "0.78"))
    for variant in (words.replace("8.4", "9.4"), words.replace("±", "−"), f"{words} 1", f"{words} more", ""):
        assert pictures.difference(words, variant), variant
    committed = Image.open(ROOT / "docs/images/report.png").text[pictures.WORDS]
    assert committed.startswith("At a glance")  # `.ci/run` holds it against the page of the samples


def test_a_picture_of_another_page_ends_in_the_command_that_draws_it(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(ROOT / "docs/images")
    pictures = importlib.import_module("make_pictures")
    report = tmp_path / "a page.html"
    surface = (
        '<section class="surface" id="surface-sandblasted"><h2>s</h2><h3>Pressure and gap</h3></section>'
    )
    report.write_text(f'<body><section id="glance">other words</section>{surface}', encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        pictures.main(report.name, "--check")
    command = shlex.split(str(ended.value).partition("; draw it again: ")[2])
    assert command == [sys.executable, str(ROOT / "docs/images/make_pictures.py"), str(report)]


def test_every_setting_has_a_row(generated):
    page = generated.settings()
    for name, field in Settings.model_fields.items():
        section = section_model(field)
        part = page.partition(f"## `{name}`\n")[2].partition("\n## ")[0]
        assert part.strip()
        for key in section.model_fields if section else ():
            assert f"\n| `{key}` | " in part


def test_every_variable_has_a_row(generated):
    rows = generated.variables().splitlines()[2:]
    assert [row.split("`")[1] for row in rows] == list(VARIABLES)


def test_every_public_name_is_on_the_pages_of_the_interface(generated):
    pages = generated.interface()
    for name in roughcontact.__all__:
        assert name.startswith("_") or f".{name}\n" in pages["index"]
        assert name.startswith("_") or f".{name}\n" in pages["functions"]


def test_the_modules_for_users_are_shown_with_their_names_and_no_others(generated):
    page = generated.interface()["modules"]
    assert re.findall(r"automodule:: roughcontact\.(\S+)\n", page) == list(generated.MODULES)
    for module in generated.MODULES:
        listing = page.partition(f"automodule:: roughcontact.{module}\n   :members: ")[2].partition("\n")[0]
        defined = generated.public_names(PACKAGE.joinpath(*module.split(".")).with_suffix(".py"))
        assert set(listing.split(", ")) == set(defined) - set(roughcontact.__all__)


def test_pages_of_an_earlier_interface_are_removed(generated, tmp_path):
    (tmp_path / "api").mkdir()
    (tmp_path / "api/contact.md").write_text("# old")
    generated.write(tmp_path / "generated", tmp_path)
    assert sorted(path.stem for path in (tmp_path / "api").iterdir()) == ["functions", "index", "modules"]


def test_the_help_of_every_verb_is_shown(generated):
    page = generated.command_line_help()
    for words in ("usage: roughcontact [-h]", "usage: roughcontact inspect", "usage: roughcontact solve"):
        assert words in page
    assert "--level-form" in page


def test_every_column_of_the_table_of_surfaces_is_explained():
    text = (ROOT / "config/README.md").read_text(encoding="utf-8")
    table = text.partition("| column | meaning |")[2].partition("\n\n")[0]
    named = [name for row in table.splitlines() for name in re.findall(r"`(\w+)`", row.split(" | ")[0])]
    assert sorted(named) == sorted(COLUMNS)


def test_every_section_of_the_settings_is_named_beside_the_configuration():
    text = (ROOT / "config/README.md").read_text(encoding="utf-8")
    table = text.partition("| section | what it is |")[2]
    assert re.findall(r"^\| `(\w+)`", table, re.MULTILINE) == list(Settings.model_fields)


def test_every_line_of_the_validation_is_shown(generated):
    with (ROOT / "docs/explanation/validation.csv").open(newline="", encoding="utf-8") as file:
        lines_kept = [row["what"] for row in csv.DictReader(file)]
    lines_of_page = re.findall(r"^\| (.*?) \| ", generated.validation(), re.MULTILINE)
    lines_of_page = [what.replace("\\", "") for what in lines_of_page if what not in ("line", "---")]
    assert lines_of_page == lines_kept
    assert f"{len(lines_kept)} lines" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_every_dependency_is_in_the_table_of_dependencies():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    requirements = list(project["project"]["dependencies"])
    for extra in project["project"]["optional-dependencies"].values():
        requirements += extra
    for group in project["dependency-groups"].values():
        requirements += [entry for entry in group if isinstance(entry, str)]
    names = {re.match(r"[\w-]+", entry).group().lower() for entry in requirements}
    # named together with what they belong to
    names = {{"pytest-cov": "cov", "pytest-xdist": "xdist"}.get(name, name) for name in names}
    table = (ROOT / "docs/reference/dependencies.md").read_text(encoding="utf-8").lower()
    assert {name for name in names if not re.search(rf"(?<![\w-]){name}(?![\w-])", table)} == set()


def test_the_recipes_name_files_and_functions_that_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([^`\n]+)`", re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)))
    modules = [*PACKAGE.rglob("*.py"), *ROOT.glob("validation/*.py")]
    source = "\n".join(path.read_text(encoding="utf-8") for path in modules)
    files = {name for name in named if re.fullmatch(r"[\w./*-]+\.(py|md)", name) and "NAME" not in name}
    functions = {name for name in named if re.fullmatch(r"[a-z_]+_[a-z_]+|PartName|Check|RecognisedBy", name)}
    functions -= {"data_samples", *(path.name for path in PACKAGE.iterdir())}
    assert len(files) > 15
    assert len(functions) > 4
    assert [name for name in files if not (any(ROOT.glob(name)) or any(PACKAGE.glob(f"**/{name}")))] == []
    defined = set(re.findall(r"^(?:def |class )?(\w+)(?:\(| = )", source, re.MULTILINE))
    assert functions - defined == set()
