"""Positions along x and y: even steps, also within their rounding, and points that form no even grid."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from roughcontact.errors import InputFileError
from roughcontact.io.channels import Channel, Points

#: Along one axis a step, or positions in the file's units.
Positions = np.ndarray | float | None
_LONGEST = 1e100  # of positions, whose squares must be finite


class UnevenPositionsError(InputFileError):
    """Positions that form no even grid; readers catch it and return the points as they are."""


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
