"""Conversion of lists of points x, y, z to the regular grid that they form."""

from collections.abc import Sequence

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.guards import check_points
from roughcontact.io.positions import UnevenPositionsError, even_step


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
        counts = f"({nx} different x, {ny} different y)"
        raise UnevenPositionsError(f"{z.size} points x y z do not form an even grid {counts}")
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
        wrong = f"several points of the list have the same position, the first is that in line {lines[index]}"
        raise InputFileError(f"{wrong}; leave one map in the file")


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
        steps = f"steps along {name} between {gaps.min():g} and {gaps.max():g}"
        raise UnevenPositionsError(f"the points x y z do not lie on an even grid ({steps})")
    starts = np.concatenate([[0], np.flatnonzero(gaps > limit) + 1])
    centres = np.add.reduceat(distinct, starts) / np.diff(np.append(starts, distinct.size))
    line = np.searchsorted(starts, np.searchsorted(distinct, positions), side="right") - 1
    return centres, line
