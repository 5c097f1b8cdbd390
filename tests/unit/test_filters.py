"""The areal Gaussian filter: transmission, end effects, missing points; other software on real files."""

import json

import numpy as np
import pytest
from known_surfaces import self_affine
from scipy import ndimage
from shared_data import DATA

from roughcontact import HeightMapError, SettingsError, height_map, level, read_height_map
from roughcontact.surface.levelling.filters import gaussian_mean_surface

# Plane removed, Gaussian low-pass of surfalize 0.19.2 (heights read by SurfaceTopography 1.27.1): nesting
# index, m, and the mean surface, m, in the middle [ny//2, nx//2] and at (+20, -30) and (-40, +10) from there.
OTHER_SOFTWARE = {
    ("al3d-1.al3d", 2.5e-6): [-6.305233311155898e-07, 7.633924344795427e-09, -2.1199118764002746e-08],
    ("al3d-1.al3d", 10e-6): [-6.030882842931825e-07, -1.3971317630274496e-08, -2.632410346395152e-08],
    ("x3p-2.x3p", 2.5e-6): [6.150388632395683e-08, 2.165022846869964e-08, -4.60404210116717e-08],
    ("x3p-2.x3p", 10e-6): [3.17725126403741e-08, -1.9646375104966535e-09, -3.533693003387271e-08],
}


@pytest.mark.parametrize("ratio", [0.5, 1.0, 1.5, 3.0])
@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0])
def test_amplitude_transmission(ratio, angle):
    """A wave passes with 2^-(nesting index / wavelength)^2 of its amplitude, whatever its direction."""
    dy, dx, wavelength = 1.0, 1.5, 30.0
    y, x = np.arange(240)[:, None] * dy, np.arange(160)[None, :] * dx
    q = 2 * np.pi / wavelength
    wave = np.cos(q * (x * np.cos(np.deg2rad(angle)) + y * np.sin(np.deg2rad(angle))) + 0.3)
    smooth = gaussian_mean_surface(wave, (dy, dx), ratio * wavelength)
    rim = int(1.3 * ratio * wavelength)
    inner = (slice(rim, -rim or None), slice(int(rim / dx) + 1, -int(rim / dx) - 1))
    if min(wave[inner].shape) == 0:
        inner = (slice(120, 121), slice(80, 81))
    share = np.sum(smooth[inner] * wave[inner]) / np.sum(wave[inner] ** 2)
    assert share == pytest.approx(2 ** -(ratio**2), rel=1e-6, abs=1e-7)


def test_half_of_a_wave_as_long_as_the_nesting_index_passes():
    x = np.arange(400)[None, :] + np.zeros((300, 1))
    wave = np.sin(2 * np.pi * x / 50)
    smooth = gaussian_mean_surface(wave, (1.0, 1.0), 50.0)
    np.testing.assert_allclose(smooth[100:200, 100:300], 0.5 * wave[100:200, 100:300], atol=1e-9)


@pytest.mark.parametrize("nesting_index", [0.3, 2.0, 15.0, 100.0, 3000.0])
def test_constants_and_planes_stay_up_to_edges_and_holes(nesting_index):
    y, x = np.indices((60, 80)) * 1.0
    plane = 7 + 0.2 * x - 0.05 * y
    plane[20:35, 10:50] = np.nan
    plane[:5, 70:] = np.nan
    smooth = gaussian_mean_surface(plane, (1.0, 1.0), nesting_index)
    np.testing.assert_array_equal(np.isnan(smooth), np.isnan(plane))
    np.testing.assert_allclose(smooth, plane, atol=1e-8)


def test_inside_it_is_the_plain_weighted_mean():
    """Against scipy's Gaussian, sigma = lambda_c sqrt(ln 2 / 2) / pi."""
    values = np.random.default_rng(0).standard_normal((150, 130))
    sigma = 20 * np.sqrt(np.log(2) / 2) / np.pi
    expected = ndimage.gaussian_filter(values, (sigma, sigma / 2), truncate=8)
    smooth = gaussian_mean_surface(values, (1.0, 2.0), 20.0)
    np.testing.assert_allclose(smooth[30:-30, 20:-20], expected[30:-30, 20:-20], atol=1e-9)


