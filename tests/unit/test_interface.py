"""The public names: what is imported on first use, what editors and type checkers are told of it."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import roughcontact as rc

STUB = Path(rc.__file__).with_suffix(".pyi")
SNIPPET = """\
from typing import assert_type
import xarray as xr
import roughcontact as rc
height = rc.read_height_map("map.txt")
assert_type(height, xr.DataArray)
assert_type(rc.evaluate(height, contact_modulus=1e9), xr.Dataset)
assert_type(rc.solve_contact(rc.periodic_window(height), contact_modulus=1e9, mean_pressure=1e6), xr.Dataset)
rc.read_height_map(3, nonsense=True)  # type: ignore[call-arg, arg-type]
rc.evaluated  # type: ignore[attr-defined]
rc.plot.area(height)  # type: ignore[arg-type]
"""


def test_types_are_those_of_the_names_that_are_imported_on_first_use():
    stub = ast.parse(STUB.read_text(encoding="utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    assert all(name.asname == name.name for node in imports for name in node.names)
    homes = {name.name: node.module for node in imports for name in node.names}
    assert homes == rc._HOME | {name: module.rpartition(".")[0] for name, module in rc._MODULES.items()}


@pytest.mark.slow  # the checker reads all that is imported
def test_a_type_checker_sees_the_signatures(tmp_path):
    pytest.importorskip("mypy")
    (tmp_path / "snippet.py").write_text(SNIPPET, encoding="utf-8")
    options = ["--warn-unused-ignores", "--ignore-missing-imports", "--no-incremental", "--config-file="]
    command = [sys.executable, "-m", "mypy", *options, "snippet.py"]
    checked = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout


def test_the_plots_are_those_that_are_listed():
    functions = {
        name for name, value in vars(rc.plot).items() if getattr(value, "__module__", "") == rc.plot.__name__
    }
    assert {name for name in functions if not name.startswith("_")} == set(rc.plot.__all__)
