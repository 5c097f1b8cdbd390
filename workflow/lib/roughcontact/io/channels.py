"""The result of a reader: the channels of one file, in the file's own units."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from roughcontact.errors import InputFileError
from roughcontact.io import instrument_kinds
from roughcontact.io.guards import MAX_POINTS
from roughcontact.io.markers import remove_marker_values
from roughcontact.io.units import is_length

_LEAST_MARKER = 1e36  # no unit makes a height so large
_LISTED = 8  # names in a message
_LONGEST = 1e100  # of positions, whose squares must be finite


class UnevenPositionsError(InputFileError):
    """Positions that form no even grid; readers catch it and return the points as they are."""


class Points(NamedTuple):
    """Points that form no even grid, in the file's units.

    Attributes
    ----------
    x, y, z : array (n,)
        One entry per point; y is None for a profile.
    uneven : str
        Why the positions form no even grid.
    """

    x: np.ndarray
    y: np.ndarray | None
    z: np.ndarray
    uneven: str


@dataclass
class Channel:
    """One map or profile of a file. None: not stated in the file.

    Attributes
    ----------
    name : str
        As the file calls it.
    shape : tuple of int
        (ny, nx); ny is 1 for a profile.
    read : callable () -> array (ny, nx)
        Returns the heights in `height_unit` as float64, NaN where not measured, in the order of the file's
        rows (`first_row`). For a channel without heights it may raise `InputFileError` instead.
    height_unit, lateral_unit : str or None
        Units of the heights; of the steps and positions.
    dx, dy : float or None
        Steps, in `lateral_unit`.
    first_x, first_y : float or None
        Position of the first cell centre, in `lateral_unit`; None: half a step.
    no_height : str
        Why this channel holds no heights; empty for a height channel. A unit that is no length is a reason.
    size_rounding : tuple of float or None
        Where the steps are a total size over the number of points found: relative rounding errors of the
        stated sizes along x and y.
    doubt : str
        Why the channel cannot be read as it is.
    otherwise : Channel or None
        The same numbers as a map, where they may be points or a map; used if the user gives both steps.
    points : Points or None
        The points themselves, where they form no even grid.
    notes : list of str
        Statements of the header that the user should know.
    first_row : str
        Where row 0 lies, if not as in the rest of the file; counts as assumed.
    """

    name: str
    shape: tuple[int, int]
    read: Callable[[], np.ndarray]
    height_unit: str | None = None
    dx: float | None = None
    dy: float | None = None
    lateral_unit: str | None = None
    first_x: float | None = None
    first_y: float | None = None
    no_height: str = ""
    size_rounding: tuple[float, ...] | None = None
    doubt: str = ""
    otherwise: "Channel | None" = None
    points: Points | None = None
    notes: list[str] = field(default_factory=list)
    first_row: str = ""

    def __post_init__(self) -> None:
        if not self.no_height and self.height_unit is not None and not is_length(self.height_unit):
            self.no_height = f"values in {self.height_unit}, no length"


@dataclass
class MeasuredFile:
    """One opened file.

    Attributes
    ----------
    format : str
        Name of the format, for people.
    channels : list of Channel
        In the file's order.
    first_row : str
        Where row 0 lies in the picture that the instrument's own software shows: ``top`` or ``bottom``.
    instrument : dict
        Metadata of the instrument, with the keys of `roughcontact.io.metadata`.
    warnings : list of str
        Warnings about the file as a whole.
    stale : str
        Which checksum or size that the file states differs from its content; empty where none does.
    first_row_assumed : bool
        Whether neither the file nor its format states `first_row`, so that it is only the usual convention.
    question : str
        What the file has several of, where the user has to name one; empty where the first will do.
    """

    format: str
    channels: list[Channel]
    first_row: str
    instrument: dict[str, Any] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    stale: str = ""
    first_row_assumed: bool = False
    question: str = ""

    def rows_of(self, channel: Channel) -> tuple[str, bool]:
        """Return where row 0 of a channel lies, ``top`` or ``bottom``, and whether that is only assumed.

        Parameters
        ----------
        channel : Channel
            Of this file.

        Returns
        -------
        tuple of str and bool
        """
        if channel.first_row:
            return channel.first_row, True
        return self.first_row, self.first_row_assumed

    @property
    def kind(self) -> instrument_kinds.Kind:
        """The kind of instrument that the file names, with the ranges that it can measure."""
        return instrument_kinds.of_name(self.instrument.get("kind"))


def choose_channel(
    file: MeasuredFile, requested: str | None, where: str, *, unit_given: bool = False
) -> tuple[Channel, str]:
    """Return the channel to use and a sentence that says how it was chosen.

    Parameters
    ----------
    file : MeasuredFile
    requested : str or None
        Name of the channel. Without it, it is the first one that holds heights (a length unit, and no
        amplitude, phase, error or the like by name).
    where : str
        Place that error messages name.
    unit_given : bool
        Whether the user gives the unit of the heights, which makes the values of an only channel heights.

    Returns
    -------
    tuple of Channel and str

    Raises
    ------
    InputFileError
        Where no channel has the wanted name, or none holds heights.

    Examples
    --------
    >>> names = {"Phase": "values in deg, no length", "Topography": "", "Topography back": ""}
    >>> channels = [Channel(name, (2, 2), lambda: None, no_height=why) for name, why in names.items()]
    >>> file = MeasuredFile("some format", channels, "top")
    >>> choose_channel(file, None, "map.dat")[1]
    "'Topography', the first height channel of 3"
    >>> choose_channel(file, "topography BACK", "map.dat")[1]
    "'Topography back', named by the user"
    """
    names = [channel.name for channel in file.channels]
    listing = ", ".join(map(repr, names[:_LISTED])) + (", ..." if len(names) > _LISTED else "")
    if requested is None and file.question:
        raise InputFileError(
            f"{where}: {file.question}; name one with channel (table of surfaces or argument), of {listing}; "
            "or all, in a row each, as repeats of one part of a group"
        )
    if requested is None:
        for channel in file.channels:
            if not channel.no_height or (unit_given and len(names) == 1):
                chosen = f"the first height channel of {len(names)}" if len(names) > 1 else "the only channel"
                return channel, f"{channel.name!r}, {chosen}"
        reasons = "; ".join(f"{channel.name!r}: {channel.no_height}" for channel in file.channels)
        raise InputFileError(
            f"{where}: no channel of this file holds heights ({reasons or 'it has none'}); if one does, "
            "name it with channel and give height_unit"
        )
    matches = [channel for channel in file.channels if channel.name == str(requested)]
    if not matches:
        matches = [c for c in file.channels if c.name.casefold() == str(requested).strip().casefold()]
    if len(matches) != 1:
        raise InputFileError(f"{where}: no channel is named {str(requested)!r}; the file has {listing}")
    return matches[0], f"{matches[0].name!r}, named by the user"


def unreadable(message: str) -> Callable[[], np.ndarray]:
    """Return the `read` of a channel without numbers: it raises InputFileError with this message.

    Parameters
    ----------
    message : str

    Returns
    -------
    callable
    """

    def read() -> np.ndarray:
        raise InputFileError(message)

    return read


def oversized(name: str, shape: tuple[int, ...], path: Path) -> Channel:
    """Return the channel of an array with more points than are read."""
    why = f"{' x '.join(map(str, shape))} points, more than the {MAX_POINTS} that are read; crop the map"
    doubt = f"variable {name!r} has {why}"
    return Channel(name, (1, prod(shape)), unreadable(f"{path}: {doubt}"), no_height=why, doubt=doubt)


def as_heights(values: ArrayLike, where: str, *, missing: float | None = None) -> np.ndarray:
    """Return values as a map of heights.

    Parameters
    ----------
    values : array (ny, nx) or (nx,)
        Real numbers of any type; also a masked array.
    where : str
        Place that the message names.
    missing : float, optional
        The value that stands for a missing point.

    Returns
    -------
    array (ny, nx)
        A copy, float64; NaN where masked, infinite, equal to `missing`, or one of the numbers beyond all
        heights that mark missing points (`io.markers`).

    Raises
    ------
    InputFileError
        Where the values are not real numbers.

    Examples
    --------
    >>> as_heights([1, 2, -9999], "map.dat", missing=-9999)
    array([[ 1.,  2., nan]])
    """
    mask = np.ma.getmaskarray(values) if isinstance(values, np.ma.MaskedArray) else None
    plain = np.asarray(np.ma.getdata(values))
    if plain.dtype.kind not in "iuf":
        raise InputFileError(
            f"{where}: the values are of type {plain.dtype}, not real numbers; store heights as float64"
        )
    with np.errstate(all="ignore"):  # a NaN of single precision may be a signalling one
        heights = np.array(plain, dtype=float, ndmin=2)
    if mask is not None:
        heights[np.atleast_2d(mask)] = np.nan
    if missing is not None:
        heights[heights == missing] = np.nan
    heights[~np.isfinite(heights)] = np.nan
    if np.nanmax(np.abs(heights), initial=0.0) > _LEAST_MARKER:
        remove_marker_values(heights)
    return heights


@np.errstate(all="ignore")  # infinite positions are not even
def even_step(positions: ArrayLike, name: str) -> float:
    """Return the step of evenly spaced positions.

    Parameters
    ----------
    positions : array (n,)
        Two or more.
    name : str
        Name of the axis, for the message.

    Returns
    -------
    float
        Negative for positions that decrease.

    Raises
    ------
    UnevenPositionsError
        Where a position is off the even grid by more than 2 % of a step, which rounding does not explain.

    Examples
    --------
    >>> even_step([0.0, 0.501, 1.0], "x")
    0.5
    """
    positions = np.asarray(positions, dtype=float)
    step = float((positions[-1] - positions[0]) / (positions.size - 1))
    deviation = np.max(np.abs(positions - positions[0] - step * np.arange(positions.size)))
    if not np.isfinite(step) or step == 0 or not deviation <= 0.02 * abs(step):
        worst = (
            ""
            if not step or not np.isfinite(deviation)
            else f": up to {deviation / abs(step):.2g} of a step off"
        )
        raise UnevenPositionsError(f"the positions along {name} are not evenly spaced{worst}")
    return step


@np.errstate(all="ignore")
def rounded_step(positions: ArrayLike) -> float | None:
    """Return the step of positions that are even but for the rounding of their last decimal.

    Fifty and more positions, all of them multiples of a power of ten that is no more than the step, within
    0.55 of it from a straight line: a list with gaps strays further.

    Parameters
    ----------
    positions : array (n,)
        Increasing.

    Returns
    -------
    float or None
        None for other positions.

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


