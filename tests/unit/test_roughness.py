"""Roughness parameters against closed forms, finite differences and the theory of random surfaces."""

import math

import numpy as np
import pytest
from known_surfaces import self_affine

from roughcontact.arguments.maps import height_map
from roughcontact.surface import synthetic
from roughcontact.surface.roughness import parameters
from roughcontact.surface.roughness.summits import summit_statistics
from roughcontact.surface.window import periodisation
from validation.surfaces import product_wave_surface


def waves(shape, spacing, terms):
    """Sum of a cos(q . r + phase) over terms (a, waves along y, waves along x)."""
    (ny, nx), (dy, dx) = shape, spacing
    y, x = np.arange(ny)[:, None] / ny, np.arange(nx)[None, :] / nx
    heights = sum(
        a * np.cos(2 * np.pi * (ky * y + kx * x) + k) for k, (a, ky, kx) in enumerate(terms)
    ) + np.zeros(shape)
    q = [2 * np.pi * np.hypot(ky / (ny * dy), kx / (nx * dx)) for _, ky, kx in terms]
    return height_map(heights, spacing), np.array([t[0] for t in terms]), np.array(q)


@pytest.mark.parametrize("shape", [(24, 40), (25, 41), (24, 41)])
def test_sum_of_waves_in_closed_form(shape):
    height, a, q = waves(shape, (3e-6, 2e-6), [(1e-7, 1, 2), (3e-7, 0, 5), (2e-8, 4, -3)])
    m0, gradient, laplacian = (np.sum(a**2 / 2 * q**k) for k in (0, 2, 4))
    assert parameters.rms_height(height) == pytest.approx(np.sqrt(m0), rel=1e-12)
    assert parameters.rms_gradient(height) == pytest.approx(np.sqrt(gradient), rel=1e-12)
    assert parameters.rms_curvature(height) == pytest.approx(np.sqrt(laplacian) / 2, rel=1e-12)
    expected = (m0, gradient / 2, 3 / 8 * laplacian)
    assert parameters.spectral_moments(height) == pytest.approx(expected, rel=1e-12)
    nayak = m0 * (3 / 8 * laplacian) / (gradient / 2) ** 2
    assert parameters.roughness_parameters(height)["nayak_parameter"] == pytest.approx(nayak, rel=1e-12)


def test_profile_in_closed_form():
    height, a, q = waves((1, 60), (1.0, 0.5), [(1.0, 0, 2), (0.5, 0, 7)])
    expected = tuple(np.sum(a**2 / 2 * q**k) for k in (0, 2, 4))
    assert parameters.spectral_moments(height) == pytest.approx(expected, rel=1e-12)
    assert parameters.rms_gradient(height) == pytest.approx(np.sqrt(expected[1]), rel=1e-12)
    column = height.transpose("x", "y").rename(x="y", y="x")
    assert parameters.roughness_parameters(column)["nayak_parameter"] == pytest.approx(
        parameters.roughness_parameters(height)["nayak_parameter"], rel=1e-12
    )


def test_least_nayak_parameters():
    single, _, _ = waves((1, 64), (1.0, 1.0), [(1.0, 0, 3)])
    assert parameters.roughness_parameters(single)["nayak_parameter"] == pytest.approx(1.0)
    height = self_affine((128, 128), 1.0, (7.99, 8.01), hurst=0.5, rms_height=1)
    assert parameters.roughness_parameters(height)["nayak_parameter"] == pytest.approx(1.5, rel=1e-2)


def test_smooth_surface_against_finite_differences():
    height = self_affine((256, 256), (2e-6, 1e-6), (80e-6, 256e-6), rms_height=1e-6, seed=2)
    z = height.values
    # fourth-order differences, periodic
    gradient_along = lambda axis, d: (8 * (np.roll(z, -1, axis) - np.roll(z, 1, axis))  # noqa: E731
                             - np.roll(z, -2, axis) + np.roll(z, 2, axis)) / (12 * d)  # fmt: skip
    curvature_along = lambda axis, d: (np.roll(z, -1, axis) - 2 * z + np.roll(z, 1, axis)) / d**2  # noqa: E731
    gradient = np.sqrt(np.mean(gradient_along(0, 2e-6) ** 2 + gradient_along(1, 1e-6) ** 2))
    curvature = np.sqrt(np.mean((curvature_along(0, 2e-6) + curvature_along(1, 1e-6)) ** 2)) / 2
    assert parameters.rms_gradient(height) == pytest.approx(gradient, rel=2e-5)
    assert parameters.rms_curvature(height) == pytest.approx(curvature, rel=5e-3)


