"""A crate unpacked in an empty folder repeats its run, by the command that the how-to page names."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from roughcontact.interface.program import main

ROOT = Path(__file__).parents[2]


@pytest.fixture
def study(tmp_path):
    """A study with a relative table, its maps in a folder of their own."""
    folder = tmp_path / "study"
    shutil.copytree(ROOT / "config", folder / "config")
    shutil.copytree(ROOT / "data_samples", folder / "data_samples")
    return folder


def command(folder, *arguments):
    program = [sys.executable, "-m", "roughcontact.interface", *arguments]
    return subprocess.run(program, cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_the_crate_of_the_samples_repeats_the_run_in_an_empty_folder(study, tmp_path):
    pytest.importorskip("rocrate")
    assert (process := command(study, "run")).returncode == 0, process.stderr
    assert (
        process := command(study, "crate", "results", "--configfile", "config/config.yaml")
    ).returncode == 0, process
    empty = tmp_path / "empty"
    empty.mkdir()
    shutil.move(study / "results", empty / "crate")
    shutil.rmtree(study)
    process = command(empty, "run", "--configfile", "crate/run_inputs/config.yaml")
    assert process.returncode == 0, process.stderr
    for table in ("summary.csv", "uncertainty.csv"):
        assert (empty / "results" / table).read_bytes() == (empty / "crate" / table).read_bytes()
    process = command(empty, "compare", "crate/statistics.nc", "results/statistics.nc", "--share", "0")
    assert process.returncode == 0, process.stdout


@pytest.mark.slow
def test_a_measured_file_that_has_changed_does_not_go_into_the_crate(tmp_path, monkeypatch, capsys):
    pytest.importorskip("rocrate")
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / "data_samples/periodic.nc", "map.nc")
    Path("surfaces.tsv").write_text("surface\tpath\nmap\tmap.nc\n")
    Path("settings.yaml").write_text(
        "surfaces: surfaces.tsv\ncontact: {contact_modulus: 1 GPa, relative_pressure: [0.05]}\n"
        "uncertainty: {sources: []}\n"
    )
    assert (process := command(tmp_path, "run", "--configfile", "settings.yaml")).returncode == 0, (
        process.stderr
    )
    assert main(["crate", "results", "--configfile", "settings.yaml"]) == 0
    (copy,) = Path("results/run_inputs/measured").rglob("*.nc")
    assert copy.read_bytes() == Path("map.nc").read_bytes()
    first_crate = Path("results/ro-crate-metadata.json").read_bytes()
    assert main(["crate", "results", "--configfile", "settings.yaml"]) == 0
    assert Path("results/ro-crate-metadata.json").read_bytes() == first_crate
    assert b'"run_inputs/config.yaml"' in first_crate
    capsys.readouterr()
    shutil.copy(ROOT / "data_samples/ground.txt", "map.nc")
    assert main(["crate", "results", "--configfile", "settings.yaml"]) == 2
    assert "map.nc: is not the file that the run has read; repeat the run first" in capsys.readouterr().err
    Path("map.nc").unlink()
    assert main(["crate", "results", "--configfile", "settings.yaml"]) == 2
    assert "map.nc': no such file" in capsys.readouterr().err
