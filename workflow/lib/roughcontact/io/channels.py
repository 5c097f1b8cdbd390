"""The result of a reader: the channels of one file, in the file's own units."""

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import islice
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from roughcontact.errors import InputFileError
from roughcontact.io import instrument_kinds
from roughcontact.io.guards import MAX_CHANNELS, MAX_POINTS, check_count, listed
from roughcontact.io.units import is_length
from roughcontact.io.vocabulary import pattern, words

MIN_MARKER = 1e36  # no unit makes a height so large
# numbers without unit or scale that programs write for a missing point
_MARKERS = [float(number) for number in words("number")["missing"]]
_MAX_LIST_LENGTH = 100  # characters of names
_LONGEST = 1e100  # of positions, whose squares must be finite
NO_TOPOGRAPHY = pattern("name", "no topography")  # of channels


class UnevenPositionsError(InputFileError):
    """Positions that form no even grid; readers catch it and return the points as they are."""


#: Along one axis a step, or positions in the file's units.
Positions = np.ndarray | float | None


class Points(NamedTuple):
    """Points (n,) that form no even grid, in the file's units."""

    x: np.ndarray
    y: np.ndarray | None  # None for a profile
    z: np.ndarray
    uneven: str  # why the positions form no even grid


@dataclass
class Channel:
    """One map or profile of a file; None: not stated in the file."""

    name: str  # as the file calls it
    shape: tuple[int, int]  # (ny, nx); ny is 1 for a profile
    # float64 heights (ny, nx) in `height_unit`, NaN where not measured, in the order of the file's rows; may
    # raise `InputFileError` for a channel without heights
    read: Callable[[], np.ndarray]
    height_unit: str | None = None
    dx: float | None = None  # steps, in `lateral_unit`
    dy: float | None = None
    lateral_unit: str | None = None
    first_x: float | None = None  # position of the first cell centre, in `lateral_unit`; None: half a step
    first_y: float | None = None
    no_height: str = ""  # why this channel holds no heights; empty for a height channel
    size_rounding: tuple[float, ...] | None = None  # relative, along x and y, of sizes over points
    doubt: str = ""  # why the channel cannot be read as it is
    # the same numbers as a map, used if the user gives both steps
    otherwise: "Channel | None" = None
    points: Points | None = None  # where they form no even grid
    notes: list[str] = field(default_factory=list)  # statements of the header that the user should know
    # what the file says where: `dx`, `unit`, `first_row` ... -> "line 3"; without it by the format
    sources: dict[str, str] = field(default_factory=dict)
    unused: list[tuple[int, str]] = field(default_factory=list)  # lines of its header that nothing uses
    first_row: str = ""  # where row 0 lies, if not as in the rest of the file; assumed

    @property
    def is_line(self) -> bool:
        """Whether it is a single profile."""
        return self.shape[0] == 1

    def __post_init__(self) -> None:
        if not self.no_height and self.height_unit is not None and not is_length(self.height_unit):
            self.no_height = f"values in {self.height_unit}, no length"


@dataclass
class MeasuredFile:
    """One opened file."""

    format: str  # for people
    channels: list[Channel]
    first_row: str  # in the picture of the instrument's own software: `top` or `bottom`
    instrument: dict[str, Any] = field(default_factory=dict)  # keys of `roughcontact.io.metadata`
    warnings: list[str] = field(default_factory=list)  # about the file as a whole
    stale: str = ""  # which stated checksum or size differs from the content
    required_size: int | None = None  # bytes by the header; readers leave the comparison to `open_file`
    first_row_assumed: bool = False  # stated neither by file nor format
    question: str = ""  # what there are several of, where the user has to name one
    close: Callable[[], object] = lambda: None  # of channels that are read from an open file

    def __post_init__(self) -> None:
        names: Counter[str] = Counter()
        for channel in counted_channels(self.channels):
            names[channel.name] += 1
            if (count := names[channel.name]) > 1:  # a number, so that each can be asked for
                channel.name = f"{channel.name} ({count})"

    @property
    def kind(self) -> instrument_kinds.Kind:
        """The kind of instrument that the file names, with the ranges that it can measure."""
        return instrument_kinds.of_name(self.instrument.get("kind"))


def counted_channels(channels: Iterable[Channel]) -> list[Channel]:
    """Return channels, and refuse a file of more than 10 000 before all of them are made."""
    counted = list(islice(channels, MAX_CHANNELS + 1))
    check_count(len(counted))
    return counted


