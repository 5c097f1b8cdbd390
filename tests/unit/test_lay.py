"""The period of the lay, and windows with a whole number of periods."""

import numpy as np
import pytest

from roughcontact import height_map, level, periodic_window
from roughcontact.surface import synthetic
from roughcontact.surface.window.lay import lay_period, side_of_whole_periods


def rough(shape, seed=0, **options):
    options = {"hurst": 0.8, "shortest": 8.0, "longest": max(shape) / 2, "rms_gradient": 1.0} | options
    return synthetic.self_affine_surface(shape, 1.0, seed=seed, **options).values


def grooves(shape, period, seed=0):
    x = np.arange(shape[1])
    return np.cos(2 * np.pi * x / period) + 0.1 * np.random.default_rng(seed).standard_normal(shape)


@pytest.mark.parametrize("period", [17.3, 24.0, 37.6])
def test_lay_period_of_grooves(period):
    values = grooves((120, 256), period)
    assert lay_period(values, 1) == pytest.approx(period, rel=0.01)
    assert lay_period(values, 0) is None
    assert lay_period(values.T, 0) == pytest.approx(period, rel=0.01)


def test_rough_surfaces_have_no_lay_period():
    periods = [lay_period(rough((512, 512), seed)[:200, :256], axis) for seed in range(8) for axis in (0, 1)]
    assert sum(period is not None for period in periods) <= 1
    assert lay_period(np.zeros((30, 40)), 1) is None


@pytest.mark.parametrize(("power", "is_found"), [(0.25, False), (0.35, True)])
def test_a_lay_shows_in_the_autocorrelation_by_0_3(power, is_found):
    """The wave makes up this share of the power; the rest is noise, alike nowhere."""
    noise = np.random.default_rng(0).standard_normal((64, 4000))
    wave = np.sqrt(2) * np.cos(2 * np.pi * np.arange(4000) / 40)
    period = lay_period(np.sqrt(power) * wave + np.sqrt(1 - power) * noise, 1)
    assert (period == pytest.approx(40, rel=0.02)) if is_found else period is None


@pytest.mark.parametrize(("ratio", "period"), [(0.78, 40), (0.82, 20)])
def test_the_first_of_the_high_maxima_is_one_period_away(ratio, period):
    """cos(t) + a cos(2 t): the maximum after half a period is (a^2 - 1)/(a^2 + 1) as high as the next."""
    a = np.sqrt((1 + ratio) / (1 - ratio))
    t = 2 * np.pi * np.arange(8000) / 40
    assert lay_period((np.cos(t) + a * np.cos(2 * t))[None, :], 1) == pytest.approx(period, rel=0.01)


@pytest.mark.parametrize(("points", "is_found"), [(100, False), (104, True)])
def test_more_than_four_periods_must_fit(points, is_found):
    assert (lay_period(np.cos(2 * np.pi * np.arange(points) / 25)[None, :], 1) is not None) is is_found


def test_a_side_is_a_whole_number_of_periods_to_a_tenth():
    """81 is the longest side below 90; 4.11 periods are too far from four, of which 80 is nearer."""
    assert side_of_whole_periods(90, 81 / 4.09) == 81
    assert side_of_whole_periods(90, 81 / 4.11) == 80


def test_sides_down_to_seven_tenths_are_tried():
    """Of 90 points 64 = 2 x 32 is the shortest side tried; none of them is a whole number of 50 points."""
    assert side_of_whole_periods(90, 32.0) == 64
    assert side_of_whole_periods(90, 50.0) == 90
    assert side_of_whole_periods(91, None) == 91


def test_the_window_has_a_whole_number_of_periods_across_grooves_alone():
    period = 37.6
    levelled = level(height_map(grooves((300, 290), period), 1e-6), outlier_threshold=None)
    largest, whole_periods = (
        periodic_window(levelled, placement=name) for name in ("largest", "whole-periods")
    )
    assert whole_periods.shape[0] == largest.shape[0]
    assert abs(whole_periods.shape[1] / period - round(whole_periods.shape[1] / period)) <= 0.1
    assert abs(largest.shape[1] / period - round(largest.shape[1] / period)) > 0.1
    assert "a whole number of periods of its texture" in whole_periods.attrs["window_reason"]
    assert "periods" not in largest.attrs["window_reason"]


def test_without_a_period_the_window_is_the_largest():
    levelled = level(height_map(rough((512, 512), seed=5)[:282, :300], 1e-6))
    largest, whole_periods = (
        periodic_window(levelled, placement=name) for name in ("largest", "whole-periods")
    )
    np.testing.assert_array_equal(whole_periods.values, largest.values)
