"""Small maps go through several stages in one job: the same files from fewer processes."""

import re

import numpy as np
import pytest
from small_project import SETTINGS, TABLE, Project, counted, write_maps

TOGETHER = SETTINGS | {"together": 4}
QUICK = TOGETHER | {"uncertainty": {"sources": []}}
FILES = ["height", "levelled", "window", "uncertainty", "contact", "statistics"]


def project_in(folder, checkout, settings, table):
    """Return a project in a folder of its own, with its maps and settings written."""
    project = Project(folder / "project", checkout)
    write_maps(project.path("measured"))
    project.write(settings, table)
    return project


@pytest.fixture(scope="module")
def together(tmp_path_factory, checkout):
    """The maps of `finished`, taken through several stages a job."""
    project = project_in(tmp_path_factory.mktemp("together"), checkout, TOGETHER, TABLE)
    project.first = project.run()
    assert project.first.returncode == 0, project.first.stderr
    return project


@pytest.mark.slow
def test_two_jobs_a_surface_leave_the_files_of_a_job_for_each_stage(together, finished):
    assert counted(together.first) == {"prepare": 2, "contact": 2, "collect": 1, "report": 1}
    for surface in ("ground", "turned"):
        for file in (*(f"{name}.nc" for name in FILES), "panel.html"):
            name = f"results/{surface}/{file}"
            assert together.path(name).read_bytes() == finished.path(name).read_bytes(), name
        logs = {path.stem for path in together.path(f"logs/{surface}").iterdir()}
        assert logs == {"ingest", "level", "window", "uncertainty", "solve", "statistics", "panel"}
    for name in ("statistics.nc", "summary.csv"):
        own = together.path(f"results/{name}").read_bytes().replace(b'"together": 4.0', b'"together": 0.0')
        assert own == finished.path(f"results/{name}").read_bytes()
    assert "Nothing to be done" in together.run().stderr


def test_what_concerns_the_contact_leaves_the_window(together):
    together.write(TOGETHER | {"statistics": {"gap_bins": 7}})
    jobs = together.jobs()
    together.write(TOGETHER)
    assert jobs == {"contact": 2, "collect": 1, "report": 1}


def test_a_file_that_is_large_has_a_job_for_every_stage(together):
    """ground.npy has 32.9 kB, turned.txt 45 kB."""
    limit = (together.path("measured/ground.npy").stat().st_size + 1) / 1e6
    together.write(SETTINGS | {"together": limit})
    jobs = together.jobs("--forceall")
    together.write(TOGETHER)
    stages = ("ingest", "level", "window", "uncertainty", "solve", "statistics", "panel")
    assert jobs == {"prepare": 1, "contact": 1, "collect": 1, "report": 1, **dict.fromkeys(stages, 1)}


def test_a_failure_stays_in_its_surface_its_case_and_its_part(tmp_path, checkout):
    """In one case a load exceeds the hardness; one of the surfaces cannot be read at all."""
    cases = {
        "base": {},
        "soft": {"contact": {"hardness": "1 MPa"}},
        "binned": {"statistics": {"gap_bins": 5}},
    }
    table = [*TABLE[:2], "empty\tmeasured/empty.txt\tum\t1\t1"]
    project = project_in(tmp_path, checkout, QUICK | {"cases": cases}, table)
    project.path("measured/empty.txt").touch()
    run = project.run("--keep-going")
    assert run.returncode != 0
    assert "Traceback" not in run.stderr
    for said in (
        r"\[ingest base empty\] ERROR: measured/empty.txt",
        r"\[\w+ soft ground\] ERROR: .*hardness",
    ):
        assert re.search(said, run.stderr), run.stderr
    for case in ("base", "binned"):
        for name in (*(f"{file}.nc" for file in FILES), "panel.html"):
            assert project.path(f"results/{case}/ground/{name}").exists(), (case, name)
    assert project.path("results/base/ground/window.nc").exists()
    assert not project.path("results/soft/ground/contact.nc").exists()
    assert not project.path("results/base/empty/height.nc").exists()
    assert not list(project.path("results").rglob("*.partial"))


@pytest.mark.slow
def test_cases_share_what_they_agree_in(tmp_path, checkout):
    cases = {
        "base": {},
        "raw": {"window": {"method": "raw"}},
        "no-maps": {"contact": {"keep_fields": False}},
    }
    project = project_in(tmp_path, checkout, QUICK | {"cases": cases}, TABLE[:2])
    run = project.run()
    assert run.returncode == 0, run.stderr
    expected = {f"{part}_{case}": 1 for case in cases for part in ("prepare", "contact")}
    del expected["prepare_no-maps"]  # has nothing to prepare
    del expected["prepare_raw"]  # what it prepares is for itself
    assert counted(run) == {**expected, "collect": 1, "report": 1}
    links = {
        str(path.relative_to(project.path("results")))
        for path in project.path("results").rglob("*.nc")
        if path.is_symlink()
    }
    shared = {"raw": ["height", "levelled"], "no-maps": ["height", "levelled", "window", "uncertainty"]}
    assert links == {f"{case}/ground/{name}.nc" for case, names in shared.items() for name in names}
    assert "Nothing to be done" in project.run().stderr


@pytest.mark.slow
def test_faces_and_members_of_pairs_go_together_as_well(tmp_path, checkout):
    table = [
        "surface\tpath\tcounter_face\tunit\tdx\tdy",
        "seal\tmeasured/ground.npy\tmeasured/turned.txt\tum\t1\t1",
    ]
    settings = QUICK | {"composite": {"shifts": 1, "rotations": [0, 90]}}
    apart, joined = (
        project_in(tmp_path / name, checkout, settings | {"together": limit}, table)
        for name, limit in (("apart", 0), ("joined", 4))
    )
    for project in (apart, joined):
        project.last = project.run()
        assert project.last.returncode == 0, project.last.stderr
    jobs = {"prepare_faces": 2, "prepare_members": 2, "contact_members": 2, "collect": 1, "report": 1}
    assert counted(joined.last) == jobs
    for surface in ("seal-1", "seal-2"):
        for name in ("levelled.nc", "statistics.nc", "panel.html"):
            both = (project.path(f"results/{surface}/{name}").read_bytes() for project in (apart, joined))
            assert len(set(both)) == 1, name
    assert np.all(np.diff([len(list(p.path("results").rglob("*.nc"))) for p in (apart, joined)]) == 0)
