"""The screen of a run: a line for each surface, the time left, and warnings and errors in full."""

import io
import json
import logging
from random import Random

import pytest

from roughcontact import errors
from snakemake_logger_plugin_roughcontact import screen
from snakemake_logger_plugin_roughcontact.clock import Clock
from snakemake_logger_plugin_roughcontact.screen import ERASE, Screen, read_record

BEGIN = 1_000_000.0
JOBS = {1: "ground", 2: "ground", 3: "turned", 4: "turned"}  # and 5, the report


class Run:
    """The records of Snakemake's logger during a run of two jobs a surface and the report."""

    def __init__(self, *, bar=False, planned=False):
        self.stream = io.StringIO()
        self.screen = Screen(self.stream, bar=bar, planned=planned)
        self.screen.clock.begin = BEGIN

    def tell(self, text="", *, level=logging.INFO, delay=0.0, **fields):
        record = logging.makeLogRecord({"levelno": level, "msg": text, "created": BEGIN + delay, **fields})
        self.screen.show(record, text)

    def begin(self):
        self.tell("Building DAG of jobs...")
        self.tell(event="workflow_started")
        stats = {"prepare": 2, "panel": 2, "report": 1, "total": 5}
        self.tell("Job stats:\n...", event="run_info", stats=stats)

    def start(self, number, start_time, log=(), output=(), resources=None):
        rule = "report" if number == 5 else ("panel", "prepare")[number % 2]
        self.tell(
            event="job_info",
            jobid=number,
            rule_name=rule,
            wildcards={"result": JOBS[number]} if number in JOBS else {},
            log=list(log),
            output=list(output),
            resources=resources or {},
            delay=start_time,
        )

    def job(self, number, start_time, end_time, log=(), output=()):
        self.start(number, start_time, log, output)
        self.tell(event="job_finished", job_id=number, delay=end_time)

    def fail(self, number, how="", log=(), aside=(), output=()):
        if how:
            self.tell(f"CalledProcessError in file x: {how}", level=logging.ERROR, event="error")
        self.tell(
            "Error in rule",
            level=logging.ERROR,
            event="job_error",
            jobid=number,
            rule_name="panel",
            log=[*log, *aside],
            output=list(output),
        )

    @property
    def lines(self):
        return self.stream.getvalue().splitlines()


def write_record(log, **fields):
    """Write the record that a job leaves beside its log."""
    log.with_suffix(".json").write_text(json.dumps(fields))


def test_a_surface_has_one_line_when_its_last_job_has_ended(tmp_path):
    log = tmp_path / "ingest.log"
    write_record(log, warnings=2)
    run = Run()
    run.begin()
    run.tell("Provided cores: 2")
    run.job(1, 0, 10, log=[str(log)])
    run.job(3, 10, 20)
    assert run.lines == ["2 results, 5 jobs"]
    run.job(2, 20, 50)
    # 50 s were 12 usual ones: (30 + 25) / 12 of 6 s for a panel, 50 / 12 of 6 s for the report
    assert run.lines[1:] == [
        "ground: done, 2 warnings in its logs and in the report (1 of 2, about 52 s left)"
    ]
    run.job(4, 50, 80)
    page = tmp_path / "report.html"
    page.write_text('<p class="answer">Seals for all 2 &amp; holds.</p>')
    run.job(5, 80, 90, output=[str(page)])
    run.tell(event="progress", done=5, total=5, delay=90)
    answer = "Seals for all 2 & holds."
    assert run.lines[2:] == ["turned: done (2 of 2, about 27 s left)", answer, f"done in 2 min: {page}"]