def scattered(
    name: str, x: ArrayLike, y: ArrayLike | None, z: ArrayLike, error: UnevenPositionsError, **attributes: Any
) -> Channel:
    """Return a channel of points that form no even grid: it can be read only by resampling.

    Parameters
    ----------
    name : str
        Name of the channel.
    x, y, z : arrays of equal size, in the file's units
        `y` is None for a profile. Points without a height are left out.
    error : UnevenPositionsError
        Why the positions form no even grid.
    **attributes
        Further attributes of the channel, such as `lateral_unit` and `height_unit`.

    Returns
    -------
    Channel
        With `points`.

    Examples
    --------
    >>> error = UnevenPositionsError("the positions along x are not evenly spaced")
    >>> channel = scattered("height", [0.0, 1.0, 3.0], None, [5.0, np.nan, 7.0], error, lateral_unit="um")
    >>> channel.points.x, channel.points.z
    (array([0., 3.]), array([5., 7.]))
    """
    along_x, heights = (np.asarray(values, dtype=float).ravel() for values in (x, z))
    along_y = None if y is None else np.asarray(y, dtype=float).ravel()
    measured = np.isfinite(heights) & np.isfinite(along_x)
    if along_y is not None:
        measured &= np.isfinite(along_y)
        along_y = along_y[measured]
    points = Points(along_x[measured], along_y, heights[measured], str(error))
    return Channel(name, (1, points.z.size), points.z[None, :].copy, points=points, **attributes)
