"""A short run of damages: no result is read with other numbers, and one that were would be noticed."""

import random

import damaged_results
import pytest
from damaged_results import damaged, outcomes, write_results

from roughcontact import read_dataset, self_affine_surface


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    band = {"hurst": 0.8, "shortest": 8e-6, "longest": 24e-6, "rms_gradient": 0.1}
    height = self_affine_surface((48, 48), 1e-6, **band, seed=1)
    return write_results(tmp_path_factory.mktemp("results"), height)


def test_no_damage_is_read_with_other_numbers(results):
    for path in results:
        counts = outcomes(path, damages=60, seed=2)
        # harmless where the checksum alone is damaged
        assert {*counts} <= {"refused", "harmless"}
        assert counts["refused"] >= 57


def test_other_numbers_would_be_noticed(results, monkeypatch):
    """One bit of the contact area is turned, and nobody compares the checksum."""
    value = read_dataset(results[0])["relative_contact_area"].values[0].tobytes()
    start = results[0].read_bytes().index(value) + 6

    def turned(data, _):
        return data[:start] + bytes([data[start] ^ 1]) + data[start + 1 :]

    monkeypatch.setattr(damaged_results, "damaged", turned)
    assert outcomes(results[0], damages=1, seed=2) == {"refused": 1}
    monkeypatch.setattr("roughcontact.results.storage.check_seal", lambda path: 1)
    assert outcomes(results[0], damages=1, seed=2) == {"other": 1}


def test_every_way_changes_a_file():
    choose, data = random.Random(1), bytes(range(256)) * 8
    lengths = [len(damaged(data, choose)) - len(data) for _ in range(200)]
    assert {min(lengths), max(lengths)} <= {*range(-64, -50), *range(50, 65)}
    assert lengths.count(0) > 50
