"""Periodisation: what each method promises, and the truth known from a larger periodic surface."""

from typing import get_args

import numpy as np
import pytest
from known_surfaces import self_affine
from scipy import ndimage
from scipy.optimize import brentq

from roughcontact import level, periodic_window
from roughcontact.arguments.choices import WindowMethod
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.window import periodisation


def rough(shape, seed=0, shortest=8.0, hurst=0.8):
    return self_affine(shape, 1.0, (shortest, max(shape) / 2), hurst=hurst, rms_gradient=1.0, seed=seed)


@pytest.mark.parametrize("shape", [(24, 30), (25, 31), (2, 9), (1, 40), (40, 1), (3, 2)])
@pytest.mark.parametrize("spacing", [(1.0, 1.0), (2.5e-6, 1e-6)])
def test_smooth_part_satisfies_the_equation_of_moisan(shape, spacing):
    """Laplacian (periodic) of s = step across the seams, so that h - s has the interior Laplacian of h."""
    values = np.random.default_rng(1).standard_normal(shape)
    smooth = values - periodisation.periodic_plus_smooth(values, spacing)
    weights = [1 / d**2 for d in spacing]
    laplacian = sum(
        w * (np.roll(smooth, 1, axis) - 2 * smooth + np.roll(smooth, -1, axis))
        for axis, w in enumerate(weights)
    )
    source = np.zeros(shape)
    for axis, w in enumerate(weights):
        step = w * (np.take(values, -1, axis) - np.take(values, 0, axis))
        for edge, sign in ((0, 1), (-1, -1)):
            index = [slice(None)] * 2
            index[axis] = edge
            source[tuple(index)] += sign * step
    np.testing.assert_allclose(laplacian, source, atol=1e-11 * max(weights))
    assert smooth.mean() == pytest.approx(0, abs=1e-14)


def test_periodic_plus_smooth_leaves_a_map_without_steps_alone():
    values = np.random.default_rng(0).standard_normal((20, 26))
    values[-1], values[:, -1] = values[0], values[:, 0]
    values[-1] = values[0]
    np.testing.assert_allclose(periodisation.periodic_plus_smooth(values, (1.0, 2.0)), values, atol=1e-14)


def test_periodic_plus_smooth_commutes_with_mirror_transpose_and_units():
    values = np.random.default_rng(2).standard_normal((18, 25))
    result = periodisation.periodic_plus_smooth(values, (2.0, 1.0))
    np.testing.assert_allclose(
        periodisation.periodic_plus_smooth(values[::-1], (2.0, 1.0)), result[::-1], atol=1e-13
    )
    np.testing.assert_allclose(periodisation.periodic_plus_smooth(values.T, (1.0, 2.0)), result.T, atol=1e-13)
    np.testing.assert_allclose(
        periodisation.periodic_plus_smooth(1e-9 * values, (2e-6, 1e-6)), 1e-9 * result, atol=1e-22
    )


def test_mirror():
    values = np.arange(6.0).reshape(2, 3)
    mirrored = periodisation.mirror(values)
    assert mirrored.shape == (4, 6)
    np.testing.assert_array_equal(mirrored[:2, :3], values)
    np.testing.assert_array_equal(mirrored, mirrored[::-1, ::-1])
    assert periodisation.mirror(values[:1]).shape == (1, 6)


def test_cross_fade_blends_the_end_into_the_beginning():
    values = np.random.default_rng(0).standard_normal((12, 34))
    blended = periodisation.cross_fade(values, (2, 10))
    assert blended.shape == (10, 24)
    # half a band is blended at each end, the rest is as it was
    np.testing.assert_allclose(blended[1:-1, 5:-5], values[2:10, 10:24], atol=1e-15)
    weight = np.sin(np.pi / 2 * (7 + 0.5) / 10) ** 2
    expected = weight * values[2:10, 7] + (1 - weight) * values[2:10, 31]
    np.testing.assert_allclose(blended[1:-1, 2], expected, atol=1e-14)
    # a periodic map goes through unchanged
    x = np.arange(34)
    wave = np.cos(2 * np.pi * x / 24)[None, :]
    for keep_variance in (False, True):
        blended = periodisation.cross_fade(wave, (0, 10), keep_variance=keep_variance)
        np.testing.assert_allclose(blended, wave[:, 5:29], atol=1e-14)
    # the blended line goes on from the last point to the first one
    smooth = np.sin(0.05 * x)[None, :]
    blended = periodisation.cross_fade(smooth, (0, 10))
    assert np.abs(np.diff(np.append(blended, blended[0, 0]))).max() < 0.2