@pytest.mark.parametrize("shape", [(32, 32), (31, 48), (1, 64)])
def test_full_contact_pressure_is_half_the_gradient(shape):
    """std(p) = E* g / 2 with p(q) = E* |q| h(q) / 2, for any map, the waves at the Nyquist limit included."""
    height = height_map(np.random.default_rng(1).standard_normal(shape), (3.0, 2.0))
    (ny, nx), (dy, dx) = shape, (3.0, 2.0)
    q = 2 * np.pi * np.hypot(np.fft.fftfreq(ny, dy)[:, None], np.fft.fftfreq(nx, dx)[None, :])
    pressure = np.fft.ifft2(q / 2 * np.fft.fft2(height.values)).real
    assert pressure.std() == pytest.approx(parameters.rms_gradient(height) / 2, rel=1e-12)


@pytest.mark.parametrize("shape", [(32, 32), (31, 48), (1, 64), (5, 1)])
def test_interior_gradient_is_that_of_the_mirrored_map(shape):
    values = np.random.default_rng(2).standard_normal(shape)
    original, mirrored = (height_map(v, (3.0, 2.0)) for v in (values, periodisation.mirror(values)))
    expected = parameters.rms_gradient(mirrored)
    assert parameters.interior_rms_gradient(original) == pytest.approx(expected, rel=1e-12)


def test_interior_gradient_counts_no_step_at_the_edges():
    x = np.arange(4000) * 1e-6
    tilt = height_map((0.02 * x)[None, :], 1e-6)
    assert parameters.interior_rms_gradient(tilt) == pytest.approx(0.02, rel=1e-3)
    assert parameters.rms_gradient(tilt) > 10 * 0.02


@pytest.mark.parametrize(("waves_per_side", "hurst"), [(16, 0.3), (64, 0.8), (64, 1.0), (128, 0.5)])
def test_cut_off_of_a_band_limited_surface(waves_per_side, hurst):
    n = 512
    height = synthetic.self_affine_surface(
        (n, n), 1e-6, hurst=hurst, shortest=n / waves_per_side * 1e-6, longest=1e-4, rms_gradient=0.2, seed=1
    )
    expected = n / waves_per_side
    assert parameters.roughness_parameters(height)["points_per_shortest_wavelength"] == pytest.approx(
        expected, rel=1e-9
    )
    assert parameters.shortest_wavelength(height) == pytest.approx(expected * 1e-6, rel=1e-9)


def test_cut_off_of_the_reference_case_and_of_one_wave():
    reference = synthetic.rough_reference_surface(256)
    assert parameters.roughness_parameters(reference)["points_per_shortest_wavelength"] == pytest.approx(16.0)
    wave = synthetic.westergaard_surface((4, 60), 1.0, amplitude=1.0, wavelength=12.0)
    assert parameters.roughness_parameters(wave)["points_per_shortest_wavelength"] == pytest.approx(12.0)
    profile = synthetic.westergaard_surface((1, 60), 1.0, amplitude=1.0, wavelength=12.0)
    assert parameters.shortest_wavelength(profile) == pytest.approx(12.0)


@pytest.mark.parametrize("shape", [(100, 150), (1, 1024), (2, 2)])
def test_noise_reaches_two_pixels(shape):
    height = height_map(np.random.default_rng(0).standard_normal(shape), (2e-6, 1e-6))
    assert parameters.roughness_parameters(height)["points_per_shortest_wavelength"] == pytest.approx(2.0)
    assert parameters.shortest_wavelength(height) == pytest.approx(2e-6)


@pytest.mark.parametrize(("remaining_power", "cut_off"), [(0.05, 60), (0.15, 100)])
def test_the_cut_off_is_the_edge_beyond_the_last_hundredth(remaining_power, cut_off):
    """Mean square gradient of 100 in each of 20 waves, of 1 up to the 60th, then of 0.05 or 0.15.

    The last 1 % begin at the 46th; the waves around it go on down to a tenth of theirs.
    """
    k = np.arange(1, 101)
    gradient = np.select([k <= 20, k <= 60], [100.0, 1.0], remaining_power)
    x = 2 * np.pi * np.arange(200) / 200
    # at the Nyquist limit a cosine is its own mirror image and counts twice
    amplitude = np.sqrt(gradient * np.where(k < 100, 2, 1)) / k
    profile = height_map((amplitude[:, None] * np.cos(k[:, None] * x)).sum(axis=0)[None, :], 1e-6)
    assert parameters.roughness_parameters(profile)["points_per_shortest_wavelength"] == pytest.approx(
        200 / cut_off
    )


