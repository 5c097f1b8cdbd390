"""The checksum of a script's modules covers whatever the script imports, and nothing else of the package."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from roughcontact.configuration import dependencies

ROOT = Path(__file__).parents[2]
PAGES = {"contact", "report"}
SOLVERS = {"contact", "unload"}
READERS = {"prepare", "contact"}
WINDOWS = {*READERS, "superpose"}
KERNELS = {"contact", "unload", "prepare", "superpose", "report"}  # roughness is transformed, too
SCRIPTS = sorted(path for path in (ROOT / "workflow/scripts").glob("[a-z]*.py"))
_PROBE = """
import ast, importlib, sys
tree = ast.parse(open(sys.argv[1]).read())
for node in ast.walk(tree):
    if isinstance(node, ast.ImportFrom) and node.module.startswith("roughcontact"):
        importlib.import_module(node.module)
print("\\n".join(m.__file__ for name, m in sys.modules.items() if name.split(".")[0] == "roughcontact"))
"""


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_all_that_is_imported_when_a_script_starts_is_covered(script):
    run = subprocess.run(
        [sys.executable, "-c", _PROBE, str(script)],
        env={"PYTHONPATH": str(ROOT / "workflow/lib")},
        capture_output=True,
        text=True,
        check=True,
    )
    loaded = {Path(line).resolve() for line in run.stdout.split()}
    assert loaded <= dependencies._closure(script)


def forget():
    """Look at the files anew, as every run does."""
    for known in (dependencies._imported, dependencies._folders, dependencies._modules):
        known.cache_clear()


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Return a copy of the package and its scripts that may be edited."""
    shutil.copytree(ROOT / "workflow", tmp_path / "workflow", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(dependencies, "PACKAGE", tmp_path / "workflow/lib/roughcontact")
    forget()
    yield tmp_path / "workflow"
    forget()


def digests(workflow):
    """Return the checksum of every script."""
    forget()
    return {path.stem: dependencies.source_digest(path) for path in (workflow / "scripts").glob("[a-z]*.py")}


@pytest.mark.parametrize(
    ("edited", "concerned"),
    [
        ("lib/roughcontact/window/periodisation.py", WINDOWS),
        ("lib/roughcontact/levelling/outliers.py", WINDOWS),
        ("lib/roughcontact/io/units.py", READERS),
        ("lib/roughcontact/kernels/c/passes.h", KERNELS),
        ("lib/roughcontact/io/readers/sdf.py", READERS),  # found in its folder at run time
        ("lib/roughcontact/io/instruments/library.py", READERS),
        ("lib/roughcontact/contact/solve.py", SOLVERS),
        ("lib/roughcontact/results/collect.py", {"report"}),
        ("lib/roughcontact/report/templates/report.css", PAGES),
        ("lib/roughcontact/configuration/models.py", set()),
        ("lib/roughcontact/pipeline.py", {"contact"}),
        ("scripts/_window.py", {"prepare", "superpose"}),
    ],
)
def test_an_edit_concerns_what_imports_the_module(package, edited, concerned):
    before = digests(package)
    path = package / edited
    path.write_bytes(path.read_bytes() + b"\n")
    after = digests(package)
    assert {name for name in before if before[name] != after[name]} == concerned


@pytest.mark.parametrize(
    "edited",
    ["scripts/_job.py", "lib/roughcontact/variables.tsv", "lib/roughcontact/uncertainty/calibration.json"],
)
def test_an_edit_of_what_all_share_concerns_all(package, edited):
    before = digests(package)
    path = package / edited
    path.write_bytes(path.read_bytes() + b"\n")
    after = digests(package)
    assert all(before[name] != after[name] for name in before)


def test_a_new_reader_concerns_what_reads_files(package):
    before = digests(package)
    (package / "lib/roughcontact/io/readers/another.py").write_text("from roughcontact.report import page\n")
    after = digests(package)
    assert {name for name in before if before[name] != after[name]} == READERS
    page = package / "lib/roughcontact/report/page.py"
    page.write_bytes(page.read_bytes() + b"\n")
    assert digests(package)["prepare"] != after["prepare"]