def choose_channel(
    file: MeasuredFile, choice: str | None, *, unit_given: bool = False
) -> tuple[Channel, str]:
    """Return the channel of that name, else the first that holds heights, and a sentence on the choice.

    A height channel has a length unit, and no amplitude, phase, error or the like by name; a unit that the
    user gives makes the values of an only channel heights.

    Examples
    --------
    >>> names = {"Phase": "values in deg, no length", "Topography": "", "Topography back": ""}
    >>> channels = [Channel(name, (2, 2), lambda: None, no_height=why) for name, why in names.items()]
    >>> file = MeasuredFile("some format", channels, "top")
    >>> choose_channel(file, None)[1]
    "'Topography', the first height channel of 3"
    >>> choose_channel(file, "topography BACK")[1]
    "'Topography back', named by the user"
    """
    names = [channel.name for channel in file.channels]
    listing, together = listed(names), ""
    if len(names) > 1 and all(channel.is_line for channel in file.channels):
        shown = names if len("; ".join(names)) < _MAX_LIST_LENGTH else [*names[:2], "..."]
        together = f"; several profiles of one surface (lay: none) are '{'; '.join(shown)}'"
    if choice is not None:
        for spelling in (str, lambda name: str(name).strip().casefold()):
            matches = [channel for channel in file.channels if spelling(channel.name) == spelling(choice)]
            if len(matches) == 1:
                return matches[0], f"{matches[0].name!r}, named by the user"
        wrong = f"no channel is named {str(choice)!r}"
        raise InputFileError(f"{wrong}; the file has {listing}{together}", keys=["channel"])
    if file.question:
        raise InputFileError(
            f"{file.question}; name one with channel (table of surfaces or argument), of {listing}; "
            f"or all, in a row each, as repeats of one part of a group{together}",
            keys=["channel"],
        )
    is_height = unit_given and len(names) == 1
    heights = [channel for channel in file.channels if is_height or not channel.no_height]
    if not heights:
        reasons = "; ".join(f"{channel.name!r}: {channel.no_height}" for channel in file.channels)
        raise InputFileError(
            f"no channel of this file holds heights ({reasons or 'it has none'}); if one does, "
            "name it with channel and give height_unit",
            keys=["channel", "height_unit"],
        )
    # by name the last resort: a map called error may still be the only one with lengths
    channel = min(heights, key=lambda channel: NO_TOPOGRAPHY.search(channel.name) is not None)
    chosen = f"the first height channel of {len(names)}" if len(names) > 1 else "the only channel"
    return channel, f"{channel.name!r}, {chosen}"


def unreadable(message: str) -> Callable[[], np.ndarray]:
    """Return the `read` of a channel without numbers: it raises InputFileError with this message."""

    def read() -> np.ndarray:
        raise InputFileError(message)

    return read


def oversized(name: str, shape: tuple[int, ...]) -> Channel:
    """Return the channel of an array with more points than are read."""
    why = f"{' x '.join(map(str, shape))} points, more than the {MAX_POINTS} that are read; crop the map"
    doubt = f"variable {name!r} has {why}"
    return Channel(name, (1, prod(shape)), unreadable(doubt), no_height=why, doubt=doubt)


def as_heights(values: ArrayLike) -> np.ndarray:
    """Return real numbers, perhaps masked, as a float64 copy (ny, nx), NaN where missing.

    Missing are masked and infinite values, and numbers that programs write for them, beyond all heights.

    Examples
    --------
    >>> as_heights([1, 2, 9.91e37])
    array([[ 1.,  2., nan]])
    """
    plain = np.asarray(np.ma.getdata(values))
    if plain.dtype.kind not in "iuf":
        raise InputFileError(
            f"the values are of type {plain.dtype}, not real numbers; store heights as float64"
        )
    with np.errstate(all="ignore"):  # a NaN of single precision may be a signalling one
        heights = np.array(plain, dtype=float, ndmin=2)
    if isinstance(values, np.ma.MaskedArray):
        heights[np.atleast_2d(np.ma.getmaskarray(values))] = np.nan
    heights[~np.isfinite(heights)] = np.nan
    if np.nanmax(np.abs(heights), initial=0.0) > MIN_MARKER:
        for marker in _MARKERS:
            heights[np.abs(np.abs(heights) / marker - 1) < 1e-5] = np.nan
    return heights


def stored_floats(path: Path, number_type: str, shape: tuple[int, int], start: int) -> np.ndarray:
    """Return the heights (ny, nx) that a file stores row by row from the byte `start` on."""
    return as_heights(np.fromfile(path, number_type, prod(shape), offset=start).reshape(shape))


