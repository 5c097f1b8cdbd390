"""A study of many surfaces on tiny maps, to its index, with a line of the screen for each."""

import re
import time
from contextlib import suppress

import numpy as np
import psutil
import pytest
from small_project import FORKS, Project

from roughcontact.surface.synthetic import self_affine_surface

SIDE = 32
CASES = {"hard": {}, "soft": {"contact": {"contact_modulus": 1e8}}, "binned": {"statistics": {"gap_bins": 5}}}
SETTINGS = {
    "surfaces": "surfaces.tsv",
    "contact": {"contact_modulus": 1e9, "relative_pressure": [0.05, 0.2]},
    "uncertainty": {"sources": ["solver"]},
    "cases": CASES,
}


def followed(project, *arguments):
    """Run the workflow; return exit status, what was said, and the CPU time (s) of Snakemake alone."""
    scheduling_time, run = 0.0, project.start(*arguments)
    while run.poll() is None:
        with suppress(psutil.Error):
            times = run.cpu_times()
            scheduling_time = max(scheduling_time, times.user + times.system)
        time.sleep(0.2)
    return run.returncode, project.path("said").read_text(encoding="utf-8"), scheduling_time


@pytest.mark.slow
@pytest.mark.parametrize("number", [16])
def test_a_study_of_many_surfaces_goes_to_its_index(tmp_path, checkout, number):
    project = Project(tmp_path / "study", checkout)
    band = {"hurst": 0.8, "shortest": 8, "longest": 16, "rms_gradient": 0.1}
    table = ["surface\tpath\tunit\tdx\tdy"]
    for seed in range(number):
        heights = self_affine_surface((SIDE, SIDE), 1.0, **band, seed=seed).values
        np.save(project.path(f"measured/{seed}.npy"), heights)
        table.append(f"s{seed}\tmeasured/{seed}.npy\tum\t1\t1")
    project.write(SETTINGS, table)
    status, output, scheduling = followed(project, *FORKS, "--logger", "roughcontact")
    assert status == 0, output
    assert scheduling < 10  # some 4 s, and 40 s where each job starts a clock of its own
    # preparing is shared by the cases; the report and the target
    jobs = number * (1 + 2 * len(CASES)) + 2
    lines = output.splitlines()
    results = number * len(CASES)
    assert f"{results} results, {jobs} jobs" in lines
    assert len([line for line in lines if re.match(r"\w+/s\d+: done", line)]) == results
    assert len(lines) < results + 10
    assert len(project.rows("summary.csv")) == 2 * len(CASES) * number
    pages = list(project.path("results/pages").rglob("*.html"))
    assert len(pages) == number
    assert sum(page.stat().st_size for page in pages) < 50e6
    index = project.path("results/report.html").read_text(encoding="utf-8")
    assert all(f"s{seed}" in index for seed in range(number))
    assert "Nothing to be done" in project.run().stderr
