"""The table of length units."""

import pytest

from roughcontact.errors import InputFileError, SettingsError
from roughcontact.io.units import is_length, metres


@pytest.mark.parametrize(
    ("unit", "value"),
    [
        ("\u03bcm", 1e-6),  # Greek mu
        ("micron", 1e-6),
        ("Microns", 1e-6),
        ("\u00c5", 1e-10),  # letter A with ring
        ("\u212b", 1e-10),  # angstrom sign
        ("A\u030a", 1e-10),  # A and combining ring
        ("Angstrom", 1e-10),
        ("\u00b5in", 25.4e-9),
        (" nm ", 1e-9),
        ("Millimeters", 1e-3),
    ],
)
def test_accepted_spellings(unit, value):
    assert metres(unit) == value
    assert is_length(unit)


@pytest.mark.parametrize("unit", ["", "V", "rad", "Mm", "NM", "MM", "A", "counts", "1"])
def test_what_is_no_length_or_may_mean_something_else(unit):
    assert not is_length(unit)
    with pytest.raises(InputFileError, match="unknown length unit"):
        metres(unit)


def test_message_names_the_nearest_spelling():
    with pytest.raises(
        SettingsError, match=r"unit: unknown length unit 'mircon'; did you mean 'micron'\? accepted are m,"
    ):
        metres("mircon", where="unit", error=SettingsError)


@pytest.mark.parametrize(
    ("prefix", "symbol", "power"),
    [
        ("kilo", "k", 3),
        ("", "", 0),
        ("deci", "d", -1),
        ("centi", "c", -2),
        ("milli", "m", -3),
        ("micro", "u", -6),
        ("micro", "\u00b5", -6),
        ("nano", "n", -9),
        ("pico", "p", -12),
    ],
)
def test_every_prefix_of_the_metre(prefix, symbol, power):
    for spelling in (f"{symbol}m", *(f"{prefix}{word}" for word in ("metre", "metres", "meter", "meters"))):
        assert metres(spelling) == float(f"1e{power}")


@pytest.mark.parametrize(
    ("spellings", "inches"),
    [
        (("in", "inch", "inches", '"', "Inch"), 1.0),
        (("mil", "mils", "thou", "Mils", "THOU"), 1e-3),
        (("uin", "\u03bcin", "microinch", "microinches", "MicroInch"), 1e-6),
    ],
)
def test_an_inch_is_25_4_millimetres(spellings, inches):
    for spelling in spellings:
        assert metres(spelling) == pytest.approx(25.4e-3 * inches, rel=1e-15)


@pytest.mark.parametrize("symbol", ["Mil", "MIL", "UIN", "Uin", "IN", "KM", "Um"])
def test_symbols_of_up_to_three_letters_are_case_sensitive(symbol):
    assert not is_length(symbol)


def test_what_is_like_no_unit_gets_no_hint():
    with pytest.raises(InputFileError) as caught:
        metres("\u00b5\u00b5\u00b5", where="file, line 3")
    assert str(caught.value).startswith(
        "file, line 3: unknown length unit '\u00b5\u00b5\u00b5'; accepted are m, mm"
    )
