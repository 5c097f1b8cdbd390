"""Synthetic surfaces against the formulas that define them."""

import numpy as np
import pytest

from data_samples.make_samples import turned_surface
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.errors import SettingsError
from roughcontact.surface import synthetic
from roughcontact.surface.roughness.parameters import rms_gradient, rms_height
from validation.surfaces import ground_surface, product_wave_surface, sum_wave_surface


@pytest.mark.parametrize("points", [33, 64, 100, 256])
def test_rough_reference_case_is_the_published_one(points):
    height = synthetic.rough_reference_surface(points)
    assert rms_height(height) == pytest.approx(0.023699516, abs=1e-9)
    assert rms_gradient(height) == pytest.approx(0.55501825, abs=1e-8)
    assert spacing(height) == pytest.approx((1 / points, 1 / points))


def test_rough_reference_case_point_by_point():
    height = synthetic.rough_reference_surface(64).values
    assert height[0, 0] == pytest.approx(-0.030736712487165578, abs=1e-15)
    assert height[1, 2] == pytest.approx(-0.02097264018456442, abs=1e-15)
    fine = synthetic.rough_reference_surface(192).values
    np.testing.assert_allclose(fine[::3, ::3], height, atol=1e-15)


def test_rough_reference_case_needs_room_for_its_waves():
    with pytest.raises(SettingsError, match="points = 32"):
        synthetic.rough_reference_surface(32)


@pytest.mark.parametrize("shape", [(64, 96), (45, 64), (1, 500), (33, 1)])
def test_self_affine_surface_has_the_asked_spectrum(shape):
    dy, dx = 2e-6, 1e-6
    hurst, shortest, longest = 0.7, 8e-6, 30e-6
    height = synthetic.self_affine_surface(
        shape, (dy, dx), hurst=hurst, shortest=shortest, longest=longest, rms_height=1e-6, seed=3
    )
    assert rms_height(height) == pytest.approx(1e-6, rel=1e-12)
    amplitude = np.abs(np.fft.fft2(height.values))
    q = 2 * np.pi * np.hypot(np.fft.fftfreq(shape[0], dy)[:, None], np.fft.fftfreq(shape[1], dx)[None, :])
    inside = (q > 2 * np.pi / longest) & (q < 2 * np.pi / shortest)
    outside = (q < 2 * np.pi / longest * 0.999) | (q > 2 * np.pi / shortest * 1.001)
    assert amplitude[outside].max() < 1e-12 * amplitude.max()
    # the logarithmic slope of the amplitudes is -(1 + H), for a profile -(1/2 + H)
    slope = np.polyfit(np.log(q[inside]), np.log(amplitude[inside]), 1)[0]
    assert slope == pytest.approx(-(hurst + (1 if min(shape) > 1 else 0.5)), abs=1e-9)


def test_self_affine_surface_is_the_same_for_the_same_seed_only():
    make = lambda seed: synthetic.self_affine_surface(  # noqa: E731
        (32, 32), 1.0, hurst=0.8, shortest=4, longest=32, rms_gradient=0.1, seed=seed
    )
    np.testing.assert_array_equal(make(5).values, make(5).values)
    assert np.abs(make(5).values - make(6).values).max() > 1e-3
    assert rms_gradient(make(5)) == pytest.approx(0.1, rel=1e-12)


def test_self_affine_surface_refuses_an_empty_band_and_two_scales():
    with pytest.raises(SettingsError, match="no wave"):
        synthetic.self_affine_surface((8, 8), 1.0, hurst=0.8, shortest=20, longest=30, rms_height=1)
    with pytest.raises(SettingsError, match="exactly one"):
        synthetic.self_affine_surface((8, 8), 1.0, hurst=0.8, shortest=2, longest=8)
    with pytest.raises(SettingsError, match="exactly one"):
        synthetic.self_affine_surface(
            (8, 8), 1.0, hurst=0.8, shortest=2, longest=8, rms_height=1, rms_gradient=1
        )


def test_stretched_surface_is_smoother_along_y():
    height = synthetic.self_affine_surface(
        (256, 256), 1.0, hurst=0.8, shortest=6, longest=60, rms_height=1, stretch=4.0, seed=1
    ).values
    # amplitudes depend on hypot(stretch q_y, q_x) alone, so the rms slopes stand as 1 : stretch
    along_y, along_x = (np.sqrt(np.mean(np.diff(height, axis=axis) ** 2)) for axis in (0, 1))
    assert along_x / along_y == pytest.approx(4.0, rel=0.1)


