"""What the jobs of a cluster ask for; tests/workflow/slurm.sh runs them."""

import re

import numpy as np
import pytest
import yaml
from small_project import ROOT, Project

SETTINGS = {
    "surfaces": "surfaces.tsv",
    "contact": {"contact_modulus": 1e9, "relative_pressure": [0.05, 0.2]},
}
PROFILE = ROOT / "workflow/profiles/slurm"


@pytest.fixture
def project(tmp_path):
    """A small map and one that is not."""
    made = Project(tmp_path / "study", ROOT)
    for name, side in (("small", 64), ("large", 1300)):
        np.save(made.path(f"measured/{name}.npy"), np.zeros((side, side)))
    rows = (f"{name}\tmeasured/{name}.npy\tum\t1\t1" for name in ("small", "large"))
    made.write(SETTINGS, ["surface\tpath\tunit\tdx\tdy", *rows])
    return made


def test_a_job_asks_for_what_its_own_map_needs(project):
    run = project.run("--dry-run")
    assert run.returncode == 0, run.stderr
    asked = {}
    for rule, text in re.findall(r"^rule (\w+):\n((?: .*\n)+)", run.stderr, re.MULTILINE):
        if surface := re.search(r"wildcards: result=(\w+)", text):
            needs = {name: int(re.search(rf"{name}=(\d+)", text)[1]) for name in ("mem_mb", "runtime")}
            asked[rule, surface[1]] = needs
    assert asked["contact", "small"]["mem_mb"] < 800
    assert asked["contact", "large"]["mem_mb"] == pytest.approx(700 + 115 * 1.69 + 200, abs=1)  # Plan.memory
    assert asked["contact", "large"]["runtime"] > asked["contact", "small"]["runtime"]
    assert "group" not in run.stderr.lower()


def test_the_profile_tries_again():
    """Without arrays, in which all jobs get the memory of the first (version 2.8 of the executor)."""
    profile = yaml.safe_load((PROFILE / "config.yaml").read_text())
    assert profile["retries"] >= 1
    assert profile["keep-going"]
    assert not {"slurm-array-jobs", "group-components", "groups"} & set(profile)