def test_cross_fade_keeps_the_variance_of_unrelated_ends():
    values = np.random.default_rng(3).standard_normal((4000, 60)) + 5.0
    plain = periodisation.cross_fade(values, (0, 20)).std(axis=0)
    faded = periodisation.cross_fade(values, (0, 20), keep_variance=True)
    seam = [-1, 0]  # where both ends have the same weight
    assert plain[seam] == pytest.approx(np.sqrt(0.5) * np.ones(2), rel=0.05)
    assert faded.std(axis=0) == pytest.approx(np.ones(40), rel=0.05)
    assert faded.mean() == pytest.approx(5.0, abs=0.02)


def test_smooth_cross_fade_closes_the_seam_and_keeps_the_roughness():
    """Cut-outs of a periodic map: the gradient is that inside; the rim loses less height than by closing."""
    rim, drawn, seam, plain, gradient = [], [], [], [], []
    for seed in range(12):
        large = rough((320, 320), seed)
        cut = large.values[:141, 30:171]
        closed = periodisation.smooth_cross_fade(cut, (13, 13), (1.0, 1.0))
        assert closed.shape == (128, 128)
        step_y, step_x = (np.roll(closed, -1, axis) - closed for axis in (0, 1))
        inside = np.mean(step_x[20:-20, 20:-20] ** 2)
        seam.append(np.mean(step_x[:, -1] ** 2) / inside)
        fade = periodisation.cross_fade(cut, (13, 13))
        plain.append(np.mean((fade[:, 0] - fade[:, -1]) ** 2) / inside)
        frame = np.ones((128, 128), dtype=bool)
        frame[8:-8, 8:-8] = False
        inner = cut[6:134, 6:134]
        smooth = periodisation.periodic_plus_smooth(inner, (1.0, 1.0))
        rim.append(np.var(closed[frame]) / np.var(inner[frame]))
        drawn.append(np.var(smooth[frame]) / np.var(inner[frame]))
        gradient.append(np.mean(step_x**2 + step_y**2) / np.mean(np.diff(cut, axis=1) ** 2) / 2)
    assert np.mean(drawn) + 0.05 < np.mean(rim) < 1.1
    # steeper than inside, but by far not as steep as a plain cross-fade makes it
    assert 1.0 < np.mean(seam) < 0.6 * np.mean(plain)
    # the rms gradient is that of the map, as in docs/explanation/surface.md; waves are as long as the window
    assert np.sqrt(np.mean(gradient)) == pytest.approx(1.0, abs=0.05)


def test_smooth_cross_fade_keeps_noise_on_correlated_ends():
    """Ends that agree in their long waves only: the noise on them keeps its gradient."""
    generator = np.random.default_rng(4)
    x = np.arange(110)
    wave = 30 * np.cos(2 * np.pi * x / 100)
    cut = wave + wave[:, None] + generator.standard_normal((110, 110))
    closed = periodisation.smooth_cross_fade(cut, (10, 10), (1.0, 1.0))
    noise = closed - wave[5:105] - wave[5:105, None]
    assert np.std(noise[0]) == pytest.approx(1.0, abs=0.2)
    assert np.std(np.diff(noise, axis=0)) == pytest.approx(np.sqrt(2), rel=0.03)


