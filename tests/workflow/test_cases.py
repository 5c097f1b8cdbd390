"""Cases share what they agree in: each folder is complete, nothing is done twice."""

import re

import pytest
from small_project import SETTINGS, TABLE, Project, counted, write_maps

from roughcontact.results.storage import read_dataset

QUICK = SETTINGS | {"uncertainty": {"sources": []}}
FILES = ["height", "levelled", "window", "uncertainty", "contact", "statistics"]


@pytest.fixture
def run(tmp_path, checkout):
    """A function that runs the workflow in a folder of its own and returns the project."""

    def run_with(cases, table=TABLE[:2], *, empty=(), **settings):
        project = Project(tmp_path / "project", checkout)
        write_maps(project.path("measured"))
        for name in empty:
            project.path(f"measured/{name}").touch()
        project.write(QUICK | {"cases": cases} | settings, table)
        project.last = project.run("--keep-going", "--logger", "roughcontact")
        return project

    return run_with


def links(project):
    """Return which files of the results are links, and to which case they lead."""
    root = project.path("results")
    return {
        str(path.relative_to(root)): path.resolve().relative_to(root.resolve()).parts[0]
        for path in root.rglob("*.nc")
        if path.is_symlink()
    }


@pytest.mark.slow
def test_a_failure_stays_in_its_surface_its_case_and_its_part(run):
    """In one case a load exceeds the hardness; one of the surfaces cannot be read at all."""
    cases = {
        "base": {},
        "soft": {"contact": {"hardness": "1 MPa"}},
        "binned": {"statistics": {"gap_bins": 5}},
    }
    table = [*TABLE[:2], "empty\tmeasured/empty.txt\tum\t1\t1"]
    project = run(cases, table, empty=["empty.txt"])
    assert project.last.returncode != 0
    assert "Traceback" not in project.last.stderr
    for said in (
        r"\[prepare base empty\] ERROR: measured/empty.txt",
        r"\[contact_whole soft ground\] ERROR: .*hardness",
    ):
        assert re.search(said, project.last.stderr), project.last.stderr
    for case in ("base", "binned"):
        for name in (*(f"{file}.nc" for file in FILES), "panel.html", "panel.json"):
            assert project.path(f"results/{case}/ground/{name}").exists(), (case, name)
    assert not project.path("results/soft/ground/contact.nc").exists()
    assert not project.path("results/base/empty/height.nc").exists()
    assert not list(project.path("results").rglob("*.partial"))


@pytest.mark.slow
def test_cases_share_what_they_agree_in(run):
    cases = {
        "base": {},
        "raw": {"window": {"method": "raw"}},
        "raw-soft": {"window": {"method": "raw"}, "contact": {"contact_modulus": "1e8"}},
        "binned": {"statistics": {"gap_bins": 5}},
        "no-maps": {"contact": {"keep_fields": False}},
    }
    project = run(cases)
    assert project.last.returncode == 0, project.last.stderr
    shared = {
        "raw": {"height": "base", "levelled": "base"},
        "raw-soft": {"height": "base", "levelled": "base", "window": "raw"},
        "binned": dict.fromkeys(FILES[:-1], "base"),
        "no-maps": dict.fromkeys(FILES[:4], "base"),
    }
    assert links(project) == {
        f"{case}/ground/{name}.nc": owner for case, names in shared.items() for name, owner in names.items()
    }
    for case in cases:
        assert all(project.path(f"results/{case}/ground/{name}.nc").exists() for name in FILES)
    assert "Nothing to be done" in project.run().stderr
    # other cases share with a later one what it does: `raw` has a job of its own for it, the rest have not
    project.path("results").rename(project.path("before"))
    planned = project.jobs()
    assert planned == {"prepare": 2, "contact": 2, "contact_whole": 3, "report": 1}


@pytest.mark.slow
def test_what_is_counted_anew_is_what_is_counted_while_solving(run):
    """The case that has other bins counts in the solution of another one, that without fields in its own."""
    bins = {"statistics": {"gap_bins": 5}}
    project = run({"base": {}, "kept": bins, "lean": bins | {"contact": {"keep_fields": False}}})
    kept, lean = (
        read_dataset(project.path(f"results/{case}/ground/statistics.nc")) for case in ("kept", "lean")
    )
    assert project.path("results/kept/ground/contact.nc").is_symlink()
    assert kept.equals(lean)


@pytest.mark.slow
def test_faces_and_members_of_pairs_share_as_well(run):
    table = [
        "surface\tpath\tcounter_face\tunit\tdx\tdy",
        "seal\tmeasured/ground.npy\tmeasured/turned.txt\tum\t1\t1",
    ]
    cases = {"base": {}, "flat": {"level": {"form": "mean"}}}
    project = run(cases, table, composite={"shifts": 1, "rotations": [0, 90]})
    assert project.last.returncode == 0, project.last.stderr
    faces = ("seal-face", "seal-counter-face")
    assert links(project) == {f"flat/{face}/height.nc": "base" for face in faces}
    assert counted(project.run("--forceall", "--dry-run")) == {
        "prepare_face": 4,
        "prepare_member": 2,
        "contact": 2,
        "contact_whole_member": 2,
        "report": 1,
    }
    assert "Nothing to be done" in project.run().stderr
