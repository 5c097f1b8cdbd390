"""The user's arguments for a file, beside its path."""

import math
from dataclasses import asdict, dataclass
from numbers import Real
from typing import Any

from roughcontact.arguments.choices import Checksum, FirstRow, Resampling, check_choice
from roughcontact.arguments.profiles.lays import check_lay
from roughcontact.io.vocabulary import rows_of

#: Options of commands that say what is missing in a file -> what they are.
FILE_OPTIONS = dict(rows_of("options.tsv"))
CHOICES: dict[str, Any] = {"resample": Resampling, "checksum": Checksum, "first_row": FirstRow}


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
        for name, value in asdict(self).items():
            # an empty cell of the table of surfaces is no argument, as a CSV reader gives it: "" or NaN
            if _is_empty(value):
                object.__setattr__(self, name, None)
            elif name in CHOICES:
                check_choice(name, value, choices=CHOICES[name])
            elif name == "lay":
                check_lay(value)

    def has_steps(self, shape: tuple[int, int]) -> bool:
        """Return whether the user gives all steps of a map, or of a profile, of a shape (ny, nx)."""
        return self.dx is not None and (self.dy is not None or shape[0] == 1)


def _is_empty(value: object) -> bool:
    """Return whether a value stands for an empty cell of a table."""
    if isinstance(value, str):
        return not value.strip()
    return value is None or (isinstance(value, Real) and math.isnan(value))
