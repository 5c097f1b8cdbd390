"""The checksum of a script's modules covers whatever the script imports, and nothing else of the package."""

import ast
import shutil
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from roughcontact.study import dependencies, readers

ROOT = Path(__file__).parents[2]
PAGES = {"panel", "report"}
SOLVERS = {"contact", "panel", "course", "unload"}  # the report of all surfaces reads what is stored
READERS = {"prepare", "contact"}
UNITS = {*READERS, "panel"}
WINDOWS = {*UNITS, "superpose", "course"}
KERNELS = {
    "contact",
    "panel",
    "course",
    "unload",
    "prepare",
    "superpose",
    "report",
}  # roughness is transformed, too
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
    assert loaded <= {*map(Path, dependencies._closure(str(script)))}


def forget():
    """Look at the files anew, as every run does."""
    for name in ("_read", "_imported", "_entries", "_sources", "_modules"):
        getattr(dependencies, name).cache_clear()


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
        ("lib/roughcontact/surface/window/periodisation.py", WINDOWS),
        ("lib/roughcontact/surface/levelling/outliers.py", WINDOWS - {"panel"}),
        ("lib/roughcontact/io/units.py", UNITS),
        ("lib/roughcontact/kernels/c/passes.h", KERNELS),
        ("lib/roughcontact/io/readers/sdf.py", set()),  # of the files that it reads: `study.readers`
        ("lib/roughcontact/io/instruments/library.py", set()),
        ("lib/roughcontact/contact/solve.py", SOLVERS),
        ("lib/roughcontact/results/collect.py", {"report"}),
        ("lib/roughcontact/report/templates/report.css", PAGES),
        ("lib/roughcontact/arguments/tables.tsv", PAGES),  # words
        ("lib/roughcontact/arguments/settings/models.py", set()),
        ("lib/roughcontact/evaluation/pipeline.py", {"contact"}),
        ("lib/roughcontact/uncertainty/calibration.json", {"contact", "panel", "report", "course"}),
        ("scripts/_window.py", {"prepare", "superpose", "course"}),
    ],
)
def test_an_edit_concerns_what_imports_the_module(package, edited, concerned):
    digests_before = digests(package)
    path = package / edited
    path.write_bytes(path.read_bytes() + b"\n")
    digests_after = digests(package)
    assert {name for name in digests_before if digests_before[name] != digests_after[name]} == concerned


@pytest.mark.parametrize("edited", ["scripts/_job.py", "lib/roughcontact/arguments/variables.tsv"])
def test_an_edit_of_what_all_share_concerns_all(package, edited):
    digests_before = digests(package)
    path = package / edited
    path.write_bytes(path.read_bytes() + b"\n")
    digests_after = digests(package)
    assert all(digests_before[name] != digests_after[name] for name in digests_before)


@pytest.mark.parametrize("reader", ["readers/digital_surf.py", "instruments/library.py"])
def test_a_table_in_the_folder_above_concerns_the_module_that_names_it(package, reader):
    folder = package / "lib/roughcontact/io"
    digest = dependencies.source_digest(folder / reader)
    table = folder / ("digital_surf.tsv" if "digital" in reader else "formats.tsv")
    table.write_bytes(table.read_bytes() + b"\n")
    forget()
    assert dependencies.source_digest(folder / reader) != digest


def test_a_reader_concerns_the_files_that_it_reads(package, monkeypatch, tmp_path):
    monkeypatch.setattr(readers, "PACKAGE", dependencies.PACKAGE)
    monkeypatch.chdir(tmp_path)
    np.save("map.npy", np.zeros((3, 4)))
    Path("map.txt").write_text("1 2\n3 4\n")

    def of_files():
        forget()
        for cached_function in (readers._digest, readers._all_readers, readers.noted):
            cached_function.cache_clear()
        return [readers.reader_digest(path) for path in ("map.npy", "map.txt")]

    folder = package / "lib/roughcontact/io"
    array, text = of_files()
    assert array.startswith("npy ")
    assert text.startswith("text ")
    (folder / "readers/another.py").write_text("from roughcontact.report import page\n")
    assert of_files() == [array, text]
    for edited, changed in (("text/columns.py", [False, True]), ("readers/npy.py", [True, False])):
        digests_before = of_files()
        (folder / edited).write_bytes((folder / edited).read_bytes() + b"\n")
        assert [a != b for a, b in zip(of_files(), digests_before, strict=True)] == changed
    assert readers.reader_digest("none.npy") == ""


def test_whatever_a_script_imports_is_there():
    """A dry run plans the jobs without their scripts."""
    for script in (ROOT / "workflow/scripts").glob("*.py"):
        for node in ast.walk(ast.parse(script.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("roughcontact"):
                module = import_module(node.module)
                for name in (entry.name for entry in node.names):
                    assert hasattr(module, name) or find_spec(f"{node.module}.{name}"), (script.name, name)
