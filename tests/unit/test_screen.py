"""The screen of a run: a line for each surface, the time left, and warnings and errors in full."""

import io
import logging

import pytest

from snakemake_logger_plugin_roughcontact.screen import ERASE, Screen

BEGIN = 1_000_000.0
JOBS = {1: "ground", 2: "ground", 3: "turned", 4: "turned"}  # and 5, the report


class Run:
    """The records of Snakemake's logger during a run of two jobs a surface and the report."""

    def __init__(self, *, bar=False, planned=False):
        self.stream = io.StringIO()
        self.screen = Screen(self.stream, bar=bar, planned=planned)
        self.screen.clock.begin = BEGIN

    def tell(self, text="", *, level=logging.INFO, after=0.0, **fields):
        record = logging.makeLogRecord({"levelno": level, "msg": text, "created": BEGIN + after, **fields})
        self.screen.show(record, text)

    def begin(self):
        self.tell("Building DAG of jobs...")
        self.tell(event="workflow_started")
        stats = {"prepare": 2, "contact": 2, "report": 1, "total": 5}
        self.tell("Job stats:\n...", event="run_info", surfaces=dict(JOBS), stats=stats)

    def job(self, number, begin, end, log=(), output=()):
        rule = "report" if number == 5 else ("contact", "prepare")[number % 2]
        self.tell(
            event="job_info", jobid=number, rule_name=rule, log=list(log), output=list(output), after=begin
        )
        self.tell(event="job_finished", job_id=number, after=end)

    @property
    def lines(self):
        return self.stream.getvalue().splitlines()


def test_a_surface_has_one_line_when_its_last_job_has_ended(tmp_path):
    log = tmp_path / "ingest.log"
    log.write_text(
        "[ingest ground] warning: no unit\n[ingest ground] warning: steep\n[ingest ground] load 1\n"
    )
    run = Run()
    run.begin()
    run.tell("Provided cores: 2")
    run.job(1, 0, 10, log=[str(log)])
    run.job(3, 10, 20)
    assert run.lines == ["2 surfaces, 5 jobs"]
    run.job(2, 20, 50)
    # a contact of 30 s as the one before, and a report of (10 + 10 + 30) / 3 s
    assert run.lines[1:] == [
        "ground: done, 2 warnings in its logs and in the report (1 of 2, about 47 s left)"
    ]
    run.job(4, 50, 80)
    run.job(5, 80, 90, output=["results/report.html"])
    run.tell(event="progress", done=5, total=5, after=90)
    assert run.lines[2:] == ["turned: done (2 of 2, about 20 s left)", "done in 2 min: results/report.html"]


def test_a_job_for_all_surfaces_is_none_of_them():
    """Such a job may end before the last one of a surface, as with a cross-check."""
    run = Run()
    run.begin()
    for number in (1, 3, 5, 2, 4):
        run.job(number, 10 * number, 10 * number + 10)
    assert [line.partition(" (")[2][:6] for line in run.lines[1:]] == ["1 of 2", "2 of 2"]


def test_jobs_that_run_side_by_side_leave_half_the_time():
    run = Run()
    run.begin()
    for number in (1, 3):
        run.tell(event="job_info", jobid=number, rule_name="prepare", log=[], output=[])
    run.tell(event="job_finished", job_id=1, after=10)
    # of prepare nothing is left of the other's 10 s; two contacts and the report of 10 s each
    assert run.screen.clock.seconds(BEGIN + 10) == pytest.approx((2 + 1) * 10 / 2)


def test_warnings_and_errors_come_in_full_above_the_bar():
    run = Run(bar=True)
    run.begin()
    run.tell("[ingest ground] ERROR: killed", level=logging.ERROR, event="error")
    run.tell("a warning\nof two lines", level=logging.WARNING)
    assert f"{ERASE}[ingest ground] ERROR: killed\n" in run.stream.getvalue()
    assert f"{ERASE}a warning\nof two lines\n" in run.stream.getvalue()


def test_the_bar_fits_the_terminal_and_says_what_is_at_work(monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    run = Run(bar=True)
    run.begin()
    run.job(1, 0, 10)
    run.tell(event="job_info", jobid=2, rule_name="contact_base", log=[], output=[], after=10)
    last = run.stream.getvalue().rpartition(ERASE)[2]
    assert last == "[####----------------] 1 of 5 jobs, about 40 s left: contac"


def test_a_dry_run_shows_the_jobs_of_each_rule_once_and_why():
    run = Run(planned=True)
    run.begin()
    run.tell(event="job_info", jobid=1, rule_name="prepare", log=[], output=[], reason="none")
    run.tell("Reasons:\n    why")
    run.tell("Job stats:\n...", event="run_info")
    run.tell("This was a dry-run (flag -n).")
    assert run.lines == ["Job stats:", "...", "2 surfaces, 5 jobs", "Reasons:", "    why"]


def test_what_is_asked_for_beside_a_run_is_shown():
    run = Run()
    run.tell("Unlocking working directory.")
    run.tell(event="workflow_started")
    run.tell("Nothing to be done (all requested files are present and up to date).")
    assert [line.split()[0] for line in run.lines] == ["Unlocking", "Nothing"]
