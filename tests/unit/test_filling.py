"""Harmonic filling against harmonic functions, which it must give back."""

from unittest import mock

import numpy as np
import pytest
import scipy.fft
from scipy import ndimage

from roughcontact.errors import HeightMapError
from roughcontact.surface.levelling import filling
from roughcontact.surface.levelling.filling import fill_harmonic, find_holes


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


def test_a_wide_hole_takes_few_transforms():
    """125 points across; conjugate gradients by themselves take about as many iterations."""
    missing = disc(250, 62.5)
    y, x = np.indices((250, 250)) / 250
    with mock.patch("scipy.fft.dstn", wraps=scipy.fft.dstn) as transform:
        filled, labels, sizes = fill(x + y, missing)
    assert sizes.tolist() == [12256]
    assert 0 < transform.call_count < 30
    np.testing.assert_allclose(filled[labels > 0], (x + y)[labels > 0], atol=1e-8)


def test_a_narrow_hole_on_which_conjugate_gradients_give_up_is_filled_all_the_same():
    """A line of points that are coupled along it alone: information goes on one point per iteration."""
    shape = (3, 2402)
    missing = np.zeros(shape, dtype=bool)
    missing[1, 1:-1] = True
    y, x = np.indices(shape)
    plane = x / 2400 + 0.1 * y
    filled, _, _ = fill(plane, missing, (1e5, 1.0))
    np.testing.assert_allclose(filled, plane, atol=1e-9)


def test_a_wide_hole_that_is_not_solved_is_no_surface(monkeypatch):
    monkeypatch.setattr(filling, "_MAX_ITERATIONS", 3)
    y, x = np.indices((60, 60))
    with pytest.raises(HeightMapError, match=r"a hole of \d+ missing points .* set level.fill to 'none'"):
        fill(np.sin(x) * y, disc(60, 20))


@pytest.mark.parametrize("hole", ["narrow", "wide"])
def test_the_residual_is_a_ten_thousand_millionth_of_the_right_hand_side(hole):
    generator = np.random.default_rng(5)
    heights = generator.random((70, 70))
    heights[0, :2] = 0, 1  # the scale that the equation is solved on
    missing = np.zeros((70, 70), dtype=bool)
    missing[20 : 30 if hole == "narrow" else 60, 10:60] = True
    filled, _, _ = fill(heights, missing)
    without_missing = np.where(missing, 0.0, heights)
    rhs, neighbours = (
        sum(np.roll(f, s, a) for s in (1, -1) for a in (0, 1)) for f in (without_missing, filled)
    )
    residual = (4 * filled - neighbours)[missing]
    assert np.linalg.norm(residual) <= 1.01e-10 * np.linalg.norm(rhs[missing])


@pytest.mark.parametrize("edge", [(0, 7), (-1, 7), (7, 0), (7, -1)])
def test_holes_open_to_any_edge_are_none(edge):
    missing = np.zeros((15, 16), dtype=bool)
    missing[edge] = True
    missing[5:9, 4:8] = True
    labels, sizes = find_holes(missing)
    assert sizes.tolist() == [16]
    assert labels[edge] == 0
    inner = np.zeros((15, 16), dtype=bool)
    inner[1, 1] = inner[-2, -2] = inner[1, -2] = inner[-2, 1] = True  # one point off both edges
    labels, sizes = find_holes(inner)
    assert sizes.tolist() == [1, 1, 1, 1]
    assert sorted(labels[inner]) == [1, 2, 3, 4]


def test_points_that_touch_by_their_corners_are_two_holes():
    missing = np.zeros((6, 6), dtype=bool)
    missing[0, 1] = missing[1, 2] = missing[2, 3] = missing[2, 4] = True
    labels, sizes = find_holes(missing)
    assert sorted(sizes) == [1, 2]
    assert labels[0, 1] == 0
    assert labels[2, 3] == labels[2, 4] != labels[1, 2]


def test_two_rows_or_columns_have_no_hole_and_one_has():
    for shape, sizes in (((2, 9), []), ((9, 2), []), ((1, 9), [1]), ((9, 1), [1])):
        missing = np.zeros(shape, dtype=bool)
        missing.flat[4] = True
        assert find_holes(missing)[1].tolist() == sizes


def test_a_map_without_holes_is_returned_as_a_copy():
    values = np.array([[1.0, np.nan, 3.0], [4.0, 5.0, 6.0]])
    filled = fill_harmonic(values, find_holes(np.isnan(values))[0], (1.0, 1.0))
    np.testing.assert_array_equal(filled, values)
    assert filled is not values
