"""Positions in the first row and column of a matrix, with or without a cell in the corner."""

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.text.traces import are_traces, runs

_FEW_POSITIONS = 6  # positions in a row or column alone; fewer are even by chance, unless they begin at 0
_MIN_FROM_ZERO = 4
_MANY_POSITIONS = 12  # positions
_MIN_AMONG_HEIGHTS = 8  # positions; fewer levels of a quantised map may be even
# of a step: largest deviation of few positions, and of many, which may be rounded
_CLOSE, _ROUNDED = 0.02, 0.06
_EXACT = 1e-3  # of a step: largest deviation of a row among heights
_STEP_RATIO = 2.0  # ratio of the steps of lines of heights, which are even on a tilted plane
# of the usual distance of two rows: that of rows of one part of wrapped lines; of that of
# neighbouring points: where the parts join
_ALIKE, _JOINED = 0.75, 1.7
_COMPARED = 50  # rows or columns that would be even as well if the first one were heights


Axes = tuple[np.ndarray, dict[str, float], str]


def find_axes(values: np.ndarray, *, corner: bool = False, positions: bool = False) -> Axes | None:
    """Return the heights of a table by the rising positions beside them, the steps of these, and a sentence.

    The steps are `dx` and `dy`; the sentence says what was taken for positions. None: there are none.

    Positions are a first row or column that is an even progression, as the others are not; the cell that both
    share, which is empty if `corner`, is no height. Counts from 0 or 1 may number the rows, unless they are
    known as `positions`.

    Examples
    --------
    >>> heights = np.random.default_rng(1).normal(size=(6, 5))
    >>> find_axes(np.vstack([np.arange(5) / 2, heights]))[1:]
    ({'dx': 0.5}, 'the first row (0, 0.5, 1 ...) is taken as positions along x')
    >>> find_axes(heights) is None
    True
    """
    if min(values.shape) < 3:
        return None
    x, y = _progression(values[0, 1:], values[1:, 1:]), _progression(values[1:, 0], values[1:, 1:].T)
    if not corner and (x is None or y is None or min(values.shape) <= _MIN_FROM_ZERO):
        # one of them, from the corner on
        min_points = _MIN_FROM_ZERO if values[0, 0] == 0 else _FEW_POSITIONS
        x = _progression(values[0], values[1:]) if values.shape[1] >= min_points else None
        y = _progression(values[:, 0], values[:, 1:].T) if x is None and len(values) >= min_points else None
    if (x is None and y is None) or (corner and (x is None or y is None)):
        return None
    rows, columns = int(x is not None), int(y is not None)
    steps, notes, heights = {}, [], values[rows:, columns:]
    for name, line, step in (("row", values[0, columns:], x), ("column", values[rows:, 0], y)):
        if step is None:
            continue
        example = ", ".join(f"{number:g}" for number in line[:3])
        axis = "x" if name == "row" else "y"
        description = f"positions along {axis}"
        if step == 1 and line[0] in (0, 1) and not positions:
            description = "numbers or positions, and left out"
            description += "; if positions, first_row is bottom" * (axis == "y")
        else:
            steps["d" + axis] = abs(step)
        notes.append(f"the first {name} ({example} ...) is taken as {description}")
        if step < 0:
            heights = np.flip(heights, axis="yx".index(axis))
    return heights, steps, "; ".join(notes)


def uneven(values: np.ndarray) -> str:
    """Return which of the first row and column holds uneven positions, beside even ones; or nothing.

    Examples
    --------
    >>> heights = np.random.default_rng(1).normal(size=(6, 5))
    >>> uneven(np.column_stack([np.arange(7), np.vstack([np.arange(5) ** 2, heights])]))
    'row'
    """
    if min(values.shape) < _FEW_POSITIONS:
        return ""
    for name, table in (("row", values), ("column", values.T)):
        even = _progression(table[1:, 0], table[1:, 1:].T) is not None
        rises = [abs(np.sign(np.diff(line)).sum()) == line.size - 1 for line in table[:_COMPARED, 1:]]
        if even and rises[0] and 2 * sum(rises) < len(rises):
            return name
    return ""


def form_a_grid(x: np.ndarray, y: np.ndarray) -> bool:
    """Return whether positions (n,) are those of a whole grid of three lines and more each way."""
    lines = [np.unique(positions).size for positions in (x, y)]
    return min(lines) >= 3 and lines[0] * lines[1] == x.size


def refuse_points(values: np.ndarray) -> None:
    """Refuse an array of points, in columns or in rows, where heights are wanted."""
    if values.ndim == 2 and (are_points(values) or are_points(values.T)):
        raise InputFileError("points, not heights; save the heights alone, or the points as text")


