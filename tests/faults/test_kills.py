"""The short form of the kills; the full one is a command of its own (see docs/explanation/faults.md)."""

import subprocess
import time

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
def test_a_killed_job_that_asked_for_no_memory_is_said_and_ends_the_run(tmp_path):
    write_study(tmp_path, sides=(40,), cases=False)
    with (tmp_path / "said.txt").open("w") as said:
        run = subprocess.Popen(
            command(tmp_path, "results/summary.csv"), env=environment(), stdout=said, stderr=said
        )
    while not (collecting := [each for each in family(run) if words(each).endswith(".collect.py")]):
        assert run.poll() is None, (tmp_path / "said.txt").read_text()
        time.sleep(0.002)
    collecting[0].kill()
    assert run.wait(timeout=60)
    said = (tmp_path / "said.txt").read_text()
    assert "\n[collect] ERROR: killed; probably out of memory. Free some memory" in said
    assert "Traceback" not in said