def test_near_edges_and_holes_it_is_the_weighted_fit_of_a_plane():
    """Point by point, by another route: least squares with the standard's weights."""
    generator = np.random.default_rng(1)
    values = generator.standard_normal((25, 30))
    values[generator.random(values.shape) < 0.4] = np.nan
    dy, dx, index = 1.0, 0.7, 6.0
    smooth = gaussian_mean_surface(values, (dy, dx), index)
    rows, columns = np.nonzero(~np.isnan(values))
    for j, i in [(0, 0), (0, 15), (24, 29), (12, 3), (10, 14)]:
        if np.isnan(values[j, i]):
            assert np.isnan(smooth[j, i])
            continue
        y, x = (rows - j) * dy, (columns - i) * dx
        root = np.sqrt(np.exp(-(np.pi**2) / np.log(2) * (x**2 + y**2) / index**2))
        design = np.stack([np.ones(x.size), x, y], axis=1) * root[:, None]
        plane = np.linalg.lstsq(design, values[rows, columns] * root, rcond=None)[0]
        assert smooth[j, i] == pytest.approx(plane[0], abs=1e-8)


@pytest.mark.shared_data
@pytest.mark.parametrize(("name", "nesting_index"), OTHER_SOFTWARE)
def test_other_software_filters_the_same(name, nesting_index):
    levelled = level(read_height_map(DATA / name), outlier_threshold=None, s_filter=nesting_index)
    # counted in the rows of the file, as the other software has them
    rows = levelled.values[::-1] if levelled.attrs["first_row"] == "top" else levelled.values
    ny, nx = (n // 2 for n in levelled.shape)
    values_at_points = [rows[ny + j, nx + i] for j, i in ((0, 0), (20, -30), (-40, 10))]
    # the other filter cuts its weights off at four standard deviations
    np.testing.assert_allclose(
        values_at_points, OTHER_SOFTWARE[name, nesting_index], rtol=0, atol=1e-4 * levelled.attrs["Sq"]
    )


def test_levelling_takes_off_short_and_long_waves_and_records_them():
    rough = self_affine((200, 240), 1e-6, (4e-6, 100e-6), rms_height=1e-6, seed=1)
    plain = level(rough, outlier_threshold=None)
    both_filters = level(rough, outlier_threshold=None, s_filter=8e-6, l_filter=40e-6)
    smooth = gaussian_mean_surface(plain.values, (1e-6, 1e-6), 8e-6)
    expected = smooth - gaussian_mean_surface(smooth, (1e-6, 1e-6), 40e-6)
    np.testing.assert_allclose(both_filters.values, expected, atol=1e-18)
    record = json.loads(both_filters.attrs["filters_removed"])
    assert record["s_filter"]["nesting_index"] == {"value": 8e-6, "units": "m"}
    assert record["s_filter"]["rms_removed"]["value"] == pytest.approx(
        np.sqrt(np.mean((plain.values - smooth) ** 2))
    )
    assert record["l_filter"]["rms_removed"]["units"] == "m"
    assert both_filters.attrs["Sq"] < plain.attrs["Sq"]
    assert json.loads(plain.attrs["filters_removed"]) == {}


def test_filters_leave_missing_points_missing_and_fill_them_after():
    rough = self_affine((80, 90), 1e-6, (4e-6, 50e-6), rms_height=1e-6, seed=2)
    rough.values[30:36, 40:50] = np.nan
    levelled = level(rough, outlier_threshold=None, l_filter=30e-6)
    assert np.isfinite(levelled.values).all()
    assert levelled.attrs["filled_points"] == 60


def test_profiles_are_filtered_along_their_own_axis():
    x = np.arange(400.0)
    wave = np.sin(2 * np.pi * x / 40)
    for shape in ((1, -1), (-1, 1)):
        smooth = gaussian_mean_surface(wave.reshape(shape), (1.0, 1.0), 40.0).ravel()
        np.testing.assert_allclose(smooth[60:-60], 0.5 * wave[60:-60], atol=1e-9)


def test_filters_without_meaning():
    height = height_map(np.random.default_rng(0).standard_normal((20, 20)), 1e-6)
    with pytest.raises(SettingsError, match=r"level\.s_filter = -1"):
        level(height, s_filter=-1)
    with pytest.raises(
        SettingsError, match=r"level.s_filter = 1e-05 m is not below level.l_filter = 5e-06 m"
    ):
        level(height, s_filter=1e-5, l_filter=5e-6)
    with pytest.raises(HeightMapError, match=r"level.l_filter = 1e-06 m is less than two pixels \(2e-06 m\)"):
        level(height, l_filter=1e-6)
