"""A run that another code cross-checks: its differences stand in the report."""

import sys

import pytest
from small_project import ROOT, SETTINGS, TABLE, counted

from roughcontact.results.storage import read_dataset


def checked_by(python):
    """Return the settings of a run that the code of that Python checks."""
    return SETTINGS | {"crosscheck": {"code": "tamaas", "python": str(python)}}


@pytest.mark.slow
def test_a_run_stops_where_the_code_is_missing_and_goes_on_where_it_is_there(project):
    project.write(checked_by(sys.executable), TABLE[:2])
    run = project.run("results/ground/crosscheck.nc")
    assert run.returncode != 0
    assert "[crosscheck ground] ERROR: Tamaas did not solve the problem" in run.stderr
    assert "No module named 'tamaas'" in run.stderr

    python = project.path("python")
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{ROOT / "tests/other_code.py"}" "$@"\n')
    python.chmod(0o755)
    project.write(checked_by(python), TABLE[:2])
    assert counted(project.run()) == {"crosscheck": 1, "report": 1}
    other = read_dataset(project.path("results/ground/crosscheck.nc"))
    assert (other["pressure_difference"] < 1e-3).all()
    html = project.path("results/report.html").read_text()
    assert "solved by Tamaas tamaas 1.0" in html
    assert html.count(">points that differ</th>") == 1
    assert project.jobs() == {}
    project.write(SETTINGS, TABLE[:2])
    assert project.jobs() == {"report": 1}
