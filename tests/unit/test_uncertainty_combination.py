"""Combination on the scales of the quantities, by hand: arms, shifts, limits, one load by another."""

import numpy as np
import pytest
from scipy import special

from roughcontact.uncertainty import combination
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, GAP, PEAK, PRESSURE, from_scale, to_scale

ONE, NONE = np.ones(1), np.zeros(1)


def test_half_widths_add_as_squares_and_shifts_as_they_are():
    """Logarithms of 3 and 4 are 5 together; a shift of 1 upwards comes on top."""
    parts = [
        combination.half_widths(3 * ONE, 3 * ONE),
        combination.half_widths(4 * ONE, 4 * ONE),
        combination.one_sided(ONE),
    ]
    lower, upper = combination.interval_bounds(GAP, NONE, combination.added_up(parts))
    assert (lower.item(), upper.item()) == pytest.approx((np.exp(-5), np.exp(6)))


def test_the_area_is_combined_as_its_inverse_error_function():
    middle = to_scale(AREA, np.array([0.2]))
    lower, upper = combination.interval_bounds(AREA, middle, combination.half_widths(0.3 * ONE, 0.4 * ONE))
    x = special.erfinv(0.2)
    bounds = special.erf(x * np.exp(-0.3)), special.erf(x * np.exp(0.4))
    assert (lower.item(), upper.item()) == pytest.approx(bounds)
    assert from_scale(AREA, middle + 50).item() <= 1


@pytest.mark.parametrize(
    ("arms", "expected_bounds"),
    [
        ((3.0, 4.0), (-5.0, np.hypot(4, 4))),  # beside a half-width of 4
        ((-1.0, 4.0), (1 - 4.0, 1 + np.hypot(4, 3))),  # the truth lies 1 to 4 above: the result moves to 1
        ((4.0, -1.0), (-1 - np.hypot(4, 3), -1 + 4.0)),
    ],
)
def test_arms_beside_the_result_move_it_to_the_nearer_end(arms, expected_bounds):
    window = combination.half_widths(*(arm * ONE for arm in arms))
    interval = combination.interval_bounds(
        GAP, NONE, combination.added_up([combination.half_widths(4 * ONE, 4 * ONE), window])
    )
    assert [np.log(bound.item()) for bound in interval] == pytest.approx(expected_bounds)


def test_infinite_arms_leave_the_physical_limits():
    load, value = np.array([0.1]), {AREA: 0.2, GAP: 1.0, PEAK: 3.0, PRESSURE: 0.5, CONSTRICTIONS[0]: 2.0}
    limits_by_name = {AREA: (0, 1), GAP: (0, np.nan), PEAK: (0.1, np.nan), PRESSURE: (0.1, np.nan)}
    for name, limits in (limits_by_name | {CONSTRICTIONS[0]: (0, np.nan)}).items():
        result = np.array([value[name]])
        bounds = combination.interval_bounds(
            name, to_scale(name, result), combination.half_widths(np.inf * ONE, np.inf * ONE)
        )
        bounds = combination.limited(name, bounds, value=result, load=load, hardness=np.inf)
        np.testing.assert_array_equal(np.concatenate(bounds), limits)
    _, upper = combination.limited(PEAK, (ONE, 20 * ONE), value=3 * ONE, load=load, hardness=10.0)
    assert upper.item() == 10


def test_one_load_bounds_the_others_as_far_as_the_quantity_is_monotonic():
    load = np.array([2.0, 1.0, 3.0])
    lower, upper = np.array([0.3, 0.4, 0.2]), np.array([0.9, 0.5, 0.6])
    rising = combination.monotonic(AREA, (lower, upper), load)
    np.testing.assert_array_equal(rising, [[0.4, 0.4, 0.4], [0.6, 0.5, 0.6]])
    falling = combination.monotonic(GAP, (lower, upper), load)
    np.testing.assert_array_equal(falling, [[0.3, 0.4, 0.2], [0.5, 0.5, 0.5]])
    assert combination.monotonic(PRESSURE, (lower, upper), load) == (lower, upper)


def test_units_and_scales_are_the_same_half_widths():
    sides = combination.half_widths(ONE, 2 * ONE) + combination.one_sided(np.inf * ONE)
    component = combination.component_from_units(GAP, np.array([2.0]), sides)
    assert [side.item() for side in component] == pytest.approx([np.log(2), np.log(2), 0, np.inf])
