"""What the jobs declare against what they take, as docs/how-to/cluster.md has it in a table."""

import re
import time
from pathlib import Path

import numpy as np
import psutil
import pytest
from known_surfaces import self_affine
from small_project import ROOT, SETTINGS, Project, project_with_maps

JOBS = ("prepare", "contact", "panel", "report")
LOADS = [0.02, 0.1, 0.3]


def peak(pid: int) -> float:
    """Return the largest memory that a process has had so far, in MB; 0 where it is gone."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0.0
    match = re.search(r"VmHWM:\s+(\d+) kB", status)
    return int(match[1]) * 1024 / 1e6 if match else 0.0


def measured(project: Project) -> dict[str, tuple[int, float]]:
    """Run the workflow, and return of each job what it declared and what it took on a cluster (MB).

    There each job is a Snakemake that starts another one, which starts the script.
    """
    peaks = dict.fromkeys(JOBS, 0.0)
    snakemake = 0.0
    run = project.start("--cores", "1")
    while run.poll() is None:
        snakemake = max(snakemake, peak(run.pid))
        for child in run.children(recursive=True):
            try:
                command = " ".join(child.cmdline())
            except psutil.Error:
                continue
            if (script := re.search(r"\.(\w+)\.py\b", command)) and script[1] in peaks:
                peaks[script[1]] = max(peaks[script[1]], peak(child.pid))
        time.sleep(0.05)
    text = project.path("said").read_text()
    assert run.returncode == 0, text
    declared = {}
    for rule, lines in re.findall(r"^(?:local)?rule (\w+):\n((?: .*\n)+)", text, re.MULTILINE):
        if memory_match := re.search(r"mem_mb=(\d+)", lines):
            declared[rule] = int(memory_match[1])
    return {job: (declared[job], peaks[job] + 2 * snakemake) for job in JOBS}


def of_map(folder: Path, size: int) -> dict[str, tuple[int, float]]:
    """Return what each job declared and took for a map of so many points by side."""
    project = Project(folder, ROOT)
    heights = self_affine((size, size), 1.0, (8, size / 4), rms_gradient=0.1, seed=1)
    np.save(project.path("measured/map.npy"), heights.values)
    contact = SETTINGS["contact"] | {"relative_pressure": LOADS}
    project.write(
        SETTINGS | {"contact": contact}, ("surface\tpath\tunit\tdx\tdy", "map\tmeasured/map.npy\tum\t1\t1")
    )
    return measured(project)


def on_the_page() -> dict[str, dict[int, int]]:
    """Return what each job declares (MB) by the points by side of a map, as the page on clusters says."""
    page = (ROOT / "docs/how-to/cluster.md").read_text(encoding="utf-8")
    heading, _, *rows = re.findall(r"^\| (.*) \|$", page, re.MULTILINE)
    sizes = [int(size) for size in re.findall(r"(\d+)²", heading)]
    declared_on_page = {}
    for row in rows:
        job, *cells = row.split(" | ")
        declared_on_page[job.strip("`")] = {
            size: int(cell.split(" / ")[0]) for size, cell in zip(sizes, cells, strict=True)
        }
    return declared_on_page


def test_memory_and_time_are_known_before_anything_ran(tmp_path):
    run = project_with_maps(tmp_path, ROOT).run("--dry-run")
    resource_lines = re.findall(r"^ *resources: .*mem_mb=.*$", run.stderr, re.MULTILINE)
    assert len(resource_lines) == 2 * len(JOBS[:-1]) + 1
    assert [line for line in resource_lines if "TBD" in line or "runtime=" not in line] == []


@pytest.mark.slow
@pytest.mark.parametrize("size", [128, 1024])
def test_jobs_declare_what_they_take_within_a_factor_of_two(tmp_path, size):
    measured_jobs, page = of_map(tmp_path, size), on_the_page()
    declared = {job: declared for job, (declared, _) in measured_jobs.items()}
    assert declared == pytest.approx({job: page[job][size] for job in JOBS}, rel=0.02)
    shares = {job: declared / memory for job, (declared, memory) in measured_jobs.items()}
    assert {job: share for job, share in shares.items() if not 1 <= share <= 2} == {}


if __name__ == "__main__":  # the rows of the table, for the sizes given
    import sys
    import tempfile

    for size in map(int, sys.argv[1:]):
        with tempfile.TemporaryDirectory() as scratch:
            for job, (declared, taken) in of_map(Path(scratch), size).items():
                print(size, job, declared, round(taken))
