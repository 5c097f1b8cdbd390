"""How many jobs a cluster gets, and what they ask for; tests/workflow/slurm.sh runs them."""

import re

import numpy as np
import pytest
from small_project import ROOT, Project

CASES = {"hard": {}, "soft": {"contact": {"contact_modulus": 1e8}}, "raw": {"window": {"method": "raw"}}}
SETTINGS = {
    "surfaces": "surfaces.tsv",
    "contact": {"contact_modulus": 1e9, "relative_pressure": [0.05, 0.2]},
    "cases": CASES,
}
PROFILE = ("--workflow-profile", ROOT / "workflow/profiles/slurm")


@pytest.fixture
def project(tmp_path):
    """24 small maps and two that are not."""
    made = Project(tmp_path / "study", ROOT)
    table = ["surface\tpath\tunit\tdx\tdy"]
    for number in range(26):
        np.save(made.path(f"measured/{number}.npy"), np.zeros((8, 8) if number < 24 else (1300, 1300)))
        table.append(f"s{number}\tmeasured/{number}.npy\tum\t1\t1")
    made.write(SETTINGS, table)
    return made


def groups(said):
    """Return the surfaces of each job of the cluster, as a plan shows them."""
    blocks = re.split(r"^\[.*\] Group job (\w+) .*\n", said, flags=re.MULTILINE)[1:]
    return [
        (name, sorted(set(re.findall(r"^ {8}wildcards: .*surface=(\w+)", text, re.MULTILINE))))
        for name, text in zip(blocks[::2], blocks[1::2], strict=True)
    ]


def test_a_surface_is_one_job_and_so_are_ten_small_ones(project):
    run = project.run("--dry-run", *PROFILE)
    assert run.returncode == 0, run.stderr
    found = groups(run.stderr)
    assert sorted(len(names) for name, names in found if name == "small_surfaces") == [4, 10, 10]
    assert sorted(names for name, names in found if name == "surface") == [["s24"], ["s25"]]
    assert sorted(each for _, names in found for each in names) == sorted(f"s{n}" for n in range(26))


def test_on_one_machine_nothing_goes_together(project):
    assert groups(project.run("--dry-run").stderr) == []
