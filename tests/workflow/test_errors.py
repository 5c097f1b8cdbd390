"""What goes wrong is said in one sentence, stops its own surface alone, and leaves nothing half-written."""

import csv
import html
import json
import os
import re
import signal
import subprocess

import numpy as np
import psutil
import pytest
from small_project import SETTINGS, TABLE, counted

from roughcontact.results.storage import read_dataset

HEADER, GOOD, _ = TABLE

# surface: (rest of its row in the table, what the message says)
BROKEN = {
    "size": ("measured/ground.npy\tum\t\t", ["measured/ground.npy", "dx", "line 3"]),
    "empty": ("measured/empty.txt\tum\t1\t1", ["measured/empty.txt", "line 4"]),
    "cut": ("measured/cut.npy\tum\t1\t1", ["measured/cut.npy", "line 5"]),
    "nan": ("measured/nan.npy\tum\t1\t1", ["measured/nan.npy", "line 6"]),
    "dot": ("measured/dot.npy\tum\t1\t1", ["measured/dot.npy", "single point"]),
    "flat": ("measured/flat.npy\tum\t1\t1", ["flat.npy: the map is flat", "mean_pressure"]),
}

# what Snakemake says about a script that failed: nothing of use beside the sentence
SNAKEMAKES_OWN = ("Traceback", "RuleException", "CalledProcessError", "message: None", "/scripts/tmp")


def test_a_broken_surface_stops_itself_alone(project):
    rows = [f"{name}\t{row}" for name, (row, _) in BROKEN.items()]
    project.write(table=[HEADER, GOOD, *rows])
    project.path("measured/empty.txt").touch()
    project.path("measured/cut.npy").write_bytes(project.path("measured/ground.npy").read_bytes()[:1000])
    for name, heights in {
        "nan": np.full((8, 8), np.nan),
        "dot": np.ones((1, 1)),
        "flat": np.ones((8, 8)),
    }.items():
        np.save(project.path(f"measured/{name}.npy"), heights)
    run = project.run("--keep-going")
    assert run.returncode != 0
    for word in SNAKEMAKES_OWN:
        assert word not in run.stderr
    # every file that cannot be read is known before anything else begins
    begun = re.findall(r"^(?:local)?rule (\w+):", run.stderr, re.MULTILINE)
    assert begun[: len(BROKEN) + 1] == ["ingest"] * (len(BROKEN) + 1)
    for name, (_, said) in BROKEN.items():
        # the solution and its error budget go side by side: what no load can be planned for stops both
        jobs = 2 if name == "flat" else 1
        lines = [line for line in run.stderr.split("\n") if f" {name}] ERROR: " in line]
        assert len(lines) == jobs
        line = lines[0]
        assert len(line) < 500
        for part in said:
            assert part in line, line
        logs = [log.read_text() for log in project.path(f"logs/{name}").iterdir()]
        assert sum("Traceback" in log for log in logs) == jobs
    assert project.path("results/ground/panel.html").exists()
    assert not list(project.path("results").rglob("*.partial"))
    assert f"Not finished: {', '.join(BROKEN)}." in run.stderr
    # the report is made of the rest, and names what failed with the reason
    page = project.path("results/report.html").read_text()
    files = re.findall(r'<a class="file" href="([^"]*)"', page)
    assert "ground/contact.nc" in files
    assert all(project.path(f"results/{file}").is_file() for file in files)
    with project.path("results/summary.csv").open(newline="") as file:
        rows = {row["surface"]: row for row in csv.DictReader(file)}
    assert list(rows) == ["ground", *BROKEN]
    assert float(rows["ground"]["relative_contact_area"]) > 0
    failed = json.loads(read_dataset(project.path("results/statistics.nc")).attrs["failed"])
    assert [failure["surface"] for failure in failed] == list(BROKEN)
    for name, (_, said) in BROKEN.items():
        assert rows[name]["verdict"] == "failed"
        shown = re.search(f'<tr class="failure"><td class="text">{name}</td>.*?</tr>', page)[0]
        for part in said:
            assert part in rows[name]["reasons"]
            assert html.escape(part) in shown
    # rows that are left out leave it as well
    project.write(table=[HEADER, GOOD, *(f"#{row}" for row in rows)])
    assert counted(project.run()) == {"collect": 1, "report": 1}
    assert "without results" not in project.path("results/report.html").read_text()
    assert "failed" not in project.path("results/summary.csv").read_text()


