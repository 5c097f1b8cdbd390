"""Two measured faces on one another: what a run with a pair leaves, and what an edit runs again."""

import hashlib
import json
import os
import re

import numpy as np
import pytest
from small_project import SETTINGS, counted, project_with_maps

from roughcontact import composite, read_dataset, relative_positions

PAIR = (
    "surface\tpath\tcounter_face\tunit\tdx\tdy",
    "ground\tmeasured/ground.npy\t\tum\t1\t1",
    "seal\tmeasured/ground.npy\tmeasured/turned.txt\tum\t1\t1",
)
ENSEMBLE = {"shifts": 1, "rotations": [0, 90], "seed": 5}
MEMBERS = ["seal-1", "seal-2"]
FIRST = {"prepare": 1, "prepare_face": 2, "superpose": 2, "contact": 3, "panel": 3, "report": 1}


def settings(**ensemble):
    """Return the settings with an ensemble of two."""
    return SETTINGS | {"composite": ENSEMBLE | ensemble}


@pytest.fixture(scope="module")
def paired(tmp_path_factory, checkout):
    """A project with a single surface and a pair in which the workflow has run once."""
    project = project_with_maps(tmp_path_factory.mktemp("pair") / "project", checkout, settings(), PAIR)
    project.first = project.succeed()
    return project


@pytest.mark.slow
def test_faces_are_measured_and_members_solved(paired):
    assert counted(paired.first) == FIRST
    assert "Nothing to be done" in paired.run().stderr
    folders = {path.name for path in paired.path("results").iterdir() if path.is_dir()}
    assert folders == {"ground", "seal-face", "seal-counter-face", *MEMBERS}
    summary = paired.rows("summary.csv")
    assert [row["surface"] for row in summary] == [s for s in ("ground", *MEMBERS) for _ in range(2)]


@pytest.mark.slow
def test_members_are_the_composites_of_the_ensemble(paired):
    faces = [
        read_dataset(paired.path(f"results/{name}/levelled.nc"))["height"]
        for name in ("seal-face", "seal-counter-face")
    ]
    positions = relative_positions(*faces, **ENSEMBLE)
    checksums = " + ".join(
        hashlib.sha256(paired.path(f"measured/{name}").read_bytes()).hexdigest()
        for name in ("ground.npy", "turned.txt")
    )
    for member, position in zip(MEMBERS, positions, strict=True):
        member_map = read_dataset(paired.path(f"results/{member}/levelled.nc"))
        np.testing.assert_array_equal(member_map["height"], composite(*faces, **position))
        attrs = read_dataset(paired.path(f"results/{member}/statistics.nc")).attrs
        assert attrs["source_sha256"] == checksums
        recorded = json.loads(attrs["settings"])["surface"]
        assert recorded["composite"] == {"overlap": 0.75, **ENSEMBLE}
        assert recorded["number"] == MEMBERS.index(member) + 1


@pytest.mark.slow
def test_the_mean_has_the_interval_of_the_next_member(paired):
    members = [row for row in paired.rows("summary.csv") if row["surface"] in MEMBERS]
    rows = paired.rows("groups.csv")
    assert [(row["group"], row["maps"]) for row in rows] == [("seal", "2")] * 2
    for load, row in enumerate(rows):
        for name, column in (("relative_contact_area", "relative_contact_area"), ("mean_gap", "mean_gap_m")):
            values = [float(member[column]) for member in members[load::2]]
            assert min(values) < float(row[name]) < max(values)
            assert float(row[f"{name}_lower"]) < min(values)
            assert float(row[f"{name}_upper"]) > max(values)
    page = paired.path("results/report.html").read_text()
    assert re.search(r"<b>seal</b>: 2 placements of two faces \((use|review) 2\)\.", page)
    # the pair reaches beyond both placements by what these share, the mean of both: an arm between theirs
    of_members = [members[:2], members[2:]]

    def at_load(member, load, column):
        loads = np.log([float(of_load["mean_pressure_Pa"]) for of_load in member])
        return np.interp(np.log(load), loads, np.log([float(of_load[column]) for of_load in member]))

    for row in paired.rows("groups.csv"):
        assert (row["group"], row["maps"]) == ("seal", "2")
        load = float(row["mean_pressure_Pa"])
        for name, unit in (("relative_contact_area", ""), ("max_pressure", "_Pa")):
            values = [at_load(member, load, f"{name}{unit}") for member in of_members]
            for side, sign in (("lower", -1), ("upper", 1)):
                column = f"{name}_{side}{unit}"
                if row[f"{name}_{side}"] and all(of_load[column] for of_load in members):
                    ends = [at_load(member, load, column) for member in of_members]
                    arms = [sign * (end - value) for value, end in zip(values, ends, strict=True)]
                    arm = sign * np.log(float(row[f"{name}_{side}"])) - max(sign * value for value in values)
                    assert 0 < min(arms) <= arm <= max(arms)
    for part in ("Counter-face, as measured", "turned.txt, its middle at", "turned by 90°"):
        assert part in page


@pytest.mark.slow
def test_more_shifts_leave_those_there_are(paired):
    paired.write(settings(shifts=2), PAIR)
    jobs = paired.jobs()
    paired.write(settings(), PAIR)
    # the members change places: one of the first rotation stays, but all carry the settings of the ensemble
    assert jobs["superpose"] == 4
    assert not {"prepare", "prepare_face"} & set(jobs)


@pytest.mark.slow
def test_an_edited_counter_face_reruns_its_members_and_not_the_rest(paired):
    path = paired.path("measured/turned.txt")
    times, text = path.stat(), path.read_text()
    path.write_text(text.replace("\n", "\n ", 1))
    os.utime(path, (1e9, 1e9))  # older than all results: the content counts
    jobs = paired.jobs()
    path.write_text(text)
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    assert jobs == {"prepare_face": 1, "superpose": 2, "contact": 2, "panel": 2, "report": 1}


@pytest.mark.slow
def test_cases_share_the_faces_and_the_composites(tmp_path, checkout):
    cases = {"base": {}, "raw": {"window": {"method": "raw"}}}
    options = settings(shifts=2, rotations=[0]) | {"cases": cases}
    project = project_with_maps(tmp_path / "project", checkout, options, (PAIR[0], PAIR[2]))
    assert counted(project.succeed()) == {
        "prepare_face": 2,
        "superpose": 4,
        "contact": 4,
        "panel": 4,
        "report": 1,
    }
    rows = project.rows("groups.csv")
    assert [(row["case"], row["group"]) for row in rows] == [("base", "seal")] * 2 + [("raw", "seal")] * 2
    assert not project.path("results/raw/seal-face").exists()
    levelled = [read_dataset(project.path(f"results/{case}/seal-2/levelled.nc"))["height"] for case in cases]
    assert levelled[0].equals(levelled[1])


def test_a_name_that_a_pair_needs(project):
    project.write(settings(), (*PAIR, "seal-2\tmeasured/turned.txt\t\tum\t1\t1"))
    run = project.run("--dry-run")
    assert run.returncode != 0
    assert "line 4, surface = seal-2: the pair seal needs this name" in run.stderr


def test_a_missing_counter_face_is_named_before_anything_runs(project):
    project.write(settings(), [row.replace("turned.txt", "nothing.x3p") for row in PAIR])
    run = project.run("--keep-going", *(f"results/{name}/window.nc" for name in ("ground", "seal-1")))
    assert run.returncode != 0
    assert "counter_face = 'measured/nothing.x3p': no such file" in run.stderr
    assert not project.path("results").exists()