def test_smooth_cross_fade_commutes_with_mirror_transpose_and_units():
    values = np.random.default_rng(2).standard_normal((22, 30))
    result = periodisation.smooth_cross_fade(values, (4, 6), (2.0, 1.0))
    assert result.shape == (18, 24)
    flipped = periodisation.smooth_cross_fade(values[::-1], (4, 6), (2.0, 1.0))
    np.testing.assert_allclose(flipped, result[::-1], atol=1e-12)
    scaled = periodisation.smooth_cross_fade(1e-9 * values + 1e-6, (4, 6), (2e-6, 1e-6))
    np.testing.assert_allclose(scaled, 1e-9 * result + 1e-6, atol=1e-20)
    assert np.ptp(periodisation.smooth_cross_fade(np.full((8, 9), 3.0), (2, 2), (1.0, 1.0))) < 1e-14
    profile = periodisation.smooth_cross_fade(values[:1], (0, 6), (1.0, 1.0))
    assert profile.shape == (1, 24)
    np.testing.assert_allclose(
        periodisation.smooth_cross_fade(values[:1].T, (6, 0), (1.0, 1.0)), profile.T, atol=1e-12
    )


def test_gaussian_mean_is_that_of_scipy():
    from scipy.ndimage import gaussian_filter

    values = np.random.default_rng(5).standard_normal((40, 57))
    expected = gaussian_filter(values, [3.0, 5.5], mode="reflect", truncate=8)
    np.testing.assert_allclose(periodisation._gaussian_mean(values, [3.0, 5.5]), expected, atol=1e-13)


def test_taper_is_the_tukey_window():
    values = np.random.default_rng(0).standard_normal((1, 40)) + 3.0
    tapered = periodisation.taper(values, 0.2)
    np.testing.assert_array_equal(tapered[0, 4:36], (values - values.mean() + values.mean())[0, 4:36])
    distance = np.arange(4) + 0.5
    window = 0.5 * (1 - np.cos(np.pi * distance / 4))
    np.testing.assert_allclose(
        tapered[0, :4] - values.mean(), window * (values[0, :4] - values.mean()), atol=1e-14
    )
    np.testing.assert_allclose(periodisation.taper(values, 0.0), values, atol=1e-15)
    np.testing.assert_allclose(periodisation.taper(values, 2.2e-309), values, atol=1e-15)


@pytest.mark.parametrize("shape", [(128, 128), (100, 65), (1, 1024), (64, 200), (16, 256)])
def test_periodic_maps_are_recognised(shape):
    verdicts = [
        periodisation.is_periodic(rough(shape, seed, shortest, hurst).values)
        for seed in range(10)
        for shortest, hurst in ((4.0, 0.5), (8.0, 0.8), (8.0, 1.0))
    ]
    assert np.mean(verdicts) >= 29 / 30


@pytest.mark.parametrize("shape", [(128, 128), (100, 65), (64, 200)])
def test_cut_outs_are_recognised(shape):
    for seed in range(10):
        for shortest, hurst in ((4.0, 0.5), (8.0, 0.8), (8.0, 1.0)):
            large = rough([2 * n for n in shape], seed, shortest, hurst).values
            assert not periodisation.is_periodic(large[: shape[0], : shape[1]])


@pytest.mark.parametrize("column", [2, 50, 97])
def test_a_ridge_inside_is_no_seam(column):
    """Its two steps and three changes of slope lie between the first column and the last."""
    ridge = 0.5 * (np.arange(100) == column)
    height = np.tile(np.cos(2 * np.pi * np.arange(100) / 100) + ridge, (12, 1))
    assert periodisation.is_periodic(height)
    assert not periodisation.is_periodic(height[:, :-20])


def test_periodicity_of_simple_maps():
    y, x = np.indices((40, 60))
    wave = np.cos(2 * np.pi * x / 20) + np.cos(2 * np.pi * y / 40)
    assert periodisation.is_periodic(wave)
    assert periodisation.is_periodic(np.zeros((40, 60)))
    assert not periodisation.is_periodic(wave[:, :-5])
    assert not periodisation.is_periodic(0.1 * x + wave)  # a tilt
    assert not periodisation.is_periodic((x - 29.5) ** 2.0)  # meets in height, not in slope
    assert not periodisation.is_periodic(np.where((y == 3) & (x == 4), np.nan, wave))
    # neighbours without relation, and maps too small, show nothing
    assert not periodisation.is_periodic(np.random.default_rng(0).standard_normal((40, 60)))
    assert not periodisation.is_periodic(np.cos(2 * np.pi * np.arange(20) / 20)[None, :])


