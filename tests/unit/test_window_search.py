"""The search for the window: each part of the score against its definition, and what it prefers."""

import json
import time

import numpy as np
import pytest

from roughcontact.contact.solve import solve_contact
from roughcontact.levelling.level import level
from roughcontact.maps import height_map
from roughcontact.references import synthetic
from roughcontact.report.tables import score_table
from roughcontact.window.lay import lay_period
from roughcontact.window.periodic_window import periodic_window
from roughcontact.window.score import WEIGHTS
from roughcontact.window.search import SHORTEST_SIDE, search_window
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
        assert all(n >= SHORTEST_SIDE * m for n, m in zip(candidate.sides, largest[1], strict=True))
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
    """The least of some times, so that other work on the machine does not count."""
    levelled = level(height_map(rough((900, 900), seed=1)[:450, :450], 1.0), outlier_threshold=None)

    def least(job, repeats):
        times = []
        for _ in range(repeats):
            begin = time.perf_counter()
            job()
            times.append(time.perf_counter() - begin)
        return min(times)

    searched = least(lambda: search(levelled.values, ((0, 0), (400, 400))), 10)
    window = periodic_window(levelled, placement="search")
    solved = least(lambda: solve_contact(window, contact_modulus=1.0, mean_pressure=0.1), 3)
    assert searched < solved


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
