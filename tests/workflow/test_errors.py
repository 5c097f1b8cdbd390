"""What goes wrong is said in one sentence, stops its own surface alone, and leaves nothing half-written."""

import html
import json
import os
import re
import signal
import subprocess
import sys
from importlib.metadata import version

import numpy as np
import pytest
from small_project import QUICK, ROOT, SETTINGS, TABLE, counted

from roughcontact.errors import SettingsError
from roughcontact.results.storage import read_dataset
from roughcontact.study.yaml_text import check_yaml

HEADER, GOOD, _ = TABLE

# surface: (rest of its row in the table, what the message says)
BROKEN = {
    "size": ("measured/ground.npy\tum\t\t", ["measured/ground.npy", "dx", "line 3"]),
    "empty": ("measured/empty.txt\tum\t1\t1", ["measured/empty.txt", "line 4"]),
    "cut": ("measured/cut.npy\tum\t1\t1", ["measured/cut.npy", "line 5"]),
    "nan": ("measured/nan.npy\tum\t1\t1", ["measured/nan.npy", "line 6"]),
    "dot": ("measured/dot.npy\tum\t1\t1", ["measured/dot.npy", "single point"]),
    "flat": (
        "measured/flat.npy\tum\t1\t1",
        ["measured/flat.npy: the map is flat", "mean_pressure", "line 8"],
    ),
}

# what Snakemake says about a script that failed: nothing of use beside the sentence
SNAKEMAKES_OWN = ("Traceback", "Exception", "CalledProcessError", "message: None", "/scripts/tmp", "Exiting")


def test_a_broken_surface_stops_itself_alone(project):
    rows = [f"{name}\t{row}" for name, (row, _) in BROKEN.items()]
    project.write(QUICK, [HEADER, GOOD, *rows])
    project.path("measured/empty.txt").touch()
    project.path("measured/cut.npy").write_bytes(project.path("measured/ground.npy").read_bytes()[:1000])
    for name, heights in {
        "nan": np.full((8, 8), np.nan),
        "dot": np.ones((1, 1)),
        "flat": np.ones((8, 8)),
    }.items():
        np.save(project.path(f"measured/{name}.npy"), heights)
    run = project.run("--keep-going", "--logger", "roughcontact")
    assert run.returncode != 0
    for word in SNAKEMAKES_OWN:
        assert word not in run.stderr
    # every file that cannot be read is known before anything else begins
    (log,) = project.path(".snakemake/log").glob("*.snakemake.log")
    rules_begun = re.findall(r"^(?:local)?rule (\w+):", log.read_text(), re.MULTILINE)
    assert set(rules_begun[: len(BROKEN) + 1]) == {"prepare"}
    assert rules_begun.count("prepare") == len(BROKEN) + 1
    assert rules_begun.count("contact") > 0
    for name, (_, message_parts) in BROKEN.items():
        lines = [line for line in run.stderr.split("\n") if f" {name}] ERROR: " in line]
        assert len(lines) == 1
        line = lines[0]
        assert len(line) < 500
        for part in message_parts:
            assert part in line, line
        logs = [log.read_text() for log in project.path(f"logs/{name}").iterdir()]
        assert sum("Traceback" in log for log in logs) == 1
    assert project.path("results/ground/panel.html").exists()
    assert not list(project.path("results").rglob("*.partial"))
    assert f"Not finished: {', '.join(BROKEN)}." in run.stderr
    # the report is made of the rest, and names what failed with the reason
    page = project.path("results/report.html").read_text()
    files = re.findall(r'<a class="file" href="([^"]*)"', page)
    assert "ground/contact.nc" in files
    assert all(project.path(f"results/{file}").is_file() for file in files)
    rows = {row["surface"]: row for row in project.rows("summary.csv")}
    assert list(rows) == ["ground", *BROKEN]
    assert float(rows["ground"]["relative_contact_area"]) > 0
    failed = json.loads(read_dataset(project.path("results/statistics.nc")).attrs["failed"])
    assert [failure["surface"] for failure in failed] == list(BROKEN)
    for name, (_, message_parts) in BROKEN.items():
        assert rows[name]["verdict"] == "failed"
        row = re.search(f'<tr class="failure"><td class="text">{name}</td>.*?</tr>', page)[0]
        for part in message_parts:
            assert part in rows[name]["reasons"]
            assert html.escape(part) in row
    # rows that are left out leave it as well
    project.write(QUICK, [HEADER, GOOD, *(f"#{row}" for row in rows)])
    assert counted(project.run()) == {"report": 1}
    assert "without results" not in project.path("results/report.html").read_text()
    assert "failed" not in project.path("results/summary.csv").read_text()


@pytest.mark.parametrize(
    ("settings", "table", "parts_of_message"),
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
                "line 4, surface = ground: occurs twice",
                "line 5, path = 'measured/nowhere.npy': no such file",
                "line 5, unit: unknown length unit 'furlong'",
                "line 5, dx = 'one': must be a number",
                "line 6, surface = turned: occurs twice",
            ],
        ),
    ],
)
def test_a_mistake_in_settings_or_table_is_found_before_anything_runs(
    project, settings, table, parts_of_message
):
    project.write(settings, table)
    run = project.run()
    assert run.returncode != 0
    for part in parts_of_message:
        assert part in run.stderr
    for word in ("Traceback", "WorkflowError", "common.smk"):
        assert word not in run.stderr
    assert not project.path("results").exists()


