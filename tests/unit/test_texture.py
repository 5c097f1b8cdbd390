"""Autocorrelation, its lengths and the lay, against closed forms and numbers of other software."""

import numpy as np
import pytest
import scipy.ndimage
from known_surfaces import self_affine
from scipy.signal import fftconvolve
from shared_data import DATA

from roughcontact import height_map, level, periodic_window, read_height_map, self_affine_surface
from roughcontact.arguments.maps import spacing
from roughcontact.surface.roughness.texture import autocorrelation, decay_lengths, texture_parameters

# Sal of surfalize 0.19.2, m, plane removed (heights read by SurfaceTopography 1.27.1)
OTHER_SAL = {"al3d-1.al3d": 12.394400975709353e-6, "x3p-2.x3p": 2.6646858855237e-6}


def directed(angle, *, spread=3.0, points=256):
    """Random waves whose directions scatter by `spread` degrees around `angle`."""
    k = np.fft.fftfreq(points, 1 / points)
    ky, kx = np.meshgrid(k, k, indexing="ij")
    angle_off = (np.rad2deg(np.arctan2(ky, kx)) - angle + 90) % 180 - 90
    size = np.hypot(kx, ky)
    amplitude = np.where((size > 3) & (size < 60), np.maximum(size, 1) ** -1.8, 0) * np.exp(
        -(angle_off**2) / (2 * spread**2)
    )
    noise = np.fft.fft2(np.random.default_rng(1).standard_normal((points, points)))
    return height_map(np.fft.ifft2(noise * amplitude).real, 1e-6)


@pytest.mark.parametrize("length", [4.0, 20.0])
def test_lengths_of_a_gaussian_autocorrelation(length):
    """exp(-(x/l)^2 - (y/3l)^2) falls to 0.2 at l sqrt(ln 5) and at 3 l sqrt(ln 5)."""
    y, x = np.arange(-128, 128)[:, None] * 1.0, np.arange(-100, 100)[None, :] * 0.7
    shortest, longest, has_decay = decay_lengths(
        np.exp(-((x / length) ** 2) - (y / 3 / length) ** 2), (1.0, 0.7)
    )
    assert shortest == pytest.approx(length * np.sqrt(np.log(5)), rel=2e-3)
    assert longest == pytest.approx(3 * length * np.sqrt(np.log(5)), rel=2e-3)
    assert has_decay


def test_long_pixels_are_sampled_at_their_own_steps(monkeypatch):
    """Steps of 1 m beside 1 µm cost no more than those of square pixels, and the lengths are the same."""
    sampled = []
    interpolate = scipy.ndimage.map_coordinates

    def counting(values, positions, **options):
        sampled.append(len(positions[0]))
        return interpolate(values, positions, **options)

    monkeypatch.setattr(scipy.ndimage, "map_coordinates", counting)
    y, x = np.arange(-32, 32)[:, None], np.arange(-32, 32)[None, :]
    gaussian = np.exp(-((x / 4) ** 2) - (y / 6) ** 2)
    for dy, dx in ((1.0, 1.0), (1e-6, 1.0), (1.0, 1e-6)):
        shortest, longest, _ = decay_lengths(gaussian, (dy, dx))
        expected = sorted(np.sqrt(np.log(5)) * np.array([4 * dx, 6 * dy]))
        assert [shortest, longest] == pytest.approx(expected, rel=2e-3)
        assert sum(sampled) < 150_000
        sampled.clear()


def test_the_autocorrelation_is_the_mean_of_products():
    values = np.random.default_rng(0).standard_normal((12, 9))
    correlation = autocorrelation(height_map(values, 1.0))
    z = values - values.mean()
    for dy, dx in ((0, 0), (1, 0), (0, 2), (3, -2)):
        expected = np.mean(z * np.roll(z, (-dy, -dx), (0, 1))) / np.mean(z**2)
        assert correlation[6 + dy, 4 + dx] == pytest.approx(expected, abs=1e-12)


def test_grooves_in_closed_form():
    """cos(2 pi x / L): correlated by 0.2 at acos(0.2) L / 2 pi across, for ever along."""
    y, x = np.indices((64, 96))
    texture = texture_parameters(height_map(np.cos(2 * np.pi * x * 4 / 96), 1e-6))
    assert texture["Sal"] == pytest.approx(24e-6 / 2 / np.pi * np.arccos(0.2), rel=1e-3)
    # the longest ray that stays on a ridge leans a little
    assert texture["Str"] == pytest.approx(texture["Sal"] / np.hypot(32e-6, texture["Sal"]), rel=5e-3)
    assert texture["Std"] == 0
    turned = texture_parameters(height_map(np.cos(2 * np.pi * y * 4 / 64), 1e-6))
    assert turned["Std"] == 90
    # the stronger one of two waves, leaning, on pixels that are not square
    waves = np.cos(2 * np.pi * (3 * x / 96 - 5 * y / 64)) + 0.9 * np.cos(2 * np.pi * x * 4 / 96)
    leaning = texture_parameters(height_map(waves, (2e-6, 1e-6)))
    assert leaning["Ssw"] == pytest.approx(1e-6 / np.hypot(3 / 96, 5 / 128), rel=1e-12)
    assert texture["Ssw"] == pytest.approx(24e-6, rel=1e-12)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(("rows", "bound"), [(12, None), (30, None), (60, 0.40), (120, 0.21), (240, 0.11)])
