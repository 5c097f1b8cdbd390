"""The plan of a run: which case computes, links and reads what, and what each job asks for."""

import re
from pathlib import Path

import numpy as np
import pytest

from roughcontact.configuration.plan import NOTHING, Plan, Run, one_of
from roughcontact.configuration.resolve import resolve
from roughcontact.configuration.surfaces import Surface

RAW = {"window": {"method": "raw"}}
SOFT = {"contact": {"contact_modulus": 1e8}}
ALL = ["height", "levelled", "window", "uncertainty", "contact", "statistics", "panel"]


def plan(cases=None, *, pair=False, path="ground.x3p", **sections):
    """Return the plan of a single surface, or of a pair with two members, under some cases."""
    settings = {"contact": {"contact_modulus": 1e9, "mean_pressure": [1e6, 2e6]}} | sections
    if cases:
        settings["cases"] = cases
    other = Path("other.x3p") if pair else None
    name = "seal" if pair else "ground"
    surface = Surface(name, Path(path), "table.tsv, line 2", {"dx": 2.0}, other)
    return Plan(resolve(settings | {"composite": {"shifts": 2}}), {name: surface})


def test_a_surface_has_two_jobs():
    made = plan()
    prepare, contact = (made.job(part, "ground") for part in ("prepare", "contact"))
    assert prepare == (ALL[:3], [], {}, ["ground.x3p"])
    folder = "results/ground"
    read = {name: f"{folder}/{name}.nc" for name in ("height", "levelled", "window")}
    assert contact == (ALL[3:], [], read, [])
    assert made.preparing == [""]
    assert made.following == []
    assert made.links() == []
    assert made.runs == [Run("ground", "")]


def test_the_first_case_prepares_and_others_link():
    made = plan({"hard": {}, "soft": SOFT, "same": {}})
    assert made.preparing == ["hard"]
    soft = made.job("contact", "ground", "soft")
    assert soft.steps == ALL[3:]
    assert soft.links == ALL[:3]
    assert soft.inputs["window"] == "results/hard/ground/window.nc"
    same = made.job("contact", "ground", "same")
    assert (same.steps, same.links) == (["panel"], ALL[:-1])
    assert same.inputs["statistics"] == "results/hard/ground/statistics.nc"
    assert sorted(made.links()) == sorted(
        [f"results/soft/ground/{name}.nc" for name in ALL[:3]]
        + [f"results/same/ground/{name}.nc" for name in ALL[:-1]]
    )


def test_a_case_prepares_by_itself_what_nobody_else_takes():
    made = plan({"hard": {}, "raw": RAW})
    assert made.preparing == ["hard"]
    raw = made.job("contact", "ground", "raw")
    assert (raw.steps, raw.links) == (ALL[2:], ALL[:2])
    assert "window" not in raw.inputs


def test_a_case_that_lends_its_window_has_a_job_for_it():
    made = plan({"hard": {}, "raw": RAW, "raw-soft": RAW | SOFT})
    assert made.preparing == ["hard", "raw"]
    prepare = made.job("prepare", "ground", "raw")
    assert (prepare.steps, prepare.links) == (["window"], ["height", "levelled"])
    assert made.job("contact", "ground", "raw-soft").inputs["window"] == "results/raw/ground/window.nc"


def test_a_case_with_other_bins_counts_in_the_solution_of_another():
    made = plan({"base": {}, "binned": {"statistics": {"gap_bins": 5}}})
    binned = made.job("contact", "ground", "binned")
    assert binned.steps == ["statistics", "panel"]
    assert binned.inputs["contact"] == "results/base/ground/contact.nc"


def test_members_of_a_pair_are_made_of_its_faces():
    made = plan(pair=True)
    assert made.solved == ["seal-1", "seal-2"]
    assert made.names("face") == ["seal-face", "seal-counter-face"]
    assert made.job("prepare", "seal-face").steps == ["height", "levelled"]
    member = made.job("prepare", "seal-2")
    assert member.steps == ["levelled", "window"]
    assert member.inputs == {
        "face": "results/seal-face/levelled.nc",
        "facing": "results/seal-counter-face/levelled.nc",
    }
    contact = made.job("contact", "seal-2").inputs
    assert contact["height"] == "results/seal-face/height.nc"
    assert contact["counter_face"] == "results/seal-counter-face/height.nc"
    assert made.settings("window", "seal-2")["surface"]["number"] == 2