def test_a_run_of_one_result_says_that_the_page_is_older(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    endings = []
    for is_there in (False, True):
        if is_there:
            (tmp_path / "results").mkdir()
            (tmp_path / "results/report.html").touch()
        run = Run()
        run.tell(event="workflow_started")
        run.tell("Job stats:", event="run_info", stats={"panel": 1, "total": 1})
        run.job(2, 0, 10)
        run.tell(event="progress", done=1, total=1, delay=10)
        endings.append(run.lines[-1].partition(" s")[2])
    page = "results/report.html is of an earlier run: `roughcontact run` makes it anew"
    assert endings == ["", f"; {page}"]


def test_of_a_study_each_case_has_a_line():
    run = Run()
    run.begin()
    for number, case in enumerate(("hard", "soft"), 1):
        fields = {"rule_name": "panel", "wildcards": {"result": f"{case}/ground"}}
        run.tell(event="job_info", jobid=number, log=[], output=[], **fields)
        run.tell(event="job_finished", job_id=number, delay=number)
    assert [line.partition(" (")[0] for line in run.lines[1:]] == ["hard/ground: done", "soft/ground: done"]


def test_warnings_of_a_face_stand_with_the_pair(tmp_path):
    write_record(log := tmp_path / "prepare.log", warnings=1)
    run = Run()
    run.begin()
    for number, rule, name in ((1, "prepare_face", "seal-counter-face"), (2, "panel", "seal-2")):
        fields = {"rule_name": rule, "wildcards": {"result": name}, "log": [str(log)] if number == 1 else []}
        run.tell(event="job_info", jobid=number, output=[], **fields)
        run.tell(event="job_finished", job_id=number, delay=number)
    assert run.lines[1].startswith("seal-2: done, 1 warning in its logs and in the report (1 of 2")


@pytest.mark.parametrize("planned", [False, True])
def test_a_name_that_ends_with_a_number_takes_nothing_of_the_surface_without_it(tmp_path, planned):
    """`plate-1` may be a surface of its own, beside one called `plate`."""
    write_record(log := tmp_path / "prepare.log", warnings=1)
    run = Run(planned=planned)
    run.begin()
    for number, rule, name in ((1, "prepare", "plate"), (2, "panel", "plate-1"), (4, "panel", "plate")):
        fields = {"rule_name": rule, "wildcards": {"result": name}, "log": [str(log)] if number == 1 else []}
        run.tell(event="job_info", jobid=number, output=[], **fields)
        run.tell(event="job_finished" if not planned else "", job_id=number, delay=number)
    if planned:
        run.tell("This was a dry-run (flag -n).")
    lines = [line.partition(" (")[0] for line in run.lines[1:]]
    assert lines == (
        ["plate: prepare, draw", "plate-1: draw", "This is a plan: nothing was done."]
        if planned
        else ["plate-1: done", "plate: done, 1 warning in its logs and in the report"]
    )


def test_what_the_report_leaves_out_is_said(tmp_path):
    write_record(log := tmp_path / "report.log", warnings=1)
    run = Run()
    run.begin()
    run.job(5, 0, 10, log=[str(log)], output=["results/report.html"])
    assert run.lines[1:] == ["report: done, 1 warning in its logs and in the report"]


def test_a_job_that_has_failed_says_why_from_its_record(tmp_path):
    write_record(log := tmp_path / "panel.log", error="g.txt: is empty")
    run = Run()
    run.begin()
    run.start(2, 0, log=[str(log)])
    run.fail(2, "returned non-zero exit status 1.", log=[str(log)])
    # what Snakemake adds at the end says no more
    run.tell("Exiting because a job execution failed.", level=logging.ERROR)
    run.tell("WorkflowError:\nOne job did not", level=logging.ERROR, event="error", exception="WorkflowError")
    assert run.lines[1:] == ["[panel ground] ERROR: g.txt: is empty"]


def test_a_failure_is_shown_once_for_each_try(tmp_path):
    """Snakemake 9.22 reports it when it happens, and again when the run ends."""
    write_record(log := tmp_path / "panel.log", error="no points")
    run = Run()
    run.begin()
    for _ in range(2):
        run.start(2, 0, log=[str(log)])
        run.fail(2, log=[str(log)])
        run.fail(2, log=[str(log)])
    assert [line for line in run.lines if "ERROR" in line] == 2 * ["[panel ground] ERROR: no points"]


@pytest.mark.cases
def test_a_job_that_was_ended_is_explained_on_the_screen_and_in_its_record(tmp_path, how, said):
    log, half = tmp_path / "panel.log", tmp_path / ".panel.nc.partial"
    write_record(log, done=False)
    half.touch()
    run = Run()
    run.begin()
    run.start(2, 0, log=[str(log)], resources={"mem_mb": 900})
    run.fail(2, how, log=[str(log)], output=[str(tmp_path / "panel.nc")])
    assert not half.exists()
    assert len(run.lines[1:]) == bool(said)
    assert all(line.startswith(f"[panel ground] ERROR: {said}") for line in run.lines[1:])
    assert bool(said) == ("error" in read_record(log))
    assert read_record(log).get("error", "").startswith(said)


@pytest.mark.cases
def test_a_job_that_a_cluster_has_killed_is_explained_by_its_log_and_tried_again(tmp_path, log_text, message):
    (log := tmp_path / "panel.log").touch()
    (aside := tmp_path / "slurm.log").write_text(f"{log_text}\n")
    run = Run()
    run.begin()
    run.start(2, 0, log=[str(log)], resources={"mem_mb": 900, "runtime": 5})
    run.fail(2, log=[str(log)], aside=[str(aside)])
    run.start(2, 10, log=[str(log)], resources={"mem_mb": 1800, "runtime": 10})
    assert run.lines[1:] == [
        f"[panel ground] ERROR: killed, {message}",
        "[panel ground] is tried again with 1800 MB and 10 minutes",
    ]
    assert message in read_record(log)["error"]
    assert len(run.screen.clock.running) == 1


def test_jobs_that_run_side_by_side_leave_half_the_time():
    run = Run()
    run.begin()
    for number in (1, 3):
        run.start(number, 0)
    run.tell(event="job_finished", job_id=1, delay=10)
    # a quarter of the other's 10 s; two contacts of 6 s, and the report, where 3 s have taken 10 s
    assert run.screen.clock.seconds(BEGIN + 10) == pytest.approx((10 / 4 + 2 * 20) / 2 + 20)


@pytest.mark.parametrize("share", [0.7, 1.0, 1.8])
@pytest.mark.parametrize("size_first", ["small", "large", "mixed"])
def test_the_time_left_is_right_within_a_factor_of_two_after_a_tenth_of_the_jobs(share, size_first):
    """Of 41 maps five have a hundred times the points; maps are as hard as they are, twice or half of it."""
    random = Random(size_first)
    minutes = {f"s{n}": random.uniform(0.1, 0.5) * (60 if n % 8 == 3 else 1) for n in range(41)}
    order = sorted(minutes, key=minutes.get, reverse=size_first == "large")
    order = order if size_first != "mixed" else list(minutes)
    large = {name: 2 if minutes[name] > 1 else 1 for name in minutes}
    clock = Clock()
    clock.expected = {("panel", name): (minutes[name], large[name]) for name in order}
    clock.expected |= {("prepare", name): (minutes[name] / 25, 1) for name in order}
    clock.plan({"prepare": 41, "panel": 41, "report": 1, "all": 1})
    jobs = [("prepare", name) for name in order] + [("panel", name) for name in order]
    now, waiting, working, estimates = 0.0, list(enumerate([*jobs, ("report", "")])), {}, []
    while waiting or working:
        while waiting and sum(
            large.get(name, 1) if kind == "panel" else 1 for _, kind, name in working.values()
        ) + (large.get(waiting[0][1][1], 1) if waiting[0][1][0] == "panel" else 1) <= (
            2 if waiting[0][1][0] != "report" or not working else 0
        ):
            number, (kind, name) = waiting.pop(0)
            slope = {"prepare": 0.4, "panel": share * random.uniform(0.5, 2), "report": 0}[kind]
            takes = {"prepare": 4, "panel": 8, "report": 9}[kind] * random.uniform(0.8, 1.2)
            threads = large[name] if kind == "panel" else 1
            clock.start(number, kind, now, result=name, threads=threads)
            working[number] = (now + takes + slope * minutes.get(name, 0) / threads, kind, name)
        number = min(working, key=working.get)
        now = working.pop(number)[0]
        clock.finish(number, now)
        estimates.append((now, clock.seconds(now)))
    wrong = [(now - at) / seconds for at, seconds in estimates if now - at > 30][8:]
    assert 0.5 < min(wrong) < max(wrong) < 2


def test_warnings_and_errors_come_in_full_above_the_bar():
    run = Run(bar=True)
    run.begin()
    run.tell("MissingOutputException: a.nc", level=logging.ERROR, event="error")
    run.tell("a warning\nof two lines", level=logging.WARNING)
    assert f"{ERASE}MissingOutputException: a.nc\n" in run.stream.getvalue()
    assert f"{ERASE}a warning\nof two lines\n" in run.stream.getvalue()


def test_the_bar_fits_the_terminal_and_says_what_is_at_work(monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    run = Run(bar=True)
    run.begin()
    run.job(1, 0, 10)
    run.start(2, 10)
    last = run.stream.getvalue().rpartition(ERASE)[2]
    assert last == "[####----------------] 1 of 5 jobs, about 1 min left: panel"


def test_a_dry_run_shows_one_line_of_each_surface():
    run = Run(planned=True)
    run.begin()
    for number in (1, 3, 2, 4, 5):
        run.start(number, 0)
    run.tell("Reasons:\n    why")
    run.tell("This was a dry-run (flag -n).")
    assert run.lines == [
        "2 results, 5 jobs",
        "ground: prepare, draw",
        "turned: prepare, draw",
        "This is a plan: nothing was done.",
    ]


def test_a_dry_run_counts_a_single_job_and_shows_faces_with_every_placement():
    """Also where the last step of a placement is not asked for, as with `--until contact`."""
    run = Run(planned=True)
    run.tell(event="run_info", stats={"contact": 1, "total": 1})
    jobs = {"prepare_face": "seal-face", "superpose": "seal-1", "contact": "seal-1"}
    for rule, result in jobs.items():
        run.tell(event="job_info", rule_name=rule, wildcards={"result": result})
    run.tell("This was a dry-run (flag -n).")
    assert run.lines == ["1 job", "seal-1: prepare, superpose, contact", "This is a plan: nothing was done."]


def test_what_is_asked_for_beside_a_run_is_shown():
    run = Run()
    run.tell("Unlocking working directory.")
    run.tell(event="workflow_started")
    run.tell("Nothing to be done (all requested files are present and up to date).")
    assert [line.split()[0] for line in run.lines] == ["Unlocking", "Nothing"]


def test_a_mark_that_turns_the_direction_of_a_name_is_shown_as_an_escape():
    run = Run()
    run.tell("a\u202ecod.txt: text without a table of numbers", level=logging.ERROR)
    assert "a\\u202ecod.txt: text" in run.stream.getvalue()
    assert screen._TURNING == errors._TURNING  # the plugin imports nothing of roughcontact
