"""How many points a file holds, before it is read."""

from pathlib import Path

import numpy as np
import pytest
from measured_files import archive, array, cells, points, saved
from shared_data import DATA

from roughcontact.errors import RoughContactError
from roughcontact.io.guards import MAX_POINTS
from roughcontact.io.registry import open_file
from roughcontact.study.points import estimate_points

SAMPLES = Path(__file__).parents[2] / "data_samples"
HEIGHTS = np.random.default_rng(1).normal(size=(400, 300))


def points_read(path):
    """Return the points of the largest map in a file, by the reader of its format."""
    return max(channel.shape[0] * channel.shape[1] for channel in open_file(path).channels)


@pytest.mark.parametrize(
    ("rows", "separator", "form", "encoding"),
    [
        (HEIGHTS, " ", "{:.6g}", "utf-8"),
        (HEIGHTS, "\t", "{:.3e}", "utf-8"),
        (HEIGHTS, ",", "{:.4f}", "utf-8"),
        (HEIGHTS, ";", "{:.4f}", "utf-16"),
        (points(HEIGHTS), " ", "{:.12e}", "utf-8"),  # lists have one in each line
        (points(HEIGHTS), ",", "{:.12e}", "utf-8"),
    ],
)
def test_the_points_of_a_text_are_counted_in_a_piece(tmp_path, rows, separator, form, encoding):
    text = cells(rows, separator, form)
    # a decimal comma separates nothing
    for content in (text, text.replace(".", ",")) if separator == ";" else (text,):
        path = saved(tmp_path, content, encoding=encoding)
        assert estimate_points(path) == pytest.approx(HEIGHTS.size, rel=0.02)


def test_a_damaged_file_has_as_many_as_its_size_lets_expect_and_a_missing_one_none(tmp_path):
    no_sizes = archive({"main.xml": " " * 4000})  # or in UTF-16
    for data in (array(HEIGHTS)[:4000], b"PK\3\4" + bytes(3996), bytes(4000), no_sizes):
        assert estimate_points(saved(tmp_path, data)) == 1000
    for path in (saved(tmp_path, b""), tmp_path / "none", tmp_path):
        assert estimate_points(path) == 0


def test_no_header_asks_for_more_than_is_ever_read(tmp_path):
    header = "<SizeX>999999999</SizeX><SizeY>999999999</SizeY><SizeZ>1</SizeZ>"
    assert estimate_points(saved(tmp_path, archive({"main.xml": header}))) == MAX_POINTS


@pytest.mark.parametrize(
    "name", ["ground.txt", "sandblasted.x3p", "turned.sdf", "periodic.nc", "stylus-profile.csv"]
)
def test_samples_are_told_within_a_factor_of_two(name):
    assert 0.5 <= estimate_points(SAMPLES / name) / points_read(SAMPLES / name) <= 2.1


@pytest.mark.shared_data
def test_real_files_are_told_within_a_factor_of_two_and_seldom_taken_for_larger():
    """Several channels, or pictures beside the map, are taken for points: too many, never too few."""
    shares = {}
    for path in sorted(DATA.iterdir()):
        if path.suffix in (".md", ".tsv", ".json") or path.stat().st_size < 1e5:
            continue
        try:
            shares[path.name] = estimate_points(path) / points_read(path)
        except RoughContactError:
            continue
    assert len(shares) > 25
    assert {name: share for name, share in shares.items() if share < 0.5} == {}
    exact = {name: share for name, share in shares.items() if name.endswith((".x3p", ".txt"))}
    assert len(exact) >= 8
    assert {name: share for name, share in exact.items() if not 0.9 <= share <= 1.1} == {}
