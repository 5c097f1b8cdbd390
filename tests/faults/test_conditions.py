"""Where a run has no room, no home or may not write: one sentence that names it, or the usual result."""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import study

from roughcontact.interface.program import main
from roughcontact.results.storage import _commit

LEVELLED = "results/surface-2/levelled.nc"


def run(folder, *arguments, **variables):
    """Run a study and return the process; `stderr` is all that was said."""
    return subprocess.run(
        study.command(folder, *arguments),
        env=study.environment(**variables),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )


def test_a_read_only_folder_is_named_before_anything_starts(tmp_path, disk, capsys):
    read_only = disk("size=64k,ro")
    study.write_study(tmp_path, cases=False)
    settings = next(tmp_path.rglob("*.yaml"))
    for folder in (read_only, read_only / "new"):
        assert main(["run", f"--directory={folder}", f"--configfile={settings}"]) == 2
        assert f"{read_only} is read-only, results cannot be written there" in capsys.readouterr().err


@pytest.mark.parametrize("what", ["a file", "a link to results"])
@pytest.mark.parametrize("option", ["", "-n", "--unlock"])
def test_something_else_in_the_place_of_the_results_is_named(tmp_path, capsys, what, option):
    study.write_study(tmp_path, cases=False)
    results = tmp_path / "results"
    results.touch() if what == "a file" else results.symlink_to("results")
    assert main(study.command(tmp_path, *filter(None, [option]))[3:]) == 2
    message = capsys.readouterr().err
    assert f"{results}: is {what}" in message
    assert len(message.splitlines()) == 1


def test_results_on_a_read_only_disk_are_named(tmp_path, disk, capsys):
    study.write_study(tmp_path, cases=False)
    results = tmp_path / "results"
    results.symlink_to(disk("ro"))
    assert main(study.command(tmp_path)[3:]) == 2
    assert f"{results} is read-only, results cannot be written there" in capsys.readouterr().err


@pytest.mark.slow
def test_results_from_the_future_are_named_with_the_way_out(tmp_path):
    study.write_study(tmp_path, sides=(40,), cases=False)
    window, levelled = (f"results/surface-1/{name}.nc" for name in ("window", "levelled"))
    assert run(tmp_path, levelled).returncode == 0
    future = time.time() + 4 * 365 * 86400
    os.utime(tmp_path / window, (future, future))
    target = "results/surface-1/statistics.nc"
    failed = run(tmp_path, target)
    assert failed.returncode == 1
    date = time.strftime("%Y-%m-%d %H:%M", time.localtime(future))
    (message,) = re.findall(r"^\[contact surface-1\] ERROR: (.*)$", failed.stdout, re.MULTILINE)
    assert message.startswith(f"{window}: is dated {date}, by a clock that was ahead")
    assert "Traceback" not in failed.stdout
    assert "load 1" not in (tmp_path / "logs/surface-1/contact.log").read_text()  # before it computes
    subprocess.run(message.rpartition(": ")[2], shell=True, check=True, cwd=tmp_path)
    assert run(tmp_path, target).returncode == 0


@pytest.mark.slow
def test_a_disk_that_is_full_when_the_rest_is_reported_is_named(disk):
    folder = disk("size=8m")
    study.write_study(folder, cases=False)
    assert run(folder, "results/surface-1/panel.html").returncode == 0
    (folder / "measured/2.npy").write_bytes(b"")
    free = shutil.disk_usage(folder).free
    (folder / "filler").write_bytes(bytes(free - 120_000))  # less than a report has
    full = run(folder)
    assert full.returncode == 1
    messages = [line for line in full.stdout.splitlines() if "no report of what is finished" in line]
    assert len(messages) == 1
    assert "results/" in messages[0]
    assert "the disk is full" in messages[0]
    assert f"The disk of {folder} is full: make room and run again." in full.stdout
    assert "Traceback" not in full.stdout
    (folder / "filler").unlink()
    assert "results/report.html and results/summary.csv have the others" in run(folder).stdout


