"""The search for the window: each part of the score against its definition, and what it prefers."""

import json
from unittest import mock

import numpy as np
import pytest

from roughcontact.contact.solve import solve_contact
from roughcontact.levelling.level import level
from roughcontact.maps import height_map
from roughcontact.references import synthetic
from roughcontact.report.tables import score_table
from roughcontact.window import score
from roughcontact.window.lay import lay_period
from roughcontact.window.periodic_window import periodic_window
from roughcontact.window.score import WEIGHTS
from roughcontact.window.search import search_window
from roughcontact.window.sides import band_points, is_friendly


def rough(shape, seed=0, **options):
    options = {"hurst": 0.8, "shortest": 8.0, "longest": max(shape) / 2, "rms_gradient": 1.0} | options
    return synthetic.self_affine_surface(shape, 1.0, seed=seed, **options).values


def grooves(shape, period, seed=0):
    x = np.arange(shape[1])
    return np.cos(2 * np.pi * x / period) + 0.1 * np.random.default_rng(seed).standard_normal(shape)


def search(values, largest, *, filled=None, fade=0.1):
    filled = np.zeros(values.shape) if filled is None else filled
    return search_window(values, filled, largest, fade=fade)


def box(candidate, fade=0.1):
    return tuple(
        slice(s, s + n + band_points(n, fade)) for s, n in zip(candidate.start, candidate.sides, strict=True)
    )


def test_candidates_fit_and_have_no_missing_point():
    values = rough((256, 288))[:200, :230]
    values[:20] = values[60:80, 200:] = np.nan
    largest = ((22, 3), (160, 162))
    found = search(values, largest)
    assert (largest[0], largest[1]) in [(c.start, c.sides) for c in found]
    assert [c.score for c in found] == sorted(c.score for c in found)
    for candidate in found:
        part = values[box(candidate)]
        assert part.shape == tuple(n + band_points(n, 0.1) for n in candidate.sides)
        assert np.isfinite(part).all()
        assert all(is_friendly(n) for n in candidate.sides)
        assert all(n >= 0.7 * m for n, m in zip(candidate.sides, largest[1], strict=True))
        assert candidate.score == pytest.approx(
            sum(weight * candidate.parts[name] for name, weight in WEIGHTS.items()), abs=1e-8
        )


def test_mismatch_and_missing_share_by_their_definitions():
    values = rough((400, 400), seed=3)[:180, :190]
    filled = np.zeros(values.shape)
    filled[50:60, 100:130] = 1
    heights = values - values.mean()
    for candidate in search(values, ((0, 0), (160, 160)), filled=filled)[:8]:
        part, bands = heights[box(candidate)], [band_points(n, 0.1) for n in candidate.sides]
        heights_apart, slopes_apart = [], []
        for axis in (0, 1):
            lines, whole = (part, heights) if axis else (part.T, heights.T)
            first = bands[axis] // 2
            last = first + candidate.sides[axis] - 1
            step = lines[:, first] - lines[:, last]
            bend = (lines[:, first + 1] - lines[:, first]) - (lines[:, last] - lines[:, last - 1])
            heights_apart.append(np.mean(step**2) / (2 * np.var(heights)))
            slopes_apart.append(np.mean(bend**2) / (2 * np.mean(np.diff(whole, axis=1) ** 2)))
        assert candidate.parts["height_mismatch"] == pytest.approx(np.mean(heights_apart))
        assert candidate.parts["slope_mismatch"] == pytest.approx(np.mean(slopes_apart))
        assert candidate.parts["missing"] == pytest.approx(filled[box(candidate)].mean())
        ratio = 160 * 160 / (candidate.sides[0] * candidate.sides[1])
        assert candidate.parts["size"] == pytest.approx(np.sqrt(ratio) - 1)


def test_mismatch_of_noise_is_one_and_of_whole_periods_zero():
    noise = np.random.default_rng(0).standard_normal((200, 200))
    found = search(noise, ((0, 0), (180, 180)))
    assert np.mean([c.parts["height_mismatch"] for c in found]) == pytest.approx(1.0, abs=0.1)
    wave = np.cos(2 * np.pi * np.arange(220) / 100)
    found = {c.sides: c for c in search(wave + wave[:, None], ((0, 0), (200, 200)))}
    assert found[200, 200].parts["height_mismatch"] < 0.1  # one pixel on
    assert found[200, 200].parts["slope_mismatch"] < 0.1


