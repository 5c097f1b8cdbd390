"""The plan of a run: which result is made of which files, and what each job asks for."""

import re
from pathlib import Path

import numpy as np
import pytest

from roughcontact.arguments.settings.resolve import resolve
from roughcontact.study.plan import NO_NAME, Plan, regex_of_names
from roughcontact.study.table.columns import PAIR, PAIR_FIRST_ROW
from roughcontact.study.table.pairs import with_faces
from roughcontact.study.table.row import Surface

RAW = {"window": {"method": "raw"}}
SOFT = {"contact": {"contact_modulus": 1e8}}
PREPARED = ("height", "levelled", "window")
# of netCDF files; the rule `panel` has all results
RULES = ("prepare", "prepare_with_overview", "prepare_face", "superpose", "contact", "statistics")


def plan(cases=None, *, pair=False, path="ground.x3p", overview="", **sections):
    """Return the plan of a surface, with an overview or not, or of a pair with two placements."""
    settings = {"contact": {"contact_modulus": 1e9, "mean_pressure": [1e6, 2e6]}} | sections
    if cases:
        settings["cases"] = cases
    name = "seal" if pair else "ground"
    cells = {"dx": 2.0} | ({"overview": [{"path": overview}]} if overview else {})
    surface = Surface(name, Path(path), "table.tsv, line 2", cells)
    row = {PAIR: "other.x3p" if pair else "", PAIR_FIRST_ROW: ""}
    surface = with_faces(surface, row, Path)
    return Plan(resolve(settings | {"composite": {"shifts": 2}}), {name: surface})


def used(plan_used, result, *names):
    """Return the folders of files that a result uses."""
    return [plan_used.file(name, result).rpartition("/")[0].removeprefix("results/") for name in names]


def rules_of(plan_used, result):
    """Return the rules whose pattern has a result."""
    return [rule for rule in RULES if re.fullmatch(plan_used.pattern(rule), result)]


def test_a_surface_has_two_jobs_before_its_panel():
    study_plan = plan()
    assert study_plan.results == ["ground"]
    assert rules_of(study_plan, "ground") == ["prepare", "contact"]
    assert used(study_plan, "ground", *PREPARED, "contact", "statistics") == ["ground"] * 5
    assert study_plan.sources("prepare", "ground") == ["ground.x3p"]
    assert study_plan.sources("contact", "ground") == []


def test_the_first_case_prepares_for_all_that_agree():
    study_plan = plan({"hard": {}, "soft": SOFT, "same": {}})
    assert rules_of(study_plan, "soft/ground") == ["contact"]
    assert used(study_plan, "soft/ground", *PREPARED, "contact") == ["hard/ground"] * 3 + ["soft/ground"]
    assert rules_of(study_plan, "same/ground") == ["statistics"]
    assert used(study_plan, "same/ground", *PREPARED, "contact", "statistics") == ["hard/ground"] * 5
    assert study_plan.other_case("statistics", "same/ground") == "hard"
    assert study_plan.other_case("contact", "soft/ground") == ""


def test_a_case_with_another_window_prepares_all_and_lends_it():
    study_plan = plan({"hard": {}, "raw": RAW, "raw-soft": RAW | SOFT})
    assert rules_of(study_plan, "raw/ground") == ["prepare", "contact"]
    assert used(study_plan, "raw/ground", *PREPARED) == ["raw/ground"] * 3
    assert rules_of(study_plan, "raw-soft/ground") == ["contact"]
    assert used(study_plan, "raw-soft/ground", *PREPARED) == ["raw/ground"] * 3


def test_a_case_with_other_bins_evaluates_the_solution_of_another():
    study_plan = plan({"base": {}, "binned": {"statistics": {"gap_bins": 5}}})
    assert rules_of(study_plan, "binned/ground") == ["statistics"]
    assert used(study_plan, "binned/ground", "contact", "uncertainty", "statistics") == [
        "base/ground",
        "base/ground",
        "binned/ground",
    ]