def test_a_profile_has_no_summits():
    profile = height_map(np.random.default_rng(1).standard_normal((1, 64)), 1e-6)
    assert all(math.isnan(value) for value in summit_statistics(profile).values())
    two_rows = height_map(np.where(np.indices((2, 50)).sum(axis=0) == 0, 1.0, 0.0), 1e-3)
    assert summit_statistics(two_rows)["density"] == pytest.approx(1 / 100e-6)


def test_summits_agree_with_the_theory_of_random_surfaces():
    """Density m4 / (6 pi sqrt(3) m2) (Nayak 1971) and mean curvature 8 sqrt(m4 / pi) / 3 (McCool 1986)."""
    height = self_affine((512, 512), 1e-6, (8e-6, 256e-6), rms_gradient=0.2, seed=4)
    _, m2, m4 = parameters.spectral_moments(height)
    summits = summit_statistics(height)
    assert summits["density"] == pytest.approx(m4 / (6 * np.pi * np.sqrt(3) * m2), rel=0.06)
    assert 1 / summits["mean_radius"] == pytest.approx(8 / 3 * np.sqrt(m4 / np.pi), rel=0.04)
    assert 0 < summits["height_std"] < parameters.rms_height(height) * 1.05


def test_summits_of_a_wave_in_closed_form():
    height = product_wave_surface((40, 40), 0.1, amplitude=0.3, wavelength=2.0)
    summits = summit_statistics(height)
    assert summits["density"] == pytest.approx(8 / 16)  # two per wavelength squared, 2 x 2 waves
    assert summits["mean_radius"] == pytest.approx(1 / (0.3 * np.pi**2), rel=1e-12)
    assert summits["height_std"] == pytest.approx(0, abs=1e-12)
    assert summits["mean_height"] == pytest.approx(0.3)


@pytest.mark.parametrize("level", [0.0, 0.3, 1e6 + 0.1])
@pytest.mark.parametrize("shape", [(7, 5), (64, 64), (1, 33)])
def test_flat_map_is_exactly_flat(shape, level):
    flat = height_map(np.full(shape, level), 1e-6)
    parameters_of_flat = parameters.roughness_parameters(flat)
    assert (
        parameters_of_flat["rms_height"]
        == parameters_of_flat["rms_gradient"]
        == parameters_of_flat["rms_curvature"]
        == 0
    )
    assert parameters.interior_rms_gradient(flat) == 0
    assert math.isnan(parameters_of_flat["nayak_parameter"])
    assert math.isnan(parameters_of_flat["points_per_shortest_wavelength"])
    assert math.isnan(summit_statistics(flat)["mean_radius"])


def test_parameters_together_are_the_parameters_one_by_one():
    height = height_map(np.random.default_rng(2).standard_normal((20, 31)), (2.0, 1.0))
    together = parameters.roughness_parameters(height)
    for name in ("rms_height", "rms_gradient", "rms_curvature"):
        assert getattr(parameters, name)(height) == pytest.approx(together[name], rel=1e-14)
    m0, m2, m4 = parameters.spectral_moments(height)
    assert m0 * m4 / m2**2 == pytest.approx(together["nayak_parameter"], rel=1e-14)


def test_steepest_points_of_random_slopes_and_of_a_single_spike():
    rough = self_affine((512, 512), 1e-6, (8e-6, 64e-6), rms_gradient=0.1, seed=1)
    expected = 0.01 * (1 - math.log(0.01))
    assert parameters.steepest_share(rough) == pytest.approx(expected, rel=0.05)
    spike = height_map(np.where(np.arange(4096).reshape(64, 64) == 100, 1e-6, 0.0), (1e-6, 2e-6))
    assert parameters.steepest_share(spike) == pytest.approx(1.0)
    assert parameters.steepest_share(spike, share=1e-9) == pytest.approx(1.25 / 2.5)
    assert parameters.steepest_share(0 * spike) == 0


@pytest.mark.parametrize("kind", ["u1", "i1", "u2", "i2"])
def test_whole_numbers_of_a_narrow_type_are_as_rough_as_doubles(kind):
    """Differences of small integers wrap around."""
    limits = np.iinfo(kind)
    heights = np.random.default_rng(0).integers(limits.min, limits.max, (9, 8), endpoint=True)
    narrow, double = (
        height_map(np.zeros(heights.shape), 1e3, unit="m").copy(data=heights.astype(dtype))
        for dtype in (kind, float)
    )
    for name in ("rms_height", "rms_gradient", "rms_curvature", "interior_rms_gradient", "steepest_share"):
        assert getattr(parameters, name)(narrow) == getattr(parameters, name)(double)