def test_stationarity_and_representativeness_of_a_map_with_two_halves():
    """Amplitudes 1 and 2: ln 2 / 2 from quarter to quarter, ln(amplitude / rms of both) in one half."""
    noise = np.random.default_rng(1).standard_normal((200, 400))
    noise[:, 200:] *= 2
    middle = next(c for c in search(noise, ((0, 100), (200, 200)), fade=0.0) if c.start == (0, 100))
    assert middle.parts["stationarity"] == pytest.approx(np.log(2) / 2, rel=0.05)
    assert middle.parts["representativeness"] == pytest.approx(0.0, abs=0.02)
    left = next(c for c in search(noise, ((0, 0), (200, 200)), fade=0.0) if c.start == (0, 0))
    assert left.parts["stationarity"] < 0.05
    assert left.parts["representativeness"] == pytest.approx(0.5 * np.log(2.5), rel=0.05)


@pytest.mark.parametrize("period", [17.3, 24.0, 37.6])
def test_lay_period_of_grooves(period):
    values = grooves((120, 256), period)
    assert lay_period(values, 1) == pytest.approx(period, rel=0.01)
    assert lay_period(values, 0) is None
    assert lay_period(values.T, 0) == pytest.approx(period, rel=0.01)


def test_rough_surfaces_have_no_lay_period():
    found = [lay_period(rough((512, 512), seed)[:200, :256], axis) for seed in range(8) for axis in (0, 1)]
    assert sum(period is not None for period in found) <= 1
    assert lay_period(np.zeros((30, 40)), 1) is None


def test_sides_are_whole_numbers_of_the_lay_period():
    period = 37.6
    height = height_map(grooves((300, 290), period), 1e-6)
    window = periodic_window(level(height, outlier_threshold=None), placement="search")
    periods = window.shape[1] / period
    assert abs(periods - round(periods)) <= 0.1
    largest = periodic_window(level(height, outlier_threshold=None))
    assert abs(largest.shape[1] / period - round(largest.shape[1] / period)) > 0.1
    scores = json.loads(window.attrs["window_scores"])
    assert (
        scores[0]["height_mismatch"]
        < 0.2
        < next(s for s in scores if s["largest_rectangle"])["height_mismatch"]
    )


def test_a_filled_hole_near_the_edge_is_mostly_left_out():
    values = rough((512, 512), seed=2)[:300, :300]
    values[60:240, 230:290] = np.nan
    levelled = level(height_map(values, 1e-6), outlier_threshold=None)
    window = periodic_window(levelled, placement="search")
    assert window["filled"].mean() < 0.3 * periodic_window(levelled)["filled"].mean()
    assert "the best score of the search" in window.attrs["window_reason"]


def test_the_record_says_where_the_window_lies():
    levelled = level(height_map(rough((512, 512), seed=5)[:282, :300], (2e-6, 1e-6)))
    window = periodic_window(levelled, placement="search", method="cross-fade")
    scores = json.loads(window.attrs["window_scores"])
    assert tuple(scores[0]["points"]) == window.shape
    for axis, offset in zip("yx", scores[0]["offset"], strict=True):
        assert offset == pytest.approx(window.attrs[f"window_offset_{axis}"], abs=1e-12)
        assert offset == pytest.approx(float(window[axis][0] - levelled[axis][0]), abs=1e-12)
    assert sum(s["largest_rectangle"] for s in scores) == 1
    margin = [round(0.1 * n) for n in window.shape]
    inner = tuple(slice(m, n - m) for m, n in zip(margin, window.shape, strict=True))
    same = levelled.sel(y=window["y"], x=window["x"], method="nearest", tolerance=1e-12)
    np.testing.assert_allclose(window.values[inner], same.values[inner], atol=1e-13)


def test_search_costs_less_than_one_solve():
    """Points that the search sums up, against the points that the transforms of a solve go over.

    Every operator application transforms the map forth and back; a transform costs more than a sum.
    """
    levelled = level(height_map(rough((500, 500), seed=1)[:250, :250], 1.0), outlier_threshold=None)
    with mock.patch.object(score, "_running_sums", wraps=score._running_sums) as sums:
        found = search(levelled.values, ((0, 0), (216, 216)))
    summed = sum(call.args[0].size for call in sums.call_args_list)
    assert len(found) >= 25  # the best places of as many sizes, of 26 x 26 pairs of ranges
    window = periodic_window(levelled, placement="search")
    solved = solve_contact(window, contact_modulus=1.0, mean_pressure=0.1)
    transformed = 2 * float(solved["operator_applications"].sum()) * window.size
    assert 0 < summed < 0.2 * transformed
    # whatever the number of candidates: the sums of one candidate alone are hardly fewer
    with mock.patch.object(score, "_running_sums", wraps=score._running_sums) as alone:
        one = score.Ranges(np.array([0]), np.array([216]), np.array([22]))
        score.score_parts(levelled.values, np.zeros(levelled.shape), one, one, 216**2)
    assert summed < 1.6 * sum(call.args[0].size for call in alone.call_args_list)