@pytest.mark.parametrize(
    ("settings", "table", "said"),
    [
        (
            SETTINGS | {"contact": {"contact_modulus": -1, "mean_pressure": []}, "levle": {}},
            TABLE,
            [
                "levle: unknown key, did you mean level?",
                "contact.contact_modulus = -1",
                "contact.mean_pressure = []",
            ],
        ),
        (
            SETTINGS,
            [HEADER.replace("path", "file"), GOOD],
            ["surfaces.tsv", "column 'file': unknown", "'path': missing"],
        ),
        (SETTINGS | {"surfaces": "no.tsv"}, TABLE, ["table of surfaces no.tsv: no such file"]),
        (
            SETTINGS | {"statistics": {"gap_bins": 0}},
            [
                *TABLE,
                "ground\tmeasured/turned.txt\tum\t1\t1",
                "absent\tmeasured/nowhere.npy\tfurlong\tone\t1",
                "turned\tmeasured/turned.txt\tMicron\t1\t1",
            ],
            [
                "statistics.gap_bins = 0: must not be less than 1",
                "line 4, surface = ground: stands twice",
                "line 5, path = measured/nowhere.npy: no such file",
                "line 5, unit: unknown length unit 'furlong'",
                "line 5, dx = 'one': must be a number",
                "line 6, surface = turned: stands twice",
            ],
        ),
    ],
)
def test_a_mistake_in_settings_or_table_is_found_before_anything_runs(project, settings, table, said):
    project.write(settings, table)
    run = project.run()
    assert run.returncode != 0
    for part in said:
        assert part in run.stderr
    for word in ("Traceback", "WorkflowError", "common.smk"):
        assert word not in run.stderr
    assert not project.path("results").exists()


def started(project, word):
    """Start the workflow and return its process as soon as it has said `word`."""
    command = project.command("results/ground/contact.nc")
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    )
    said = []
    for line in process.stdout:
        said.append(line)
        if word in line:
            return process
    pytest.fail("".join(said))


@pytest.fixture
def lengthy(project):
    """A project whose solution takes some seconds."""
    loads = [0.01 * (1 + number) for number in range(24)]
    project.write(
        SETTINGS | {"contact": SETTINGS["contact"] | {"relative_pressure": loads, "tolerance": 1e-10}}
    )
    return project


def test_what_was_cut_off_leaves_nothing_and_is_taken_up_again(lengthy):
    process = started(lengthy, "load 3 of 24")
    solvers = [
        child
        for child in psutil.Process(process.pid).children(recursive=True)
        if child.cmdline()[-1:] and child.cmdline()[-1].endswith(".solve.py")
    ]
    solvers[-1].kill()  # the job alone
    said, _ = process.communicate(timeout=60)
    assert process.returncode != 0
    assert re.search(r"^\[solve ground\] ERROR: killed; .* it had asked for \d{3} MB\.", said, re.MULTILINE)
    for word in SNAKEMAKES_OWN:
        assert word not in said
    before = ["height.nc", "levelled.nc", "window.nc"]
    assert sorted(path.name for path in lengthy.path("results/ground").iterdir()) == before
    assert lengthy.jobs("results/ground/contact.nc") == {"solve": 1}

    process = started(lengthy, "load 3 of 24")
    os.killpg(process.pid, signal.SIGKILL)  # the whole run
    process.wait(timeout=60)
    assert not lengthy.path("results/ground/contact.nc").exists()
    lengthy.path("results/ground/.contact.nc.partial").touch()  # as if killed while it wrote
    assert lengthy.run("--unlock").returncode == 0
    assert counted(lengthy.run("results/ground/contact.nc", "--rerun-incomplete")) == {"solve": 1}
    assert not list(lengthy.path("results").rglob("*.partial"))
