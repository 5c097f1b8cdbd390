"""Numbers that carry their unit, against what the units are by definition."""

import pytest

from roughcontact.arguments.units import carries_unit, convert_to_base_unit, unknown_unit


@pytest.mark.cases
def test_a_number_with_its_unit(text, base, value):
    assert carries_unit(text)
    assert convert_to_base_unit(text, base) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("bare", ["1e9", "1e9 ", 5, 5.0, None, True, [1], "soft", "", "GPa", "nan", "-inf"])
def test_what_carries_no_unit_is_left_as_it_is(bare):
    assert not carries_unit(bare)
    assert convert_to_base_unit(bare, "Pa") is bare


def test_decimal_units_give_the_number_that_was_written():
    for text, value in [("2.5 um", 2.5e-6), ("0.3 nm", 3e-10), ("0.7 mm", 7e-4), ("1.1 MPa", 1.1e6)]:
        assert convert_to_base_unit(text, "Pa" if "Pa" in text else "m") == value


@pytest.mark.cases
def test_a_unit_that_is_none_is_said(text, base, words):
    with pytest.raises(ValueError) as caught:
        convert_to_base_unit(text, base)
    assert words in str(caught.value)


def test_a_unit_that_is_near_nothing_gets_no_hint():
    assert unknown_unit("furlongs per fortnight", "Pa").startswith(
        "unknown pressure unit 'furlongs per fortnight'; accepted are Pa"
    )
