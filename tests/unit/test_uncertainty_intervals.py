"""The intervals end to end: coverage of known surfaces, the measurands, limits, laws, words of errors."""

import numpy as np
import pytest
from known_surfaces import contact, self_affine, surface

from roughcontact import SettingsError, error_budget, height_map, level, periodic_window, solve_contact
from roughcontact.uncertainty.budget_inputs import budget_inputs
from roughcontact.uncertainty.scales import AREA, GAP, PEAK, PRESSURE, QUANTITIES, from_scale, to_scale

MEASURANDS = ("", "next_", "octave_", "map_")


def budget_of(heights, problem, *, step=1.0, **options):
    levelled = level(height_map(np.array(heights), step))
    settings = {"level": {}, "window": {}, "contact": problem}
    return error_budget(levelled, periodic_window(levelled), settings, **options)


def ends(result, name, measurand=""):
    return [result[f"{name}_{measurand}{side}"].values for side in ("lower", "upper")]


@pytest.fixture(scope="module")
def heights():
    return surface(128, longest=24.0, seed=41).values[:80, :84]


@pytest.fixture(scope="module")
def budget(heights):
    return budget_of(heights, contact(0.3, 0.03))


def covered(seeds):
    """Return the share of intervals that hold the mean of four maps of a surface, for each quantity."""
    inside = {name: [] for name in QUANTITIES}
    for seed in seeds:
        large_surface, problem = (
            surface(192, longest=24.0, seed=1000 + seed, hurst=0.5 + 0.1 * (seed % 5)),
            contact(0.05),
        )
        maps = [large_surface.values[y : y + 64, x : x + 64] for y in (0, 100) for x in (0, 100)]
        rows = [
            solve_contact(periodic_window(level(height_map(m, 1.0))), **problem, reduce=budget_inputs)
            for m in maps
        ]
        result = budget_of(
            large_surface.values[50:114, 50:114], problem, sources=["solver", "discretisation", "window"]
        )
        truths = {
            name: from_scale(name, np.mean([to_scale(name, row[name].values) for row in rows], axis=0))
            for name in QUANTITIES
        }
        # a mean over whole pixels is too low: the pressure in contact is the load over the area
        truths[PRESSURE] = np.array(problem["mean_pressure"]) / truths[AREA]
        for name, is_inside in inside.items():
            truth = truths[name]
            lower, upper = ends(result, name)
            is_inside.extend((lower <= truth) & (truth <= upper))
    return {name: np.mean(is_inside) for name, is_inside in inside.items()}


def test_intervals_hold_surfaces_that_were_not_in_the_bank():
    assert min(covered(range(4)).values()) >= 0.75


@pytest.mark.nightly
def test_nine_of_ten_intervals_hold():
    assert min(covered(range(40)).values()) >= 0.9


def test_the_result_lies_in_its_interval_and_the_next_map_in_a_wider_one(budget):
    for name in QUANTITIES:
        value = budget[f"{name}_estimate"].values
        for measurand in MEASURANDS[:2]:
            lower, upper = ends(budget, name, measurand)
            assert ((lower <= value) & (value <= upper)).all(), (name, measurand)
        (lower, upper), (low, high) = ends(budget, name), ends(budget, name, "map_")
        assert (high - low < upper - lower).all(), name


def test_the_pressure_in_contact_is_the_load_over_the_corrected_area(budget):
    load = budget["mean_pressure"].values
    np.testing.assert_allclose(
        budget[f"{PRESSURE}_estimate"], load / budget[f"{AREA}_estimate"].values, rtol=1e-12
    )


@pytest.mark.parametrize(("turn", "tolerance"), [(1, 2e-3), (-1, 0.1)])
def test_units_order_of_the_loads_and_a_half_turn_change_nothing(heights, budget, turn, tolerance):
    """Lengths 1e-6 times as large, loads in another order; turned, parts of uneven size lie elsewhere."""
    result = budget_of(1e-6 * heights[::turn, ::turn], contact(0.03, 0.3), step=1e-6)
    for name, unit in ((AREA, 1.0), (GAP, 1e-6), (PEAK, 1.0), (PRESSURE, 1.0)):
        for measurand in MEASURANDS:
            expected = unit * np.array(ends(budget, name, measurand))[:, ::-1]
            np.testing.assert_allclose(
                ends(result, name, measurand), expected, rtol=tolerance, err_msg=f"{name} {measurand}"
            )


