"""What lies in the working folder is data: no run imports it, whatever its name."""

import os
import subprocess
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import numpy as np
import pytest
import yaml
from small_project import ROOT, SETTINGS, TABLE, write_maps

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
    done = subprocess.run(
        list(map(str, command)), cwd=folder, env=variables, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout + done.stderr


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
    status, said = run_in(study, PROGRAMS / "roughcontact", "run", "-n")
    assert (status, executed(study)) == (0, [])
    status, said = run_in(study, PROGRAMS / "roughcontact", "run", "--cores", "2")
    assert executed(study) == []
    assert status == 1
    assert "Not finished: empty." in said
    assert (study / "results/ground/statistics.nc").stat().st_size
    assert "empty" in (study / "results/report.html").read_text()


def test_snakemake_itself_imports_nothing_of_a_study_in_the_checkout(checkout, study):
    """Its jobs neither; Snakemake puts the folder of the Snakefile on its path."""
    (study / "Snakefile").write_bytes((checkout / "Snakefile").read_bytes())
    (study / "workflow").symlink_to(checkout / "workflow")
    status, said = run_in(study, PROGRAMS / "snakemake", "--cores", "2", "results/ground/statistics.nc")
    assert (status, executed(study)) == (0, []), said
    assert (study / "results/ground/statistics.nc").stat().st_size


def test_run_py_imports_nothing_of_a_study_in_the_checkout(tmp_path):
    """Neither it itself nor the programs by which it installs, here as far as a file that pip refuses."""
    write_modules(tmp_path)
    for name in ("run.py", "setup.py"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    (tmp_path / "pyproject.toml").write_text("not a table")
    status, said = run_in(tmp_path, sys.executable, "run.py", "-n")
    assert executed(tmp_path) == []
    assert status == 1
    assert "failed: " in said
    assert "install --editable" in said
