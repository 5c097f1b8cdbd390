"""Harmonic filling against harmonic functions, which it must give back."""

import time

import numpy as np
import pytest
from scipy import ndimage

from roughcontact.levelling.filling import fill_harmonic, find_holes


def fill(heights, missing, spacing=(1.0, 1.0)):
    labels, sizes = find_holes(missing)
    return fill_harmonic(np.where(missing, np.nan, heights), labels, spacing), labels, sizes


def disc(n, radius):
    y, x = np.indices((n, n)) - (n - 1) / 2
    return np.hypot(y, x) < radius


@pytest.mark.parametrize("hole", ["scattered", "disc", "blobs", "both"])
def test_a_plane_is_given_back(hole):
    n = 160
    generator = np.random.default_rng(1)
    scattered = generator.random((n, n)) < 0.3
    blobs = ndimage.gaussian_filter(generator.standard_normal((n, n)), 6, mode="wrap")
    missing = {
        "scattered": scattered,
        "disc": disc(n, 50),
        "blobs": blobs > np.quantile(blobs, 0.7),
        "both": disc(n, 40) | (scattered & (generator.random((n, n)) < 0.2)),
    }[hole]
    y, x = np.indices((n, n))
    plane = 5e-6 + 2e-9 * x - 3e-9 * y
    filled, labels, sizes = fill(plane, missing, (3e-6, 1e-6))
    inside = labels > 0
    assert inside.sum() == sizes.sum() > 1000
    np.testing.assert_allclose(filled[inside], plane[inside], atol=1e-6 * np.ptp(plane), rtol=0)
    np.testing.assert_array_equal(filled[~missing], plane[~missing])


def test_a_harmonic_function_is_given_back_to_second_order():
    errors = []
    for n in (65, 129):
        y, x = np.indices((n, n)) / (n - 1)
        heights = np.exp(2 * x) * np.cos(2 * y)
        filled, _, _ = fill(heights, disc(n, 0.3 * n))
        errors.append(np.abs(filled - heights).max())
    assert errors[1] < errors[0] / 3.5
    assert errors[1] < 1e-5


def test_the_discrete_equation_holds_with_pixels_that_are_not_square():
    generator = np.random.default_rng(3)
    dy, dx = 2.5, 1.0
    heights = generator.standard_normal((80, 90))
    missing = np.zeros((80, 90), dtype=bool)
    missing[10:40, 20:70] = True  # wide
    missing[60:64, 5:80] = True  # narrow
    filled, labels, sizes = fill(heights, missing, (dy, dx))
    assert sorted(sizes) == [300, 1500]
    laplacian = (np.roll(filled, 1, 0) - 2 * filled + np.roll(filled, -1, 0)) / dy**2
    laplacian += (np.roll(filled, 1, 1) - 2 * filled + np.roll(filled, -1, 1)) / dx**2
    assert np.abs(laplacian[labels > 0]).max() < 1e-7
    # maximum principle
    assert filled[labels > 0].max() < heights[~missing].max()


def test_regions_open_to_the_border_are_left_missing():
    missing = np.zeros((20, 30), dtype=bool)
    missing[0:4, 10] = True
    missing[10, 10:14] = True
    missing[15:18, 29] = True
    filled, labels, sizes = fill(np.ones((20, 30)), missing)
    assert sizes.tolist() == [4]
    np.testing.assert_array_equal(labels > 0, np.where(np.indices((20, 30))[0] == 10, missing, False))
    assert np.isnan(filled[0:4, 10]).all()
    assert np.isnan(filled[15:18, 29]).all()
    assert filled[10, 11] == pytest.approx(1.0)


@pytest.mark.parametrize("axis", [0, 1])
def test_profile_is_filled_by_straight_lines(axis):
    heights = np.array([np.nan, 1.0, np.nan, np.nan, 4.0, 2.0, np.nan, 0.0, np.nan])
    expected = np.array([np.nan, 1.0, 2.0, 3.0, 4.0, 2.0, 1.0, 0.0, np.nan])
    shape = (1, 9) if axis else (9, 1)
    values = heights.reshape(shape)
    labels, sizes = find_holes(np.isnan(values))
    assert sorted(sizes) == [1, 2]
    np.testing.assert_allclose(fill_harmonic(values, labels, (1.0, 1.0)), expected.reshape(shape))


def test_flat_rim_gives_a_flat_filling_and_offsets_do_no_harm():
    missing = disc(60, 20)
    filled, _, _ = fill(np.full((60, 60), 3.0), missing)
    np.testing.assert_allclose(filled, 3.0, rtol=1e-12)
    generator = np.random.default_rng(0)
    rough = 1e-9 * generator.standard_normal((60, 60))
    low, _, _ = fill(rough, missing)
    high, _, _ = fill(rough + 1e-3, missing)
    np.testing.assert_allclose(high - 1e-3, low, atol=1e-15)


def test_a_quarter_million_missing_points_are_filled_in_seconds():
    n = 1000
    missing = disc(n, 250) | (np.random.default_rng(0).random((n, n)) < 0.1)
    y, x = np.indices((n, n)) / n
    start = time.perf_counter()
    filled, labels, sizes = fill(x + y, missing)
    assert time.perf_counter() - start < 20
    assert sizes.max() > 190_000
    np.testing.assert_allclose(filled[labels > 0], (x + y)[labels > 0], atol=1e-6)
