"""The result of a reader: the channels of one file, in the file's own units."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import InitVar, dataclass, field, replace
from itertools import islice
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from roughcontact.errors import InputFileError
from roughcontact.io.guards import MAX_CHANNELS, MAX_POINTS, check_count, listed, refusal
from roughcontact.io.metadata import instrument_metadata
from roughcontact.io.units import is_length
from roughcontact.io.vocabulary import pattern, words

MIN_MARKER = 1e36  # no unit makes a height so large
# numbers without unit or scale that programs write for a missing point
_MARKERS = [float(number) for number in words("number")["missing"]]
_MAX_LIST_LENGTH = 100  # characters of names
NO_TOPOGRAPHY = pattern("name", "no topography")  # of channels


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
    points: Points | None = None  # where they form no even grid
    notes: list[str] = field(default_factory=list)  # statements of the header that the user should know
    # what the file says where: `dx`, `unit`, `first_row` ... -> "line 3"; without it by the format
    sources: dict[str, str] = field(default_factory=dict)
    unused: list[tuple[int, str]] = field(default_factory=list)  # lines of its header that nothing uses
    count_height: float = 1.0  # of one of the numbers, in `height_unit`
    first_row: str = ""  # where row 0 lies, if not as in the rest of the file; assumed

    @property
    def is_line(self) -> bool:
        """Whether it is a single profile."""
        return self.shape[0] == 1

    @property
    def scale_advice(self) -> str:
        """What to give where the steps in the file are doubted."""
        return "give dx, dy and unit" if self.height_unit else "give dx, dy, unit and height_unit"

    def __post_init__(self) -> None:
        if not self.no_height and self.height_unit is not None and not is_length(self.height_unit):
            self.no_height = f"values in {self.height_unit}, no length"


@dataclass
class MeasuredFile:
    """One opened file."""

    format: str  # for people
    channels: list[Channel]
    first_row: str  # in the picture of the instrument's own software: `top` or `bottom`
    instrument: Mapping[str, Any] = field(default_factory=dict)  # keys of `roughcontact.io.metadata`
    warnings: list[str] = field(default_factory=list)  # about the file as a whole
    stale: str = ""  # which stated checksum or size differs from the content
    required_size: int | None = None  # bytes by the header; readers leave the comparison to `open_file`
    first_row_assumed: bool = False  # stated neither by file nor format
    question: str = ""  # what there are several of, where the user has to name one
    close: Callable[[], object] = lambda: None  # of channels that are read from an open file
    header: InitVar[Mapping | None] = None  # that may say more of the instrument

    def __post_init__(self, header: Mapping | None) -> None:
        self.instrument = instrument_metadata(self.instrument, header)
        names: Counter[str] = Counter()
        for channel in counted_channels(self.channels):
            names[channel.name] += 1
            if (count := names[channel.name]) > 1:  # a number, so that each can be asked for
                channel.name = f"{channel.name} ({count})"


def on_field(channel: Channel, field: Iterable[float | None], lateral_unit: str | None) -> Channel:
    """Return a channel with its steps on a field (along x, y; None: unknown); impossible: refused.

    Examples
    --------
    >>> on_field(Channel("height", (2, 4), lambda: None), (8.0, None), "um").dx
    2.0
    """
    sides, shape = [*field], channel.shape
    if min(shape) < 1 or any(side is not None and not 0 < side < np.inf for side in sides):
        lengths = " x ".join("?" if side is None else f"{side:g}" for side in sides)
        raise InputFileError(f"its header is damaged: {shape[0]} x {shape[1]} points on {lengths} are no map")
    dx, dy = (side and side / count for side, count in zip(sides, shape[::-1], strict=True))
    return replace(channel, dx=dx, dy=dy, lateral_unit=lateral_unit or None)


def stated_length(value: Any) -> float | None:
    """Return a length of a header; zero, a negative number and none stand for one that it does not say."""
    return float(value) if value and 0 < value < np.inf else None


def counted_channels(channels: Iterable[Channel]) -> list[Channel]:
    """Return channels, and refuse a file of more than 10 000 before all of them are made."""
    counted = list(islice(channels, MAX_CHANNELS + 1))
    check_count(len(counted))
    return counted


def choose_channel(file: MeasuredFile, choice: str | None, *, has_unit: bool = False) -> tuple[Channel, str]:
    """Return the channel of that name, else the first that holds heights, and a sentence on the choice.

    A height channel has a length unit, and no amplitude, phase, error or the like by name; where the
    user gives a unit (`has_unit`), the values of an only channel are heights.

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
        raise refusal("no such channel", choice=str(choice), listing=listing, together=together)
    if file.question:
        raise refusal("several channels", question=file.question, listing=listing, together=together)
    is_height = has_unit and len(names) == 1
    heights = [channel for channel in file.channels if is_height or not channel.no_height]
    if not heights:
        reasons = "; ".join(f"{channel.name!r}: {channel.no_height}" for channel in file.channels)
        raise refusal("no heights", reasons=reasons or "it has none")
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
        raise InputFileError(f"values of type {plain.dtype}, not real numbers; store heights as float64")
    with np.errstate(all="ignore"):  # a NaN of single precision may be a signalling one
        heights = np.array(plain, dtype=float, ndmin=2)
    heights[np.atleast_2d(np.ma.getmaskarray(np.ma.asarray(values))) | ~np.isfinite(heights)] = np.nan
    if np.nanmax(np.abs(heights), initial=0.0) > MIN_MARKER:
        for marker in _MARKERS:
            heights[np.abs(np.abs(heights) / marker - 1) < 1e-5] = np.nan
    return heights


def stored_floats(path: Path, number_type: str, shape: tuple[int, int], start: int) -> np.ndarray:
    """Return the heights (ny, nx) that a file stores row by row from the byte `start` on."""
    return as_heights(np.fromfile(path, number_type, prod(shape), offset=start).reshape(shape))
