"""No old numbers with exit status 0: lost records of Snakemake, files of another run, damaged ones."""

import os
import shutil
from base64 import urlsafe_b64encode

import numpy as np
import pytest
from small_project import QUICK, SETTINGS, TABLE, Project

from roughcontact.results.storage import read_dataset, write_dataset
from roughcontact.study.records import LAST_RESULTS
from roughcontact.study.running import CONTENT_TRIGGERS, run_workflow

DRAWN = {"panel": 1, "report": 1}  # of one surface
SOLVED = {"contact": 1, **DRAWN}
BOTH = {"prepare": 1, "contact": 2, "panel": 2, "report": 1}  # one from the measured file, one is solved


@pytest.fixture
def study(tmp_path, checkout, finished_quickly):
    """A copy of that folder."""
    return Project(shutil.copytree(finished_quickly.folder, tmp_path / "project"), checkout)


def another_load(project):
    project.write(QUICK | {"contact": SETTINGS["contact"] | {"relative_pressure": [0.1]}}, TABLE[:2])
    return "relative_pressure", 2


def another_pixel(project):
    project.write(QUICK, [TABLE[0], TABLE[1].replace("2\t1", "4\t2")])
    return "rms_gradient", 1 / 2


def another_file_of_an_old_date(project):
    project.write(QUICK, TABLE[:2])
    heights = project.path("measured/ground.npy")
    np.save(heights, 3 * np.load(heights))
    os.utime(heights, (1e9, 1e9))
    return "rms_height_m", 3


def empty(path):
    path.write_bytes(b"")


@pytest.mark.parametrize(
    ("lose", "change"),
    [
        (empty, another_load),
        (os.unlink, another_pixel),
        (os.unlink, another_file_of_an_old_date),
    ],
)
def test_where_records_are_lost_the_numbers_are_of_the_present_input(study, lose, change):
    """Without a record Snakemake compares dates alone."""
    for path in filter(os.path.isfile, study.path(".snakemake/metadata").rglob("*")):
        lose(path)
    before, (name, factor) = study.rows("summary.csv")[0], change(study)
    study.succeed()
    assert float(study.rows("summary.csv")[0][name]) == pytest.approx(factor * float(before[name]), rel=0.02)
    assert study.jobs() == {}


def test_one_lost_record_is_enough(study):
    """Of a job with several files Snakemake compares no settings where the record of one is missing."""
    empty(study.path(".snakemake/metadata") / urlsafe_b64encode(b"results/ground/statistics.nc").decode())
    assert study.jobs() == SOLVED


def copied(path):
    """Put the file of another surface in the place of that of `ground`, under the date that this had."""
    date = path.stat().st_mtime_ns
    shutil.copy(path.parents[1] / "turned" / path.name, path)
    os.utime(path, ns=(date, date))


def of_other_settings(path):
    write_dataset(read_dataset(path).assign_attrs(settings="{}"), path)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"ground/window.nc": copied, "turned/contact.nc": os.unlink}, BOTH),
        ({"ground/contact.nc": copied, "turned/levelled.nc": os.unlink}, BOTH),
        ({"ground/panel.html": empty}, DRAWN),
        ({"statistics.nc": of_other_settings}, {"report": 1}),
        ({"summary.csv": empty, "report.html": empty}, {"report": 1}),
        ({"uncertainty.csv": os.unlink}, {"report": 1}),
    ],
)
def test_what_is_not_as_the_last_run_has_left_it_is_made_again(study, changes, expected):
    """Of both surfaces at once, which do not know one another, or of all together."""
    for name, replace in changes.items():
        replace(study.path(f"results/{name}"))
    assert study.jobs() == expected


def test_where_that_run_is_killed_the_next_one_makes_it_again(study):
    """By content alone, whatever the dates."""
    result = study.path("results/turned/contact.nc")
    of_other_settings(result)
    record = study.path(".snakemake/metadata") / urlsafe_b64encode(b"results/turned/contact.nc").decode()
    run = study.start()
    study.wait_for(run, lambda: not record.exists())
    for process in [*run.children(recursive=True), run]:
        process.kill()
    run.wait()
    study.run("--unlock")
    assert study.jobs(*CONTENT_TRIGGERS, "--rerun-incomplete").items() >= SOLVED.items()


def test_a_study_from_before_an_installation_is_not_solved_again(study, checkout, capfd):
    """An installation dates the scripts of today, whatever they say."""
    for path in filter(os.path.isfile, study.folder.rglob("*")):
        date = path.stat().st_mtime_ns - 10**17  # three years
        os.utime(path, ns=(date, date))
    options = ["--directory", str(study.folder), "--configfile", str(study.path("settings.yaml")), "-n"]
    assert run_workflow(options) == 0
    assert "Nothing to be done" in "".join(capfd.readouterr())
    script = checkout / "workflow/scripts/contact.py"
    text, times = script.read_text(), script.stat()
    try:
        script.write_text(f"{text}\n")
        os.utime(script, (1e9, 1e9))
        assert study.jobs(*CONTENT_TRIGGERS) == {"contact": 2, "panel": 2, "report": 1}
    finally:
        script.write_text(text)
        os.utime(script, ns=(times.st_atime_ns, times.st_mtime_ns))


@pytest.mark.parametrize("note", [None, "", "{}", "[]", "3", '{"results/summary.csv": 1}'])
def test_without_the_note_of_the_last_run_what_is_of_all_is_made_again(study, note):
    """A text has no checksum in it, and whoever changed it may have changed the note."""
    path = study.path("results/summary.csv")
    summary = path.read_text()
    path.write_text(summary.replace("0.", "9."))
    study.path(LAST_RESULTS).unlink()
    if note is not None:
        study.path(LAST_RESULTS).write_text(note)
    assert study.jobs() == {"report": 1}
    if note is None:
        study.succeed()
        assert path.read_text() == summary
        assert study.jobs() == {}


@pytest.mark.parametrize(
    ("replace", "name", "message"),
    [
        (copied, "ground/window.nc", "belongs to other settings or another measured file"),
        (of_other_settings, "ground/statistics.nc", "belongs to other settings or another"),
    ],
)
def test_where_the_last_run_has_noted_nothing_that_is_refused(study, replace, name, message):
    """As where it was killed: the jobs compare what the files say."""
    study.path(LAST_RESULTS).unlink()
    replace(study.path(f"results/{name}"))
    run = study.run("--forcerun", *(["contact"] if "window" in name else ["report"]))
    assert run.returncode != 0
    assert f"] ERROR: results/{name}: {message}" in run.stderr
    assert "run again" in run.stderr