@pytest.mark.parametrize("pair", [False, True])
@pytest.mark.parametrize(
    "cases", [None, {"a": {}, "b": RAW, "c": RAW | SOFT, "d": {"level": {"form": "mean"}}, "e": {}}]
)
def test_every_file_is_made_once_before_it_is_read_and_every_folder_is_complete(pair, cases):
    """What rules would say by their patterns, followed from the measured files on."""
    made = plan(cases, pair=pair)
    jobs, written = [], []
    for case in made.cases:
        for name in [*made.measured, *made.members]:
            kind = made.kind(name)
            parts = ["prepare"] if kind == "face" or case in made.preparing else []
            for part in (*parts, *(["contact"] if kind != "face" else [])):
                whole = part == "contact" and case not in made.preparing
                files = made.outputs(part, kind, whole=whole)
                job = made.job(part, name, case)
                expected = sorted([*job.steps, *job.links], key=ALL.index)
                assert [*files] == expected + ["summary"] * (part == "contact")
                jobs.append((job, [file.format(surface=name, case=case) for file in files.values()]))
                written += jobs[-1][1]
    assert len(written) == len(set(written))
    assert set(made.links()) <= set(written)
    wanted = {made.file(stage, *run) for run in made.runs for stage in ("statistics", "window")}
    assert wanted | {made.panel(*run) for run in made.runs} <= set(written)
    assert {made.summary(*run) for run in made.runs} <= set(written)
    there, waiting = {"ground.x3p", "seal-face.x3p", "other.x3p"}, jobs
    while waiting:
        ready = [job for job in waiting if set(job[0].inputs.values()) <= there]
        assert ready, [job[0].inputs for job in waiting]
        there |= {file for _, files in ready for file in files}
        waiting = [job for job in waiting if job not in ready]


def test_settings_of_a_file_are_all_that_it_depends_on():
    made = plan({"hard": {}, "soft": SOFT})
    assert made.settings("height", "ground", "soft") == {"surface": {"name": "ground", "dx": 2.0}}
    assert list(made.settings("window", "ground", "soft")) == ["surface", "level", "window"]
    assert set(made.all_settings()) == {"hard", "soft"}


def test_memory_and_time_grow_with_the_map(tmp_path):
    np.save(tmp_path / "map.npy", np.zeros((1000, 1000)))
    made = plan(path=tmp_path / "map.npy")
    for part in ("prepare", "contact"):
        small, large = (made.memory(part, "ground", points=points) for points in (1e6, 4e6))
        assert 700 < small < large
        small, large = (made.minutes(part, "ground", points=points) for points in (1e6, 4e6))
        assert 0 < small < large
    assert made.memory("prepare", "ground", points=0) == pytest.approx(700 + 80, rel=0.01)  # the file of 8 MB
    flowing = plan(path=tmp_path / "map.npy", statistics={"flow": "always"})
    assert flowing.memory("contact", "ground", points=1e6) > made.memory("contact", "ground", points=1e6)
    steel = {"youngs_modulus": "210 GPa", "poissons_ratio": 0.3}
    bodies = [steel, steel | {"layers": [steel | {"thickness": "2 um", "yield_stress": "7 GPa"}]}]
    for stress, asked in (("never", 0), ("auto", 200)):  # bytes a point
        contact, statistics = {"bodies": bodies, "mean_pressure": [1e6]}, {"stress": stress}
        strained = plan(path=tmp_path / "map.npy", contact=contact, statistics=statistics)
        more = strained.memory("contact", "ground", points=4e6) - made.memory("contact", "ground", points=4e6)
        assert more == pytest.approx(4 * asked)
    assert made.threads("ground") == 4
    assert plan(path=tmp_path / "none.npy").threads("ground") == 1


def test_logs_of_a_result_are_those_of_the_jobs_it_is_made_by():
    made = plan({"hard": {}, "soft": SOFT, "raw": RAW}, pair=True)
    of_prepare = ["seal-face/prepare", "seal-counter-face/prepare", "seal-1/prepare"]
    prepared = [f"logs/hard/{name}.log" for name in of_prepare]
    for case in ("hard", "soft", "raw"):
        assert made.log_files(Run("seal-1", case)) == [*prepared, f"logs/{case}/seal-1/contact.log"]
    one = plan().log_files(Run("ground", ""))
    assert one == [f"logs/ground/{job}.log" for job in ("prepare", "contact")]


@pytest.mark.parametrize(
    "names", [["a"], ["a", "ab", "abc"], ["ground-1", "ground-2", "ground"], ["s1", "s10", "s2", "t"]]
)
def test_a_pattern_admits_its_names_and_no_other(names):
    pattern = re.compile(one_of(names))
    candidates = {*names, *(f"{name}0" for name in names), *(name[:-1] for name in names), "x"}
    assert {name for name in candidates if pattern.fullmatch(name)} == set(names)


def test_the_pattern_of_no_name_admits_none():
    assert one_of([]) == NOTHING
    assert not any(re.fullmatch(NOTHING, text) for text in ("", "a"))