def test_the_sides_and_places_that_are_tried():
    """Five good sides of 0.7 and more of the longest, and five places from end to end, along each axis."""
    values = rough((600, 600), seed=6)[:220, :220]
    found = search(values, ((0, 0), (200, 200)), fade=0.0)
    good = [n for n in range(140, 201) if is_friendly(n)]
    assert (good[0], good[-1]) == (144, 200)  # 140 has the factor 7
    picked = {good[i] for i in (0, len(good) - 1)}
    for axis in (0, 1):
        sides = {c.sides[axis] for c in found}
        assert len(sides) == 5
        assert picked < sides <= set(good)
        for candidate in found:
            spare = 220 - candidate.sides[axis]
            assert candidate.start[axis] in np.round(np.linspace(0, spare, 5))
    assert len({c.start[1] for c in found if c.sides[1] == 144}) > 1


def test_sides_are_tried_down_to_a_share_of_the_longest():
    """0.7 x 90 = 63; 64 and not 60 is the shortest side."""
    assert min(c.sides[0] for c in search(rough((300, 300))[:90, :90], ((0, 0), (90, 90)), fade=0.0)) == 64
    found = search(rough((400, 400))[:80, :80], ((0, 0), (80, 80)), fade=0.0)  # 56 is no good side
    assert min(c.sides[0] for c in found) == 60


def test_the_shortest_side_is_rounded_up():
    """0.7 x 46 = 32.2: 32 would be a good side, but the next one is 36."""
    assert min(c.sides[0] for c in search(rough((90, 90))[:46, :46], ((0, 0), (46, 46)), fade=0.0)) == 36


def test_a_side_is_a_whole_number_of_periods_to_a_tenth():
    """Of the good sides of 63 to 90 points 80 is 4.07 and 81 is 4.12 of the periods that are found."""
    values = np.cos(2 * np.pi * np.arange(95) / 19.8) + np.zeros((95, 1))
    period = lay_period(values[:90, :90], 1)
    assert 0.1 < 81 / period - 4 < 0.13
    assert {c.sides[1] for c in search(values, ((0, 0), (90, 90)), fade=0.0)} == {80, 90}


@pytest.mark.parametrize(("power", "found"), [(0.25, False), (0.35, True)])
def test_a_lay_shows_in_the_autocorrelation_by_0_3(power, found):
    """The wave makes up this share of the power; the rest is noise, alike nowhere."""
    noise = np.random.default_rng(0).standard_normal((64, 4000))
    wave = np.sqrt(2) * np.cos(2 * np.pi * np.arange(4000) / 40)
    period = lay_period(np.sqrt(power) * wave + np.sqrt(1 - power) * noise, 1)
    assert (period == pytest.approx(40, rel=0.02)) if found else period is None


@pytest.mark.parametrize(("ratio", "period"), [(0.78, 40), (0.82, 20)])
def test_the_first_of_the_high_maxima_is_one_period_away(ratio, period):
    """cos(t) + a cos(2 t): the maximum after half a period is (a^2 - 1)/(a^2 + 1) as high as the next."""
    a = np.sqrt((1 + ratio) / (1 - ratio))
    t = 2 * np.pi * np.arange(8000) / 40
    assert lay_period((np.cos(t) + a * np.cos(2 * t))[None, :], 1) == pytest.approx(period, rel=0.01)


@pytest.mark.parametrize(("points", "found"), [(100, False), (104, True)])
def test_more_than_four_periods_must_fit(points, found):
    assert (lay_period(np.cos(2 * np.pi * np.arange(points) / 25)[None, :], 1) is not None) is found


def test_the_report_lists_the_scores():
    levelled = level(height_map(rough((512, 512), seed=5)[:282, :300], 1e-6))
    window = periodic_window(levelled, placement="search")
    table = score_table(window)
    best, scores = table["rows"][0], json.loads(window.attrs["window_scores"])
    assert len(table["rows"]) == len(scores)
    assert best["cells"][0] == f"{window.shape[1]} × {window.shape[0]}"
    assert best["cells"][2] == f"{scores[0]['score']:.3f}"
    assert best["words"].startswith("solved")
    assert sum("largest rectangle" in row["words"] for row in table["rows"]) == 1
    assert all(len(row["cells"]) == len(table["header"]) for row in table["rows"])
    assert score_table(periodic_window(levelled)) is None