def line_waves(steps, rows):
    """Waves along x, from point to point by such phases, shifted evenly against one another from row to row.

    A step by the phase d has the rms 2 sin(d / 2) over the rows, and the rms height is 1. Down the rows the
    map is periodic, whatever the phases.
    """
    phases = np.concatenate([[0.0], np.cumsum(steps)])
    shifts = 2 * np.pi * np.arange(rows)[:, None] / rows
    return np.sqrt(2) * np.cos(phases + shifts)


@pytest.mark.parametrize("rows", [9, 100, 2500])
def test_how_steep_a_seam_may_be(rows):
    """By 20 % + 1.5 / sqrt(points of the seam) steeper than inside, and not by more."""
    columns, turns = 41, 4

    def steepness(seam):
        """Larger one of the rms step and the rms change of slope at the seam, over those inside."""
        inside = (2 * np.pi * turns - seam) / (columns - 1)
        bend = abs(np.exp(1j * seam) - 2 + np.exp(-1j * inside))
        return max(np.sin(seam / 2) / np.sin(inside / 2), bend / (4 * np.sin(inside / 2) ** 2))

    for factor, periodic in ((0.999, True), (1.001, False)):
        target = factor * (1.2 + 1.5 / np.sqrt(rows))
        seam = brentq(lambda phase, target=target: steepness(phase) - target, 0.65, 2.0)
        inside = (2 * np.pi * turns - seam) / (columns - 1)
        values = line_waves(np.full(columns - 1, inside), rows)
        assert periodisation.is_periodic(values) is periodic
        assert periodisation.is_periodic(values.T) is periodic


@pytest.mark.parametrize(("steep", "periodic"), [(0, False), (2, False), (3, True), (8, True)])
def test_a_seam_may_be_as_steep_as_the_steepest_twentieth_inside(steep, periodic):
    """2 of 40 steps inside are just a twentieth: the 95 % that are not exceeded know nothing of them."""
    flat = (2 * np.pi * 3 - 0.8 * (steep + 1)) / (40 - steep)
    steps = np.full(40, flat)
    steps[2 : 2 + 4 * steep : 4] = 0.8
    assert flat < 0.6
    assert periodisation.is_periodic(line_waves(steps, 2500)) is periodic


@pytest.mark.parametrize("is_forward", [True, False])
def test_a_kink_on_one_side_of_the_seam_is_seen(is_forward):
    """Steps shrink bit by bit from the first to the last, and the seam is like the first one; or reversed."""
    steps = np.linspace(10.0, 1.0, 60)
    steps *= 2 * np.pi / (steps.sum() + steps[0])
    values = line_waves(steps if is_forward else steps[::-1], 2500)
    assert not periodisation.is_periodic(values)


@pytest.mark.parametrize(("turns", "periodic"), [(204, True), (206, False)])
def test_neighbours_as_good_as_unrelated_show_nothing(turns, periodic):
    """The rms step is 1.197 and 1.206 times the rms height."""
    values = line_waves(np.full(999, 2 * np.pi * turns / 1000), 16)
    assert periodisation.is_periodic(values) is periodic


def test_sixty_four_points_are_enough():
    wave = np.cos(2 * np.pi * np.arange(64) / 32)[None, :]
    assert periodisation.is_periodic(wave)
    assert not periodisation.is_periodic(np.cos(2 * np.pi * np.arange(63) / 31.5)[None, :])


def test_two_columns_say_nothing_and_three_do():
    wave = np.cos(2 * np.pi * np.arange(64) / 32)[:, None]
    assert periodisation.is_periodic(wave + np.array([0.0, 0.1]))
    assert not periodisation.is_periodic(wave + np.array([0.0, 0.1, 0.2]))