def test_placements_of_a_pair_are_made_of_its_faces():
    study_plan = plan(pair=True)
    assert study_plan.results == study_plan.solved == ["seal-1", "seal-2"]
    assert rules_of(study_plan, "seal-face") == rules_of(study_plan, "seal-counter-face") == ["prepare_face"]
    assert rules_of(study_plan, "seal-2") == ["superpose", "contact"]
    assert rules_of(study_plan, "seal-3") == ["prepare", "contact"]  # another surface could have this name
    files = {
        name: study_plan.file(name, "seal-2") for name in ("height", "counter_height", "face", "counter_face")
    }
    assert files == {
        "height": "results/seal-face/height.nc",
        "counter_height": "results/seal-counter-face/height.nc",
        "face": "results/seal-face/levelled.nc",
        "counter_face": "results/seal-counter-face/levelled.nc",
    }
    assert study_plan.file("levelled", "seal-2") == "results/seal-2/levelled.nc"
    assert study_plan.file("levelled", "seal-face") == "results/seal-face/levelled.nc"
    assert study_plan.settings("window", "seal-2")["surface"]["number"] == 2
    cells = {"dx": 2.0}
    assert study_plan.settings("statistics", "seal-2")["surface"]["sides"] == {
        "seal-face": cells,
        "seal-counter-face": cells,
    }
    assert study_plan.all_sources("seal-2") == ["ground.x3p", "other.x3p"]


def test_the_overview_of_a_surface_is_read_by_its_first_job_alone():
    study_plan = plan({"hard": {}, "soft": SOFT, "raw": RAW}, overview="field.x3p")
    assert rules_of(study_plan, "hard/ground") == ["prepare_with_overview", "contact"]
    assert rules_of(study_plan, "hard/grounds") == ["prepare", "contact"]
    assert study_plan.sources("prepare_with_overview", "hard/ground") == ["ground.x3p", "field.x3p"]
    assert study_plan.sources("contact", "hard/ground") == []
    folders = {case: study_plan.file("overview", f"{case}/ground") for case in ("hard", "soft", "raw")}
    assert folders == {
        case: f"results/{owner}/ground/overview.nc"
        for case, owner in {"hard": "hard", "soft": "hard", "raw": "raw"}.items()
    }
    assert plan().file("overview", "ground") == ""


OUTPUTS = {
    "prepare": PREPARED,
    "prepare_with_overview": (*PREPARED, "overview"),
    "prepare_face": ("height", "levelled"),
    "superpose": ("levelled", "window"),
    "contact": ("contact", "uncertainty", "statistics"),
    "statistics": ("uncertainty", "statistics"),
}
INPUTS = {
    "superpose": ("face", "counter_face"),
    "contact": (*PREPARED, "overview", "counter_height"),
    "statistics": (*PREPARED, "overview", "counter_height", "contact"),
}


@pytest.mark.parametrize("kind", [{}, {"pair": True}, {"overview": "field.x3p"}])
@pytest.mark.parametrize(
    "cases",
    [
        None,
        {
            "a": {},
            "b": RAW,
            "c": RAW | SOFT,
            "d": {"level": {"form": "mean"}},
            "e": {},
            "f": {"statistics": {"gap_bins": 5}},
            "g": {"contact": {"keep_fields": False}},
            "h": {"uncertainty": {"sources": []}},
        },
    ],
)
def test_every_file_has_one_rule_and_is_made_before_it_is_read(kind, cases):
    """What the rules do by their patterns, followed from the results back to the measured files."""
    study_plan = plan(cases, **kind)
    producers = {}
    for case in study_plan.cases:
        for name in [*study_plan.measured, *study_plan.placements]:
            result = f"{case}/{name}" if case else name
            for rule in RULES:
                if re.fullmatch(study_plan.pattern(rule), result):
                    for output in OUTPUTS[rule]:
                        assert producers.setdefault(f"results/{result}/{output}.nc", (rule, result)) == (
                            rule,
                            result,
                        )

    def follow(file, waiting):
        rule, result = producers[file]
        assert (rule, result) not in waiting
        names = [*INPUTS.get(rule, ())]
        if rule in ("contact", "statistics"):
            names += [name for name in ("uncertainty", "statistics") if study_plan.other_case(name, result)]
            names = names if rule == "statistics" else [name for name in names if name != "statistics"]
        jobs = {(rule, result)}
        for read in filter(None, (study_plan.file(name, result) for name in names)):
            jobs |= follow(read, {*waiting, (rule, result)})
        return jobs

    for result in study_plan.results:
        jobs = follow(f"results/{result}/statistics.nc", frozenset())
        assert re.fullmatch(study_plan.pattern("panel"), result)
        assert set(study_plan.contributing(result)) <= {*jobs, ("panel", result)}


