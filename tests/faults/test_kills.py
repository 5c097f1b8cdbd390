"""The short form of the kills; the full one is a command of its own (see docs/explanation/faults.md)."""

from kills import kill_at_random


def test_a_killed_run_goes_on_and_leaves_the_same_bytes(tmp_path):
    counts, wrong = kill_at_random(
        tmp_path, kills=3, seed=3, targets=("results/surface-2/levelled.nc",), cases=False
    )
    assert not wrong
    assert counts["kills"] == 3
