"""Outliers: every trap that instruments set, and no surface eaten."""

import json

import numpy as np
import pytest

from data_samples.make_samples import turned_surface
from roughcontact import SettingsError, height_map, level
from roughcontact.surface import synthetic
from roughcontact.surface.levelling import outliers
from roughcontact.surface.levelling.outliers import find_outliers
from validation.surfaces import product_wave_surface

THRESHOLD = 6.0  # the default of `level`


def rough(shape=(128, 128), hurst=0.8, shortest=4e-6, seed=5, rms=1e-6):
    return synthetic.self_affine_surface(
        shape, 1e-6, hurst=hurst, shortest=shortest, longest=max(shape) * 1e-6, rms_height=rms, seed=seed
    ).values


@pytest.mark.parametrize("shape", [(128, 128), (3, 400)])
def test_the_same_outliers_without_compiled_kernels(monkeypatch, shape):
    values = rough(shape)
    values[1, ::40] += 1e-4
    values[:, 30:33] = np.nan
    found, counts = find_outliers(values, threshold=THRESHOLD)
    assert counts["spike"] >= 3
    monkeypatch.setattr(outliers, "library_available", lambda: False)
    plain, plain_counts = find_outliers(values, threshold=THRESHOLD)
    np.testing.assert_array_equal(found, plain)
    assert counts == plain_counts