def test_settings_of_a_file_are_all_that_it_depends_on():
    study_plan = plan({"hard": {}, "soft": SOFT})
    assert study_plan.settings("height", "soft/ground") == {"surface": {"name": "ground", "dx": 2.0}}
    assert list(study_plan.settings("window", "soft/ground")) == ["surface", "level", "window"]
    assert set(study_plan.report_arguments()["settings"]) == {"hard", "soft"}
    assert set(plan().report_arguments()["settings"]) > {"level", "window", "contact"}


def test_memory_and_time_grow_with_the_map(tmp_path):
    np.save(tmp_path / "map.npy", np.zeros((1000, 1000)))
    study_plan = plan(path=tmp_path / "map.npy")
    for part in ("prepare", "contact"):
        small, large = (study_plan.memory(part, "ground", points=points) for points in (1e6, 4e6))
        assert 700 < small < large
        small, large = (study_plan.minutes(part, "ground", points=points) for points in (1e6, 4e6))
        assert 0 < small < large
    assert study_plan.memory("prepare", "ground", points=0) == pytest.approx(
        700 + 80, rel=0.01
    )  # the file of 8 MB
    flowing = plan(path=tmp_path / "map.npy", statistics={"flow": "always"})
    assert flowing.memory("contact", "ground", points=1e6) > study_plan.memory(
        "contact", "ground", points=1e6
    )
    steel = {"youngs_modulus": "210 GPa", "poissons_ratio": 0.3}
    bodies = [steel, steel | {"layers": [steel | {"thickness": "2 um", "yield_stress": "7 GPa"}]}]
    for stress, bytes_per_point in (("never", 0), ("auto", 200)):  # bytes a point
        contact, statistics = {"bodies": bodies, "mean_pressure": [1e6]}, {"stress": stress}
        strained = plan(path=tmp_path / "map.npy", contact=contact, statistics=statistics)
        extra_memory = strained.memory("contact", "ground", points=4e6) - study_plan.memory(
            "contact", "ground", points=4e6
        )
        assert extra_memory == pytest.approx(4 * bytes_per_point)
    assert study_plan.threads("ground") == 4
    assert plan(path=tmp_path / "none.npy").threads("ground") == 1


def test_logs_of_a_result_are_those_of_the_jobs_it_is_made_by():
    binned = {"statistics": {"gap_bins": 5}}
    study_plan = plan({"hard": {}, "soft": SOFT, "raw": RAW, "binned": binned}, pair=True)
    faces = ["seal-face/prepare_face", "seal-counter-face/prepare_face"]
    prepared = [f"logs/hard/{name}.log" for name in faces]
    for case, window in (("hard", "hard"), ("soft", "hard"), ("raw", "raw")):
        own_logs = [f"logs/{window}/seal-1/superpose.log"]
        own_logs += [f"logs/{case}/seal-1/{rule}.log" for rule in ("contact", "panel")]
        assert study_plan.log_files(f"{case}/seal-1") == [*prepared, *own_logs]
    assert study_plan.log_files("binned/seal-1")[2:] == [
        "logs/hard/seal-1/superpose.log",
        "logs/hard/seal-1/contact.log",
        "logs/binned/seal-1/statistics.log",
        "logs/binned/seal-1/panel.log",
    ]
    assert plan().log_files("ground") == [f"logs/ground/{job}.log" for job in ("prepare", "contact", "panel")]


@pytest.mark.parametrize(
    "names", [["a"], ["a", "ab", "abc"], ["ground-1", "ground-2", "ground"], ["s1", "s10", "s2", "t"]]
)
def test_a_pattern_admits_its_names_and_no_other(names):
    pattern = re.compile(regex_of_names(names))
    candidates = {*names, *(f"{name}0" for name in names), *(name[:-1] for name in names), "x"}
    assert {name for name in candidates if pattern.fullmatch(name)} == set(names)


def test_the_pattern_of_no_name_admits_none():
    assert regex_of_names([]) == NO_NAME
    assert not any(re.fullmatch(NO_NAME, text) for text in ("", "a"))
