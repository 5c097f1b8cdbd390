"""The sample maps: rebuilt from their formulas, as described, and readable."""

import hashlib
import importlib.util
import io
import json
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.arguments.maps import spacing
from roughcontact.surface.faces.placing import place_of
from roughcontact.surface.roughness.parameters import roughness_parameters

FOLDER = Path(__file__).parents[2] / "data_samples"


def load_script():
    spec = importlib.util.spec_from_file_location("make_samples", FOLDER / "make_samples.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def samples():
    return load_script().make_samples()


def content(name, data):
    """Return what must not differ: inside an archive its members, whatever compressed them."""
    if name.endswith(".x3p"):
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return {member: archive.read(member) for member in archive.namelist()}
    return data


def test_files_are_what_the_script_makes(samples):
    for name, data in samples.items():
        assert content(name, data) == content(name, (FOLDER / name).read_bytes()), name


def test_script_makes_the_same_bytes_twice(samples):
    assert load_script().make_samples() == samples


def test_checksums_and_names_in_the_readme(samples):
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    listed = dict(re.findall(r"\| `([^`]+)` \| `([0-9a-f]{64})` \|", text))
    assert set(listed) == set(samples)
    for name, digest in listed.items():
        assert hashlib.sha256((FOLDER / name).read_bytes()).hexdigest() == digest, name


def test_files_are_small(samples):
    assert all(len(data) < 1_000_000 for data in samples.values())


@pytest.mark.cases
def test_reader_gives_back_the_heights(name, maker, pitch):
    height = rc.read_height_map(FOLDER / name)
    expected = getattr(load_script(), maker)()
    assert height.shape == expected.shape
    assert spacing(height) == pytest.approx(pitch, rel=1e-9)
    first_line = -1 if name.endswith(".txt") else 1  # a text is a picture: its first line is the top
    np.testing.assert_allclose(height.values[::first_line], expected, atol=1e-12, rtol=0)
    assert height.attrs["missing_points"] == int(np.isnan(expected).sum())


def test_sandblasted_sample_shows_the_dirt_of_a_measurement():
    height = rc.read_height_map(FOLDER / "sandblasted.x3p")
    assert height.attrs["missing_share"] > 0.02
    levelled = rc.level(height)
    assert 25 <= levelled.attrs["outliers_rejected"] <= 30
    assert levelled.attrs["largest_hole"] > 300
    window = rc.periodic_window(levelled)
    assert window.attrs["periodisation"] == "smooth-cross-fade"
    assert window.attrs["window_share"] > 0.85
    assert roughness_parameters(window)["points_per_shortest_wavelength"] == pytest.approx(6.0, rel=0.05)


def test_periodic_sample_is_left_alone():
    height = rc.read_height_map(FOLDER / "periodic.nc")
    window = rc.periodic_window(rc.level(height))
    assert window.attrs["periodisation"] == "none"
    np.testing.assert_allclose(window.values, height.values - height.values.mean(), atol=1e-20)


def test_ground_and_turned_samples_have_their_lay_along_y():
    for name in ("ground.txt", "turned.sdf"):
        height = rc.read_height_map(FOLDER / name)
        steps = [
            np.sqrt(np.mean((np.diff(height.values, axis=axis) / step) ** 2))
            for axis, step in enumerate(spacing(height))
        ]
        assert steps[1] > 2 * steps[0]


def test_the_map_of_the_lapped_surface_lies_in_its_overview():
    fine, overview = (rc.level(rc.read_height_map(FOLDER / f"lapped-{name}.txt")) for name in ("50x", "10x"))
    place = place_of(fine, overview)
    assert [place.y, place.x] == pytest.approx([176e-6, 176e-6], abs=2e-6)  # of 384 µm
    assert place.correlation > 0.95


def test_of_a_profile_without_its_highest_tips_light_loads_are_not_to_be_used():
    contact = {"contact_modulus": 4.67e9, "hardness": 3e8, "mean_pressure": [1e6, 50e6]}
    statistics = rc.evaluate(
        FOLDER / "stylus-profile.csv", lay="across", contact=contact, uncertainty={"sources": []}
    )
    assert statistics["verdict"].values.tolist() == [2, 0]
    (reason,) = [
        entry for entry in json.loads(statistics.attrs["reasons"]) if entry["check"] == "Missing points"
    ]
    assert reason["loads"] == [0]


def test_a_sample_is_found_by_its_name():
    assert rc.sample_file("ground.txt") == FOLDER / "ground.txt"
    with pytest.raises(rc.InputFileError, match=r"not a sample; the samples are .*ground") as refused:
        rc.sample_file("steel")
    assert "README" not in str(refused.value)
    assert "make_samples" not in str(refused.value)
