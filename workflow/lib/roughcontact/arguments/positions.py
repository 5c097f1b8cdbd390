"""Where a map lies in an overview, as the column `overview_position` of the table of surfaces states it."""

from roughcontact.arguments.quantities import counted_noun
from roughcontact.arguments.units import lengths_in_text
from roughcontact.errors import SettingsError

ELSEWHERE = "elsewhere"  # the overview is of another position of the same face
_COLUMN = "overview_position"
_RULE = (
    "must be x and y of the middle of the map, from the lower left corner of the overview, and their unit "
    f"(300 250 um), {ELSEWHERE} for another position of the face, or empty: it is then looked for"
)


def parse_position(text: str) -> tuple[float, float] | None:
    """Return x and y (m) of the middle of a map in its overview; None where it is to be found, or elsewhere.

    Raises
    ------
    SettingsError
        If the text is something else.

    Examples
    --------
    >>> parse_position("300 250 um"), parse_position("elsewhere"), parse_position("")
    ((0.0003, 0.00025), None, None)
    """
    if text in ("", ELSEWHERE):
        return None
    try:
        x, y = lengths_in_text(text, 2, _RULE)
    except ValueError as error:
        raise SettingsError(f"{_COLUMN} = {text!r}: {error}", keys=[_COLUMN]) from error
    return x, y


def separate_positions(text: str, number: int) -> list[str]:
    """Return the position of each of so many overviews, which semicolons separate.

    Raises
    ------
    SettingsError
        If there are more or fewer of them.

    Examples
    --------
    >>> separate_positions("; elsewhere", 2), separate_positions("", 2)
    (['', 'elsewhere'], ['', ''])
    """
    if not isinstance(text, str):
        raise SettingsError(f"{_COLUMN} = {text!r}: give text, as '300 250 um'", keys=[_COLUMN])
    positions = [part.strip() for part in text.split(";")] if text.strip() else [""] * number
    if len(positions) != number:
        raise SettingsError(
            f"{_COLUMN} = {text!r}: {counted_noun(len(positions), 'position')} for "
            f"{counted_noun(number, 'overview')}; give one for each, between semicolons, empty where the map "
            "is to be found",
            keys=[_COLUMN],
        )
    return positions
