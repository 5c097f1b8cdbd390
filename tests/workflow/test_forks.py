"""Jobs of a local run are forks of one process: files, failures and ends as of processes of their own."""

import numpy as np
import psutil
from small_project import QUICK, SETTINGS, TABLE, project_with_maps

OPTIONS = ("--executor", "roughcontact", "--keep-going", "--logger", "roughcontact")


def contents(project):
    """Return the content of every file of the results."""
    paths = (path for path in project.path("results").rglob("*") if path.is_file())
    return {str(path.relative_to(project.folder)): path.read_bytes() for path in paths}


def forks(process, rule):
    """Return the running jobs of a rule, which are named after it."""
    found = []
    for child in process.children(recursive=True):
        try:
            found += [child] * (child.name() == rule and "server.py" in " ".join(child.cmdline()))
        except psutil.Error:
            continue
    return found


def test_results_are_those_of_processes_of_their_own(finished, tmp_path):
    project = project_with_maps(tmp_path / "forked", finished.checkout)
    project.succeed(*OPTIONS)
    expected = contents(finished)
    assert contents(project) == expected
    assert project.jobs() == {}


def test_a_job_that_fails_fails_alone_and_says_why(project):
    project.write(QUICK)
    np.save(project.path("measured/ground.npy"), np.full((64, 64), np.nan))
    run = project.run(*OPTIONS)
    assert run.returncode == 1
    assert "[prepare ground] ERROR: measured/ground.npy: " in run.stderr
    assert project.path("results/turned/panel.html").is_file()
    assert not project.path("results/ground").exists() or not list(project.path("results/ground").iterdir())


def test_a_job_that_is_killed_fails_alone_and_is_made_again(project):
    loads = [0.01 * (1 + number) for number in range(24)]
    contact = SETTINGS["contact"] | {"relative_pressure": loads, "tolerance": 1e-10}
    project.write(QUICK | {"contact": contact}, TABLE[:2])
    process = project.start(*OPTIONS)
    project.wait_for(process, lambda: forks(process, "contact"))[0].kill()
    assert process.wait(timeout=600) == 1
    assert "[contact ground] ERROR: killed; probably out of memory" in project.path("said").read_text()
    assert project.jobs() == {"contact": 1, "panel": 1, "report": 1}


def test_a_server_that_is_killed_is_started_again_by_the_next_job(project):
    project.write(QUICK, TABLE[:2])
    process = project.start(*OPTIONS, "--retries", "1")
    project.wait_for(process, lambda: forks(process, "prepare"))[0].parent().kill()
    assert process.wait(timeout=600) == 0, project.path("said").read_text()
    assert project.path("results/report.html").is_file()
