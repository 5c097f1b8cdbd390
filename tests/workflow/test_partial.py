"""The report of a run in which a surface has failed: what is in it, and how the next run goes on."""

import json
import os
import shutil
import subprocess
import sys
import time

import pytest
from small_project import FORKS, QUICK, SETTINGS, Project, counted

from roughcontact.results.storage import read_dataset
from roughcontact.study.failures import report_finished
from roughcontact.study.plan import Plan
from roughcontact.study.study import read_study

REPORT = ("results/statistics.nc", "results/summary.csv", "results/uncertainty.csv", "results/report.html")


@pytest.fixture
def study(tmp_path, checkout, finished_quickly, monkeypatch):
    """A copy of that folder, as the working directory."""
    shutil.copytree(finished_quickly.folder, tmp_path / "project", symlinks=True)
    project = Project(tmp_path / "project", checkout)
    monkeypatch.chdir(project.folder)
    return project


def plan(**settings):
    """Return the plan of the run in the working directory, with other settings."""
    return Plan(*read_study(QUICK | settings, ["."], measured_in=["."]))


def said_by_command(**config):
    """Return what the command says that ends a run which has not finished."""
    request = {"config": QUICK | config, "folders": ["."], "measured_in": ["."]}
    command = [sys.executable, "-m", "roughcontact.study.failures"]
    return subprocess.run(
        command, input=json.dumps(request), capture_output=True, text=True, check=True
    ).stderr


def contents(project):
    """Return the report as it is."""
    return {name: project.path(name).read_bytes() for name in REPORT}


def test_what_is_mended_is_in_the_next_report_though_it_is_as_before(study):
    """Snakemake compares contents of small files with those of the last report that it has made itself."""
    complete, measured = contents(study), study.path("measured/turned.txt")
    times, text = measured.stat(), measured.read_bytes()
    start = time.time()
    measured.write_bytes(b"")
    failed = study.run(*FORKS, "--keep-going")
    assert failed.returncode != 0
    assert "Not finished: turned." in failed.stderr
    changed = "tolerance: 1.0e-06; uncertainty sources: []</p>"
    assert changed in complete[REPORT[-1]].decode()
    assert changed in contents(study)[REPORT[-1]].decode()
    assert study.path("results/report.html").stat().st_mtime > start - 1
    partial = read_dataset(study.path("results/statistics.nc"))
    assert partial["surface"].values.tolist() == ["ground"]
    (failure,) = json.loads(partial.attrs["failed"])
    assert (failure["surface"], failure["case"]) == ("turned", None)
    assert "measured/turned.txt: the file is empty" in failure["reason"]
    measured.write_bytes(text)
    os.utime(measured, ns=(times.st_atime_ns, times.st_mtime_ns))
    assert not study.path("results/turned/window.nc").exists()  # of the failed job
    assert counted(study.run(*FORKS, "--rerun-incomplete")) == {
        "prepare": 1,
        "contact": 1,
        "panel": 1,
        "report": 1,
    }
    assert study.path("results/turned/window.nc").exists()
    assert contents(study) == complete
    assert "Nothing to be done" in study.run().stderr


def test_a_partial_report_is_made_again_whatever_its_date(study):
    study.path("logs/turned/contact.json").write_text('{"done": false}')
    assert report_finished(plan())
    os.utime(study.path("results/uncertainty.csv"))  # as a copy does
    assert study.jobs() == {"report": 1}


def test_where_all_is_finished_nothing_is_written(study):
    contents_before = contents(study)
    assert report_finished(plan()) == []
    assert contents(study) == contents_before


@pytest.mark.parametrize(
    "edit",
    [
        lambda folder: (folder / "measured/turned.txt").write_text("1 2\n3 4\n"),
        lambda folder: os.utime(folder / "results/turned/window.nc"),
        lambda folder: (folder / "results/turned/panel.html").unlink(),
        lambda folder: (folder / "results/turned/panel.json").unlink(),
        lambda folder: (folder / "results/turned/statistics.nc").write_bytes(b"not netCDF"),
        lambda folder: (folder / "logs/turned/contact.json").write_text('{"done": false}'),
    ],
    ids=[
        "another measurement",
        "a newer window",
        "no panel",
        "no summary",
        "a damaged file",
        "a job that was killed",
    ],
)
def test_a_result_that_is_not_of_this_run_is_not_in_it(study, edit):
    edit(study.folder)
    (failure,) = report_finished(plan())
    assert (failure["surface"], failure["case"]) == ("turned", None)
    assert failure["reason"].startswith(
        ("not finished", "ended without a word, as a job does that is killed")
    )
    page = study.path("results/report.html").read_text()
    assert 'id="surface-ground"' in page
    assert 'id="surface-turned"' not in page


def test_results_of_other_settings_are_not_in_it(study):
    contents_before = contents(study)
    failures = report_finished(plan(contact=SETTINGS["contact"] | {"tolerance": 1e-5}))
    assert [failure["surface"] for failure in failures] == ["ground", "turned"]
    assert contents(study) == contents_before


@pytest.mark.parametrize("partial", [True, False])
def test_files_of_an_earlier_table_with_groups_and_pairs_do_not_stay_beside_it(study, partial):
    earlier = [
        study.path(f"results/{name}") for name in ("groups.nc", "groups.csv", "pairs.csv", "pages/x.html")
    ]
    for path in earlier:
        path.parent.mkdir(exist_ok=True)
        path.write_text("of an earlier run")
    if partial:
        study.path("results/turned/panel.html").unlink()
        assert report_finished(plan())
    else:
        study.write(QUICK | {"report": {"title": "Without groups"}})
        assert study.run().returncode == 0
    assert not any(path.exists() for path in earlier)
    assert study.path("results/summary.csv").exists()


def test_the_command_says_that_the_page_is_older_where_nothing_is_finished(study):
    text = said_by_command(contact=SETTINGS["contact"] | {"tolerance": 1e-5})
    assert text.startswith("Not finished: ground, turned.")
    assert text.endswith("results/report.html and the tables beside it are of an earlier run.\n")


def test_the_command_says_what_is_missing(study):
    study.path("logs/ground/contact.json").write_text('{"error": "killed; out of memory"}')
    study.path("results/ground/panel.html").unlink()
    text = said_by_command()
    assert text.startswith("Not finished: ground. The lines with ERROR above give the reasons")
    assert "results/report.html and results/summary.csv have the others" in text
    failed = json.loads(read_dataset(study.path("results/statistics.nc")).attrs["failed"])
    assert failed[0]["reason"] == "killed; out of memory"


def test_a_file_that_is_gone_since_the_run_began_keeps_no_other_from_the_report(study):
    study.path("measured/turned.txt").unlink()
    assert said_by_command().startswith("Not finished: turned. ")
    statistics = read_dataset(study.path("results/statistics.nc"))
    assert statistics["surface_name"].values.tolist() == ["ground"]
    (failed,) = json.loads(statistics.attrs["failed"])
    assert failed["reason"] == "measured/turned.txt: is gone since the run began; put it back and run again"
