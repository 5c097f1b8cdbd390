"""Loads left out: which, and what they take from those on both sides."""

import numpy as np
import pytest

from roughcontact.references import synthetic
from roughcontact.uncertainty import discretisation
from roughcontact.uncertainty.representative_loads import (
    interpolate_over_loads,
    maximum_of_neighbours,
    representative_loads,
)


@pytest.mark.parametrize("number", [1, 2, 3, 8, 40])
def test_a_load_left_out_lies_between_two_that_are_not_far_apart(number):
    load = np.geomspace(0.003, 0.3, number)
    chosen = representative_loads(load, load)
    assert {0, number - 1} <= {*chosen.tolist()}
    steps = np.diff(chosen)
    assert np.all((load[chosen[1:]] <= 4 * load[chosen[:-1]]) | (steps == 1))
    assert chosen.size <= max(3, 2 + np.log(100) / np.log(2))  # two steps in a row go beyond a factor of 4


def test_no_load_is_left_out_where_most_is_closed():
    load = np.geomspace(1, 1.5, 6)
    assert representative_loads(load, np.array([0.2, 0.3, 0.4, 0.6, 0.8, 1.0])).tolist() == [0, 2, 3, 4, 5]


def test_the_order_of_the_loads_does_not_matter():
    load, value = np.geomspace(1.0, 20.0, 7), np.linspace(1.0, 3.0, 7)
    mixed = np.array([3, 0, 6, 2, 5, 1, 4])
    chosen, of_mixed = (
        representative_loads(load, load / 100),
        representative_loads(load[mixed], load[mixed] / 100),
    )
    assert sorted(mixed[of_mixed]) == chosen.tolist()
    found = np.sin(load)
    for carry in (interpolate_over_loads, maximum_of_neighbours):
        expected = carry(found[chosen], chosen, load, value)
        again = carry(found[mixed][of_mixed], of_mixed, load[mixed], value[mixed])
        np.testing.assert_allclose(again, expected[mixed], rtol=1e-12)


def test_what_is_not_known_beside_a_load_is_not_known_there_and_nothing_else():
    load, chosen = np.geomspace(1.0, 64.0, 7), np.array([0, 2, 4, 6])
    found, value = np.array([0.1, np.nan, 0.1, 0.3]), np.ones(7)
    carried = maximum_of_neighbours(found, chosen, load, value)
    np.testing.assert_allclose(carried, [0.1, np.nan, np.nan, np.nan, 0.3, 0.3, 0.3])
    assert np.flatnonzero(np.isnan(interpolate_over_loads(found, chosen, load, value))).tolist() == [1, 2, 3]


def test_half_widths_at_loads_left_out_are_like_those_of_all_loads(monkeypatch):
    window = synthetic.rough_reference_surface(128)
    contact = {"contact_modulus": 1.0, "mean_pressure": np.geomspace(0.002, 0.1, 9).tolist()}
    few = discretisation.discretisation_uncertainty(window, contact=contact)
    monkeypatch.setattr(discretisation, "representative_loads", lambda load, share: np.arange(load.size))
    all_of_them = discretisation.discretisation_uncertainty(window, contact=contact)
    for name in ("relative_contact_area", "max_pressure", "mean_contact_pressure"):
        np.testing.assert_allclose(few[name], all_of_them[name], rtol=0.3, err_msg=name)
    assert np.all(few["mean_gap"] <= 2 * all_of_them["mean_gap"].max())