def test_turned_surface_has_the_ideal_peak_to_valley():
    feed, radius, pitch = 80e-6, 0.8e-3, 0.1e-6
    height = turned_surface((2, 3200), pitch, feed=feed, nose_radius=radius)
    assert np.ptp(height.values) == pytest.approx(feed**2 / (8 * radius), rel=5e-3)
    np.testing.assert_array_equal(height.values[0], height.values[1])
    np.testing.assert_allclose(height.values[0, :800], height.values[0, 800:1600], atol=1e-15)


def test_turned_surface_follows_the_arc_of_the_tool():
    arc, pitch, feed, radius = 2e-3, 1e-6, 60e-6, 1e-3
    height = turned_surface((401, 300), pitch, feed=feed, nose_radius=radius, arc_radius=arc)
    y, x = height["y"].values[:, None] - 401 / 2 * pitch, height["x"].values[None, :]
    from_axis = np.hypot(x + arc, y) - arc
    expected = (np.mod(from_axis, feed) - feed / 2) ** 2 / (2 * radius)
    np.testing.assert_allclose(height.values, expected, atol=1e-6 * expected.max())


def test_ground_surface_has_deep_valleys():
    height = ground_surface(
        (128, 256), 1e-6, hurst=0.7, shortest=5e-6, longest=50e-6, rms_height=1e-6, skewness_power=1.5, seed=1
    )
    z = height.values - height.values.mean()
    assert np.mean(z**3) / np.mean(z**2) ** 1.5 < -0.3
    assert rms_height(height) == pytest.approx(1e-6, rel=1e-12)


def test_waves_follow_their_formulas():
    shape, step = (12, 20), (0.25, 0.1)
    y, x = np.arange(12)[:, None] * 0.25, np.arange(20)[None, :] * 0.1
    wave = synthetic.westergaard_surface(shape, step, amplitude=0.3, wavelength=2.0)
    np.testing.assert_allclose(wave.values, 0.3 * np.cos(np.pi * x) + 0 * y, atol=1e-15)
    wave = product_wave_surface(shape, step, amplitude=0.3, wavelength=1.0)
    np.testing.assert_allclose(wave.values, 0.3 * np.cos(2 * np.pi * x) * np.cos(2 * np.pi * y), atol=1e-15)
    wave = sum_wave_surface(shape, step, amplitudes=(0.1, 0.2), wavelengths=(3.0, 2.0))
    expected = 0.1 * np.cos(2 * np.pi * y / 3) + 0.2 * np.cos(np.pi * x)
    np.testing.assert_allclose(wave.values, expected, atol=1e-15)


def test_sum_of_equal_waves_is_the_product_wave_turned_by_45_degrees():
    n = 64
    total = sum_wave_surface((n, n), 1 / n, amplitudes=(1, 1), wavelengths=(1, 1)).values
    # cos a + cos b = 2 cos((a + b) / 2) cos((a - b) / 2): the points (i, j) of the sum lie at
    # ((i + j) / 2, (i - j) / 2) of a product wave of the same period, sqrt(2) shorter in the turned frame
    product = product_wave_surface((2 * n, 2 * n), 0.5 / n, amplitude=2, wavelength=1).values
    i, j = np.indices((n, n))
    np.testing.assert_allclose(total, product[(i + j) % (2 * n), (i - j) % (2 * n)], atol=1e-13)


def test_height_map_follows_the_contract():
    values = np.array([[1.0, np.nan, 3.0], [4.0, 5.0, 6.0]])
    height = height_map(values, (2e-6, 1e-6))
    assert height.dims == ("y", "x")
    assert height.name == "height"
    np.testing.assert_allclose(height["y"], [1e-6, 3e-6])
    np.testing.assert_allclose(height["x"], [0.5e-6, 1.5e-6, 2.5e-6])
    assert height.attrs["missing_points"] == 1
    assert height.attrs["missing_share"] == pytest.approx(1 / 6)
    assert all(isinstance(value, (str, int, float)) for value in height.attrs.values())
