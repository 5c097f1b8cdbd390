"""Numbers that carry their unit, against what the units are by definition."""

import pytest

from roughcontact.arguments.units import carries_unit, convert_to_base_unit, unknown_unit


@pytest.mark.parametrize(
    ("text", "base", "value"),
    [
        ("115 GPa", "Pa", 115e9),
        ("115GPa", "Pa", 115e9),
        (" 1.5e3  MPa ", "Pa", 1.5e9),
        ("0.5 N/mm2", "Pa", 5e5),
        ("0.5 N/mm²", "Pa", 5e5),
        ("0.5 N / mm^2", "Pa", 5e5),
        ("3 kN/mm2", "Pa", 3e9),
        ("7 N/cm2", "Pa", 7e4),
        ("250 bar", "Pa", 25e6),
        ("3 mbar", "Pa", 300.0),
        ("1.15 Mbar", "Pa", 115e9),
        ("12 kPa", "Pa", 12e3),
        ("115 Pa", "Pa", 115.0),
        ("1 psi", "Pa", 6894.757293168361),  # NIST Special Publication 811 (2008), appendix B.8
        ("30 Msi", "Pa", 30 * 6894.757293168361e6),
        ("1 kgf/mm2", "Pa", 9.80665e6),
        ("250 nN", "N", 2.5e-7),
        ("3 µN", "N", 3e-6),
        ("3 uN", "N", 3e-6),
        ("2 Megapascal", "Pa", 2e6),
        ("50 W/(m K)", "W m-1 K-1", 50.0),
        ("50 W/(m·K)", "W m-1 K-1", 50.0),
        ("1.68e-8 Ohm m", "Ohm m", 1.68e-8),
        ("1.68 µΩ cm", "Ohm m", 1.68e-8),
        ("0.0168 Ohm mm²/m", "Ohm m", 1.68e-8),
        ("2.5 µm", "m", 2.5e-6),
        ("0.8 mm", "m", 8e-4),
        ("800um", "m", 8e-4),
        ("1 in", "m", 0.0254),
        ("5 cm/s", "m s-1", 0.05),
        ("30 m/min", "m s-1", 0.5),
        ("600 mm/min", "m s-1", 0.01),
        ("100 ft/min", "m s-1", 0.508),
        ("10 in/s", "m s-1", 0.254),
        ("0.14 cm2/s", "m2 s-1", 1.4e-5),
        ("45°", "degree", 45.0),
        ("45 deg", "degree", 45.0),
        ("3.141592653589793 rad", "degree", 180.0),
        ("-90 deg", "degree", -90.0),
    ],
)
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


@pytest.mark.parametrize(
    ("text", "base", "words"),
    [
        ("115 Gpa", "Pa", "unknown pressure unit 'Gpa'; did you mean 'GPa'?"),
        ("1 MBAR", "Pa", "did you mean 'Mbar' or 'mbar'?"),
        ("1 mPa", "Pa", "did you mean 'MPa'?"),  # a millipascal is never meant
        ("1 mm", "Pa", "unknown pressure unit 'mm'; accepted are Pa, kPa, MPa, GPa"),
        ("1 MPa", "m", "unknown length unit 'MPa'"),
        ("1,5 GPa", "Pa", "write a decimal point, not a comma"),
        ("1 e9", "Pa", "unknown pressure unit 'e9'"),
    ],
)
def test_a_unit_that_is_none_is_said(text, base, words):
    with pytest.raises(ValueError) as caught:
        convert_to_base_unit(text, base)
    assert words in str(caught.value)


def test_a_unit_that_is_near_nothing_gets_no_hint():
    assert unknown_unit("furlongs per fortnight", "Pa").startswith(
        "unknown pressure unit 'furlongs per fortnight'; accepted are Pa"
    )
