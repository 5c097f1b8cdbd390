"""The interval of the pixel size: it covers a finer solution, is not too wide, shrinks with the pixels."""

import numpy as np
import pytest
import xarray as xr

from roughcontact.contact.solve import solve_contact
from roughcontact.maps import height_map, refined, spacing
from roughcontact.references import closed_forms, synthetic
from roughcontact.uncertainty import discretisation
from roughcontact.uncertainty.answers import answers_present, headline_and_answers
from roughcontact.uncertainty.discretisation import discretisation_uncertainty, resolution_indicators
from roughcontact.uncertainty.headline import QUANTITIES, headline
from roughcontact.uncertainty.solver import solver_uncertainty
from roughcontact.validation.coverage import pixel_size_cases
from roughcontact.window.periodisation import periodic_plus_smooth

PROBLEM = {"contact_modulus": 1.0, "tolerance": 1e-4}


@pytest.fixture(scope="module")
def cases():
    return pixel_size_cases(12, seed=3)


@pytest.mark.parametrize("name", QUANTITIES)
def test_the_interval_of_the_pixel_size_covers_a_finer_solution(cases, name):
    half_width, error = cases[name]
    assert np.mean(error <= half_width) >= 0.9
    assert np.median(half_width / error) <= 3


def test_the_interval_covers_the_closed_form_of_ridges():
    amplitude, share = 0.01, 0.3
    load = share * np.pi * amplitude
    for points in (64, 128, 256):
        ridges = synthetic.westergaard_surface((1, points), 1 / points, amplitude=amplitude, wavelength=1.0)
        contact = PROBLEM | {"mean_pressure": [load]}
        solved = solve_contact(ridges, **contact, reduce=resolution_indicators)
        half_widths = discretisation_uncertainty(ridges, contact=contact, solved=solved)
        true_area = 2 / np.pi * np.arcsin(np.sqrt(share))
        found = float(solved["relative_contact_area"][0])
        assert abs(found - true_area) <= float(half_widths["relative_contact_area"][0]) < 0.1
    assert closed_forms.westergaard_contact_share(share) == pytest.approx(true_area)


def test_the_interval_shrinks_with_the_pixels():
    loads = [0.05, 0.3]
    widths = []
    for points in (64, 256):
        window = synthetic.rough_reference_surface(points)
        found = discretisation_uncertainty(window, contact=PROBLEM | {"mean_pressure": loads})
        widths.append([found[name].values for name in QUANTITIES])
    assert np.all(np.array(widths[1]) < 0.6 * np.array(widths[0]))


def test_of_a_large_window_a_part_is_refined(monkeypatch):
    window = synthetic.self_affine_surface(
        (96, 128), 1.0, hurst=0.8, shortest=8.0, longest=32.0, rms_gradient=0.5, seed=1
    )
    contact = PROBLEM | {"mean_pressure": [0.05, 0.2]}
    solved = solve_contact(window, **contact, reduce=resolution_indicators)
    fine = solve_contact(refined(window, 4), **contact, reduce=resolution_indicators)
    monkeypatch.setattr(discretisation, "_MAX_POINTS", 64 * 96)
    assert discretisation._subwindow(window, solved["place_of_the_peak"].values).shape == (96, 64)
    part = discretisation_uncertainty(window, contact=contact, solved=solved)
    for name in QUANTITIES:
        error = np.abs(solved[name] - fine[name])
        assert np.all(error <= part[name] + 1e-3 * fine[name]), name
        assert np.all(part[name] < 0.3 * fine[name]), name


def test_the_peak_stands_out_from_its_neighbours():
    pressure = np.zeros((4, 5))
    pressure[0, 0], pressure[3, 0], pressure[1, 0], pressure[0, 4], pressure[0, 1] = 8, 4, 2, 1, 1
    assert discretisation._peak_drop(pressure, (0, 0)) == 6
    assert discretisation._peak_drop(pressure[:1], (0, 0)) == 7
    both_along_y = pressure[[0, 3]]  # are the same
    assert discretisation._peak_drop(both_along_y, (0, 0)) == 5.5


def test_full_contact_that_a_finer_grid_does_not_have_keeps_its_gap():
    """Between the points of the map the heights lie lower: there a gap opens on the finer grid."""
    window = synthetic.self_affine_surface(
        (1, 200), 1.0, hurst=0.8, shortest=2.0, longest=50.0, rms_height=1.0, seed=4
    )
    wavenumbers = 2 * np.pi * np.abs(np.fft.fftfreq(window.size))
    load = -1.001 * np.fft.ifft(0.5 * wavenumbers * np.fft.fft(window.values[0])).real.min()
    problem = {"contact_modulus": 1.0, "mean_pressure": [load]}
    assert solve_contact(window, **problem)["contact"].all()
    finer = solve_contact(refined(window, 2), **problem, reduce=resolution_indicators)
    assert finer["mean_gap"] > 0
    found = discretisation_uncertainty(window, contact=problem)
    assert found["mean_gap"].item() >= finer["mean_gap"].item()
    assert found["relative_contact_area"].item() >= 1 - finer["relative_contact_area"].item() > 0


def test_what_is_flat_has_no_error_of_the_pixel_size():
    flat = height_map(np.zeros((32, 32)), 1.0)
    found = discretisation_uncertainty(flat, contact=PROBLEM | {"mean_pressure": [1.0]})
    assert all(float(found[name][0]) == 0 for name in QUANTITIES)


