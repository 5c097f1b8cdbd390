"""The answers in the error budget: conductance and narrowest places, their sources and their intervals."""

import numpy as np
import pytest
from scipy.special import stdtrit

import roughcontact as rc
from roughcontact.contact.solve import solve_contact
from roughcontact.maps import height_map
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.statistics.contact_statistics import with_uncertainty
from roughcontact.uncertainty.answers import ANSWERS, headline_and_answers, of_other_places
from roughcontact.uncertainty.budget import error_budget
from roughcontact.uncertainty.window_sampling import window_uncertainty

PITCH = 1e-6
CONTACT = {"contact_modulus": 2e9, "mean_pressure": [2e6, 2e7]}
BODIES = [{"thermal_conductivity": 50.0}, {"thermal_conductivity": 0.3}]


def surface(points, seed, longest=24e-6):
    return self_affine_surface(
        (points, points),
        (PITCH, PITCH),
        hurst=0.8,
        shortest=4e-6,
        longest=longest,
        rms_height=4e-7,
        seed=seed,
    )


def cut(height, points):
    """Return a piece of a surface, which is no longer periodic, levelled, and its window."""
    levelled = rc.level(height_map(height.values[:points, :points].copy(), PITCH))
    return levelled, rc.periodic_window(levelled)


@pytest.fixture(scope="module")
def budget():
    levelled, window = cut(surface(96, seed=1), 90)
    settings = {"level": {}, "window": {}, "contact": CONTACT}
    numbers = rc.contact_statistics(solve_contact(window, **CONTACT), bodies=BODIES)
    return error_budget(levelled, window, settings), numbers


@pytest.mark.parametrize("name", ANSWERS)
def test_an_answer_lies_in_its_interval(budget, name):
    found, numbers = budget
    value, lower, upper = (
        data.values for data in (numbers[name], found[f"{name}_lower"], found[f"{name}_upper"])
    )
    assert (lower >= 0).all()
    assert (lower < value).all()
    assert (value < upper).all()
    parts = found[f"{name}_uncertainty"]
    assert np.isnan(parts.sel(source="solver")).all()
    for source in ("discretisation", "window", "processing"):
        assert (parts.sel(source=source) > 0).all()
    assert (parts.sel(source="combined") >= parts.sel(source="window")).all()
    assert found[f"{name}_parts"].shape == (9, 2)


def test_what_is_counted_in_the_budget_is_what_the_statistics_count(budget):
    """The response is solved less tightly: its energy is minimal, so that the error is that squared."""
    levelled, window = cut(surface(96, seed=1), 90)
    found = solve_contact(window, **CONTACT, reduce=headline_and_answers)
    for name in ANSWERS[1:]:
        np.testing.assert_array_equal(found[name], budget[1][name])
    np.testing.assert_allclose(found[ANSWERS[0]], budget[1][ANSWERS[0]], rtol=2e-3)
    assert levelled.shape == (90, 90)


def test_the_interval_of_what_conducts_heat_is_that_of_the_constriction(budget):
    found, numbers = budget
    complete = with_uncertainty(numbers, found)
    mean = 2 / (1 / 50.0 + 1 / 0.3)
    for end in ("lower", "upper"):
        np.testing.assert_allclose(
            complete[f"thermal_conductance_{end}"], mean * found[f"{ANSWERS[0]}_{end}"], rtol=1e-12
        )


def test_full_contact_has_no_conductance_to_be_uncertain_of():
    window = surface(32, seed=3)
    loads = [1e6, 2e10]
    found = solve_contact(window, contact_modulus=2e9, mean_pressure=loads, reduce=headline_and_answers)
    assert np.isnan(found[ANSWERS[0]].values[1])
    assert found["critical_constriction_x"].values[1] == 0
    settings = {"level": {}, "window": {}, "contact": {"contact_modulus": 2e9, "mean_pressure": loads}}
    intervals = error_budget(rc.level(window), window, settings)
    assert np.isnan(intervals[f"{ANSWERS[0]}_upper"].values[1])
    assert intervals["critical_constriction_x_lower"].values[1] == 0


