"""What a reader hands over: the channels of one file, in the file's own units."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from roughcontact.errors import InputFileError


class UnevenPositions(InputFileError):
    """Positions that form no even grid; readers catch it and hand over the points as they are."""


@dataclass
class Channel:
    """One map or profile of a file.

    `read()` returns the heights in `height_unit`, float64 (ny, nx), NaN where not measured, row j at the j-th
    y. `dx`, `dy` are the steps in `lateral_unit`; None stands for what the file does not say.
    """

    name: str
    shape: tuple[int, int]
    read: Callable[[], np.ndarray]
    height_unit: str | None = None
    dx: float | None = None
    dy: float | None = None
    lateral_unit: str | None = None
    first_x: float | None = None  # position of the first cell centre; None: half a step
    first_y: float | None = None
    no_height: str = ""  # why this channel holds no heights; empty for a height channel
    steps_from_size: bool = False  # the steps are a total size divided by the points that were found
    # positions that form no even grid: (x, y, z), one entry per point, y None for a profile; what is wrong
    points: tuple | None = None
    uneven: str = ""
    notes: list[str] = field(default_factory=list)  # what the header says that the user should know


@dataclass
class SourceFile:
    """One opened file: its format, its channels in the file's order, and what it says of the instrument.

    `first_row` is where the instrument's own software draws row 0: at the top or at the bottom. `instrument`
    has the words of `roughcontact.io.metadata`.
    """

    format: str
    channels: list[Channel]
    first_row: str
    instrument: dict = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)


def choose_channel(source: SourceFile, wanted, where: str, *, unit_given=False) -> tuple[Channel, str]:
    """Return the channel to use and a sentence that says how it was chosen.

    Without `wanted` it is the first channel that holds heights (a length unit, and no amplitude, phase, error
    or the like by name); with `unit_given` the user says that the values of the only channel are heights.

    Raises
    ------
    InputFileError
        where no channel has the wanted name, or none holds heights.
    """
    names = [channel.name for channel in source.channels]
    listing = ", ".join(repr(name) for name in names)
    if wanted is None:
        for channel in source.channels:
            if not channel.no_height or (unit_given and len(names) == 1):
                chosen = f"the first height channel of {len(names)}" if len(names) > 1 else "the only channel"
                return channel, f"{channel.name!r}, {chosen}"
        reasons = "; ".join(f"{channel.name!r}: {channel.no_height}" for channel in source.channels)
        raise InputFileError(f"{where}: no channel of this file holds heights ({reasons or 'it has none'})")
    matches = [channel for channel in source.channels if channel.name == str(wanted)]
    if not matches:
        matches = [c for c in source.channels if c.name.casefold() == str(wanted).strip().casefold()]
    if len(matches) != 1:
        raise InputFileError(f"{where}: no channel is named {str(wanted)!r}; the file has {listing}")
    return matches[0], f"{matches[0].name!r}, named by the user"


def as_heights(values, where: str, *, missing=None) -> np.ndarray:
    """Return `values` as a float64 map (ny, nx), NaN where masked, infinite or equal to `missing`.

    Raises
    ------
    InputFileError
        where the values are no plain real numbers.
    """
    mask = np.ma.getmaskarray(values) if isinstance(values, np.ma.MaskedArray) else None
    values = np.ma.getdata(values)
    if values.dtype.kind not in "iuf":
        raise InputFileError(
            f"{where}: the values are of type {values.dtype}, not real numbers; store heights as float64"
        )
    heights = np.array(values, dtype=float, ndmin=2)
    if mask is not None:
        heights[np.atleast_2d(mask)] = np.nan
    if missing is not None:
        heights[heights == missing] = np.nan
    heights[~np.isfinite(heights)] = np.nan
    return heights


def even_step(positions, name: str) -> float:
    """Return the step of evenly spaced positions (signed).

    Raises
    ------
    UnevenPositions
        where a position is off the even grid by more than 2 % of a step, which rounding does not explain.
    """
    positions = np.asarray(positions, dtype=float)
    step = (positions[-1] - positions[0]) / (positions.size - 1)
    off = np.max(np.abs(positions - positions[0] - step * np.arange(positions.size)))
    if not np.isfinite(step) or step == 0 or not off <= 0.02 * abs(step):
        worst = "" if not step or not np.isfinite(off) else f": up to {off / abs(step):.2g} of a step off"
        raise UnevenPositions(f"the positions along {name} are not evenly spaced{worst}")
    return step


def scattered(name: str, x, y, z, error: UnevenPositions, **words) -> Channel:
    """Return a channel of points that form no even grid: it can be read only by resampling.

    Parameters
    ----------
    x, y, z : arrays of equal size, in the file's units
        `y` is None for a profile. Points without a height are left out.
    error : UnevenPositions
        What is wrong with the positions.
    words
        Further entries of the channel, `lateral_unit` and `height_unit` above all.
    """
    x, z = (np.asarray(values, dtype=float).ravel() for values in (x, z))
    y = None if y is None else np.asarray(y, dtype=float).ravel()
    measured = np.isfinite(z) & np.isfinite(x) & (True if y is None else np.isfinite(y))
    points = x[measured], None if y is None else y[measured], z[measured]
    shape = (1, int(np.count_nonzero(measured)))
    return Channel(name, shape, lambda: points[2][None, :].copy(), points=points, uneven=str(error), **words)