@pytest.mark.parametrize("hurst", [0.1, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("shortest", [2e-6, 8e-6])
def test_self_affine_surfaces_are_not_eaten(hurst, shortest):
    points = rejected = 0
    for shape, seeds in (((256, 256), range(4)), ((1, 4096), range(8))):
        for seed in seeds:
            outliers, _ = find_outliers(rough(shape, hurst, shortest, seed), threshold=THRESHOLD)
            points, rejected = points + outliers.size, rejected + outliers.sum()
    assert rejected / points < 1e-5


@pytest.mark.parametrize("shape", [(500, 500), (1, 100_000), (3, 20_000), (2, 3)])
def test_noise_is_not_eaten(shape):
    outliers, _ = find_outliers(np.random.default_rng(1).standard_normal(shape), threshold=THRESHOLD)
    assert outliers.mean() < 1e-5


def structured():
    y, x = np.indices((96, 96)) - 48.0
    noise = 0.01 * np.random.default_rng(0).standard_normal((96, 96))
    turned = {"feed": 32e-6, "nose_radius": 4e-4}
    return {
        "turned": turned_surface((96, 96), 1e-6, arc_radius=5e-3, rms_roughness=2e-8, **turned).values,
        "turned, no roughness": turned_surface((96, 96), 1e-6, **turned).values,
        "turned profile": turned_surface((1, 2000), 1e-6, **turned).values,
        "wave": product_wave_surface((96, 96), 1.0, amplitude=1.0, wavelength=48.0).values,
        "cone": -np.hypot(x, y),
        "ball on a flat": np.maximum(0, 10 - x**2 - y**2),
        "step": np.where(x > 3, 1.0, 0.0) + noise,
        "pillars": ((x % 12 < 5) & (y % 12 < 5)) + noise,
        "scratch": np.where(np.abs(x - y) < 1.5, -1.0, 0.0) + noise,
        "pit": np.where(np.hypot(x, y) < 5, -1.0, 0.0) + noise,
        "checkerboard": (x + y) % 2,
        "ridges without noise": np.where(x % 16 == 0, 1.0, 0.0),
        "two levels": np.where(x > 3, 1.0, 0.0),
        "tilt": 3.0 * x - y,
        "flat": np.zeros((96, 96)),
    }


@pytest.mark.parametrize("name", structured())
def test_structure_is_not_eaten(name):
    assert find_outliers(structured()[name], threshold=THRESHOLD)[1] == {}


@pytest.mark.parametrize("tilt", [0.0, 0.5])
@pytest.mark.parametrize("size", [5.0, 40.0])
def test_spikes_are_found_each_and_alone(size, tilt):
    generator = np.random.default_rng(7)
    values = rough((256, 256)) + tilt * np.arange(256) * 1e-6
    spikes = np.zeros(values.shape, dtype=bool)
    spikes[tuple(generator.integers(0, 256, (2, 60)))] = True
    values[spikes] += size * 1e-6 * generator.choice([-1, 1], spikes.sum())
    outliers, kinds = find_outliers(values, threshold=THRESHOLD)
    np.testing.assert_array_equal(outliers, spikes)
    assert kinds == {"spike": int(spikes.sum())}


def test_small_clusters_are_spikes_and_large_ones_are_structure():
    values = rough()
    values[40:42, 60:63] += 30e-6
    values[80:90, 20:30] += 30e-6
    outliers, _ = find_outliers(values, threshold=THRESHOLD)
    assert outliers[40:42, 60:63].all()
    assert outliers.sum() == 6


def test_spikes_in_a_profile_and_beside_missing_points():
    values = rough((1, 1000), shortest=16e-6)
    values[0, 300] += 5e-6
    values[0, 700] -= 5e-6
    outliers, _ = find_outliers(values, threshold=THRESHOLD)
    assert np.nonzero(outliers[0])[0].tolist() == [300, 700]
    values = rough()
    values[50:54, 50:54] = np.nan
    values[52, 54] += 20e-6
    outliers, kinds = find_outliers(values, threshold=THRESHOLD)
    assert kinds == {"spike": 1}
    assert outliers[52, 54]


def test_a_single_marker_value_among_heights():
    values = np.rint(480 + 1e7 * rough())
    assert values.min() > 420
    values[30, 40] = -1
    outliers, kinds = find_outliers(values, threshold=THRESHOLD)
    assert kinds == {"spike": 1}
    assert outliers[30, 40]


def test_regions_of_marker_values_at_both_ends():
    values = np.rint(480 + 1e7 * rough())
    values[10:30, 10:60] = -1
    values[:, 120:] = 32767
    outliers, kinds = find_outliers(values, threshold=THRESHOLD)
    assert kinds == {"sentinel": 1000 + 8 * 128}
    assert outliers.sum() == 1000 + 8 * 128


def test_a_line_of_zeros_far_from_the_heights():
    values = np.rint(480 + 1e7 * rough())
    values[64] = 0
    outliers, kinds = find_outliers(values, threshold=THRESHOLD)
    assert kinds == {"sentinel": 128}
    assert outliers[64].all()


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("lines", [slice(50, 51), slice(0, 1), slice(100, 128)])
def test_dead_lines_amid_the_heights(lines, axis):
    values = rough()
    view = values if axis == 0 else values.T
    view[lines] = 0.0  # within the range of the heights
    outliers, kinds = find_outliers(values, threshold=THRESHOLD)
    assert list(kinds) == ["dead_line"]
    expected = np.zeros_like(outliers)
    (expected if axis == 0 else expected.T)[lines] = True
    np.testing.assert_array_equal(outliers, expected)


def test_level_records_and_fills_what_it_rejects():
    values = rough()
    values[50, 60] += 40e-6
    values[70, :] = 0.0
    levelled = level(height_map(values, 1e-6))
    assert levelled.attrs["outliers_rejected"] == 129
    assert json.loads(levelled.attrs["outlier_kinds"]) == {"spike": 1, "dead_line": 128}
    assert levelled["filled"].values[50, 60] == 1
    assert abs(levelled.values[50, 60]) < 5e-6
    unfiltered = level(height_map(values, 1e-6), outlier_threshold=None)
    assert unfiltered.attrs["outliers_rejected"] == 0
    assert unfiltered.values[50, 60] > 30e-6


def test_one_spike_moves_the_plane_no_more_than_its_absence():
    clean = rough()
    spiked = clean.copy()
    spiked[3, 4] += 1e-3
    a, b = (level(height_map(v, 1e-6)) for v in (clean, spiked))
    assert np.abs(a.values - b.values).max() < 1e-7


def test_spikes_up_and_down_beside_one_another_are_two_groups():
    height = rough(rms=1e-6)
    height[60:62, 60:64] += 40e-6  # eight points up, eight down: together they would pass for structure
    height[60:62, 64:68] -= 40e-6
    outliers, counts = find_outliers(height, threshold=THRESHOLD)
    assert counts == {"spike": 16}
    assert outliers[60:62, 60:68].all()


def test_far_spikes_in_a_disturbed_patch_are_found():
    height = rough(rms=1e-6)
    off_median = 0.05e-6  # what the points of this surface are off their median, about
    patch = np.random.default_rng(2).choice([-1, 1], (5, 5)) * 60 * off_median
    height[58:63, 70:75] += np.abs(patch)  # a patch that is too large for one group
    height[60, 72] += 2000 * off_median
    outliers, _ = find_outliers(height, threshold=THRESHOLD)
    assert outliers[60, 72]
    assert outliers.sum() <= 3


def grid_of_places(count, shape, seed):
    """Return places at least ten points apart, off the border."""
    rows, columns = np.meshgrid(
        np.arange(12, shape[0] - 12, 22), np.arange(12, shape[1] - 12, 22), indexing="ij"
    )
    centres = np.stack([rows.ravel(), columns.ravel()], axis=1)[:count]
    return centres + np.random.default_rng(seed).integers(-4, 5, centres.shape)


def with_bells(values, centres, *, height, width, seed):
    """Return a map with a Gaussian bell at each place, its top anywhere within the point."""
    values = values.copy()
    y, x = np.indices(values.shape)
    for (row, column), offset in zip(
        centres, np.random.default_rng(seed).uniform(-0.5, 0.5, (len(centres), 2)), strict=True
    ):
        square = (y - row - offset[0]) ** 2 + (x - column - offset[1]) ** 2
        values += height * np.exp(-square / (2 * width**2))
    return values


@pytest.mark.parametrize(
    ("height", "width", "spikes"),
    [(5e-6, 0.9, 80), (6e-6, 1.2, 50), (5e-6, 1.6, 0), (15e-6, 0.7, 80), (40e-6, 1.2, 0)],
)
def test_narrow_grains_are_surface(height, width, spikes, monkeypatch):
    """A hundred bells of one to two points, 5 to 40 rms heights tall: the load is theirs."""
    centres = grid_of_places(100, (256, 256), seed=1)
    values = with_bells(rough((256, 256), 0.3, 2e-6), centres, height=height, width=width, seed=2)
    is_kept = ~find_outliers(values, threshold=THRESHOLD)[0]
    tops = [is_kept[r - 1 : r + 2, c - 1 : c + 2].all() for r, c in centres]
    assert np.mean(tops) >= 0.95
    # without their shape many would go
    monkeypatch.setattr(outliers, "_drop_bumps", lambda groups, *_: groups)
    rejected_bumps, _ = find_outliers(values, threshold=THRESHOLD)
    assert sum(rejected_bumps[r - 1 : r + 2, c - 1 : c + 2].any() for r, c in centres) >= spikes


@pytest.mark.parametrize("block", [(1, 1), (1, 3), (2, 2), (2, 3)])
def test_spikes_have_no_sides(block):
    centres = grid_of_places(100, (256, 256), seed=3)
    values, spikes = rough((256, 256)), np.zeros((256, 256), dtype=bool)
    for row, column in centres:
        spikes[row : row + block[0], column : column + block[1]] = True
    values[spikes] += 15e-6
    outliers, _ = find_outliers(values, threshold=THRESHOLD)
    np.testing.assert_array_equal(outliers, spikes)


def test_grains_and_spikes_are_told_apart_on_one_map():
    centres = grid_of_places(100, (256, 256), seed=5)
    grains, spikes = centres[::2], centres[1::2]
    values = with_bells(rough((256, 256)), grains, height=15e-6, width=1.1, seed=6)
    values[tuple(spikes.T)] += 15e-6
    outliers, _ = find_outliers(values, threshold=THRESHOLD)
    assert np.argwhere(outliers).tolist() == sorted(spikes.tolist())


def dense_spikes():
    """Return a map of which one point in sixteen is a spike, 3 to 30 rms heights tall."""
    generator, values = np.random.default_rng(0), rough((192, 192))
    spikes = generator.random(values.shape) < 0.06
    signs = generator.choice([-1, 1], spikes.sum())
    values[spikes] += signs * generator.uniform(3e-6, 30e-6, spikes.sum())
    return values, spikes


def disturbed_patch():
    """Return a map with a patch of which one point in four is a spike, some a hundred times as tall."""
    generator, values = np.random.default_rng(0), rough((192, 192))
    spikes = np.zeros(values.shape, dtype=bool)
    spikes[60:80, 60:80] = generator.random((20, 20)) < 0.25
    values[spikes] += 5e-6 * generator.lognormal(0, 1.5, spikes.sum())
    return values, spikes


@pytest.mark.parametrize(("make", "share"), [(dense_spikes, 1.0), (disturbed_patch, 0.4)])
def test_no_spike_is_left_that_the_rule_would_find(make, share):
    """Far spikes hide near ones: the rule is applied to what it leaves, and takes nothing but spikes."""
    values, spikes = make()
    outliers, kinds = find_outliers(values, threshold=THRESHOLD)
    assert not outliers[~spikes].any()
    assert outliers.sum() >= share * spikes.sum()
    assert kinds == {"spike": outliers.sum()}
    second_outliers, _ = find_outliers(np.where(outliers, np.nan, values), threshold=THRESHOLD)
    assert not second_outliers.any()


def test_bumps_stay_beside_spikes_that_hide_one_another():
    values, spikes = disturbed_patch()
    centres = grid_of_places(60, values.shape, seed=5)
    centres = centres[(np.abs(centres - 70) > 20).any(axis=1)]
    with_bumps = with_bells(values, centres, height=15e-6, width=1.1, seed=6)
    outliers, _ = find_outliers(with_bumps, threshold=THRESHOLD)
    assert outliers.any()
    assert not outliers[~spikes].any()


def test_dust_is_structure_and_stays():
    """Grains of dust with steep sides, larger than a spike."""
    values = rough((256, 256))
    y, x = np.indices(values.shape)
    for row, column in grid_of_places(20, values.shape, seed=7):
        values[np.hypot(y - row, x - column) < 3] += 8e-6
    assert find_outliers(values, threshold=THRESHOLD)[1] == {}


def test_scanned_streaks_are_no_bumps():
    """A bell along the line alone, nothing in the lines before and after."""
    values = rough((256, 256))
    centres = grid_of_places(50, values.shape, seed=8)
    for row, column in centres:
        values[row, column - 2 : column + 3] += 15e-6 * np.array([0.2, 0.6, 1.0, 0.6, 0.2])
    outliers, _ = find_outliers(values, threshold=THRESHOLD)
    assert outliers[tuple(centres.T)].all()


@pytest.mark.parametrize("row", [0, 1, 2, 5, 64, 126, 127])
@pytest.mark.parametrize("column", [0, 1, 3, 64, 127])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_spike_is_found_wherever_it_is(row, column, sign):
    """In the corners and on the border as inside: 4 rms heights, where the surface has slopes of 0.1."""
    values = rough(shortest=8e-6)
    values[row, column] += sign * 4e-6
    outliers, kinds = find_outliers(values, threshold=THRESHOLD)
    assert kinds == {"spike": 1}
    assert outliers[row, column]


@pytest.mark.parametrize("gap", [2, 6, 30])
def test_a_point_alone_among_missing_ones_is_not_its_own_surroundings(gap):
    values = rough()
    values[20:100, 20:100] = np.nan
    values[20 + gap, 60] = 40e-6
    values[90, 90] = values[110, 90]  # another one at the height of the map stays
    outliers, kinds = find_outliers(values, threshold=THRESHOLD)
    assert kinds == {"spike": 1}
    assert outliers[20 + gap, 60]


def test_a_spike_on_the_rim_of_a_hole_does_not_fill_the_hole():
    values = rough()
    values[40:80, 40:80] = np.nan
    values[60, 40] = 20e-6  # juts out into the hole: the nearest point of much of it
    outliers, kinds = find_outliers(values, threshold=THRESHOLD)
    assert kinds == {"spike": 1}
    assert outliers[60, 40]


def test_islands_on_a_slope_are_kept():
    """Small islands far out lie off what is nearest to them by the slope between: no spikes."""
    y, x = np.indices((128, 128))
    values = rough() - 40e-6 * ((x / 127) ** 2 + (y / 127) ** 2)
    missing = (x > 80) & (y > 80)
    missing[100:128:9, 100:128:9] = False
    values[missing] = np.nan
    assert find_outliers(values, threshold=THRESHOLD)[1] == {}


@pytest.mark.parametrize(
    ("threshold", "words"),
    [
        *((value, r"outlier_threshold = .*: give a number") for value in (True, "six", np.nan, 1j)),
        *(
            (value, r"level\.outlier_threshold = .*: give a positive number, or null")
            for value in (0, -1, np.inf)
        ),
    ],
)
def test_a_threshold_that_is_no_positive_number_is_named(threshold, words):
    with pytest.raises(SettingsError, match=words):
        level(height_map(np.eye(8), 1.0), outlier_threshold=threshold)
