"""What lies in the working folder is data: no run imports it, whatever its name."""

import os
import subprocess
import sys
from importlib.metadata import packages_distributions
from pathlib import Path
from urllib.request import urlopen

import numpy as np
import pytest
import yaml
from small_project import ROOT, SETTINGS, TABLE, write_maps
from test_app import in_time, opened, served

PROGRAMS = Path(sys.executable).parent
MODULES = sorted({*sys.stdlib_module_names, *packages_distributions(), "_job", "_preparing"})


def write_modules(folder):
    """Write a module of each name that a run imports, which notes that it is run, and ends the program."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in filter(str.isidentifier, MODULES):
        text = f"open({str(folder / 'executed.txt')!r}, 'a').write({name!r} + '\\n')\nraise SystemExit(0)\n"
        (folder / f"{name}.py").write_text(text)


def executed(folder):
    """Return the modules of a folder that were run."""
    notes = [*folder.glob("executed.txt"), *folder.glob(".snakemake/scripts/executed.txt")]
    return [line for note in notes for line in note.read_text().splitlines()]


def run_in(folder, *command):
    """Run a program in a folder, and return its exit status and all that it says."""
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}
    process = subprocess.run(
        list(map(str, command)), cwd=folder, env=variables, capture_output=True, text=True, check=False
    )
    return process.returncode, process.stdout + process.stderr


@pytest.fixture
def study(tmp_path):
    """A study among modules of the names that a run imports; one of its maps has no point."""
    folder = tmp_path / "study"
    write_modules(folder)
    write_modules(folder / ".snakemake/scripts")  # where Snakemake writes the scripts of jobs
    (folder / "measured").mkdir()
    write_maps(folder / "measured")
    np.save(folder / "measured/empty.npy", np.full((8, 8), np.nan))
    (folder / "surfaces.tsv").write_text("\n".join([*TABLE[:2], TABLE[1].replace("ground", "empty")]))
    (folder / "config").mkdir()
    (folder / "config/config.yaml").write_text(yaml.safe_dump(SETTINGS))
    return folder


def test_a_run_its_jobs_and_the_partial_report_import_nothing_of_the_study(study):
    status, output = run_in(study, PROGRAMS / "roughcontact", "run", "-n")
    assert (status, executed(study)) == (0, [])
    status, output = run_in(study, PROGRAMS / "roughcontact", "run", "--cores", "2")
    assert executed(study) == []
    assert status == 1
    assert "Not finished: empty." in output
    assert (study / "results/ground/statistics.nc").stat().st_size
    assert "empty" in (study / "results/report.html").read_text()


def test_the_page_imports_nothing_of_the_study(study):
    """Neither it itself nor the run and the exports that it starts; maps and report are drawn."""
    program, variables = [PROGRAMS / "roughcontact"], {**os.environ}
    variables.pop("PYTHONSAFEPATH", None)
    with served(study, program=program, cwd=study, env=variables) as address:
        press = opened(address)
        assert "1 added, 2 there already" in press({"page.path": "measured"}, "add")[1]  # which is ticked
        assert press({"rows.1.ticked": "on"}, "remove")[0] == 200  # with the map without a point
        assert press({}, "start")[0] == 200
        in_time(lambda: 'id="state" role="status">done' in press({})[1], seconds=300)
        assert executed(study) == []
        for name in ("methods", "table", "crate", ".xlsx", ".png"):
            with urlopen(f"{address}export?result=ground&form={name}") as answer:
                assert answer.status == 200
                assert answer.read()
            assert executed(study) == []
    assert (study / "results/report.html").stat().st_size
    assert (study / "exports/ground.png").stat().st_size
    assert executed(study) == []


def test_snakemake_itself_imports_nothing_of_a_study_in_the_checkout(checkout, study):
    """Its jobs neither; Snakemake puts the folder of the Snakefile on its path."""
    (study / "Snakefile").write_bytes((checkout / "Snakefile").read_bytes())
    (study / "workflow").symlink_to(checkout / "workflow")
    status, output = run_in(study, PROGRAMS / "snakemake", "--cores", "2", "results/ground/statistics.nc")
    assert (status, executed(study)) == (0, []), output
    assert (study / "results/ground/statistics.nc").stat().st_size


def test_run_py_imports_nothing_of_a_study_in_the_checkout(tmp_path):
    """Neither it itself nor the programs by which it installs, here as far as a file that pip refuses."""
    write_modules(tmp_path)
    for name in ("run.py", "setup.py"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    (tmp_path / "pyproject.toml").write_text("not a table")
    status, output = run_in(tmp_path, sys.executable, "run.py", "-n")
    assert executed(tmp_path) == []
    assert status == 1
    assert "failed: " in output
    assert "install --editable" in output