def test_the_form_is_put_back_only_where_that_makes_the_map_periodic():
    x = np.arange(128)[None, :]
    wave = np.sin(2 * np.pi * x / 64) + 3.0
    heights, put_back = periodisation.periodic_heights(wave, 0.1 * x)
    assert heights is wave
    assert not put_back
    heights, put_back = periodisation.periodic_heights(wave - 0.1 * x, 0.1 * x)
    assert put_back
    np.testing.assert_allclose(heights, wave - 3.0, atol=1e-12)
    assert periodisation.periodic_heights(wave + 0.1 * x, 0.1 * x) is None
    assert periodisation.periodic_heights(wave + 0.1 * x, np.full(x.shape, 0.3)) is None


@pytest.mark.parametrize("band", [1, 4, 5])
def test_each_point_of_a_cross_fade(band):
    """The result starts in the middle of the band, rounded down."""
    values = np.random.default_rng(6).standard_normal((3, 20 + band))
    positions = np.arange(20) + band // 2
    weight = np.sin(np.pi / 2 * (np.arange(band) + 0.5) / band) ** 2
    expected = np.empty((3, 20))
    for column, at in enumerate(positions % 20):
        expected[:, column] = values[:, at]
        if at < band:
            expected[:, column] = weight[at] * values[:, at] + (1 - weight[at]) * values[:, 20 + at]
    np.testing.assert_allclose(periodisation.cross_fade(values, (0, band)), expected, atol=1e-14)
    np.testing.assert_allclose(periodisation.cross_fade(values.T, (band, 0)), expected.T, atol=1e-14)


@pytest.mark.parametrize("correlation", [-0.9, 0.0, 0.6, 1.0])
def test_variance_is_kept_whatever_the_correlation_of_the_ends(correlation):
    """Ends that are against one another count as unrelated, so that nothing blows up."""
    generator = np.random.default_rng(7)
    values, partner = generator.standard_normal((2, 20_000, 30))
    values[:, 20:] = correlation * values[:, :10] + np.sqrt(1 - correlation**2) * partner[:, :10]
    deviations = periodisation.cross_fade(values, (0, 10), keep_variance=True).std(axis=0)
    weight = np.sin(np.pi / 2 * (np.arange(10) + 0.5) / 10) ** 2
    blended = np.ones(20)
    if correlation < 0:
        overlap = 2 * weight * (1 - weight)
        blended[:10] = np.sqrt((1 - overlap + overlap * correlation) / (1 - overlap))
    np.testing.assert_allclose(deviations, np.roll(blended, -5), rtol=0.03)


def test_smooth_cross_fade_by_its_parts():
    """Long waves are what a Gaussian over half of the band passes; 0.55 of their smooth component goes."""
    values = np.cumsum(np.random.default_rng(8).standard_normal((70, 83)), axis=1)
    band = (6, 9)
    long_waves = ndimage.gaussian_filter(values, [3.0, 4.5], mode="reflect", truncate=10)
    inner = long_waves[3:67, 4:79]
    smooth = np.pad(inner - periodisation.periodic_plus_smooth(inner, (2.0, 1.0)), ((3, 3), (4, 4)), "edge")
    expected = periodisation.cross_fade(long_waves - 0.55 * smooth, band)
    expected += periodisation.cross_fade(values - long_waves, band, keep_variance=True)
    faded = periodisation.smooth_cross_fade(values, band, (2.0, 1.0))
    np.testing.assert_allclose(faded, expected, atol=1e-10)


def test_taper_of_a_map_is_the_product_of_both_windows():
    values = np.random.default_rng(9).standard_normal((16, 30)) + 2.0
    tapered = periodisation.taper(values, 0.25)
    windows = []
    for points in values.shape:
        distance = np.minimum(np.arange(points) + 0.5, points - 0.5 - np.arange(points))
        rising = 0.5 * (1 - np.cos(np.pi * distance / (0.25 * points / 2)))
        windows.append(np.where(distance < 0.25 * points / 2, rising, 1.0))
    expected = (values - values.mean()) * windows[0][:, None] * windows[1] + values.mean()
    np.testing.assert_allclose(tapered, expected, atol=1e-14)


