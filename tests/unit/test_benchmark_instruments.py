"""Simulated instruments do to simple maps what optics and geometry say."""

import instruments
import numpy as np
import pytest
from scipy import integrate

from roughcontact.arguments.maps import height_map, spacing


@pytest.fixture
def rough():
    values = np.random.default_rng(1).standard_normal((48, 40))
    return height_map(values * 1e-8, (2e-7, 1e-7))


def waves(periods: float, points: int = 240, pitch: float = 1e-7):
    """Return a map of a cosine that is its own mirror image, along x, and its wavelength (m)."""
    x = (np.arange(points) + 0.5) / points
    heights = 1e-7 * np.cos(2 * np.pi * periods * x)
    return height_map(np.tile(heights, (16, 1)), pitch), points * pitch / periods


def test_noise_has_its_rms_and_no_neighbours(rough):
    flat = height_map(np.zeros((256, 256)), 1e-6)
    noise = instruments.add_noise(flat, 3e-9, seed=5).values
    assert noise.std() == pytest.approx(3e-9, rel=0.01)
    assert abs(np.mean(noise[:, 1:] * noise[:, :-1])) < 0.02 * 9e-18
    assert instruments.add_noise(flat, 3e-9, seed=5).identical(instruments.add_noise(flat, 3e-9, seed=5))
    assert instruments.add_noise(rough, 1e-9, seed=0).attrs == rough.attrs


@pytest.mark.parametrize("periods", [2.5, 10, 20])
def test_a_lens_damps_a_wave_by_the_overlap_of_its_pupils(periods):
    numerical_aperture, colour = 0.5, 550e-9
    wave, length = waves(periods)
    shift = colour / length / numerical_aperture  # of the two pupils, in radii
    half, _ = integrate.quad(lambda x: 2 * np.sqrt(1 - x**2), min(shift / 2, 1), 1)
    seen = instruments.through_lens(wave, numerical_aperture, colour)
    assert np.allclose(seen, wave * 2 * half / np.pi, atol=1e-12)


def test_a_lens_keeps_planes_nearly_and_stops_waves_beyond_its_limit():
    wave, length = waves(60)
    assert abs(instruments.through_lens(wave, 0.99 * 550e-9 / 2 / length, 550e-9)).max() < 1e-20
    level = height_map(np.full((20, 30), 3e-6), 1e-7)
    assert np.allclose(instruments.through_lens(level, 0.3, 550e-9), level)


def test_a_sphere_draws_its_own_shape_around_a_spike():
    heights = np.zeros((41, 41))
    heights[20, 20] = 3e-8
    spike = height_map(heights, (2e-9, 1e-9))
    traced = instruments.traced_by(spike, 5e-8).values
    y, x = 2e-9 * (np.arange(41) - 20)[:, None], 1e-9 * (np.arange(41) - 20)[None, :]
    sphere = 3e-8 - 5e-8 + np.sqrt(2.5e-15 - y**2 - x**2)
    assert np.allclose(traced, np.maximum(sphere, 0), atol=1e-20)


def test_a_tip_does_not_reach_over_a_step_by_more_than_its_radius():
    step = height_map(np.where(np.arange(60) < 30, 0.0, 1e-6)[None, :] + np.zeros((4, 1)), 1e-8)
    traced = instruments.traced_by(step, 1e-7).values
    assert (traced[:, :20] == 0).all()
    assert (traced[:, 21:] > 0).all()


def test_a_tip_sharpens_a_valley_by_the_difference_of_the_radii():
    x = 2e-9 * np.arange(-50, 51)
    valley = height_map(np.tile(x**2 / (2 * 4e-6), (3, 1)), 2e-9)
    traced = instruments.traced_by(valley, 2e-6)[:, 30:-30]
    assert np.allclose(traced, x[30:-30] ** 2 / (2 * 2e-6), atol=1e-12)


def test_pixels_are_merged_and_divided(rough):
    blocks = instruments.coarser(rough, 2)
    assert np.allclose(blocks, rough.values.reshape(24, 2, 20, 2).mean((1, 3)))
    assert spacing(blocks) == pytest.approx((4e-7, 2e-7))
    assert blocks["x"].values[0] == pytest.approx(1e-7)
    wave, _ = waves(4)
    finer_map, (exact, _) = instruments.finer(wave, 2), waves(4, 480, 5e-8)
    assert np.allclose(finer_map, np.vstack([exact, exact]), atol=2e-11)
    assert np.allclose(finer_map["x"], exact["x"])
    assert spacing(finer_map) == pytest.approx((5e-8, 5e-8))


def test_scales_multiply_slopes(rough):
    wrong = instruments.scaled(rough, z=1.1, xy=0.5)
    assert np.allclose(wrong.differentiate("x"), 2.2 * rough.differentiate("x").values)


def test_software_of_instruments(rough):
    assert np.median(rough[9:14, 19:24]) == instruments.median_filtered(rough, 5)[11, 21]
    wave, length = waves(10)
    damped = np.exp(-2 * (np.pi * 2e-7 / length) ** 2)
    assert np.allclose(instruments.gauss_filtered(wave, 2.0), damped * wave, atol=1e-10)


def test_dust_and_compressed_peaks(rough):
    dusty = instruments.with_dust(rough, 1e-6, 2.0, (10, 20)) - rough
    assert dusty[10, 20] == pytest.approx(1e-6)
    assert dusty[10, 22] == pytest.approx(1e-6 * np.exp(-0.5))
    assert dusty.sum() == pytest.approx(1e-6 * 2 * np.pi * 4, rel=1e-3)
    ramp = height_map(np.arange(100.0)[None, :] + np.zeros((2, 1)), 1.0)
    pressed = instruments.with_compressed_peaks(ramp, 0.1, 0.3).values
    assert np.array_equal(pressed[0, :89], np.arange(89.0))
    assert np.ptp(pressed[0, 91:]) == pytest.approx(0.3 * 8)