def test_grooves_across_a_window_of_any_width(rows, bound, turned):
    """Directions in which a window shows no decay are none of the shortest, and an open end is no lay."""
    values = np.cos(2 * np.pi * np.arange(120) / 60) * np.ones((rows, 1))
    texture = texture_parameters(height_map(values.T if turned else values, 1e-6))
    assert texture["Sal"] == pytest.approx(60e-6 / 2 / np.pi * np.arccos(0.2), rel=1e-3)
    assert texture["Std"] == (90 if turned else 0)
    assert texture["Str"] == pytest.approx(np.nan if bound is None else bound, abs=0.01, nan_ok=True)


@pytest.mark.parametrize("rows", [256, 128, 64, 32, 16])
def test_an_isotropic_surface_has_the_same_length_in_any_strip_of_it(rows):
    """One that is too narrow to show it all round says nothing of a lay."""
    options = {"hurst": 0.8, "shortest": 8e-6, "longest": 128e-6, "rms_height": 1e-6}
    lengths, aspects = [], []
    for seed in range(8):
        surface = self_affine_surface((512, 512), 1e-6, seed=seed, **options)
        texture = texture_parameters(periodic_window(level(surface[:rows]), method="periodic-plus-smooth"))
        lengths.append(texture["Sal"])
        aspects.append(texture["Str"])
    reference = texture_parameters(surface)["Sal"]  # of all seeds: the amplitudes are those of the spectrum
    assert np.mean(lengths) == pytest.approx(reference, rel=0.2)
    assert np.std(lengths, ddof=1) < 0.2 * reference
    assert np.isnan(aspects).all() == (rows * 1e-6 < 1.5 * reference)
    assert not np.mean(aspects) < 0.6


@pytest.mark.parametrize("angle", [0.0, 20.0, 45.0, 90.0, 133.7])
def test_the_lay_is_found_at_any_angle(angle):
    texture = texture_parameters(directed(angle))
    assert abs((texture["Std"] - angle + 90) % 180 - 90) <= 1
    assert texture["Str"] < 0.15


def test_an_isotropic_surface_has_no_lay():
    height = self_affine((512, 512), 1e-6, (8e-6, 60e-6), rms_height=1e-6, seed=5)
    assert texture_parameters(height)["Str"] > 0.75


def test_stretched_waves_give_the_stretch():
    options = {"hurst": 0.8, "shortest": 6e-6, "longest": 24e-6, "rms_height": 1e-6, "seed": 6}
    texture = texture_parameters(self_affine_surface((1024, 512), 1e-6, stretch=3.0, **options))
    assert texture["Str"] == pytest.approx(1 / 3, rel=0.1)


@pytest.mark.shared_data
@pytest.mark.parametrize("name", OTHER_SAL)
def test_other_software_finds_the_same_length(name):
    """With the autocorrelation that the other software takes: each shift over the points that overlap."""
    levelled = level(read_height_map(DATA / name), outlier_threshold=None)
    z = levelled.values - levelled.values.mean()
    ny, nx = z.shape
    overlap = np.outer(ny - np.abs(np.arange(1 - ny, ny)), nx - np.abs(np.arange(1 - nx, nx)))
    products = fftconvolve(z, z[::-1, ::-1]) / overlap
    shortest, _, _ = decay_lengths(products / products[ny - 1, nx - 1], spacing(levelled))
    assert shortest == pytest.approx(OTHER_SAL[name], rel=2e-3)


def test_profiles_and_flat_maps():
    profile = self_affine_surface((1, 2000), 1e-6, hurst=0.8, shortest=8e-6, longest=60e-6, rms_height=1e-6)
    texture = texture_parameters(profile)
    column = texture_parameters(profile.transpose("x", "y").rename(x="y", y="x"))
    assert texture["Sal"] == pytest.approx(column["Sal"], rel=1e-12)
    ray = autocorrelation(profile)[0, 1000:]
    index = int(np.argmax(ray < 0.2))
    assert (index - 1) * 1e-6 <= texture["Sal"] <= index * 1e-6
    assert np.isnan(texture["Str"])
    assert np.isnan(texture["Std"])
    flat = texture_parameters(height_map(np.full((8, 9), 0.3), 1e-6))
    assert all(np.isnan(value) for value in flat.values())


@pytest.mark.parametrize("shape", [(2, 2), (2, 5), (7, 2), (3, 4)])
def test_the_smallest_maps_have_a_length(shape):
    """The mean of the autocorrelation is zero: it falls somewhere, over half the period at most."""
    for seed in range(20):
        height = height_map(np.random.default_rng(seed).standard_normal(shape), (3.0, 1.0))
        texture = texture_parameters(height)
        assert 0 < texture["Sal"] <= np.hypot(3.0 * shape[0], shape[1]) / 2
        assert 0 <= texture["Std"] < 180