def ratios(method, width=0.125):
    """Gradient of windows over that of the periodic surface they were cut from, 16 windows."""
    result = []
    for seed in range(4):
        master = self_affine((512, 512), 1 / 512, (8 / 512, 1 / 4), rms_gradient=1.0, seed=seed)
        for y0, x0 in ((0, 0), (256, 100), (200, 250), (100, 31)):
            cut = master.isel(y=slice(y0, y0 + 256), x=slice(x0, x0 + 256))
            window = periodic_window(level(cut), method=method, width=width)
            assert window.attrs["rms_gradient_after"] == pytest.approx(rms_gradient(window), rel=1e-12)
            result.append(window.attrs["rms_gradient_after"])
    return np.array(result)


@pytest.mark.nightly
def test_gradient_of_cut_outs_against_the_truth():
    """The gradient that a window solves with, over the true one; the scatter between windows is 2-3 %."""
    mean = {method: ratios(method).mean() for method in get_args(WindowMethod)}
    assert mean["raw"] > 1.3
    assert mean["periodic-plus-smooth"] == pytest.approx(1.0, abs=0.03)
    assert mean["mirror"] == pytest.approx(1.0, abs=0.03)
    assert mean["cross-fade"] == pytest.approx(1.0, abs=0.05)
    assert mean["smooth-cross-fade"] == pytest.approx(1.0, abs=0.03)
    assert mean["taper"] == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("gap_width", [-2, 0])
def test_a_jump_between_the_two_points_beside_the_seam_is_not_at_the_seam(gap_width):
    """A walk that ends one of its own steps from where it began; one jump is elsewhere."""
    steps = np.random.default_rng(10).standard_normal(400)
    steps[[-3, -2, -1, 0, 1]] = 0.1
    steps[[gap_width, 200]] = 6.3, -6.3
    steps -= steps.mean()
    walk = np.cumsum(steps)
    assert periodisation.is_periodic(np.roll(walk, 1)[None, :])
    assert not periodisation.is_periodic(np.roll(walk, -gap_width)[None, :])  # there it is the seam


@pytest.mark.parametrize("last", [True, False])
def test_every_pair_inside_counts_where_neighbours_are_as_good_as_unrelated(last):
    """Four rms steps of 1.17 rms heights and one of 1.43 at either end: 1.23 together, above 1.2."""
    steps = np.array([1.25, 1.25, 1.25, 1.25, 1.6])
    assert not periodisation.is_periodic(line_waves(steps if last else steps[::-1], 2500))
    assert periodisation.is_periodic(line_waves(np.full(5, 1.25), 2500))


@pytest.mark.parametrize("last", [True, False])
def test_every_change_of_slope_inside_counts(last):
    """A seam that bends by 1.185, where all bend by 0.919 inside but for one at either end, by 1.198."""
    steps = np.array([1.0, 1.0, 1.0, 1.0, 1.3])
    assert periodisation.is_periodic(line_waves(steps if last else steps[::-1], 2500))


def test_a_seam_between_plains_is_closed_up_to_rounding():
    ridge = np.zeros((20, 100))
    ridge[:, 40:60] = 3.0
    for step, periodic in ((0.0, True), (2e-12, True), (4e-12, False)):
        ridge[:, -1] = step
        ridge[:, -2] = step
        assert periodisation.is_periodic(ridge) is periodic


def test_taper_of_two_points_is_the_hann_window_of_two_points():
    np.testing.assert_allclose(periodisation.taper(np.array([[1.0, 3.0]]), 1.0), [[1.5, 2.5]], rtol=1e-15)
    np.testing.assert_array_equal(periodisation.taper(np.array([[1.0, 3.0]]), 0.5), [[1.0, 3.0]])
