"""The answers in the error budget: conductance and narrowest places, their sources and their intervals."""

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact.contact.solve import solve_contact
from roughcontact.maps import height_map
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.report.glance import _seals, glance_units
from roughcontact.results.comparison import _half_width
from roughcontact.statistics.contact_statistics import with_uncertainty
from roughcontact.uncertainty.budget import error_budget
from roughcontact.uncertainty.headline import headline_and_answers
from roughcontact.uncertainty.sample import constrictions_in_grooves
from roughcontact.uncertainty.scales import ANSWERS

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
    for source in ("discretisation", "window"):
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


def groove(points, slope):
    """Return a rough plane with one groove that climbs by `slope` rows a column, and is not periodic."""
    rows, columns = np.mgrid[:points, :points]
    heights = surface(points, seed=2).values
    return heights - 4e-6 * np.exp(
        -((((rows - slope * columns) + 3 * points) % points - points / 2) ** 2) / 8
    )


@pytest.mark.parametrize("slope", [0.0, 0.4])
def test_a_groove_that_leaves_the_map_has_no_bound_upwards(slope):
    """At 0 it matches itself at the seam, at 0.4 it does not; along y there is none."""
    levelled = rc.level(height_map(groove(96, slope), PITCH))
    window = rc.periodic_window(levelled)
    assert constrictions_in_grooves(window) == [ANSWERS[1]]
    settings = {"level": {}, "window": {}, "contact": CONTACT}
    found = error_budget(levelled, window, settings, sources=["solver", "window"])
    along, across = ANSWERS[1:]
    assert np.isnan(found[f"{along}_upper"]).all()
    assert np.isnan(found[f"{along}_uncertainty"].sel(source="combined")).all()
    assert np.isfinite(found[f"{along}_lower"]).all()
    assert np.isfinite(found[f"{across}_upper"]).all()
    assert "lead out of the map along x:" in found.attrs["window_reason"]


def test_the_table_says_or_more_where_there_is_no_bound_and_doubts_a_closed_gap():
    found = {"gap_percolates_x": [1.0, 0.0], "gap_percolates_y": [0.0, 0.0], "mean_gap": [2e-6, 1e-6]}
    found |= {"critical_constriction_x": [1e-6, 0.0], "critical_constriction_y": [0.0, 0.0]}
    found |= {
        "critical_constriction_x_lower": [0.8e-6, 0.0],
        "critical_constriction_x_upper": [np.nan, np.nan],
    }
    numbers = xr.Dataset({name: ("load", values) for name, values in found.items()})
    leaks, seals = (_seals(numbers, *glance_units([numbers]), place) for place in (0, 1))
    assert leaks.text == "seals along y, leaks along x"
    assert leaks.more.replace("\N{NO-BREAK SPACE}", " ") == "narrowest place 1.00 (0.80 or more) µm (x)"
    assert seals.text == "seals (in doubt)"
    doubted = "gap closed along x and y; narrowest place 0 or more µm (x)"
    assert seals.more.replace("\N{NO-BREAK SPACE}", " ") == doubted
    rates = {"leak_rate_x": [1e-12, 0.0], "leak_rate_y": [0.0, 0.0]}
    rates |= {"leak_rate_x_lower": [0.0, 0.0], "leak_rate_x_upper": [9.2e-11, 9.2e-11]}
    numbers = numbers.assign({name: ("load", values) for name, values in rates.items()})
    leaks, seals = (_seals(numbers, *glance_units([numbers]), place).more for place in (0, 1))
    assert leaks.startswith("leak rate 0.0036 (0 to 0.33)\N{NO-BREAK SPACE}ml/(h m) (x); narrowest")
    assert "; leak rate 0.00 +0.33\N{NO-BREAK SPACE}ml/(h m) (x); narrowest" in seals


def test_two_runs_do_not_differ_where_one_of_them_has_no_bound():
    """The narrowest place of the new run is above that of the old one, whose grooves leave the map."""
    name = ANSWERS[1]

    def run(value, lower, upper):
        known = {name: value, f"{name}_lower": lower, f"{name}_upper": upper, "mean_pressure": 1e6}
        half_widths = ("source", [upper - value])
        return xr.Dataset(known | {f"{name}_uncertainty": half_widths}, coords={"source": ["combined"]})

    old, new = run(1e-6, 0.8e-6, np.nan), run(5e-6, 4.9e-6, 5.1e-6)
    assert _half_width(old, name, 5e-6) == np.inf
    assert _half_width(old, name, 0.5e-6) == pytest.approx(0.2e-6)
    assert _half_width(new, name, 1e-6) == pytest.approx(0.1e-6)


def test_the_leak_rate_goes_as_the_cube_of_the_narrowest_place_and_a_closed_one_as_plates():
    levelled, window = cut(surface(96, seed=1), 90)
    seal = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 1e-3}
    problem = {"contact_modulus": 2e9, "mean_pressure": [2e6, 1e8]}
    numbers = rc.contact_statistics(solve_contact(window, **problem), seal=seal)
    found = error_budget(levelled, window, {"level": {}, "window": {}, "contact": problem})
    complete = with_uncertainty(numbers, found)
    narrowest, leak = numbers["critical_constriction_x"].values, numbers["leak_rate_x"].values
    assert narrowest[0] > 0 == narrowest[1] == leak[1]
    for end in ("lower", "upper"):
        height, of_leak = (
            complete[f"{name}_{end}"].values for name in ("critical_constriction_x", "leak_rate_x")
        )
        assert of_leak[0] ** (1 / 3) / height[0] == pytest.approx(leak[0] ** (1 / 3) / narrowest[0])
        assert of_leak[1] == pytest.approx(height[1] ** 3 * 1e5 / (12 * 1e-3 * 1e-3))
    assert complete["leak_rate_x_lower"][0] < leak[0] < complete["leak_rate_x_upper"][0]


def test_a_profile_has_no_grooves_that_leave_it():
    assert constrictions_in_grooves(height_map(np.cos(np.arange(64) / 9)[None, :], PITCH)) == []
