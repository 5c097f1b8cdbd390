"""Small texts from public reports, in a folder beside the real files: read right, or asked about."""

import json

import numpy as np
import pytest
from measured_files import refuses, steps, warnings_of
from shared_data import DATA

from roughcontact import inspect_file, read_height_map

pytestmark = pytest.mark.shared_data
CASES = DATA.parent / "cases"
NM = {"unit": "um", "height_unit": "nm"}
STEPS = {"dx": 0.5, "dy": 0.25}


@pytest.fixture(scope="module")
def truth():
    return np.load(CASES / "truth.npy") * 1e-6  # m; row 0 is the lowest


def read(name, **arguments):
    return read_height_map(CASES / name, **arguments)


@pytest.mark.cases
def test_maps(truth, name, arguments, columns, channel_names):
    height = read(name, **arguments)
    np.testing.assert_allclose(height.values, truth[:, :columns], atol=6e-11)
    assert steps(height) == pytest.approx([0.5e-6, 0.5e-6 if columns == 36 else 0.75e-6], rel=1e-9)
    assert json.loads(height.attrs["channels"])[1:] == channel_names
    is_named = "the first row (0, 0.5, 1 ...) is taken as positions along x" in warnings_of(height)
    assert is_named == (name == "xpos_first_row.csv")


def test_the_unit_of_each_channel_is_kept():
    channels = inspect_file(CASES / "gwy_two_channels.txt")["channels"]
    assert [(channel["name"], channel["height_unit"], channel["is_height"]) for channel in channels] == [
        ("Topography", "m", True),
        ("Phase", "deg", False),
    ]


@pytest.mark.cases
def test_one_of_several_profiles(truth, name, channel, row):
    height = read(name, channel=channel)
    np.testing.assert_allclose(height.values, truth[row : row + 1], atol=6e-11)
    assert steps(height) == pytest.approx([0.5e-6], rel=1e-9)


@pytest.mark.parametrize(
    ("name", "arguments", "words"),
    [
        ("profile_x_restarts.csv", {}, r"x restarts at line 50.*3 profiles.*channel"),
        ("profile_x_restarts.csv", {"resample": "linear"}, r"x restarts at line 50.*3 profiles.*channel"),
        ("profiles_below.csv", {}, r"at line 52.*channel"),
        ("profiles_three_german.csv", {}, r"'Profil 1', 'Profil 2', 'Profil 3'; name one with channel"),
        ("profiles_three_german.csv", STEPS | NM, "name one with channel"),
        ("named_three_profiles.csv", {}, r"'Profile 1', 'Profile 2'; name one with channel"),
        ("h02.txt", {}, r"line 1 says 'Pixel size: 1,234 nm'.*give dx, dy and unit"),
        ("h13.txt", {}, "give dx, dy, unit"),
        ("h21.txt", {}, r"line 1 says 'Width: 6.5 µm', line 2 says 'Width: 13 µm'"),
        ("h38.txt", NM, "give dx, dy, unit"),
        ("c1.txt", {}, r"line 1 says 'Pixel size: 0.5 µm', line 2 says 'Width: 13 µm'"),
        ("l06.txt", STEPS | NM, "second table begins at line 11"),
        ("ratio1000.txt", {}, r"line 1 says 'Width: 48 mm', line 2 says 'Height: 48 µm'"),
    ],
)
def test_questions(name, arguments, words):
    refuses(f"{name}: .*{words}", CASES / name, **arguments)


@pytest.mark.parametrize("name", ["c16.txt", "c17.txt", "h11b.txt"])
def test_the_unit_of_each_number_is_kept(name):
    height = read(name, height_unit="nm")
    assert steps(height) == pytest.approx([500e-6, 250e-6], rel=1e-9)
    if name != "h11b.txt":
        assert "where the file says mm" in warnings_of(read(name, **NM))


def test_the_resolution_of_a_lens_is_no_pixel():
    assert steps(read("h12.txt")) == pytest.approx([0.5e-6, 0.25e-6], rel=1e-9)


@pytest.mark.parametrize("name", ["l30.txt", "c6.txt"])
def test_positions_in_row_and_column(name):
    height = read(name, **NM)
    assert height.shape == (9, 13)
    assert steps(height) == pytest.approx([0.5e-6, 0.25e-6], rel=1e-9)
    assert float(height[0, 0]) == pytest.approx(0.5561e-9, rel=1e-12)
    with_steps = read(name, **NM, **STEPS)
    np.testing.assert_array_equal(with_steps.values, height.values)
    assert "taken as positions along y" in warnings_of(with_steps)


def test_a_row_of_an_encoder():
    height = read("octo_real_one_row.txt")
    assert height.shape == (1, 60)
    assert steps(height) == pytest.approx([5e-6], rel=1e-9)
    assert float(height[0, 0]) == pytest.approx(623.1020e-6, rel=1e-12)


def test_a_marker_is_stated():
    name = "profile_marker_-25400.csv"
    bare = read(name, unit="um")
    assert "missing_value states it" in warnings_of(bare)
    height = read(name, unit="um", missing_value="-25400")
    assert height.shape == (1, 200)
    assert height.attrs["missing_points"] == 63
    assert float(height.min()) > 0
