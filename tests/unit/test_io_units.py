"""The table of length units."""

import pytest

from roughcontact.errors import InputFileError, SettingsError
from roughcontact.io.units import is_length, metres


@pytest.mark.parametrize(
    ("value", "spellings"),
    [
        (1e3, "km kilometre kilometres kilometer kilometers"),
        (1.0, "m metre metres meter meters"),
        (1e-1, "dm decimetre decimetres decimeter decimeters"),
        (1e-2, "cm centimetre centimetres centimeter centimeters"),
        (1e-3, "mm millimetre millimetres millimeter millimeters Millimeters"),
        (1e-6, "um \u00b5m \u03bcm micrometre micrometres micrometer micrometers micron Microns"),
        (
            1e-6,
            "мкм 微米 ㎛ Mikrometer Micromètres micrómetros UM mu [um] (µm) µm. Âµm \ufffdm &micro;m $\\mu$m",
        ),
        (1e-6, "1e-6\u00a0m 10^-6\u00a0m 10⁻⁶\u00a0m"),
        (1e-9, "nm nanometre nanometres nanometer nanometers нм 纳米 ㎚ nanomètre"),
        (1e-12, "pm picometre picometres picometer picometers"),
        (1e-10, "\u00c5 \u212b A\u030a Angstrom"),  # letter, sign of the angstrom, A and combining ring
        (25.4e-3, 'in inch inches " Inch'),
        (25.4e-6, "mil mils thou Mils THOU"),
        (25.4e-9, "uin \u00b5in \u03bcin microinch microinches MicroInch"),
    ],
)
def test_accepted_spellings(value, spellings):
    for spelling in (*spellings.split(" "), f" {spellings.split(' ')[0]} "):
        assert metres(spelling) == value
        assert is_length(spelling)


@pytest.mark.parametrize(
    "unit",
    ["", "V", "rad", "A", "counts", "1", "Mm", "NM", "MM", "Mil", "MIL", "UIN", "Uin", "IN", "KM", "Um"],
)
def test_what_is_no_length_or_may_mean_something_else(unit):
    """Symbols of up to three letters are case-sensitive."""
    assert not is_length(unit)
    with pytest.raises(InputFileError, match="unknown length unit"):
        metres(unit)


@pytest.mark.parametrize(
    ("unit", "hint"), [("mircon", "did you mean 'micron'? "), ("\u00b5\u00b5\u00b5", "")]
)
def test_message_names_the_nearest_spelling_if_there_is_one(unit, hint):
    with pytest.raises(SettingsError) as caught:
        metres(unit, where="file, line 3", error=SettingsError)
    assert str(caught.value).startswith(
        f"file, line 3: unknown length unit '{unit}'; {hint}accepted are m, mm"
    )
