"""Positions along x and y: even steps, also within their rounding, and points that form a grid or none."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from roughcontact.errors import InputFileError
from roughcontact.io.channels import Channel, Points
from roughcontact.io.guards import check_points, refusal

#: Along one axis a step, or positions in the file's units.
Positions = np.ndarray | float | None
_LONGEST = 1e100  # of positions, whose squares must be finite


class UnevenPositionsError(InputFileError):
    """Positions that form no even grid; readers catch it and return the points as they are."""


@np.errstate(all="ignore")  # infinite positions are not even
def even_step(positions: np.ndarray, name: str) -> float:
    """Return the step of two or more positions (n,), negative for decreasing ones, even to 2 % of a step.

    Examples
    --------
    >>> even_step(np.array([0.0, 0.501, 1.0]), "x")
    0.5
    """
    step = float((positions[-1] - positions[0]) / (positions.size - 1))
    deviation = np.max(np.abs(positions - positions[0] - step * np.arange(positions.size)))
    if not np.isfinite(step) or step == 0 or not deviation <= 0.02 * abs(step):
        worst = f": up to {deviation / abs(step):.2g} of a step off" if step and deviation < np.inf else ""
        raise UnevenPositionsError(f"the positions along {name} are not evenly spaced{worst}")
    return step


@np.errstate(all="ignore")
def rounded_step(positions: np.ndarray) -> float | None:
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
    even = positions.size >= 50 and np.isfinite(positions).all()
    if not even or not 0 < positions[-1] - positions[0] < _LONGEST:
        return None
    number = np.arange(positions.size)
    step, start = np.polyfit(number, positions, 1)
    last = 10.0 ** np.floor(np.log10(step)) if step > 0 else 0.0
    if not last or np.max(np.abs(positions / last - np.rint(positions / last))) > 1e-3:
        return None
    return float(step) if np.max(np.abs(positions - start - step * number)) <= 0.55 * last else None


def channel_on_grid(channel: Channel, x: Positions, y: Positions, names: Sequence[str] = "xy") -> Channel:
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


@np.errstate(all="ignore")  # infinite positions form no grid
def points_on_grid(
    x: np.ndarray, y: np.ndarray, z: np.ndarray, lines: Sequence[int]
) -> tuple[np.ndarray, dict[str, float | None], tuple[float, float]]:
    """Return the map that points (n,) in any order form, NaN if absent, its steps and first position (x, y).

    Positions are sorted into lines by gaps larger than half the largest one, which tolerates rounding; the
    step along an axis of one line is None. `lines` are those of the file.

    Examples
    --------
    >>> x, y, z = np.array([[0, 0, 1], [2, 0, 2], [0, 3, 4], [2, 3, 5]]).T
    >>> heights, steps, first = points_on_grid(x, y, z, range(1, 5))
    >>> heights
    array([[1., 2.],
           [4., 5.]])
    >>> steps
    {'x': 2.0, 'y': 3.0}
    """
    _refuse_repeated(x + 1j * y, lines)
    along_x, column = _grid_lines(x, "x")
    along_y, row = _grid_lines(y, "y")
    nx, ny = along_x.size, along_y.size
    if z.size < 0.5 * nx * ny:
        raise refusal("few points of a grid", UnevenPositionsError, count=z.size, nx=nx, ny=ny)
    check_points((ny, nx))
    _refuse_repeated(row * nx + column, lines)  # within rounding
    # before the missing points are filled with NaN, which would hide that the list was cut off
    _refuse_cut_list(row, column)
    heights = np.full((ny, nx), np.nan)
    heights[row, column] = z
    positions = {"x": along_x, "y": along_y}
    steps = {axis: even_step(along, axis) if along.size > 1 else None for axis, along in positions.items()}
    return heights, steps, (float(along_x[0]), float(along_y[0]))


def _refuse_repeated(indices: np.ndarray, lines: Sequence[int]) -> None:
    """Refuse points with the place of one above."""
    _, unique = np.unique(indices, return_index=True)
    if unique.size < indices.size:
        index = int(np.setdiff1d(np.arange(indices.size), unique)[0])
        raise refusal("repeated position", line=lines[index])


def _refuse_cut_list(row: np.ndarray, column: np.ndarray) -> None:
    """Refuse a list in which only the grid line that stands last in the file is incomplete, at its end."""
    for line, across in ((row, column), (column, row)):
        last, counts = line == line[-1], np.bincount(line)
        line_count, counts_elsewhere = counts[line[-1]], np.delete(counts, line[-1])
        written_by_line = np.count_nonzero(np.diff(line)) == counts.size - 1
        short = counts_elsewhere.size and counts_elsewhere.min() == counts_elsewhere.max() > line_count
        if written_by_line and short and np.array_equal(across[last], across[~last][:line_count]):
            raise InputFileError("the list of points ends in the middle of a grid line: the file was cut off")


def _grid_lines(positions: np.ndarray, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the distinct positions of the grid lines and the line of each point."""
    distinct = np.unique(positions)
    if distinct.size == 1:
        return distinct, np.zeros(positions.size, dtype=int)
    gaps = np.diff(distinct)
    # positions of one line differ by their rounding, those of two by a step: nothing lies between
    limit = 0.5 * np.max(gaps)
    if np.any((gaps < limit) & (gaps > 0.02 * np.max(gaps))):
        raise refusal("uneven points", UnevenPositionsError, axis=name, low=gaps.min(), high=gaps.max())
    starts = np.concatenate([[0], np.flatnonzero(gaps > limit) + 1])
    centres = np.add.reduceat(distinct, starts) / np.diff(np.append(starts, distinct.size))
    return centres, np.searchsorted(starts, np.searchsorted(distinct, positions), side="right") - 1
