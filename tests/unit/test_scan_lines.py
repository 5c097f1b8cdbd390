"""Scanned maps: shifted lines are put right, scars are found, structure is left alone."""

import json

import numpy as np
import pytest
from known_surfaces import self_affine

from data_samples.make_samples import turned_surface
from roughcontact import SettingsError, height_map, level
from roughcontact.surface.levelling.scan_lines import find_scars, line_offsets


def rough(seed=0, shape=(96, 128)):
    return self_affine(shape, 1e-6, (8e-6, 40e-6), rms_height=1e-7, seed=seed)


@pytest.mark.parametrize("method", ["median", "matched-steps"])
def test_shifts_of_lines_are_found(method):
    """Rows of one shape, shifted at random: the shifts come out exactly, but for their mean."""
    generator = np.random.default_rng(0)
    shifts = generator.standard_normal(50)
    values = np.sin(np.arange(200) / 7)[None, :] + shifts[:, None]
    np.testing.assert_allclose(line_offsets(values, method=method), shifts - shifts.mean(), atol=1e-12)


def test_matched_steps_are_not_deceived_by_a_valley():
    """A valley that fills more than half of some rows moves their median, not the steps beside it."""
    values = np.zeros((60, 100))
    values[20:40, 10:80] = -5.0
    shifts = np.random.default_rng(1).standard_normal(60) * 0.1
    shifted = values + shifts[:, None]
    shifts -= shifts.mean()
    # the steps in and out of the valley are shared by most points, the others are right
    offsets = line_offsets(shifted, method="matched-steps")
    median = line_offsets(shifted, method="median")
    inside = slice(21, 40)
    np.testing.assert_allclose(np.diff(offsets[inside]), np.diff(shifts[inside]), atol=1e-12)
    assert np.abs(median - shifts).max() > 2


def test_a_narrow_valley_moves_neither():
    values = np.zeros((60, 100))
    values[20:40, 10:50] = -5.0
    for method in ("median", "matched-steps"):
        np.testing.assert_allclose(line_offsets(values, method=method), 0, atol=1e-12)


@pytest.mark.parametrize("method", ["median", "matched-steps"])
def test_missing_points_and_missing_lines(method):
    generator = np.random.default_rng(2)
    shifts = generator.standard_normal(40)
    values = np.cos(np.arange(300) / 9)[None, :] + shifts[:, None]
    values[generator.random(values.shape) < 0.2] = np.nan
    values[10:12] = np.nan
    offsets = line_offsets(values, method=method)
    measured_rows = np.delete(np.arange(40), [10, 11])
    assert (offsets[10:12] == 0).all()
    tolerance = 1e-12 if method == "matched-steps" else 0.3  # the missing points move the medians
    np.testing.assert_allclose(
        offsets[measured_rows], shifts[measured_rows] - shifts[measured_rows].mean(), atol=tolerance
    )


def test_lines_that_share_no_point_are_not_shifted():
    values = np.full((4, 10), np.nan)
    values[:2, :5], values[2:, 5:] = 1.0, 7.0
    np.testing.assert_allclose(line_offsets(values, method="matched-steps"), 0)


def test_levelling_puts_lines_right_and_says_what_it_took():
    surface = rough()
    shifts = np.random.default_rng(3).standard_normal(96) * 5e-7
    shifted = surface.copy(data=surface.values + shifts[:, None])
    raw = level(shifted, line_alignment="none")
    levelled = level(shifted, line_alignment="matched-steps")
    assert np.std(levelled.values - surface.values) < 0.35 * surface.values.std()
    assert np.std(raw.values - surface.values) > 3 * surface.values.std()
    assert levelled.attrs["line_alignment"] == "matched-steps"
    offsets = levelled["line_offset"]
    assert offsets.dims == ("y",)
    assert np.corrcoef(offsets, shifts)[0, 1] > 0.99
    assert levelled.attrs["line_shift_rms"] == pytest.approx(float(np.sqrt(np.mean(offsets**2))))
    assert "line_offset" not in raw.coords
    # map, offsets and form together are the measurement again
    form = json.loads(levelled.attrs["form_removed"])
    assert form["mean"]["units"] == "m"


