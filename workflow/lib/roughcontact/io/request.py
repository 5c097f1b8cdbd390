"""What the user says of a file beside its path."""

import math
from dataclasses import dataclass, fields
from numbers import Real


@dataclass(frozen=True)
class Request:
    """What the user asks for and knows; None for all that is left to the file.

    An empty cell of a table (an empty text, NaN) stands for None.

    Attributes
    ----------
    channel : str or None
        Name of the channel.
    dx, dy : float, str or None
        Steps from point to point, in `unit` or with their own (``1.5 um``).
    unit, height_unit : str or None
        Units of the steps and of the heights.
    resample : str or None
        How points on no even grid are brought to one.
    checksum : str or None
        ``ignore``: a file that differs from the checksum in it is read nevertheless.
    first_row : str or None
        ``top`` or ``bottom``: where the first row of the file lies in the picture of the surface.

    Examples
    --------
    >>> Request(channel="", dx=2.0, dy=float("nan")) == Request(dx=2.0)
    True
    """

    channel: str | None = None
    dx: float | str | None = None
    dy: float | str | None = None
    unit: str | None = None
    height_unit: str | None = None
    resample: str | None = None
    checksum: str | None = None
    first_row: str | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            if _is_empty(getattr(self, field.name)):
                object.__setattr__(self, field.name, None)


def _is_empty(value: object) -> bool:
    """Return whether a value is what an empty cell of a table hands over."""
    if isinstance(value, str):
        return not value.strip()
    return value is None or (isinstance(value, Real) and math.isnan(value))
