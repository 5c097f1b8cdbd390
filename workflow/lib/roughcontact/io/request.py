"""The user's arguments for a file, beside its path."""

import math
from dataclasses import dataclass, fields
from numbers import Real

from roughcontact.arguments.checking import check_choice
from roughcontact.arguments.choices import Checksum, FirstRow, Resampling
from roughcontact.arguments.lays import check_lay

# information missing in a file: the arguments of read_height_map, the columns of the table of surfaces
FILE_OPTIONS = {
    "channel": "which channel of the file, by name",
    "dx": "step from point to point along x, in --unit, or with its own: 1.5um",
    "dy": "step from point to point along y, in --unit, or with its own: 1.5um",
    "unit": "unit of --dx and --dy, and of the heights without --height-unit: m, mm, um, nm, ...",
    "height-unit": "unit of the heights",
    "resample": "linear: interpolate points on an uneven grid to an even one",
    "checksum": "ignore: read a file that differs from the checksum in it (X3P edited by hand)",
    "first-row": "top or bottom: position of the first row of the file in the picture of the surface",
    "missing-value": "number that marks missing points, in the unit of the heights; several: '-9999 0'",
    "ignore-lines": "numbers of lines of a header that do not concern the map: '5 7'",
    "lay": "of a profile: across (a lay, ridges) or none (an isotropic surface with its spectrum is solved)",
}
_CHOICES = {"resample": Resampling, "checksum": Checksum, "first_row": FirstRow}


@dataclass(frozen=True)
class Request:
    """The user's arguments for a file, as in `read_height_map`; None, an empty text or NaN: as in the file.

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
    missing_value: float | str | None = None
    ignore_lines: int | str | None = None
    lay: str | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            if _is_empty(getattr(self, field.name)):
                object.__setattr__(self, field.name, None)
            elif field.name in _CHOICES:
                check_choice(field.name, getattr(self, field.name), _CHOICES[field.name])
        if self.lay is not None:
            check_lay(self.lay)


def _is_empty(value: object) -> bool:
    """Return whether a value stands for an empty cell of a table."""
    if isinstance(value, str):
        return not value.strip()
    return value is None or (isinstance(value, Real) and math.isnan(value))