def test_numbers_drawn_from_a_law_are_held_as_often_as_is_said():
    """Parts of a log-normal answer without growth: t of Student holds another such part in 19 of 20 cases."""
    rng, cases = np.random.default_rng(4), 4000
    draws = rng.normal(size=(10, cases))
    factor = float(stdtrit(8, 0.975)) * np.sqrt(1 + 1 / 9)
    for name, law in ((ANSWERS[0], np.exp(0.2 * draws)), (ANSWERS[1], 10 + draws)):
        middle = np.exp(np.log(law[:9]).mean(axis=0)) if name == ANSWERS[0] else law[:9].mean(axis=0)
        down, up = of_other_places(name, law[:9], middle, factor=factor, growth=0.0)
        held = (middle - down <= law[9]) & (law[9] <= middle + up)
        assert held.mean() == pytest.approx(0.95, abs=0.015)


def test_growth_of_the_heights_widens_gaps_and_takes_conductance_away():
    parts, result = np.full((9, 1), 2.0), np.array([2.0])
    down, up = of_other_places(ANSWERS[0], parts, result, factor=1.0, growth=0.1)
    assert down[0] == pytest.approx(2 * (1 - np.exp(-0.15)))
    assert up[0] == 0
    down, up = of_other_places(ANSWERS[1], parts, result, factor=1.0, growth=0.1, added=np.array([0.3]))
    assert up[0] == pytest.approx(0.3)
    assert down[0] == 0


def test_what_changed_from_the_parts_to_the_window_may_go_on_either_way():
    parts, result = np.full((9, 1), 1.0), np.array([2.0])
    down, up = of_other_places(ANSWERS[0], parts, result, factor=1.0, growth=0.0, going_on=0.5)
    assert up[0] == pytest.approx(2 * (np.sqrt(2) - 1))
    assert down[0] == pytest.approx(2 * (1 - np.sqrt(0.5)))
    down, up = of_other_places(ANSWERS[1], parts, result, factor=1.0, growth=0.0, going_on=0.5)
    assert down[0] == up[0] == pytest.approx(0.5)
    down, _ = of_other_places(ANSWERS[1], parts, result, factor=1.0, growth=0.0, going_on=5.0)
    assert down[0] == 2.0  # no narrower than closed


def test_a_gap_that_higher_heights_open_is_known_to_be_open_elsewhere():
    """A closed gap has nothing to scale; the window with higher heights is solved, and its gap counted."""
    levelled, window = cut(surface(288, seed=4, longest=288e-6), 96)
    problem = {"contact_modulus": 2e9, "mean_pressure": [3e7, 4e7]}
    solved = solve_contact(window, **problem, reduce=headline_and_answers)
    found = window_uncertainty(levelled, window={}, contact=problem, solved=solved)
    higher = window * found.attrs["growth"]
    grown = solve_contact(higher, **problem, tolerance=1e-2, reduce=headline_and_answers)
    for name in ANSWERS[1:]:
        assert (solved[name] == 0).all()
        assert (grown[name] > 1e-7).all()
        assert (found[f"{name}_up"] >= 1.25 * grown[name] * (1 - 1e-9)).all()


@pytest.mark.slow
def test_intervals_hold_the_answers_of_the_surface_three_times_as_long():
    held = {name: [] for name in ANSWERS}
    for seed in range(8):
        whole = surface(192, seed=seed)
        levelled, window = cut(whole, 64)
        problem = {"contact_modulus": 2e9, "mean_pressure": [4e6, 4e7]}
        truth = solve_contact(whole, **problem, tolerance=1e-3, reduce=headline_and_answers)
        found = error_budget(levelled, window, {"level": {}, "window": {}, "contact": problem})
        for name, inside in held.items():
            lower, upper = (found[f"{name}_{end}"].values for end in ("lower", "upper"))
            inside.extend((lower <= truth[name].values) & (truth[name].values <= upper))
    for name, inside in held.items():
        assert np.mean(inside) >= 0.85, name