def test_the_formulas_of_the_half_widths():
    """Each number from the two solutions by hand, as the head of the module states it."""
    window, loads = synthetic.rough_reference_surface(64), [0.05, 0.4]
    contact = PROBLEM | {"mean_pressure": loads}
    solved = solve_contact(window, **contact, reduce=resolution_indicators)
    fine = solve_contact(refined(window, 2), **contact)
    finer, certificate = headline(fine), solver_uncertainty(fine)
    found = discretisation_uncertainty(window, contact=contact)
    change = {name: 2 * abs(solved[name].values - finer[name].values) for name in QUANTITIES}
    switches = solved["switches"].values
    area = np.sqrt(
        change["relative_contact_area"] ** 2
        + (0.02 * switches / window.size) ** 2
        + (0.3 * np.sqrt(switches) / window.size) ** 2
    )
    share = solved["relative_contact_area"].values
    bias = abs(loads / share - solved["mean_contact_pressure"].values)
    expected = {
        "relative_contact_area": area,
        "mean_gap": np.hypot(change["mean_gap"], certificate["mean_gap"].values),
        "max_pressure": np.hypot(change["max_pressure"], 0.2 * solved["beside_the_peak"].values),
        "mean_contact_pressure": bias + loads * area / share**2,
        "mean_contact_pressure_bias": bias,
    }
    assert set(found) == set(expected)
    for name, values in expected.items():
        np.testing.assert_allclose(found[name], values, rtol=1e-9, err_msg=name)


def test_the_half_widths_of_answers_are_twice_the_largest_share_that_the_finer_grid_changes_at_loads_beside():
    window, loads = synthetic.rough_reference_surface(64), [0.01, 0.05, 0.4]
    contact = PROBLEM | {"mean_pressure": loads, "tolerance": 1e-6}

    def marks_and_answers(solution):
        return resolution_indicators(solution).merge(headline_and_answers(solution), compat="override")

    solved = solve_contact(window, **contact, reduce=marks_and_answers)
    finer = solve_contact(refined(window, 2), **contact, reduce=headline_and_answers)
    found = discretisation_uncertainty(window, contact=contact, solved=solved)
    assert answers_present(solved)
    for name in answers_present(solved):
        share = (abs(solved[name] - finer[name]) / solved[name]).values
        largest = np.array([max(share[:2]), max(share), max(share[1:])])
        np.testing.assert_allclose(found[name], 2 * largest * solved[name], rtol=1e-9, err_msg=name)
        assert (found[name] > 0).any()


@pytest.mark.parametrize(
    ("given", "used"), [({"tolerance": 1e-1}, 3e-4), ({"tolerance": 1e-6}, 1e-6), ({}, 3e-4)]
)
def test_the_finer_grid_is_solved_to_a_small_tolerance_of_its_own_at_most(monkeypatch, given, used):
    window = synthetic.rough_reference_surface(36)
    asked = []

    def recorded(*arguments, **keywords):
        asked.append((keywords["tolerance"], keywords["on_failure"]))
        return solve_contact(*arguments, **keywords)

    contact = {"contact_modulus": 1.0, "mean_pressure": [0.1]} | given
    solved = solve_contact(window, **contact, reduce=resolution_indicators)
    monkeypatch.setattr(discretisation, "solve_contact", recorded)
    discretisation_uncertainty(window, contact=contact, solved=solved)
    assert asked == [(used, "flag")]


def test_a_load_that_the_finer_grid_misses_has_no_interval():
    window, problem = synthetic.rough_reference_surface(36), {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    solved = solve_contact(window, **problem, reduce=resolution_indicators)
    found = discretisation_uncertainty(window, contact=problem | {"tolerance": 1e-15}, solved=solved)
    assert all(np.isnan(found[name]).all() for name in QUANTITIES)


def test_the_part_of_a_large_window_surrounds_the_peak_of_most_loads(monkeypatch):
    ramp = np.add.outer(1000.0 * np.arange(9), np.arange(12.0))
    window = height_map(ramp, (1.0, 2.0))
    places = np.array([0, 7 * 12 + 6, 7 * 12 + 6])
    monkeypatch.setattr(discretisation, "_MAX_POINTS", 9 * 12)
    assert discretisation._subwindow(window, places) is window
    monkeypatch.setattr(discretisation, "_MAX_POINTS", 9 * 12 - 1)
    part = discretisation._subwindow(window, places)
    assert part.shape == (9, 6)
    assert spacing(part) == (1.0, 2.0)
    monkeypatch.setattr(discretisation, "_MAX_POINTS", 9 * 6 - 1)
    part = discretisation._subwindow(window, places)
    assert part.shape == (5, 6)  # half of an odd side, rounded up
    around = ramp[[5, 6, 7, 8, 0]][:, 3:9]  # across the seam of the period
    np.testing.assert_allclose(part.values, periodic_plus_smooth(around, (1.0, 2.0)), rtol=1e-12, atol=1e-9)


def test_switches_and_peak_of_each_load():
    pressure = np.zeros((2, 3, 4))
    pressure[0, 1, 1], pressure[1, :, 2] = 8.0, 5.0
    fields = {"pressure": pressure, "gap": np.where(pressure > 0, 0.0, 1.0)}
    found = resolution_indicators(xr.Dataset({name: (("load", "y", "x"), v) for name, v in fields.items()}))
    np.testing.assert_array_equal(found["switches"], [4, 6])
    np.testing.assert_array_equal(found["beside_the_peak"], [8.0, 2.5])
    np.testing.assert_array_equal(found["place_of_the_peak"], [5, 2])
    np.testing.assert_array_equal(found["max_pressure"], [8.0, 5.0])


def test_a_window_of_1024_by_1024_points_is_refined_as_a_whole():
    window = height_map(np.zeros((1024, 1025)), 1.0)
    assert discretisation._subwindow(window[:, :1024], np.zeros(1, int)).shape == (1024, 1024)
    assert discretisation._subwindow(window, np.zeros(1, int)).shape == (1024, 513)
