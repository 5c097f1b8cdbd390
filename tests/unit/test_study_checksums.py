"""A file that was replaced has another checksum, whatever its date and size, and no file is read in vain."""

import json
import os
import threading
import time

import numpy as np
import pytest
from measured_files import GIVEN, array, refuses, saved

from roughcontact import InputFileError, read_height_map
from roughcontact.io.guards import file_state, sha256, unchanged
from roughcontact.study import notes
from roughcontact.study.checksums import checksum


@pytest.fixture
def noted(tmp_path):
    notes.noted.cache_clear()
    return tmp_path / "noted"


@pytest.fixture
def path(tmp_path):
    (tmp_path / "a.txt").write_text("1 2")
    return tmp_path / "a.txt"


def lines(noted):
    """Return what another process finds noted."""
    notes.write_notes()
    notes.noted.cache_clear()
    return [json.loads(line) for line in noted.read_text().splitlines()] if noted.exists() else []


@pytest.mark.parametrize("how", ["in place", "another file"])
def test_a_file_of_the_same_size_and_date_is_told_from_the_one_before(path, noted, how):
    os.utime(path, (1e9, 1e9))
    time.sleep(3.1)  # until its dates are settled
    checksum_before = checksum(path, memo=noted)
    assert not noted.exists(), "as after a dry run"
    assert lines(noted) == [[str(path), [file_state(path), checksum_before]]]
    written = path if how == "in place" else path.with_name("b.txt")
    written.write_text("1 3")
    os.utime(written, (1e9, 1e9))
    written.replace(path)
    assert (path.stat().st_size, path.stat().st_mtime) == (3, 1e9)
    assert checksum(path, memo=noted) == sha256(path) != checksum_before


def test_a_file_that_has_not_changed_is_not_read_again(path, noted):
    noted.write_text(json.dumps([str(path), [file_state(path), "as noted"]]) + "\n")
    assert checksum(path, memo=noted) == "as noted"
    path.write_text("1 3")
    assert checksum(path, memo=noted) == sha256(path)


def test_what_may_yet_change_within_a_tick_of_the_clock_is_not_noted(path, noted):
    assert checksum(path, memo=noted) == sha256(path)
    assert lines(noted) == []


def test_damaged_lines_are_left_out_and_the_last_of_a_path_counts(path, noted):
    rows = [[str(path), [[1, 2, 3, 4], "old"]], [str(path), [file_state(path), "new"]]]
    noted.write_text("\n".join(["{", *map(json.dumps, rows), "[1, 2, 3]", "7", '["half']))
    assert checksum(path, memo=noted) == "new"


def test_a_file_that_is_not_there_is_left_to_the_job_that_reads_it(tmp_path, noted):
    assert checksum(tmp_path / "nowhere.txt", memo=noted) == ""
    assert checksum(tmp_path, memo=noted) == ""


def test_a_file_that_is_written_to_while_it_is_read_is_refused(tmp_path):
    path = saved(tmp_path, array(np.random.default_rng(0).standard_normal((1500, 1500))))
    stop_event = threading.Event()

    def write():
        with path.open("r+b") as file:
            while not stop_event.is_set():
                file.seek(1000)
                file.write(b"12345678")
                file.flush()
                time.sleep(0.001)

    writer = threading.Thread(target=write)
    writer.start()
    try:
        refuses(r"map\.dat: changed while it was read; wait until", path, **GIVEN)
    finally:
        stop_event.set()
        writer.join()
    assert read_height_map(path, **GIVEN).shape == (1500, 1500)


def test_a_file_that_is_replaced_while_it_is_read_is_refused(path):
    path.with_name("b.txt").write_text("1 3")
    with pytest.raises(InputFileError, match="changed while it was read"), unchanged(path):
        path.with_name("b.txt").replace(path)