def test_profile_has_no_lines_to_align():
    height = height_map(np.random.default_rng(0).standard_normal((1, 100)), 1e-6)
    for method in ("median", "matched-steps"):
        assert line_offsets(height.values, method=method) == [0]


@pytest.mark.parametrize("rows", [1, 2, 4])
@pytest.mark.parametrize("sign", [1, -1])
def test_scars_are_found_whole(rows, sign):
    values = rough(seed=4).values.copy()
    values[30 : 30 + rows, 40:90] += sign * 8e-7
    scars = find_scars(values, threshold=4)
    expected = np.zeros(values.shape, dtype=bool)
    expected[30 : 30 + rows, 40:90] = True
    assert (scars & expected).sum() >= 0.9 * expected.sum()
    assert not (scars & ~expected).any()


def test_structure_is_no_scar():
    for seed in range(4):
        assert not find_scars(rough(seed=seed, shape=(256, 256)).values, threshold=4).any()
    noise = np.random.default_rng(5).standard_normal((300, 300))
    assert not find_scars(noise, threshold=4).any()
    step = np.where(np.arange(100)[:, None] < 50, 0.0, 1.0) + 1e-3 * np.random.default_rng(0).standard_normal(
        (100, 80)
    )
    assert not find_scars(step, threshold=4).any()
    wide = 1e-3 * np.random.default_rng(0).standard_normal((100, 80))
    wide[40:46] += 1.0  # six rows: structure
    assert not find_scars(wide, threshold=4).any()
    short = 1e-3 * np.random.default_rng(0).standard_normal((100, 80))
    short[40, 10:20] += 1.0  # ten points: a spike or a particle
    assert not find_scars(short, threshold=4).any()


def test_grooves_across_the_lines_stay():
    turned = turned_surface((128, 128), 1e-6, feed=32e-6, nose_radius=4e-4)
    assert not find_scars(turned.values, threshold=4).any()


def test_scars_become_missing_and_are_filled():
    surface = rough(seed=6)
    scarred = surface.copy(data=surface.values.copy())
    scarred.values[50, 20:100] += 1e-6
    levelled = level(scarred, scar_threshold=4.0)
    kinds = json.loads(levelled.attrs["outlier_kinds"])
    assert kinds["scar"] >= 78
    assert levelled.attrs["outliers_rejected"] == sum(kinds.values())
    assert levelled["filled"].values[50, 25:95].all()
    clean = level(surface)
    assert np.abs(levelled.values[50, 25:95] - clean.values[50, 25:95]).max() < 0.2e-6
    assert "scar" not in json.loads(level(scarred).attrs["outlier_kinds"])


def test_spikes_that_shifted_lines_hide_are_found_after_alignment():
    surface = rough(seed=7)
    values = surface.values + np.random.default_rng(8).standard_normal(96)[:, None] * 2e-6
    values[20, 30] += 3e-6
    levelled = level(surface.copy(data=values), line_alignment="median")
    assert json.loads(levelled.attrs["outlier_kinds"]) == {"spike": 1}


def test_small_and_flat_maps_have_no_scars():
    assert not find_scars(np.zeros((30, 40)), threshold=4).any()
    assert not find_scars(np.random.default_rng(0).standard_normal((2, 100)), threshold=4).any()
    assert not find_scars(np.full((30, 40), np.nan), threshold=4).any()


def test_options_without_meaning():
    with pytest.raises(SettingsError, match=r"line_alignment = 'matched': did you mean 'matched-steps'"):
        level(rough(), line_alignment="matched")
    with pytest.raises(SettingsError, match=r"level\.scar_threshold = 0: give a positive number, or null"):
        level(rough(), scar_threshold=0)