def are_points(table: np.ndarray) -> bool:
    """Return whether the columns of a table are x and z, or x, y and z of points on a grid."""
    if table.shape[1] == 2:
        return len(table) >= _FEW_POSITIONS and _progression(table[:, 0], table[:, 1:].T) is not None
    return table.shape[1] == 3 and form_a_grid(table[:, 0], table[:, 1])


def begins_anew(values: np.ndarray) -> int:
    """Return the row at which positions in the first columns or row begin anew, or a row of positions; or 0.

    Examples
    --------
    >>> heights = np.random.default_rng(1).normal(size=(15, 4))
    >>> begins_anew(np.column_stack([np.tile(np.arange(5), 3), heights]))
    5
    """
    if min(values.shape) < _MIN_FROM_ZERO:
        return 0
    # the first column, one behind a counter, or the first below a row of positions
    for offset, column in ((0, values[:, 0]), (0, values[:, 1]), (1, values[1:, 0])):
        monotonic_runs = runs(column)
        even = all(_step(column[run]) is not None for run in monotonic_runs)
        if len(monotonic_runs) > 1 and even and are_traces(column, monotonic_runs):
            return offset + monotonic_runs[1].start
    repeated_rows = np.flatnonzero(np.all(values[1:, 1:] == values[0, 1:], axis=1))
    if repeated_rows.size and _progression(values[0, 1:], values[1:, 1:]) is not None:
        return int(repeated_rows[0]) + 1
    return _row_of_positions(values[:, 1:]) or _row_of_positions(values[:, :-1])


def wrapped(values: np.ndarray) -> str:
    """Return a sentence where rows are the second, third or fourth parts of longer ones; else nothing.

    Rows are then most like those of the same part, and their ends like the next one's beginnings.

    Examples
    --------
    >>> heights = np.add.outer(np.arange(8) ** 2.0, 30 * np.sin(np.arange(20) / 3))
    >>> wrapped(heights), wrapped(heights.reshape(16, 10))[:45]
    ('', '2 lines each go on where the one above ends: ')
    """
    distances = [np.inf]  # of rows one, two ... lines apart
    for count in (1, 2, 3, 4) if values.shape[1] >= _MIN_FROM_ZERO else ():
        if len(values) < _MIN_FROM_ZERO * count:
            break
        distances.append(float(np.nanmean(np.abs(values[count:] - values[:-count]))))
        joins = np.abs(values[1:, 0] - values[:-1, -1])[np.arange(1, len(values)) % count != 0]
        is_wrapped = count > 1 and len(values) % count == 0 and distances[-1] < _ALIKE * min(distances[:-1])
        if is_wrapped and np.nanmean(joins) < _JOINED * np.nanmean(np.abs(np.diff(values))):
            return f"{count} lines each go on where the one above ends: if lines were wrapped, join them"
    return ""


def _row_of_positions(values: np.ndarray) -> int:
    """Return the first row below others whose many numbers are even to their digits, as few are; or 0."""
    steps = np.diff(values[:, :3])
    begins_even = np.isclose(steps[:, 0], steps[:, 1], rtol=_EXACT, atol=0.0) & (steps[:, 0] != 0)
    for row in np.flatnonzero(begins_even[1:]) + 1 if values.shape[1] >= _MIN_AMONG_HEIGHTS else ():
        differences = np.diff(values[row])
        even = np.allclose(differences, differences[0], rtol=_EXACT, atol=0.0)
        if even and _progression(values[row], values) is not None:
            return int(row)
    return 0


def _progression(line: np.ndarray, rows: np.ndarray) -> float | None:
    """Return the step of an even progression that most of the others are not, else None."""
    step = _step(line) if np.isfinite(line).all() else None
    # beside a line that is uneven, as those of most maps are, no other line counts
    even = [abs(row_step) for row in rows[:_COMPARED] if step and (row_step := _step(row)) is not None]
    # heights on a tilted plane are even too: positions stand out among the other rows, or are no positions
    like_rows = step is not None and even and min(even) / _STEP_RATIO <= abs(step) <= max(even) * _STEP_RATIO
    return None if like_rows and 2 * len(even) > len(rows[:_COMPARED]) else step


def _step(line: np.ndarray) -> float | None:
    """Return the step of numbers that are even within their rounding, None for others; NaN is left out."""
    positions = np.flatnonzero(np.isfinite(line))
    if positions.size < 2 or line[positions[0]] == line[positions[-1]]:
        return None
    step = (line[positions[-1]] - line[positions[0]]) / (positions[-1] - positions[0])
    deviation = np.max(np.abs(line[positions] - line[positions[0]] - step * (positions - positions[0])))
    limit = _CLOSE if positions.size < _MANY_POSITIONS else _ROUNDED
    return float(step) if deviation <= limit * abs(step) else None
