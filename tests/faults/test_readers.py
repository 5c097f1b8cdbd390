"""A short form of `fuzz_readers.py`, and that it would notice what goes wrong."""

import time

import fuzz_readers
import numpy as np
import pytest

from roughcontact.errors import InputFileError


def test_damaged_files_give_maps_or_clear_errors(tmp_path):
    counts = fuzz_readers.fuzz(120, seed=3, folder=tmp_path)
    lines = fuzz_readers.rows(counts)
    assert sum(int(line["files"]) for line in lines) == 120
    assert sum(int(line["maps"]) + int(line["refused"]) for line in lines) == 120


@pytest.mark.slow
def test_hostile_files_do_no_harm(tmp_path):
    lines = fuzz_readers.rows(fuzz_readers.hostile(tmp_path))
    assert [line["file"] for line in lines if line["maps"] == line["refused"]] == []


@pytest.mark.parametrize(
    ("read", "kind"),
    [
        (lambda path: None, "map"),
        (lambda path: _refuse(f"{path}: no map"), "refused"),
        (lambda path: _refuse("no map"), "message"),
        (lambda path: _refuse(f"{path}: {'no map ' * 200}"), "message"),
        (lambda path: 1 / 0, "exception"),
        (lambda path: np.zeros(2**30), "exception"),  # 8 GiB: more than a process gets
        (lambda path: np.ones(2**27), "memory"),
        (lambda path: __import__("os").kill(__import__("os").getpid(), 11), "signal"),
    ],
)
def test_what_goes_wrong_is_noticed(tmp_path, monkeypatch, read, kind):
    monkeypatch.setattr(fuzz_readers, "LARGEST", 10**9)
    assert fuzz_readers.outcome_of(tmp_path / "file", read).kind == kind


def _refuse(words):
    raise InputFileError(words)


def test_what_does_not_end_is_noticed(tmp_path, monkeypatch):
    monkeypatch.setattr(fuzz_readers, "LONGEST", 1)

    def spin(path):
        deadline = time.process_time() + 20
        while time.process_time() < deadline:
            pass

    assert fuzz_readers.outcome_of(tmp_path / "file", spin).kind == "time"
