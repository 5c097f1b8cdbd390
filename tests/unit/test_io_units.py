"""The table of length units."""

import pytest

from roughcontact.errors import InputFileError, SettingsError
from roughcontact.io.units import is_length, metres


@pytest.mark.cases
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
