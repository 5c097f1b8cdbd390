"""The short form of the kills; the full one is a command of its own (see docs/explanation/reliability.md)."""

import os
import re
import signal
import socket
import subprocess
import sys

import psutil
import pytest
from kills import family, jobs_at_work, kill_at_random, session, words
from study import ROOT, begin, command, environment, write_study
from terminations import end_at_random, load


@pytest.mark.nightly
def test_a_killed_run_goes_on_and_leaves_the_same_bytes(tmp_path):
    counts, wrong = kill_at_random(
        tmp_path, kills=3, seed=3, targets=("results/surface-2/levelled.nc",), cases=False
    )
    assert not wrong
    assert counts["kills"] == 3


def ended(words_of_it):
    """Return a command of the study that has come to its end, with what it has said."""
    return subprocess.run(words_of_it, env=environment(), capture_output=True, text=True, check=False)


RUN_PY = """
import sys
sys.path.insert(0, sys.argv[1])
import run
sys.exit(run.run(sys.argv[2:]))
"""


@pytest.mark.nightly
@pytest.mark.parametrize(
    "wrapper", ["roughcontact run", "run.py", "in the background", "interrupted", "Ctrl-C"]
)
def test_nothing_goes_on_after_the_program_was_stopped(tmp_path, wrapper):
    """Snakemake has cleaned up, whether a signal reaches the program alone or, as Ctrl-C, all of the run."""
    write_study(tmp_path, sides=(48,), cases=False)
    words_of_it = command(tmp_path, "results/surface-1/levelled.nc")
    if wrapper == "run.py":
        words_of_it = [sys.executable, "-c", RUN_PY, str(ROOT), *words_of_it]
    interrupted = wrapper in ("interrupted", "Ctrl-C")
    heard = signal.SIG_IGN if wrapper == "in the background" else signal.default_int_handler
    run = begin(
        words_of_it,
        log := tmp_path / "said.txt",
        preexec_fn=lambda: signal.signal(signal.SIGINT, heard),  # as shells start what they do not wait for
    )
    try:
        jobs_at_work(run, "prepare", log)
        started = family(run)[1:]
        assert len(started) >= 2
        if wrapper == "Ctrl-C":
            os.killpg(run.pid, signal.SIGINT)
        else:
            run.send_signal(signal.SIGINT if interrupted else signal.SIGTERM)
        assert run.wait(timeout=60) == (130 if interrupted else 143)
        assert ("Interrupted: what is finished is kept" in log.read_text()) == interrupted
        _, left = psutil.wait_procs([*started, *session(run)], timeout=30)
        assert [words(each) for each in left] == []
        assert "Traceback" not in log.read_text()
        assert not list(tmp_path.glob(".snakemake/locks/*"))
        assert not list(tmp_path.glob("results/**/*.nc"))
    finally:
        for each in session(run):
            each.kill()


@pytest.mark.nightly
@pytest.mark.parametrize("killed", ["roughcontact run", "all but a job"])
def test_the_next_run_ends_what_goes_on_of_a_killed_one(tmp_path, killed):
    write_study(tmp_path, sides=(48,), cases=False)
    target = "results/surface-1/levelled.nc"
    run = begin(command(tmp_path, target), log := tmp_path / "said.txt")
    try:
        jobs = jobs_at_work(run, "prepare", log)
        jobs[0].suspend()  # it cannot end before the next run begins
        remains = family(run)[1:] if killed == "roughcontact run" else jobs
        for process in family(run):
            if process not in remains:
                process.kill()
        run.wait()
        assert session(run)
        continued = ended(command(tmp_path, target))
        assert continued.returncode == 0, continued.stderr
        assert "The last run in this folder was killed: it is continued." in continued.stderr
        assert session(run) == []
        assert (tmp_path / target).exists()
    finally:
        for each in session(run):
            each.kill()


@pytest.mark.nightly
def test_a_termination_ends_jobs_whose_parent_has_gone(tmp_path):
    """As that of a shell that was ended while it started its program."""
    write_study(tmp_path, sides=(48,), cases=False)
    words_of_it, log = command(tmp_path, "results/surface-1/levelled.nc"), tmp_path / "said.txt"
    run = begin(words_of_it, log, start_new_session=False)
    started, *_ = jobs_at_work(run, "prepare", log)
    orphan = subprocess.Popen(["sleep", "600"], env=started.environ())
    try:
        run.terminate()
        assert run.wait(timeout=60) == 143
        assert orphan.wait(timeout=1) == -signal.SIGTERM
    finally:
        orphan.kill()


@pytest.mark.slow
def test_no_termination_on_a_busy_machine_leaves_a_process(tmp_path):
    with load(2):
        assert end_at_random(tmp_path, tries=4, seed=1) == []


@pytest.mark.nightly
@pytest.mark.parametrize("started_by", ["roughcontact run", "snakemake"])
def test_beside_a_run_at_work_none_begins_and_its_locks_stay(tmp_path, started_by):
    write_study(tmp_path, sides=(48,), cases=False)
    first_command = command(tmp_path, "results/surface-1/levelled.nc")
    if started_by == "snakemake":
        first_command[2:4] = ["snakemake", "--snakefile", str(ROOT / "Snakefile")]
    run = begin(first_command, log := tmp_path / "said.txt")
    try:
        jobs = jobs_at_work(run, "prepare", log)
        jobs[0].suspend()
        locks = {*tmp_path.glob(".snakemake/locks/*.lock")}
        assert locks
        if started_by == "snakemake":  # which keeps others out itself
            refused = ended(command(tmp_path))
            assert refused.returncode == 1
            assert "Directory cannot be locked" in refused.stdout + refused.stderr
        else:
            for options in ((), ("--unlock",), ("--nolock",)):
                refused = ended(command(tmp_path, *options))
                assert refused.returncode == 2
                output = f"a run is at work there (process {run.pid} on {socket.gethostname()})"
                assert output in refused.stderr
                assert len(refused.stderr.splitlines()) == 1
        assert {*tmp_path.glob(".snakemake/locks/*.lock")} == locks
        jobs[0].resume()
        assert run.wait(timeout=60) == 0, log.read_text()
    finally:
        for process in session(run):
            process.kill()


@pytest.mark.slow
def test_a_job_that_is_killed_says_how_much_memory_it_had_asked_for(tmp_path):
    write_study(tmp_path, sides=(40,), cases=False)
    words_of_it, log = command(tmp_path, "results/summary.csv"), tmp_path / "said.txt"
    run = begin(words_of_it, log, start_new_session=False)
    reporting, *_ = jobs_at_work(run, "report", log)
    reporting.kill()
    assert run.wait(timeout=60)
    output = log.read_text()
    pattern = (
        r"\n\[report\] ERROR: killed; probably out of memory: it had asked for \d+ MB\. Free some memory"
    )
    assert re.search(pattern, output)
    assert "Traceback" not in output
