"""Conversion of a file's channels to one map in metres: channel, even grid, scale, orientation.

Every map is right-handed, the height towards the viewer, row 0 the bottom line of the picture.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from roughcontact.arguments.checking import marker_values
from roughcontact.errors import HeightMapError, InputFileError
from roughcontact.io import instrument_kinds
from roughcontact.io.channels import NO_TOPOGRAPHY, Channel, MeasuredFile, choose_channel
from roughcontact.io.guards import refusal
from roughcontact.io.plausibility import Suspicion, suspicions
from roughcontact.io.positions import scattered
from roughcontact.io.request import Request
from roughcontact.io.resampling import resample_evenly
from roughcontact.io.scale import decide_scale
from roughcontact.io.sources import lines_not_used, sources
from roughcontact.io.text.axes import find_axes

_MAX_HEIGHT = 1e5  # m; higher than any mountain
_USUAL_MARKERS = (-9999.0, -99999.0)  # of missing points, where no header says so


@dataclass(frozen=True)
class Converted:
    """One map or profile in metres, on an even grid."""

    channel: Channel  # on its even grid, in the file's units
    choice: str  # which channel was chosen, and why
    heights: np.ndarray  # (ny, nx), m, NaN where not measured; row 0 is the bottom line
    dx: float  # m
    dy: float  # m
    notes: list[str]  # sentences for the user
    facts: list[str]  # those that say what the user asked for
    sources: dict  # column of the table -> where it comes from; "not used" -> lines of the header
    first_row: str  # of the file, in the picture: `top` or `bottom`
    first_row_assumed: bool
    doubts: list[Suspicion]  # what is implausible in metres

    def centres(self) -> Iterator[np.ndarray]:
        """Yield the cell centres along x and y (m, rising), from the file's first one or half a step."""
        (ny, nx), channel = self.heights.shape, self.channel
        for n, step, origin in ((nx, self.dx, channel.first_x), (ny, self.dy, channel.first_y)):
            first = 0.5 * step if origin is None or not channel.dx else origin * (self.dx / channel.dx)
            yield first + step * np.arange(n)


def convert(file: MeasuredFile, request: Request) -> Converted:
    """Return the map of a file that the user asks for, in metres."""
    channel, choice = choose_channel(file, request.channel, has_unit=request.height_unit is not None)
    notes = file.warnings + channel.notes + _checksum_notes(file, request)
    if channel.no_height:
        notes.append(f"channel {channel.name!r} is read as heights on request ({channel.no_height})")
    elif request.channel is None and NO_TOPOGRAPHY.search(channel.name):
        notes.append(f"channel {channel.name!r} is read as heights, which by its name it does not hold")
    if channel.doubt:
        if request.resample is not None or not request.has_steps(channel.shape):
            raise InputFileError(channel.doubt)
        size = "{} rows of {}".format(*channel.shape)
        notes.append(f"the numbers are read as a map of {size}, because dx and dy are given")
    # before the points are interpolated: a marker among them would spread into the heights around it
    channel, marker_notes = _drop_markers(channel, request)
    channel, request, resampling = resample_evenly(channel, request)
    steps, unit_factor, scale_notes = decide_scale(channel, request)
    factor = unit_factor * channel.count_height
    numbers = channel.read()
    for marker in _USUAL_MARKERS if request.missing_value is None else ():
        if (count := np.count_nonzero(numbers == marker)) > 1:
            missing = "if that marks missing points, missing_value states it"
            notes.append(f"{count} points are {marker:g}: {missing}")
    # formats other than text have places for positions: what looks like them is only named
    if axes := find_axes(numbers):
        notes.append(axes[2].replace("is taken as", "may be").replace(", and left out", ""))
    with np.errstate(over="ignore"):  # infinite heights are refused below
        heights = _checked(numbers * factor)
    header_lines, remarks = lines_not_used(channel, request, steps, factor, numbers)
    origins = sources(file, channel, request) | {"not used": header_lines}
    first_row, is_assumed, turn_notes = _first_row(file, channel, request)
    if first_row == "top":
        heights = np.ascontiguousarray(heights[::-1])
    facts = [*marker_notes, *resampling, *scale_notes, *turn_notes]
    notes += [*remarks, *facts]
    doubts = suspicions(heights, *steps, kind=instrument_kinds.of_name(file.instrument.get("kind")))
    return Converted(channel, choice, heights, *steps, notes, facts, origins, first_row, is_assumed, doubts)


def _drop_markers(channel: Channel, request: Request) -> tuple[Channel, list[str]]:
    """Return a channel without the numbers that mark missing points by the user, and how often they occur."""
    if not (markers := marker_values(request.missing_value)):
        return channel, []
    values, points = np.array(channel.read(), dtype=float), channel.points
    is_marker = np.any([np.isclose(values, marker, rtol=1e-6, atol=0.0) for marker in markers], axis=0)
    note = f"{is_marker.sum()} points are {request.missing_value} and taken as missing (missing_value)"
    values[is_marker] = np.nan
    if points is not None:
        return scattered(channel, points.x, points.y, values, points.uneven), [note]
    return replace(channel, read=lambda: values), [note]


def _first_row(file: MeasuredFile, channel: Channel, request: Request) -> tuple[str, bool, list[str]]:
    """Return where row 0 of the file lies, whether that is assumed, a note if the user overrides the file."""
    orientation = channel.first_row or file.first_row
    is_assumption = bool(channel.first_row) or file.first_row_assumed
    if request.first_row is None or channel.is_line:  # a profile has only one row
        return orientation, is_assumption and not channel.is_line, []
    is_other = not is_assumption and request.first_row != orientation
    note = f"first_row = {request.first_row} is given, the file has its first row at the {orientation}"
    return request.first_row, False, [note] * is_other


def _checksum_notes(file: MeasuredFile, request: Request) -> list[str]:
    """Refuse a file that differs from its checksum, or return a note where the user wants it read."""
    if not file.stale:
        return []
    if request.checksum is None:
        raise refusal("wrong checksum", stale=file.stale, format=file.format.partition(" (")[0])
    return [f"{file.stale}: read nevertheless, as asked (checksum = ignore)"]


def _checked(heights: np.ndarray) -> np.ndarray:
    """Return plausible heights (m), or raise an error that says why they are no measurement."""
    if heights.size == 1:
        raise HeightMapError("the map has a single point; a map or a profile needs at least two")
    if not np.isfinite(heights).any():
        raise HeightMapError(f"all {heights.size} points of the map are missing; check the channel")
    if (largest := np.nanmax(np.abs(heights))) > _MAX_HEIGHT:
        raise refusal("no measured heights", HeightMapError, largest=largest)
    return heights