@pytest.mark.parametrize("shape", [(1, 22), (20, 20)])
def test_a_map_too_small_for_parts_has_open_ends(shape):
    rough = self_affine((1 if shape[0] == 1 else 64, 64), 1.0, (4.0, 32.0), rms_gradient=0.1)
    result = budget_of(rough.values[: shape[0], : shape[1]], contact(0.05))
    assert "too small" in result.attrs["window_flag"]
    assert [bound.item() for bound in ends(result, AREA)] == [0, 1]
    assert np.isnan(ends(result, PEAK)[1]).all()
    assert np.isfinite(ends(result, PEAK, "map_")).all()


def test_full_contact_has_no_gap_and_the_hardness_is_a_limit(heights):
    full = budget_of(heights, contact(100.0))
    assert full[f"{GAP}_estimate"].item() == 0 == ends(full, GAP)[0].item()
    assert full[f"{AREA}_estimate"].item() == 1 == ends(full, AREA)[1].item()
    hard = budget_of(heights, contact(0.1) | {"hardness": 0.05})
    assert ends(hard, PEAK)[1].item() <= 0.05
    assert ends(hard, PRESSURE)[1].item() <= 0.05


def test_a_largest_pressure_at_the_hardness_stays_there():
    """The part of the window with finer pixels may be without the point that flows."""
    heights = self_affine((160, 160), 1.0, (3, 80), rms_gradient=0.1, seed=9).values
    for heaviest in (1e6, 2e7):
        problem = {"contact_modulus": 1e9, "hardness": 120e6, "mean_pressure": [2e5, 3e5, heaviest]}
        result = budget_of(heights, problem, sources=["solver", "discretisation"])
        assert (result[f"{PEAK}_as_solved"] == 120e6).all()
        np.testing.assert_allclose(result[f"{PEAK}_estimate"], 120e6, rtol=1e-12)
        assert (result[f"{PEAK}_upper"] == 120e6).all()


@pytest.mark.parametrize("load", [1e-4, 0.01, 0.9])
def test_the_area_carries_the_load_and_the_peak_is_no_less_than_the_mean(heights, load):
    """No point bears more than H: A ≥ p̄/H (Bowden and Tabor 1950), which the area of soft bodies is near."""
    hardness = 1e-3
    soft = budget_of(heights, contact(load) | {"hardness": hardness, "mean_pressure": [load * hardness]})
    min_area = load * (1 - 1e-9)
    for measurand in ("", "next_", "octave_", "map_"):
        assert ends(soft, AREA, measurand)[0].item() >= min_area
    area, pressure, peak = (soft[f"{name}_estimate"].item() for name in (AREA, PRESSURE, PEAK))
    assert min_area <= area <= 1.2 * load or load == 1e-4
    assert area * pressure == pytest.approx(load * hardness, rel=1e-6)
    assert pressure <= peak * (1 + 1e-9) <= hardness * (1 + 1e-6)
    single = budget_of(heights, contact(1.0) | {"mean_pressure": [1e-9]})  # one point touches
    assert single[f"{PEAK}_estimate"].item() >= single[f"{PRESSURE}_estimate"].item() * (1 - 1e-9)


def test_layers_and_profiles_have_intervals(heights):
    layer = {"youngs_modulus": 0.75, "poissons_ratio": 0.5, "thickness": 3.0}
    bodies = [{"youngs_modulus": 3.0, "poissons_ratio": 0.5, "layers": [layer]}]
    layered = {"bodies": bodies, "mean_pressure": [0.02]}
    profile = self_affine((1, 512), 1.0, (8.0, 64.0), rms_gradient=0.1, seed=3).values[:, :400]
    for values, problem in ((heights, layered), (profile, contact(0.1))):
        result = budget_of(values, problem, sources=["window"])
        for name in QUANTITIES:
            lower, upper = ends(result, name)
            assert (lower < upper).all()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"windows": 3}, "windows = 3: give a whole number of 4"),
        ({"sources": ["windows"]}, "did you mean 'window'"),
    ],
)
def test_what_cannot_be_asked_for_is_named(heights, options, words):
    with pytest.raises(SettingsError, match=words):
        budget_of(heights, contact(0.1), **options)