@pytest.mark.slow
def test_a_full_disk_is_named_and_the_run_goes_on_when_there_is_room(tmp_path, disk):
    study.write_study(tmp_path / "elsewhere", cases=False)
    assert run(tmp_path / "elsewhere", LEVELLED).returncode == 0
    folder = disk("size=140k")
    study.write_study(folder, cases=False)
    full = run(folder, LEVELLED)
    assert full.returncode
    assert (
        "[prepare surface-2] ERROR: results/surface-2/levelled.nc: cannot be written, the disk is full"
        in (full.stdout)
    )
    assert f"The disk of {folder} is full: make room and run again." in full.stdout
    for word in ("Traceback", "unexpected", "RuleException"):
        assert word not in full.stdout
    assert {*study.results(folder)} <= {"results/surface-2/height.nc"}  # whole, and made again
    disk("size=2m", folder)
    assert run(folder, LEVELLED).returncode == 0
    assert study.results(folder) == study.results(tmp_path / "elsewhere")


@pytest.mark.slow
def test_a_read_only_installation_without_home_in_the_c_locale(tmp_path, disk, monkeypatch):
    installed = disk("size=60m")
    shutil.copytree(study.ROOT / "workflow", installed / "workflow", ignore=shutil.ignore_patterns("*.pyc"))
    for name in ("Snakefile", "config"):
        copy = shutil.copytree if (study.ROOT / name).is_dir() else shutil.copy
        copy(study.ROOT / name, installed / name)
    noted = installed / "workflow/lib/roughcontact/_commit.txt"  # as in a wheel
    noted.write_text(_commit(), encoding="ascii")
    disk("ro", installed)
    writable, read_only = tmp_path / "here", tmp_path / "there"
    for folder in (writable, read_only):
        study.write_study(folder, cases=False)
    assert run(writable, LEVELLED).returncode == 0
    monkeypatch.setattr(study, "ROOT", installed)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    bare = run(read_only, LEVELLED, HOME="/proc/nowhere", LC_ALL="C", LANG="C", TMPDIR="/proc/nowhere")
    assert bare.returncode == 0, bare.stdout
    assert study.results(read_only) == study.results(writable)


@pytest.mark.slow
def test_files_from_the_future(tmp_path):
    study.write_study(tmp_path / "study", cases=False)
    measured = tmp_path / "study/measured/2.npy"
    future = time.time() + 4 * 365 * 86400
    os.utime(measured, (future, future))
    first_run = run(tmp_path / "study", LEVELLED)
    assert first_run.returncode == 0, first_run.stdout
    results_before = study.results(tmp_path / "study")
    second_run = run(tmp_path / "study", LEVELLED)
    assert "Nothing to be done" in second_run.stdout
    assert study.results(tmp_path / "study") == results_before
    os.utime(measured, (future + 1, future + 1))  # the content is what counts
    assert "Nothing to be done" in run(tmp_path / "study", LEVELLED, "--dry-run").stdout
    np.save(measured, 2 * np.load(measured))
    os.utime(measured, (future, future))
    planned = run(tmp_path / "study", LEVELLED, "--dry-run").stdout
    assert re.findall(r"^(.*): (.*)$", planned, re.MULTILINE)[:-1] == [("surface-2", "prepare")]


def test_who_stops_reading_ends_the_program_quietly():
    samples = sorted(str(path) for path in Path(study.ROOT, "data_samples").glob("*.*"))
    program = [sys.executable, "-m", "roughcontact.interface", "inspect", *samples]
    inspect = subprocess.Popen(
        program, env=study.environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    inspect.stdout.readline()
    inspect.stdout.close()  # as `head -1` does
    message = inspect.stderr.read()
    assert inspect.wait() == 141
    assert "Broken" not in message
    assert "Traceback" not in message


def test_who_stops_reading_what_a_run_shows_sees_no_traceback(tmp_path):
    study.write_study(tmp_path, cases=False)
    planned = subprocess.Popen(
        study.command(tmp_path, "--dry-run"),
        env=study.environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    planned.stdout.close()  # before the first line
    message = planned.stderr.read()
    assert planned.wait() == 0
    assert "Broken" not in message
    assert "Traceback" not in message
