"""A run that another code cross-checks: its differences stand in the report."""

import sys

from small_project import ROOT, SETTINGS, TABLE

from roughcontact.results.storage import read_dataset


def test_the_differences_stand_in_the_report(project):
    python = project.path("python")
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{ROOT / "tests/other_code.py"}" "$@"\n')
    python.chmod(0o755)
    settings = SETTINGS | {"crosscheck": {"code": "tamaas", "python": str(python)}}
    project.write(settings, TABLE[:2])
    run = project.run()
    assert run.returncode == 0, run.stderr
    other = read_dataset(project.path("results/ground/crosscheck.nc"))
    assert (other["pressure_difference"] < 1e-3).all()
    html = project.path("results/report.html").read_text()
    assert "solved by Tamaas tamaas 1.0" in html
    assert html.count("points that differ") == 1
    assert project.jobs() == {}
    project.write(SETTINGS, TABLE[:2])
    assert project.jobs() == {"panel": 1, "report": 1}


def test_a_code_that_is_missing_stops_the_run_with_a_sentence(project):
    project.write(SETTINGS | {"crosscheck": {"code": "tamaas", "python": sys.executable}}, TABLE[:2])
    run = project.run()
    assert run.returncode != 0
    assert "[crosscheck ground] ERROR: Tamaas did not solve the problem" in run.stderr
    assert "No module named 'tamaas'" in run.stderr
