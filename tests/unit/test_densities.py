"""Logarithmic bins and the densities in them: bounds, edges, values beyond either end."""

import numpy as np
import pytest

from roughcontact.statistics.densities import GAP_DECADES, PRESSURE_DECADES, density, logarithmic_edges


@pytest.mark.parametrize(("decades", "bins"), [(PRESSURE_DECADES, 20), (GAP_DECADES, 20), ((-2, 1), 1)])
def test_bounds_begin_at_zero_and_rise_by_the_same_factor(decades, bins):
    edges = logarithmic_edges(decades, bins)
    assert edges.size == (decades[1] - decades[0]) * bins + 2
    assert edges[0] == 0.0
    assert edges[1] == pytest.approx(10.0 ** decades[0], rel=1e-14)
    assert edges[-1] == pytest.approx(10.0 ** decades[1], rel=1e-14)
    np.testing.assert_allclose(edges[2:] / edges[1:-1], 10 ** (1 / bins), rtol=1e-13)


def test_six_decades_of_pressure_and_four_of_the_gap():
    """Bounds are part of the files: whoever compares two runs relies on them."""
    assert PRESSURE_DECADES == (-3, 3)
    assert GAP_DECADES == (-4, 0)


def test_a_value_on_a_bound_belongs_to_the_bin_above():
    edges = np.array([0.0, 1.0, 2.0, 4.0])
    np.testing.assert_array_equal(density(np.array([1.0]), edges), [0, 1, 0])
    np.testing.assert_array_equal(density(np.array([0.0]), edges), [1, 0, 0])
    np.testing.assert_array_equal(density(np.array([np.nextafter(1.0, 0)]), edges), [1, 0, 0])


def test_values_beyond_either_end_are_counted_in_the_outermost_bins():
    edges = np.array([0.0, 1.0, 2.0, 4.0])
    np.testing.assert_array_equal(density(np.array([4.0, 1e9, -1e-20, 3.0]), edges), [0.25, 0, 3 / 8])


def test_the_density_is_a_count_over_the_number_and_the_width():
    edges = np.array([0.0, 0.5, 2.5])
    np.testing.assert_allclose(density(np.array([0.1, 0.6, 0.7, 2.4]), edges), [0.5, 3 / 8], rtol=1e-15)


def test_nothing_has_no_density():
    values = density(np.array([]), np.array([0.0, 1.0, 2.0]))
    assert values.shape == (2,)
    assert np.isnan(values).all()