def bomb(value):
    """Return eight lines that stand for 20 to the power of 8 values."""
    lines = [f"x{n}: &x{n} {value % ', '.join([f'*x{n - 1}'] * 20)}" for n in range(1, 9)]
    return "\n".join(["contact: {mean_pressure: 1}", "x0: &x0 {a: 1}", *lines])


def test_plain_snakemake_refuses_a_configuration_that_grows_before_it_reads_it(project):
    project.path("config").mkdir()
    project.path("config/config.yaml").write_text(bomb("[%s]"))
    words = [sys.executable, "-m", "snakemake", "--snakefile", str(project.checkout / "Snakefile"), "-n"]
    run = subprocess.run(words, cwd=project.folder, capture_output=True, text=True, check=False, timeout=60)
    assert run.returncode == 1
    assert run.stderr.startswith("config/config.yaml: has more than 100000 values: look for aliases")
    assert "Traceback" not in run.stderr
    assert len(run.stderr.splitlines()) == 1


def test_plain_snakemake_asks_about_octal_numbers(project):
    settings = project.path("settings.yaml")
    settings.write_text("contact: {contact_modulus: 0100000}\nsurfaces: surfaces.tsv\n")
    run = project.run("-n")
    assert run.returncode == 1
    assert "settings.yaml, line 1: YAML reads 0100000 to the base of 8, here as 32768" in run.stderr


def test_what_is_merged_again_and_again_is_refused_or_merged_once(tmp_path):
    config = tmp_path / "config.yaml"
    config.write_text(bomb("{<<: [%s]}"))
    if tuple(map(int, version("PyYAML").split("."))) >= (6, 0, 4):
        check_yaml(config)
    else:
        with pytest.raises(SettingsError, match=r"line 6: has more than 100000 values by merge keys"):
            check_yaml(config)


@pytest.mark.parametrize("what", ["a file", "a link to results"])
def test_something_else_than_a_folder_in_the_place_of_the_results_is_named(project, what):
    results = project.path("results")
    results.touch() if what == "a file" else results.symlink_to("results")
    run = project.run()
    assert run.returncode == 1
    assert f"{results}: is {what}" in run.stderr
    assert "rename or delete it" in run.stderr
    assert "Traceback" not in run.stderr


def started(project, word, *arguments):
    """Start the workflow and return its process as soon as the log of the contact has `word`."""
    process = project.start("results/ground/contact.nc", *arguments, start_new_session=True)
    log = project.path("logs/ground/contact.log")
    project.wait_for(process, lambda: log.exists() and word in log.read_text())
    return process


@pytest.fixture
def lengthy(project):
    """A project whose solution takes some seconds."""
    loads = [0.01 * (1 + number) for number in range(24)]
    contact = SETTINGS["contact"] | {"relative_pressure": loads, "tolerance": 1e-10}
    project.write(QUICK | {"contact": contact})
    return project


@pytest.mark.slow
def test_what_was_cut_off_leaves_nothing_and_is_taken_up_again(lengthy):
    process = started(lengthy, "load 3 of 24", "--logger", "roughcontact")
    solvers = [
        child
        for child in process.children(recursive=True)
        if child.cmdline()[-1:] and child.cmdline()[-1].endswith(".contact.py")
    ]
    solvers[-1].kill()  # the job alone
    process.wait(timeout=60)
    assert process.returncode != 0
    output, log = lengthy.path("said").read_text(), lengthy.path("logs/ground/contact.log")
    killed = r"^\[contact ground\] ERROR: killed; .* it had asked for \d{3} MB\."
    assert re.search(killed, output, re.MULTILINE)
    for word in SNAKEMAKES_OWN:
        assert word not in output
    files_before = ["height.nc", "levelled.nc", "window.nc"]
    assert sorted(path.name for path in lengthy.path("results/ground").iterdir()) == files_before
    assert lengthy.jobs("results/ground/contact.nc") == {"contact": 1}

    log.unlink()
    process = started(lengthy, "load 3 of 24")
    os.killpg(process.pid, signal.SIGKILL)  # the whole run
    process.wait(timeout=60)
    assert not lengthy.path("results/ground/contact.nc").exists()
    lengthy.path("results/ground/.contact.nc.partial").touch()  # as if killed while it wrote
    assert lengthy.run("--unlock").returncode == 0
    assert counted(lengthy.run("results/ground/contact.nc", "--rerun-incomplete")) == {"contact": 1}
    assert not list(lengthy.path("results").rglob("*.partial"))


JOB = """
import sys
from types import SimpleNamespace
snakemake = SimpleNamespace(
    rule="contact", wildcards=["ground"], output={}, input={}, params={}, resources={}, log=["job.log"]
)
sys.path.insert(0, sys.argv[1])
import _job
raise ZeroDivisionError("half of nothing")
"""


def test_an_unexpected_error_names_its_type_and_the_log(tmp_path):
    command = [sys.executable, "-c", JOB, str(ROOT / "workflow/scripts")]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    hint = "(unexpected, please report it with job.log)"
    line = f"[contact ground] ERROR: ZeroDivisionError: half of nothing {hint}"
    assert run.returncode == 1
    assert run.stderr.splitlines() == [line]
    log = (tmp_path / "job.log").read_text()
    assert log.startswith("Traceback")
    assert log.endswith(f"{line}\n")
