"""Crop and mask of a measured map: the same as heights cut and left out by hand."""

import numpy as np
import pytest

from roughcontact import HeightMapError, SettingsError, height_map, level
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.rectangles import Rectangle, parse_rectangles
from roughcontact.statistics.map_checks import reading
from roughcontact.statistics.outcome import NOTE
from roughcontact.study.table.read import read_surfaces
from roughcontact.surface.preparation.region import used_region


@pytest.fixture
def rough():
    heights = np.random.default_rng(4).normal(0, 1e-7, (30, 50))
    return height_map(heights, ("2 um", "1 um"))  # dy, dx: 60 by 50 um


def test_a_crop_is_a_slice_by_hand_and_keeps_its_place(rough):
    part = used_region(rough, crop="10 20 40 50 um")
    np.testing.assert_array_equal(part.values, rough.values[10:25, 10:40])
    np.testing.assert_array_equal(part["x"], rough["x"][10:40])
    np.testing.assert_array_equal(part["y"], rough["y"][10:25])
    # corners in any order and unit, and what is drawn up to the border
    for crop in (
        "40 50 10 20 um",
        "0.04 0.02 0.01 0.05 mm",
        "4e-5 2e-5 1e-5 5e-5 m",
        "9.6 19.1 40.4 50.9 um",
    ):
        assert part.identical(used_region(rough, crop=crop).assign_attrs(part.attrs))
    assert used_region(rough, crop="-0.5 0 50.4 60.9um").shape == rough.shape


def test_masked_points_are_as_points_that_were_not_measured(rough):
    dusty = rough.copy()
    dusty.values[3:6, 20:30] += 4e-6
    masked = used_region(dusty, mask="20 6 30 12 um; 0 0 1 60 um")
    by_hand = rough.copy()
    by_hand.values[3:6, 20:30] = np.nan
    by_hand.values[:, 0] = np.nan
    np.testing.assert_array_equal(masked.values, by_hand.values)
    assert masked.attrs["missing_points"] == 60
    assert masked.attrs["missing_share"] == 60 / 1500
    np.testing.assert_array_equal(level(masked).values, level(by_hand).values)
    # of both together the rectangles are those of the whole map
    both = used_region(dusty, crop="10 0 40 30 um", mask="20 6 30 12 um")
    np.testing.assert_array_equal(both.values, by_hand.values[:15, 10:40])


def test_what_was_done_is_a_note_of_the_results(rough):
    attrs = used_region(rough, crop="10 20 40 50 um", mask="0 0 50 2 um").attrs
    text = "cropped to 30.0 µm × 30.0 µm of 50.0 µm × 60.0 µm (crop = 10 20 40 50 um)"
    masked = "1 rectangle masked (mask = 0 0 50 2 um), 3.33 % of the points of 50.0 µm × 60.0 µm"
    assert json_attribute(attrs, "ingest_facts") == [f"{masked}: they count as not measured", text]
    check = reading(attrs, {})
    assert check.outcome == NOTE
    assert "Cropped to 30.0 µm" in check.finding


@pytest.mark.cases
def test_rectangles_that_do_not_fit_the_map(texts, message, rough):
    with pytest.raises(HeightMapError) as raised:
        used_region(rough, **texts)
    assert message in str(raised.value)
    (key, text), *_ = texts.items()
    with pytest.raises(HeightMapError, match=f"{key} = {text}: is of maps, and this is a profile; leave it"):
        used_region(rough[:1], **texts)


@pytest.mark.cases
def test_cells_that_are_no_rectangles(cell, message, tmp_path):
    with pytest.raises(SettingsError) as raised:
        parse_rectangles("crop", cell)
    assert message.split("'MPa'")[0] in str(raised.value)
    (tmp_path / "one.npy").touch()
    table = tmp_path / "surfaces.tsv"
    table.write_text(f"surface\tpath\tcrop\none\tone.npy\t{cell}\n")
    with pytest.raises(SettingsError) as raised:
        read_surfaces(table)
    assert raised.value.mistakes[0].place == "rows.2.crop"
    assert "line 2, crop = " in str(raised.value)


def test_the_cells_of_the_table_reach_the_reader(tmp_path):
    table = tmp_path / "surfaces.tsv"
    table.write_text("surface\tpath\tcrop\tmask\none\tone.npy\t1 1 9 9 um\t2 2 3 3 um\n")
    assert read_surfaces(table)["one"].read_arguments == {"crop": "1 1 9 9 um", "mask": "2 2 3 3 um"}
    assert parse_rectangles("mask", "2 2 3 3 um;") == [Rectangle(2e-6, 2e-6, 3e-6, 3e-6)]
    for column, cell in (("counter_face", "two.npy"), ("lay", "none")):
        table.write_text(f"surface\tpath\tcrop\t{column}\none\tone.npy\t1 1 9 9 um\t{cell}\n")
        with pytest.raises(SettingsError, match=f"is of single maps; leave it or {column} empty"):
            read_surfaces(table)