@np.errstate(all="ignore")  # infinite positions are not even
def even_step(positions: ArrayLike, name: str) -> float:
    """Return the step of two or more positions (n,), negative for decreasing ones, even to 2 % of a step.

    Examples
    --------
    >>> even_step([0.0, 0.501, 1.0], "x")
    0.5
    """
    positions = np.asarray(positions, dtype=float)
    step = float((positions[-1] - positions[0]) / (positions.size - 1))
    deviation = np.max(np.abs(positions - positions[0] - step * np.arange(positions.size)))
    if not np.isfinite(step) or step == 0 or not deviation <= 0.02 * abs(step):
        worst = f": up to {deviation / abs(step):.2g} of a step off" if step and deviation < np.inf else ""
        raise UnevenPositionsError(f"the positions along {name} are not evenly spaced{worst}")
    return step


@np.errstate(all="ignore")
def rounded_step(positions: ArrayLike) -> float | None:
    """Return the step of rising positions (n,) even but for the rounding of their last decimal, or None.

    Fifty and more, multiples of a power of ten up to the step, lie within 0.55 of it from a line; gaps stray
    further.

    Examples
    --------
    >>> round(rounded_step(np.round(0.15625 * np.arange(200), 1)), 4)
    0.1563
    >>> rounded_step(np.cumsum(np.tile([0.1, 0.2, 0.2, 0.5], 50))) is None
    True
    """
    positions = np.asarray(positions, dtype=float)
    even = positions.size >= 50 and np.isfinite(positions).all()
    if not even or not 0 < positions[-1] - positions[0] < _LONGEST:
        return None
    number = np.arange(positions.size)
    step, start = np.polyfit(number, positions, 1)
    last = 10.0 ** np.floor(np.log10(step)) if step > 0 else 0.0
    if not last or np.max(np.abs(positions / last - np.rint(positions / last))) > 1e-3:
        return None
    return float(step) if np.max(np.abs(positions - start - step * number)) <= 0.55 * last else None


def channel_on_grid(
    channel: Channel, x: Positions, y: Positions, names: tuple[str, str] = ("x", "y")
) -> Channel:
    """Return a channel with its steps, rows and columns by rising positions, or as points off a grid.

    Along each axis a step, positions (n,), those of all points (ny, nx), or None where they are unknown.
    """
    try:
        dx, dy = _step(x, names[0]), _step(y.T if isinstance(y, np.ndarray) else y, names[1])
    except UnevenPositionsError as error:
        if channel.no_height:
            return channel
        if x is None or (y is None and channel.shape[0] > 1):
            raise InputFileError(f"{error}, and the other axis has no positions") from error
        along_x = _expand_positions(x, channel.shape, 1)
        along_y = None if y is None else _expand_positions(y, channel.shape, 0)
        return scattered(channel, along_x, along_y, channel.read(), str(error))
    read = channel.read
    orientation = np.s_[:: -1 if (dy or 0) < 0 else 1, :: -1 if (dx or 0) < 0 else 1]
    return replace(channel, dx=dx and abs(dx), dy=dy and abs(dy), read=lambda: np.array(read()[orientation]))


def _step(positions: Positions, name: str) -> float | None:
    """Return the step along an axis, those of all points being (lines, points along it); None if unknown."""
    if not isinstance(positions, np.ndarray):
        return positions
    lines = np.atleast_2d(positions).astype(float)
    if lines.shape[1] == 1:
        return None
    step = even_step(lines[0], name)
    if not np.nanmax(np.abs(lines - lines[0])) <= 0.02 * abs(step):
        raise UnevenPositionsError("the points do not lie on a rectangular grid")
    return step


def _expand_positions(positions: np.ndarray | float, shape: tuple[int, int], axis: int) -> np.ndarray:
    """Return the positions (ny, nx) of all points along an axis, stored or counted."""
    if not isinstance(positions, np.ndarray):
        return positions * np.indices(shape)[axis]
    return np.broadcast_to(positions[:, None] if positions.ndim == 1 and axis == 0 else positions, shape)


def scattered(channel: Channel, x: ArrayLike, y: ArrayLike | None, z: ArrayLike, uneven: str) -> Channel:
    """Return a channel with points (x, y, z; y None for a profile) that can be read only by resampling.

    Points without a height are left out; `uneven` says why they form no even grid.
    """
    columns = [np.asarray(series, dtype=float).ravel() for series in (x, z, *(() if y is None else (y,)))]
    is_finite = np.isfinite(columns).all(axis=0)
    along_x, heights, *along_y = (column[is_finite] for column in columns)
    points = Points(along_x, along_y[0] if along_y else None, heights, uneven)
    return replace(channel, shape=(1, heights.size), read=heights[None, :].copy, points=points)
