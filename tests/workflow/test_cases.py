"""Cases share what they agree in: nothing is solved twice, and each result names the files it is made of."""

import json
import re

import pytest
from small_project import FORKS, QUICK, TABLE, counted, project_with_maps

from roughcontact.results.storage import read_dataset

FILES = ["height", "levelled", "window", "uncertainty", "contact", "statistics"]


@pytest.fixture
def run(tmp_path, checkout):
    """A function that runs the workflow in a folder of its own and returns the project."""

    def run_with(cases, table=TABLE[:2], *, empty=(), **settings):
        settings = QUICK | {"cases": cases} | settings
        project = project_with_maps(tmp_path / "project", checkout, settings, table)
        for name in empty:
            project.path(f"measured/{name}").touch()
        project.last = project.run(*FORKS, "--keep-going", "--logger", "roughcontact")
        return project

    return run_with


def files(project):
    """Return the netCDF files of each case of a surface, and those of earlier cases that it names."""
    own_files, used = {}, {}
    for folder in sorted(project.path("results").glob("*/ground")):
        case = folder.parent.name
        own_files[case] = {path.stem for path in folder.glob("*.nc")}
        attrs = read_dataset(folder / "statistics.nc").attrs
        used[case] = json.loads(attrs.get("files_of_cases", "{}"))
    return own_files, used


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
    for pattern in (
        r"\[prepare base/empty\] ERROR: measured/empty.txt",
        r"\[contact soft/ground\] ERROR: .*hardness",
    ):
        assert re.search(pattern, project.last.stderr), project.last.stderr
    for case, names in (("base", FILES), ("binned", ["uncertainty", "statistics"])):
        for name in (*(f"{file}.nc" for file in names), "panel.html", "panel.json"):
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
        "same": {},
    }
    project = run(cases)
    assert project.last.returncode == 0, project.last.stderr
    own_files, used = files(project)
    of_base = dict.fromkeys(("height", "levelled", "window"), "base")
    assert used == {
        "base": {},
        "raw": {},
        "raw-soft": dict.fromkeys(of_base, "raw"),
        "binned": of_base | dict.fromkeys(("contact", "uncertainty"), "base"),
        "no-maps": of_base | {"uncertainty": "base"},
        "same": of_base | dict.fromkeys(("contact", "uncertainty", "statistics"), "base"),
    }
    solved = {"contact", "uncertainty", "statistics"}
    assert own_files == {
        "base": {*FILES},
        "raw": {*FILES},
        "raw-soft": solved,
        "binned": solved - {"contact"},
        "no-maps": solved,
        "same": solved - {"contact"},
    }
    base, same = (
        read_dataset(project.path(f"results/{case}/ground/statistics.nc")) for case in ("base", "same")
    )
    assert base.equals(same)
    assert "Nothing to be done" in project.run().stderr
    project.path("results").rename(project.path("before"))
    assert project.jobs() == {"prepare": 2, "contact": 4, "statistics": 2, "panel": 6, "report": 1}


@pytest.mark.slow
def test_what_is_counted_anew_is_what_is_counted_while_solving(run):
    """The case that has other bins counts in the solution of another one, that without fields in its own."""
    bins = {"statistics": {"gap_bins": 5}}
    project = run({"base": {}, "kept": bins, "lean": bins | {"contact": {"keep_fields": False}}})
    with_fields, lean = (
        read_dataset(project.path(f"results/{case}/ground/statistics.nc")) for case in ("kept", "lean")
    )
    assert not project.path("results/kept/ground/contact.nc").exists()
    assert with_fields.equals(lean)


@pytest.mark.slow
def test_faces_and_placements_of_pairs_share_as_well(run):
    table = [
        "surface\tpath\tcounter_face\tunit\tdx\tdy",
        "seal\tmeasured/ground.npy\tmeasured/turned.txt\tum\t1\t1",
    ]
    cases = {"base": {}, "flat": {"level": {"form": "mean"}}, "soft": {"contact": {"contact_modulus": "1e8"}}}
    project = run(cases, table, composite={"shifts": 1, "rotations": [0, 90]})
    assert project.last.returncode == 0, project.last.stderr
    assert counted(project.run("--forceall", "--dry-run")) == {
        "prepare_face": 4,
        "superpose": 4,
        "contact": 6,
        "panel": 6,
        "report": 1,
    }
    assert "Nothing to be done" in project.run().stderr
