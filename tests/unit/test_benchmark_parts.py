"""The benchmark of the parts of `evaluate` tells the time and the memory of each apart."""

import sys
import time

import numpy as np
import parts
import pytest


def test_the_times_of_the_parts_add_up_to_that_of_the_call():
    began = time.process_time()
    rows = parts.measured(64)
    assert [row["part"] for row in rows] == list(parts.PARTS.values())
    total = sum(row["CPU s"] for row in rows)
    assert 0.5 < total / (time.process_time() - began) <= 1  # the rest makes the map, and imports


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the peak is that since the process began")
def test_a_part_does_not_have_the_peak_of_an_earlier_one():
    clock = parts.Clock()
    clock(0, None, "levelling")
    np.ones(25_000_000).sum()  # 200 MB, freed again
    clock(0, None, "periodic window")
    clock.end()
    first, second = (row["peak memory (MB)"] for row in clock.rows)
    assert first - second > 150
