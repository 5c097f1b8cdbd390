"""Rectangles on a map, as the columns `crop` and `mask` of the table of surfaces have them."""

from typing import NamedTuple

from roughcontact.arguments.units import lengths_in_text
from roughcontact.errors import SettingsError

_RULE = "must be x and y of two corners from the lower left one of the map, and their unit: 20 10 120 110 um"


class Rectangle(NamedTuple):
    """A rectangle of which two opposite corners are given, m from the first corner of the map."""

    left: float
    lower: float
    right: float
    upper: float


def parse_rectangles(column: str, text: str) -> list[Rectangle]:
    """Return the rectangles of a cell: x, y of two corners and their unit, several separated by semicolons.

    Raises
    ------
    SettingsError
        If the text is something else, an empty rectangle, or in `crop` more than one.

    Examples
    --------
    >>> parse_rectangles("crop", "20 10 120 110 um")
    [Rectangle(left=2e-05, lower=1e-05, right=0.00012, upper=0.00011)]
    >>> len(parse_rectangles("mask", "0.1 0.1 0.2 0.3 mm; 0 0 1 0.02 mm"))
    2
    """
    message, rectangles = f"{column} = {text!r}: ", []
    parts = [part.strip() for part in text.split(";") if part.strip()]
    for part in parts:
        try:
            x1, y1, x2, y2 = lengths_in_text(part, 4, _RULE)
        except ValueError as error:
            raise SettingsError(f"{message}{error}") from error
        if x1 == x2 or y1 == y2:
            raise SettingsError(
                f"{message}a rectangle without an area; its two corners lie opposite each other"
            )
        rectangles.append(Rectangle(min(x1, x2), min(y1, y2), max(x1, x2), max(y1, y2)))
    if column == "crop" and len(rectangles) > 1:
        raise SettingsError(f"{message}has {len(rectangles)} rectangles; a map is cropped to one")
    return rectangles
