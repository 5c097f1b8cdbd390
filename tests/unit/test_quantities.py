"""Numbers as people read them: which prefix, how many digits, at which limits."""

import numpy as np
import pytest
import xarray as xr

from roughcontact.arguments.quantities import Unit, number, percent, prefix, quantity, with_interval


@pytest.mark.cases
def test_prefix(value, unit, factor, symbol):
    assert prefix(value, unit) == (factor, symbol)


@pytest.mark.cases
def test_ends_stand_with_their_unit_where_one_is_known(lower, upper, text):
    assert Unit(1e-6, "MPa").ends(lower, upper) == text


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(1.5, 2, "1.5 km"), (1.5, 3, "1.50 km"), (12.345, 3, "12.3 km"), (0.25, 3, "250 m")],
)
def test_kilometres(value, digits, text):
    assert quantity(1000 * value, "m", digits=digits) == text


@pytest.mark.cases
def test_number(value, digits, text):
    assert number(value, digits=digits) == text


@pytest.mark.cases
def test_plus_minus(value, half_width, text):
    assert with_interval(value, value - half_width, value + half_width) == text


@pytest.mark.cases
def test_with_interval(value, lower, upper, text):
    assert with_interval(value, lower, upper) == text


@pytest.mark.cases
def test_ends_of_an_interval(lower, upper, text):
    assert with_interval(np.nan, lower, upper) == text


def test_no_digit_is_shown_below_the_finest_half_width():
    texts = [
        with_interval(*interval, finest=0.1) for interval in ((0.0, -2e-4, 3e-4), (18.4731, 18.413, 18.519))
    ]
    assert texts == ["0.00", "18.47 −0.06 +0.05"]
    assert with_interval(5.0, 4.0, 6.0, finest=0.1) == with_interval(5.0, 4.0, 6.0)


def test_percent_of_extremes():
    assert [percent(share) for share in (0.0, 1.0, 1e-7, np.nan)] == ["0 %", "100 %", "1.00×10⁻⁵ %", "– %"]


def test_an_interval_of_labelled_numbers():
    numbers = xr.DataArray([0.412, 0.321, 0.502], dims="load")
    assert with_interval(*numbers) == "0.412 ± 0.091"
