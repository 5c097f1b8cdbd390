"""A short form of `unnoticed.py`, and that it notices what it counts."""

import json
from collections import Counter

import numpy as np
import pytest
import unnoticed

from roughcontact.errors import InputFileError

GIVEN = {"dx": 1.0, "dy": 1.5, "unit": "um", "height_unit": "nm"}


@pytest.mark.slow
def test_no_damage_ends_in_an_exception_and_little_passes_in_silence(tmp_path):
    records = unnoticed.fuzz(200, seed=2, folder=tmp_path, largest=0)
    kinds = Counter(record["kind"] for record in records)
    assert kinds.total() == 200
    assert set(kinds) <= {"refused", "same", "warned", "silent"}
    assert kinds["silent"] <= 0.08 * 200
    moved = [record for record in records if record["kind"] == "silent" and record["way"] in SIZES]
    assert all("text" in record["file"] for record in moved)  # binary headers state their sizes


SIZES = ("block inserted", "block lost", "block doubled", "cut off", "padded")


@pytest.fixture
def original(tmp_path):
    path = tmp_path / "map.npy"
    np.save(path, 500 + np.cumsum(np.random.default_rng(1).standard_normal((30, 40)), axis=1))
    return path, unnoticed.whole(path)


def outcome(path, original, change):
    heights = np.frombuffer(original.data, "<f8", offset=128).copy()
    change(heights)
    path.write_bytes(original.data[:128] + heights.tobytes())
    return json.loads(unnoticed.compared(path, original))


def test_every_difference_counts(original):
    path, original = original
    assert original.arguments == GIVEN
    assert outcome(path, original, lambda heights: None) == {"other": "", "word": False}

    def least(heights):
        heights[7] = np.nextafter(heights[7], 0)

    found = outcome(path, original, least)
    assert (found["other"], found["word"], found["points"]) == ("heights", False, 1)
    assert 0 < found["change"] < 1e-12

    def spike(heights):
        heights[7] += 100

    found = outcome(path, original, spike)
    assert (found["word"], found["points"]) == (True, 1)
    path.write_bytes(original.data[:-8])
    with pytest.raises(InputFileError):
        unnoticed.compared(path, original)


def test_a_warning_with_other_numbers_is_no_new_word():
    kinds = unnoticed._kinds
    assert kinds(["3 points lie far above (up to 1.2 µm)"]) == kinds(
        ["41 points lie far above (up to −7 nm)"]
    )
    assert kinds(["3 points lie far above"]) != kinds(["3 points lie far below"])


@pytest.mark.parametrize("way", unnoticed.WAYS)
def test_every_way_changes_a_file(way):
    choose = unnoticed.random.Random(1)
    data = b"# Width: 24 um\n" + bytes(range(256)) * 8
    damaged = [unnoticed.WAYS[way](data, choose) for _ in range(20)]
    assert all(each != data for each in damaged)
    longer = {"block inserted": 1, "padded": 1, "block doubled": 1, "block lost": -1, "cut off": -1}.get(
        way, 0
    )
    assert all(np.sign(len(each) - len(data)) == longer for each in damaged)
