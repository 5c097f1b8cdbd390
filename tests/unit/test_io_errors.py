"""Whatever a reader raises leaves as one sentence on the file, through every door."""

import ast
import os
import string
import subprocess
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from option_pairs import every_pair

import roughcontact
from roughcontact import InputFileError, inspect_file, read_height_map
from roughcontact.interface.command_line.folders import list_measurements
from roughcontact.interface.program import main
from roughcontact.io.channels import Channel, MeasuredFile
from roughcontact.io.registry import readers
from roughcontact.io.request import Request
from roughcontact.io.vocabulary import rows_of

ERRORS = [
    ValueError("not enough values to unpack"),
    TypeError("object of type 'int' has no len()"),
    IndexError("list index out of range"),
    KeyError("dx"),
    AttributeError("'NoneType' object has no attribute 'shape'"),
    ZeroDivisionError("float division by zero"),
    RecursionError("maximum recursion depth exceeded"),
    MemoryError(),
    OSError(5, "Input/output error"),
    UnicodeDecodeError("utf-8", b"\xff", 0, 1, "invalid start byte"),
    np.linalg.LinAlgError("SVD did not converge"),
    StopIteration(),
    ImportError("no module of that name"),
    ExceptionGroup("several", [ValueError("one")]),
]


def raises(error):
    def function(*arguments):
        raise error

    return function


def file_of(read):
    """Return a file of one channel, which is read so."""
    return lambda path: MeasuredFile("kind", [Channel("z", (2, 2), read, "m", 1.0, 1.0, "m")], "top")


@pytest.mark.parametrize(
    ("reader", "error", "stage"),
    every_pair([name for name, _ in readers()], ERRORS, ["recognises", "read", "channel"]),
    ids=lambda part: part if isinstance(part, str) else type(part).__name__,
)
def test_every_error_of_every_reader_is_a_sentence_on_its_file(
    tmp_path, capsys, monkeypatch, reader, error, stage
):
    """The reader takes every file that is left, and raises."""
    path = tmp_path / "map.dat"
    path.write_bytes(b"1 2\n3 4\n\0")  # with a row of numbers, but no text
    module = import_module(f"roughcontact.io.readers.{reader}")
    parts = {"recognises": lambda path, head: True, "memory_per_byte": 0, "binary": False}
    parts |= {"read": file_of(raises(error))} if stage == "channel" else {stage: raises(error)}
    monkeypatch.setattr(module, "READER", replace(module.READER, **parts))
    with pytest.raises(InputFileError, match=r"needs more memory|cannot be read") as caught:
        read_height_map(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert ("damaged" in str(caught.value)) != isinstance(error, OSError | ImportError | MemoryError)
    if stage == "channel":
        content = inspect_file(path)
        assert content["problem"] == str(caught.value) == content["channels"][0]["reason"]
    assert path in list_measurements(tmp_path)[0]
    assert main(["inspect", str(tmp_path), str(path)]) == (0 if stage == "channel" else 2)
    output = capsys.readouterr()
    assert output.out.count("cannot be read") + output.out.count("needs more memory") >= 1
    assert "Traceback" not in output.err


def test_a_package_that_is_not_complete_is_named(tmp_path):
    """As dask without a package that it needs: the file is not damaged."""
    (tmp_path / "dask").mkdir()
    (tmp_path / "dask/__init__.py").write_text("import one_of_its_own")
    sample = Path(__file__).parents[2] / "data_samples/periodic.nc"
    environment = os.environ | {
        "PYTHONPATH": f"{tmp_path}{os.pathsep}{Path(roughcontact.__file__).parents[1]}"
    }
    module = "roughcontact.interface"
    inspected = subprocess.run(
        [sys.executable, "-m", module, "inspect", sample],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if inspected.returncode == 0:
        pytest.skip("this version of xarray asks for no dask")
    message = (
        "cannot be read, as the package dask is not complete (No module named 'one_of_its_own'); install it"
    )
    assert message in inspected.stdout + inspected.stderr
    assert "damaged" not in inspected.stdout + inspected.stderr


def test_every_refusal_of_the_table_is_made_with_the_facts_of_its_sentence():
    """Calls of `refusal` name it as a word, or, where two sentences fit, by a variable that holds either."""
    sentences = {name: (keys.split(), sentence) for name, keys, sentence in rows_of("refusals.tsv")}
    fields = {
        name: {field.partition("[")[0] for _, field, _, _ in string.Formatter().parse(sentence) if field}
        for name, (_, sentence) in sentences.items()
    }
    used = set()
    for path in sorted((Path(roughcontact.__file__).parent / "io").rglob("*.py")):
        for function in ast.walk(ast.parse(path.read_text())):
            calls = [node for node in ast.walk(function) if isinstance(node, ast.Call)]
            calls = [call for call in calls if getattr(call.func, "id", "") in ("refusal", "sentence")]
            named = isinstance(function, ast.FunctionDef) and function.name != "sentence"
            for call in calls if named else ():
                place = function if isinstance(call.args[0], ast.Name) else call.args[0]
                texts = {node.value for node in ast.walk(place) if isinstance(node, ast.Constant)}
                facts = {keyword.arg for keyword in call.keywords}
                fitting = {name for name in texts & {*fields} if fields[name] <= facts}
                assert fitting, f"{path}:{call.lineno} gives {facts}"
                used |= fitting
    assert used == {*fields}
    assert {key for keys, _ in sentences.values() for key in keys} <= {*Request.__dataclass_fields__}
