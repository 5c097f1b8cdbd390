"""Numbers as people read them: which prefix, how many digits, at which limits."""

import numpy as np
import pytest
import xarray as xr

from roughcontact.arguments.quantities import Unit, number, percent, prefix, quantity, with_interval


@pytest.mark.parametrize(
    ("value", "unit", "factor", "symbol"),
    [
        (1500.0, "m", 1e-3, "km"),
        (1000.0, "m", 1e-3, "km"),
        (999.94, "m", 1.0, "m"),
        (999.96, "m", 1e-3, "km"),  # four digits would be 1000
        (1.0, "m", 1.0, "m"),
        (0.99994, "m", 1e3, "mm"),
        (0.99996, "m", 1.0, "m"),
        (-2.5e-6, "m", 1e6, "µm"),
        (1e-15, "m", 1e15, "fm"),
        (1e-16, "m", 1.0, "m"),  # no prefix below
        (3e12, "Pa", 1e-12, "TPa"),
        (3e16, "Pa", 1e-12, "TPa"),  # none above
        (2e3, "J", 1e-3, "kJ"),
        (2e3, "m-1", 1.0, "m-1"),  # composed units take none
        (2e3, "1", 1.0, "1"),
        (0.0, "m", 1.0, "m"),
        (np.inf, "m", 1.0, "m"),
    ],
)
def test_prefix(value, unit, factor, symbol):
    assert prefix(value, unit) == (factor, symbol)


@pytest.mark.parametrize(
    ("lower", "upper", "text"),
    [
        (1e6, 2e6, "1.00 to 2.00 MPa"),
        (1e6, np.inf, "1.00 or more MPa"),
        (np.nan, 2e6, "2.00 or less MPa"),
        (np.nan, np.nan, "–"),
        (-np.inf, np.inf, "–"),  # nothing is known either
    ],
)
def test_ends_stand_with_their_unit_where_one_is_known(lower, upper, text):
    assert Unit(1e-6, "MPa").ends(lower, upper) == text


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(1.5, 2, "1.5 km"), (1.5, 3, "1.50 km"), (12.345, 3, "12.3 km"), (0.25, 3, "250 m")],
)
def test_kilometres(value, digits, text):
    assert quantity(1000 * value, "m", digits=digits) == text


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (1e-3, 3, "0.00100"),
        (0.99949e-3, 3, "9.99×10⁻⁴"),
        (0.9996e-3, 3, "0.00100"),  # rounds up to what is written without a power
        (999499.0, 3, "999499"),
        (999600.0, 3, "1.00×10⁶"),
        (-0.5, 1, "−0.5"),
        (-1.25e9, 3, "−1.25×10⁹"),
        (-np.inf, 3, "−∞"),
        (0.0, 3, "0"),
    ],
)
def test_number(value, digits, text):
    assert number(value, digits=digits) == text


@pytest.mark.parametrize(
    ("value", "half_width", "text"),
    [
        (0.123456, 0.0096, "0.1235 ± 0.0096"),
        (0.123456, 0.00999, "0.123 ± 0.010"),  # two digits after rounding
        (-12.34, 1.2, "−12.3 ± 1.2"),
        (123456.0, 1234.0, "123500 ± 1200"),
        (1.0, np.nan, "1.00"),
        (1.0, -0.1, "1.00"),
        (1e-9, 2e-12, "1.00×10⁻⁹ ± 2.0×10⁻¹²"),  # too small for places
    ],
)
def test_plus_minus(value, half_width, text):
    assert with_interval(value, value - half_width, value + half_width) == text


@pytest.mark.parametrize(
    ("value", "lower", "upper", "text"),
    [
        (0.5, 0.4, 0.6, "0.50 ± 0.10"),
        (0.5, 0.4, 0.609, "0.50 ± 0.11"),  # as far, within a tenth
        (0.5, 0.4, 0.8, "0.50 −0.10 +0.30"),
        (0.97, 0.9, 1.0, "0.970 −0.070 +0.030"),
        (0.0, 0.0, 0.02, "0 (0 to 0.020)"),  # no gap: nothing below it
        (0.0, 0.0, 2e-15, "0"),  # the gap of full contact, and the error of its solution
        (0.5, np.nan, np.nan, "0.500"),
        (0.5, 0.5, 0.5, "0.500"),
        (238.3, 238.3, 238.3 * (1 + 1e-15), "238"),  # an end that rounding has moved
        (300.0, 291.7, 300.0 * (1 + 1e-15), "300.0 −8.3"),
        (238.3, 238.3 * (1 - 1e-15), 238.3, "238"),
        (np.inf, np.nan, np.nan, "∞"),
        (np.inf, 5.0, np.nan, "∞ (5.0 or more)"),  # full contact: only the lower end is known
        (5.7, 4.4, np.inf, "5.7 (4.4 or more)"),
        (0.0, 0.0, np.nan, "0 or more"),
        (238.3, 238.3, np.nan, "238 or more"),
        (5.0, np.nan, 8.0, "5.0 (8.0 or less)"),
        (0.0028, 0.0, 0.3312, "0.0028 (0 to 0.33)"),  # beyond ten times the value: both ends in full
        (18.0, 0.0803, 4883.0, "18 (0.080 to 4900)"),
        (1.0, 0.0, 10.0, "1.0 −1.0 +9.0"),
        (1.0, 1.0, 20.0, "1.00 (1.0 to 20)"),
        (0.008, 0.008 * (1 + 1e-15), 0.127, "0.00800 (0.0080 to 0.13)"),  # one number but for rounding
        (1.0, 0.0, 10.01, "1.0 (0 to 10.0)"),
        (3.0, -60.0, 200.0, "3 (−60 to 200)"),
        (3.4e-7, 2.9e-12, np.nan, "3.4×10⁻⁷ (2.9×10⁻¹² or more)"),
        (44000.0, 0.0, 1.3e6, "44000 (0 to 1.3×10⁶)"),
        (300.0, 299.996, 300.0, "300.00"),  # certain to more digits than are read
        (18.4731234, 18.4731229, 18.4731239, "18.473"),
        (300.0, 299.96, 300.04, "300.00 ± 0.04"),
        (100.71, 100.0, 187.0, "100.7 −0.7 +86"),  # the wider end carries fewer digits
        (12.3456789, 12.3456779, 15.3, "12.35 +3.0"),
        (-0.04, -11.0, 11.0, "0 ± 11"),  # no −0
        (10.4, 0.4, 20.0, "10 (0.40 to 20.0)"),
        (240.3, 1.98, 243.5, "240 (2.0 to 243.5)"),
    ],
)
def test_with_interval(value, lower, upper, text):
    assert with_interval(value, lower, upper) == text


@pytest.mark.parametrize(
    ("lower", "upper", "text"),
    [
        (5.2134, 8.1, "5.21 to 8.10"),
        (300.0, 300.1, "300.00 to 300.10"),  # as many digits as tell the ends apart
        (0.0803, 4883.0, "0.0803 to 4880"),
        (1e-16, 4.0, "0 to 4.00"),  # rounding
        (2.0, 2.0, "2.00"),
        (4.4, np.nan, "4.40 or more"),
        (np.nan, np.nan, "–"),
    ],
)
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
