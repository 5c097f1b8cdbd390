"""What the jobs of a cluster ask for; tests/workflow/slurm.sh runs them."""

import os
import re
import subprocess
import tomllib

import numpy as np
import pytest
import yaml
from small_project import ROOT, Project

SETTINGS = {"surfaces": "surfaces.tsv", "contact": {"contact_modulus": 1e9, "relative_pressure": [0.05, 0.2]}}
PROFILE = ROOT / "workflow/profiles/slurm"


@pytest.fixture
def project(tmp_path):
    """A small map and one that is not."""
    study = Project(tmp_path / "study", ROOT)
    for name, side in (("small", 64), ("large", 1300)):
        np.save(study.path(f"measured/{name}.npy"), np.zeros((side, side)))
    rows = (f"{name}\tmeasured/{name}.npy\tum\t1\t1" for name in ("small", "large"))
    study.write(SETTINGS, ["surface\tpath\tunit\tdx\tdy", *rows])
    return study


def test_a_job_asks_for_what_its_own_map_needs(project):
    run = project.succeed("--dry-run")
    resources = {}
    for rule, text in re.findall(r"^rule (\w+):\n((?: .*\n)+)", run.stderr, re.MULTILINE):
        if surface := re.search(r"wildcards: result=(\w+)", text):
            needs = {name: int(re.search(rf"{name}=(\d+)", text)[1]) for name in ("mem_mb", "runtime")}
            resources[rule, surface[1]] = needs
    assert resources["contact", "small"]["mem_mb"] < 800
    assert resources["contact", "large"]["mem_mb"] == pytest.approx(
        700 + 115 * 1.69 + 200, abs=1
    )  # Plan.memory
    assert resources["contact", "large"]["runtime"] > resources["contact", "small"]["runtime"]
    assert "group" not in run.stderr.lower()


def test_the_profile_tries_again():
    """Without arrays, in which all jobs get the memory of the first (version 2.8 of the executor)."""
    profile = yaml.safe_load((PROFILE / "config.yaml").read_text())
    assert profile["retries"] >= 1
    assert profile["keep-going"]
    assert not {"slurm-array-jobs", "group-components", "groups"} & set(profile)


def test_a_run_without_the_executor_needs_no_program_which(project):
    """As in small containers: where the executor is installed, Snakemake imports it, which calls `which`."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    ours = [re.match(r"[\w-]+", line)[0].replace("-", "_") for line in extras["workflow"]]
    hidden = f"lambda *a: (m for m in listed(*a) if 'executor' not in m.name or m.name in {ours})"
    code = f"import pkgutil; listed = pkgutil.iter_modules; pkgutil.iter_modules = {hidden}"
    project.path("sitecustomize.py").write_text(code)
    variables = {"PATH": str(project.path("measured")), "PYTHONPATH": str(project.folder)}
    command = project.command("--executor", "local", "--dry-run")
    run = subprocess.run(command, env=os.environ | variables, capture_output=True, text=True, check=False)
    assert "snakemake_executor_plugin" not in run.stderr
    assert run.returncode == 0, run.stderr
