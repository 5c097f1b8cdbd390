"""The two stiffnesses of a contact that yields: of unloading, and of further loading."""

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.response import linear_response
from roughcontact.surface.synthetic import self_affine_surface

MODULUS, GRADIENT, STEP = 1e9, 0.1, 2e-3


def rough(shape, spacing, seed):
    """Return a map with 12 points per shortest wave."""
    shortest = 12 * max(spacing)
    waves = {"shortest": shortest, "longest": 4 * shortest, "rms_gradient": GRADIENT}
    return self_affine_surface(shape, spacing, hurst=0.8, seed=seed, **waves)


def around(load, height, **settings):
    """Return the statistics at a load and just below and above it, and -dp̄/dū between these two."""
    loads = [load * (1 - STEP), load, load * (1 + STEP)]
    statistics = rc.contact_statistics(
        rc.solve_contact(height, contact_modulus=MODULUS, mean_pressure=loads, tolerance=1e-9, **settings),
        flow="never",
    )
    below, _, above = statistics["mean_gap"].values
    return statistics.isel(load=1), (loads[2] - loads[0]) / (below - above)


@pytest.mark.parametrize(
    ("shape", "spacing"), [((96, 96), (1e-6, 1e-6)), ((75, 90), (2e-6, 1e-6)), ((1, 1024), (1e-6, 1e-6))]
)
@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize(("load", "hardness"), [(0.05, 0.35), (0.2, 0.4), (0.1, 0.8)])
def test_further_loading_as_in_differences_of_solved_loads(shape, spacing, seed, load, hardness):
    """At constant hardness, with a tenth to nearly all of the load on points that have yielded."""
    unit = MODULUS * GRADIENT
    statistics, slope = around(load * unit, rough(shape, spacing, seed), hardness=hardness * unit)
    assert 0.05 < statistics["load_share_above_hardness"] < 0.98
    assert statistics["loading_stiffness"].item() == pytest.approx(slope, rel=0.015)
    assert statistics["contact_stiffness"].item() > 1.02 * slope


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_unloading_is_that_of_the_flattened_surface(seed):
    """Once flattened, the surface carries the same pressure without a limit, and answers elastically."""
    height, unit = rough((96, 96), (1e-6, 1e-6), seed), MODULUS * GRADIENT
    load, settings = 0.1 * unit, {"contact_modulus": MODULUS, "tolerance": 1e-9}
    solved = rc.solve_contact(height, mean_pressure=load, hardness=0.3 * unit, **settings)
    pressure = solved["pressure"].values[0]
    q = 2 * np.pi * np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(96, 1e-6)], indexing="ij"))
    q[0, 0] = np.inf
    displacement = np.fft.ifft2(2 / (MODULUS * q) * np.fft.fft2(pressure)).real
    flattened = height.copy(data=displacement + solved["approach"].item() - solved["gap"].values[0])
    assert (flattened - height).max() < 1e-6 * height.std()
    statistics = rc.contact_statistics(solved, flow="never")
    second_statistics, slope = around(load, flattened)
    assert second_statistics["max_pressure"].item() == pytest.approx(0.3 * unit, rel=1e-6)
    assert statistics["contact_stiffness"].item() == pytest.approx(slope, rel=0.01)
    assert statistics["loading_stiffness"].item() < 0.6 * slope
    np.testing.assert_array_equal(
        statistics["conductance_per_conductivity"], statistics["contact_stiffness"] / MODULUS
    )


def test_both_are_one_where_no_point_has_yielded():
    height, unit = rough((64, 64), (1e-6, 1e-6), 0), MODULUS * GRADIENT
    problem = {"contact_modulus": MODULUS, "mean_pressure": [0.02 * unit, 100 * unit]}
    hard = rc.solve_contact(height, hardness=1000 * unit, **problem)
    statistics = rc.contact_statistics(hard, flow="never")
    np.testing.assert_array_equal(statistics["loading_stiffness"], statistics["contact_stiffness"])
    assert statistics["contact_stiffness"][1] == np.inf  # full contact
    elastic = rc.contact_statistics(hard.drop_vars("hardness"), flow="never")
    assert "loading_stiffness" not in elastic
    np.testing.assert_array_equal(elastic["contact_stiffness"], statistics["contact_stiffness"])


def test_a_hardness_that_single_precision_rounds_is_met():
    """The pressure in the file is that of the solve: 0.35 is another number in single precision."""
    height, unit = rough((96, 96), (1e-6, 1e-6), 0), MODULUS * GRADIENT
    problem = {"contact_modulus": MODULUS, "mean_pressure": 0.05 * unit, "hardness": 0.35 * unit}
    double, single = (
        rc.contact_statistics(rc.solve_contact(height, precision=precision, **problem), flow="never")
        for precision in ("double", "single")
    )
    assert double["loading_stiffness"].item() == pytest.approx(single["loading_stiffness"].item(), rel=0.01)
    assert single["loading_stiffness"] < 0.8 * single["contact_stiffness"]


def test_where_all_of_the_contact_has_yielded_no_contact_set_tells():
    """More load comes onto points that do not touch yet."""
    height, unit = rough((64, 64), (1e-6, 1e-6), 0), MODULUS * GRADIENT
    solved = rc.solve_contact(height, contact_modulus=MODULUS, mean_pressure=0.1 * unit, hardness=0.2 * unit)
    solved["pressure"] = solved["pressure"].where(solved["pressure"] == 0, 0.2 * unit)
    statistics = rc.contact_statistics(solved, flow="never")
    assert np.isnan(statistics["loading_stiffness"].item())
    assert np.isfinite(statistics["contact_stiffness"].item())


def test_full_contact_does_not_give_way_whatever_has_yielded():
    touching = np.ones((8, 8), bool)
    yielded = np.arange(64).reshape(8, 8) < 20
    assert linear_response(touching, (1e-6, 1e-6), Elasticity(MODULUS), yielding=yielded) == (0, 0)
    with pytest.raises(ValueError, match="no point in contact is elastic"):
        linear_response(yielded, (1e-6, 1e-6), Elasticity(MODULUS), yielding=yielded)
