"""What the certificate says of each number: it covers the difference from a converged solution."""

import numpy as np
import pytest

from roughcontact import contact_statistics, solve_contact
from roughcontact.surface import synthetic
from roughcontact.uncertainty.budget_inputs import budget_inputs, points_within_reach, solver_uncertainty
from roughcontact.uncertainty.discretisation import CORRECTED

SHAPES = ((32, 32), (64, 64), (40, 96), (1, 128))


def rough(index):
    """Return one of many maps: profiles, oblong ones, smooth ones, some with noise on every point."""
    generator = np.random.default_rng(index)
    shape = SHAPES[index % len(SHAPES)]
    height = synthetic.self_affine_surface(
        shape,
        1 / shape[1],
        hurst=generator.uniform(0.1, 1),
        shortest=generator.uniform(2.2, 10) / shape[1],
        longest=generator.uniform(0.35, 1),
        rms_gradient=1.0,
        seed=index,
    )
    if index % 5 == 4:
        height = height + 0.3 / shape[1] * generator.standard_normal(shape)
    return height


def widths_of(contact):
    return solver_uncertainty(contact, energy=contact_statistics(contact)["elastic_energy"].values)


def test_the_interval_of_the_solver_covers_converged_solutions():
    inside, gap_shares = {name: [] for name in CORRECTED}, []
    for index in range(24):
        window = rough(index)
        loads = np.exp(np.random.default_rng(index).uniform(np.log(0.01), np.log(1.0), 3))
        problem = {"contact_modulus": 1.0, "mean_pressure": list(loads)}
        truth = solve_contact(window, **problem, tolerance=1e-9, reduce=budget_inputs)
        for tolerance in (1e-1, 1e-2, 1e-3, 1e-4):
            contact = solve_contact(window, **problem, tolerance=tolerance)
            inputs, half_widths = budget_inputs(contact), widths_of(contact)
            for name, width in half_widths.items():
                error = np.abs(inputs[name].values - truth[name].values)
                inside[name].append(error <= width + 1e-9 * truth[name].values)
            # a quarter of the proved bound is used: the bound itself holds without exception
            error = np.abs(inputs["mean_gap"].values - truth["mean_gap"].values)
            gap_shares.append(error <= 4 * half_widths["mean_gap"] + 1e-12)
    assert np.all(gap_shares)
    for name, cases in inside.items():
        assert np.mean(cases) >= 0.95, name


def test_the_formulas_at_a_solution():
    contact = solve_contact(rough(1), contact_modulus=3.0, mean_pressure=[0.1, 0.6], tolerance=1e-2)
    statistics, half_widths = contact_statistics(contact), widths_of(contact)
    bound = contact["error_bound"]
    np.testing.assert_allclose(
        half_widths["mean_gap"], bound * statistics["elastic_energy"] / contact["mean_pressure"], rtol=1e-12
    )
    np.testing.assert_allclose(
        half_widths["max_pressure"], 3 * bound * statistics["max_pressure"], rtol=1e-12
    )
    points = [
        points_within_reach(pressure, gap, 3 * error)
        for pressure, gap, error in zip(
            contact["pressure"].values, contact["gap"].values, bound.values, strict=True
        )
    ]
    share = np.array(points) / contact["pressure"][0].size
    np.testing.assert_allclose(half_widths["relative_contact_area"], share, rtol=1e-12)


def test_points_within_reach_are_those_near_the_edge_of_the_contact():
    pressure = np.array([[10.0, 0.02, 0.0, 0.0]])
    gap = np.array([[0.0, 0.0, 0.001, 2.0]])
    # reach of the pressure: 0.01 x 5 = 0.05; of the gap: 0.01 x 1 = 0.01
    assert points_within_reach(pressure, gap, 0.01) == 2
    assert points_within_reach(pressure, gap, 1e-6) == 0


def test_what_lies_at_the_reach_is_not_within_it():
    pressure, gap = np.array([[8.0, 0.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 0.0, 2.0]])
    # rms pressure 4, rms gap 1: the reach of the gap is the bound itself
    assert points_within_reach(pressure, gap, 1.0) == 2  # the two closed points
    assert points_within_reach(pressure, gap, 2.0) == 2  # the open one lies at its reach, as does the peak
    assert points_within_reach(pressure, gap, np.nextafter(2.0, 3.0)) == 4


def test_full_contact_has_no_gap_to_be_uncertain_of():
    contact = solve_contact(rough(0), contact_modulus=1.0, mean_pressure=50.0)
    half_widths = widths_of(contact)
    assert float(half_widths["relative_contact_area"][0]) == 0
    assert float(half_widths["mean_gap"][0]) == pytest.approx(0, abs=1e-12)
