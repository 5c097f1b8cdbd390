"""The short form of the kills; the full one is a command of its own (see docs/explanation/reliability.md)."""

import fcntl
import re
import socket
import subprocess
import time

import psutil
import pytest
from kills import family, kill_at_random, words
from study import command, environment, write_study


def test_a_killed_run_goes_on_and_leaves_the_same_bytes(tmp_path):
    counts, wrong = kill_at_random(
        tmp_path, kills=3, seed=3, targets=("results/surface-2/levelled.nc",), cases=False
    )
    assert not wrong
    assert counts["kills"] == 3


@pytest.mark.slow
def test_a_job_that_is_killed_says_how_much_memory_it_had_asked_for(tmp_path):
    write_study(tmp_path, sides=(40,), cases=False)
    with (tmp_path / "said.txt").open("w") as said:
        run = subprocess.Popen(
            command(tmp_path, "results/summary.csv"), env=environment(), stdout=said, stderr=said
        )
    while not (reporting := [each for each in family(run) if words(each).endswith(".report.py")]):
        assert run.poll() is None, (tmp_path / "said.txt").read_text()
        time.sleep(0.002)
    reporting[0].kill()
    assert run.wait(timeout=60)
    said = (tmp_path / "said.txt").read_text()
    asked = r"\n\[report\] ERROR: killed; probably out of memory: it had asked for \d+ MB\. Free some memory"
    assert re.search(asked, said)
    assert "Traceback" not in said


@pytest.mark.slow
def test_a_job_of_a_killed_run_does_not_take_the_next_run_for_its_own(tmp_path):
    write_study(tmp_path, sides=(48,), cases=False)
    run = subprocess.Popen(
        command(tmp_path, "results/surface-1/levelled.nc"),
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    while not (jobs := [each for each in family(run) if words(each).endswith(".prepare.py")]):
        assert run.poll() is None
        time.sleep(0.002)
    (job,) = jobs
    job.suspend()  # it cannot notice that its run is gone
    others = [each for each in family(run) if each != job]
    for each in others:
        each.kill()
    run.wait()
    psutil.wait_procs(others)
    with (tmp_path / ".snakemake/running").open("r+") as held:  # as the next run does
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        held.write(f"{socket.gethostname()} another\n")
        held.truncate()
        held.flush()
        job.resume()
        psutil.wait_procs([job], timeout=20)
        assert not job.is_running()
    assert not list(tmp_path.glob("results/**/*.nc"))
