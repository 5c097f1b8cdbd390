"""Points, steps and runs of a map that do not continue their neighbours: signs of damage without a checksum.

The deviations of measured maps fall off without a gap: edges, scratches, particles and scars come in numbers
or in the size of their neighbours. One bit, or one block of a file in another place, leaves few deviations
far above all others. What is far is compared with the largest of the others, never with a fixed height; the
limits lie beyond what the maps of some hundred public files of instruments show.
"""

import numpy as np

from roughcontact.quantities import quantity

_FEW = 100  # points of a map below which its heights are not compared with each other
_LEAST_ROWS = 10
_STEPS_APART = 2.5  # the largest step along the rows over the fifth
_GAP = 4.0  # between a deviation of a point and the next smaller one
_WIDEST_GAP = 1e4
_MARGIN = 2  # points that a cubic needs on each side
_AT_ONCE = 2**20  # points
_LEAST_SIDE = 8
_CLIP = 30.0  # of a change, over the median: a few spikes are no run
_SAMPLE = 2**18  # points from which the median is found
_PIECES = 16  # of a row
_SHORTEST = 3  # points of a piece
_MOST_RUNS = 6  # two blocks, each with a beginning and an end, and two more
_RUNS_APART = (5.0, 3.0)  # the gap below one run, and below two and more


def steps_apart(height: np.ndarray) -> list[str]:
    """Suspect up to four steps along the rows that are far larger than all others.

    Edges and scratches cross many rows: on some sixty measured maps the largest step is at most 2.3 times the
    fifth, but for spikes, which have a warning of their own. Heights whose places in the file were exchanged
    leave such steps where they begin and end. Profiles may have few true edges.
    """
    if height.shape[0] < _LEAST_ROWS or height.size < _FEW:
        return []
    steps = np.abs(np.diff(height, axis=1)).ravel()
    steps = steps[np.isfinite(steps)]
    if steps.size < _FEW:
        return []
    most = np.sort(np.partition(steps, steps.size - 5)[-5:])
    if most[-1] <= _STEPS_APART * most[0] + 1e-6 * np.nanmax(np.abs(height)) or most[0] == 0:
        return []
    sentence = (
        f"a few steps between neighbours in a row are up to {quantity(most[-1], 'm')}, all others at most "
        f"{quantity(most[0], 'm')}: spikes, or heights that were damaged or exchanged in the file"
    )
    return [sentence]


def points_apart(height: np.ndarray) -> list[str]:
    """Suspect one to four points that deviate from their neighbours more than any other point, by far.

    The deviation is the distance to the nearest of the neighbours, or to the nearest of the cubics through
    them in four directions where these leave the point on the same side; edges and ridges have a direction
    that does not. Corners and tips, which continue a curve from one side, are left out.
    """
    if height.size < _FEW:
        return []
    rounding = 1e-6 * np.nanmax(np.abs(height))
    for deviations, margin, what in (
        (_from_nearest(height), 0, "the nearest neighbour"),
        (_from_curves(height), _MARGIN, "the curves through their neighbours"),
    ):
        if deviations.size < _FEW:
            continue
        places = np.argpartition(deviations, deviations.size - 5, axis=None)[-5:]
        places = places[np.argsort(deviations.flat[places])][::-1]
        most = deviations.flat[places]
        for count in range(4, 0, -1):
            one, next_one = most[count - 1], most[count]
            # drawn surfaces, as a pyramid, have a tip and no other point off its neighbours
            if one <= _GAP * next_one + rounding or next_one <= one / _WIDEST_GAP:
                continue
            found = np.transpose(np.unravel_index(places[:count], deviations.shape)) + margin
            if margin and any(_continues(height, row, column, 0.1 * one) for row, column in found):
                continue
            points = f"{count} points differ" if count > 1 else "1 point differs"
            sentence = (
                f"{points} from {what} by {quantity(one, 'm')} and more, all others by "
                f"{quantity(next_one, 'm')} at most: a spike, or a number that was damaged in the file"
            )
            return [sentence]
    return []


def _continues(height: np.ndarray, row: int, column: int, limit: float) -> bool:
    """Return whether a point lies within a limit of a parabola through three points on one side of it."""
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1), (0, -1), (-1, 0), (-1, -1), (-1, 1)):
        rows, columns = (start + step * np.arange(4) for start, step in ((row, down), (column, right)))
        last = rows[-1], columns[-1]
        if min(last) >= 0 and last[0] < height.shape[0] and last[1] < height.shape[1]:
            line = height[rows, columns]
            if abs(line @ (1, -3, 3, -1)) < limit:
                return True
    return False


def _from_nearest(height: np.ndarray) -> np.ndarray:
    """Return the distances to the nearest neighbour in row and column, without map-sized stacks."""
    nearest = np.full(height.shape, np.inf)
    for axis in (0, 1):
        steps = np.abs(np.diff(height, axis=axis))
        steps[np.isnan(steps)] = np.inf
        one, other = (np.s_[:, :-1], np.s_[:, 1:]) if axis else (np.s_[:-1], np.s_[1:])
        np.minimum(nearest[one], steps, out=nearest[one])
        np.minimum(nearest[other], steps, out=nearest[other])
    nearest[np.isinf(nearest)] = 0.0  # without a measured neighbour
    return nearest


def _from_curves(height: np.ndarray) -> np.ndarray:
    """Return the smallest deviation from cubics in four directions, 0 where these do not agree in sign."""
    ny, nx = height.shape
    if min(ny, nx) < 5:
        return np.zeros((0, 0))
    found = np.empty((ny - 4, nx - 4))
    rows = max(1, _AT_ONCE // nx)
    for first in range(0, ny - 4, rows):
        part = height[first : first + rows + 4]
        inner = len(part) - 4

        def at(down: int, right: int, part: np.ndarray = part, inner: int = inner) -> np.ndarray:
            return part[2 + down : 2 + down + inner, 2 + right : nx - 2 + right]

        curves = [
            (4 * (at(a, b) + at(-a, -b)) - at(2 * a, 2 * b) - at(-2 * a, -2 * b)) / 6
            for a, b in ((0, 1), (1, 0), (1, 1), (1, -1))
        ]
        off = at(0, 0) - np.array(curves)
        known = np.isfinite(off).sum(axis=0) > 1
        smallest = np.maximum(np.fmin.reduce(off), -np.fmax.reduce(off))
        found[first : first + rows] = np.where(known, np.maximum(smallest, 0.0), 0.0)
    return found


def runs_apart(values: np.ndarray) -> list[str]:
    """Suspect few runs of numbers that do not continue the rows, or columns, beside them.

    A block of a file in another place is a run of foreign numbers: the steps from the row before to it, and
    from it to the row behind, change from point to point as nowhere else. (A shift of a whole row or a part
    of it, a usual fault of a scan, changes them at its ends alone.) Where the run is longer than a row, the
    steps to its first row are foreign from its beginning, those to its second up to there. Edges and
    particles have no such steps in the next row, or have them in many rows.

    Parameters
    ----------
    values : array (ny, nx)
        As the file has them, in its order; NaN where not measured.

    Returns
    -------
    list of str

    Examples
    --------
    >>> y, x = np.indices((60, 80))
    >>> values = np.sin(x / 7 + y / 9) + 0.01 * np.random.default_rng(1).standard_normal((60, 80))
    >>> runs_apart(values)
    []
    >>> values[20, 10:50], values[40, 30:70] = values[40, 30:70].copy(), values[20, 10:50].copy()
    >>> runs_apart(values)[0][:47]
    'numbers around rows 21, 41 of the file do not c'
    """
    if min(values.shape) < _LEAST_SIDE:
        return []
    for table, name in ((values, "row"), (values.T, "column")):
        if places := _apart(_beside_others(_changes(table))):
            several = "s" if len(places) > 1 else ""
            numbers = ", ".join(map(str, places))
            sentence = (
                f"numbers around {name}{several} {numbers} of the file do not continue those beside them, as "
                "all others do: scars of the scan, or heights that were damaged or exchanged in the file"
            )
            return [sentence]
    return []


def _changes(table: np.ndarray) -> np.ndarray:
    """Return the mean change along the row of the steps between rows (step, piece of the row)."""
    ny, nx = table.shape
    some = np.arange(0, ny - 1, max(1, table.size // _SAMPLE))
    sample = np.abs(np.diff(table[some + 1] - table[some], axis=1))
    sample = sample[sample > 0]
    limit = _CLIP * np.median(sample) if sample.size else np.inf
    starts = np.linspace(0, nx - 1, min(_PIECES, nx // _SHORTEST), endpoint=False).astype(int)
    found = []
    rows = max(1, _AT_ONCE // nx)
    for first in range(0, ny - 1, rows):
        changes = np.abs(np.diff(np.diff(table[first : first + rows + 1], axis=0), axis=1))
        known = np.isfinite(changes)
        sums = np.add.reduceat(np.where(known, np.minimum(changes, limit), 0.0), starts, axis=1)
        counts = np.add.reduceat(known, starts, axis=1, dtype=int)
        enough = counts > (nx - 1) // starts.size // 2
        found.append(np.where(enough, sums / np.maximum(counts, 1), 0.0))
    return np.concatenate(found)


def _beside_others(changes: np.ndarray) -> np.ndarray:
    """Return the changes over what four of the six rows two to four away have at most, or half of the map."""
    if not changes.any():
        return changes
    others = np.zeros((6, *changes.shape))
    for place, away in enumerate((2, 3, 4)):
        others[2 * place, away:], others[2 * place + 1, :-away] = changes[:-away], changes[away:]
    return changes / np.maximum(np.sort(others, axis=0)[3], np.median(changes[changes > 0]))


def _apart(changes: np.ndarray) -> list[int]:
    """Return the rows, counted from 1, around which the changes are far larger than anywhere else."""
    pieces = changes.shape[1]
    sums = np.pad(np.cumsum(changes, axis=1), ((0, 0), (1, 0)))
    off = np.zeros(len(changes) - 1)
    for width in {2, max(2, pieces // 3), pieces}:  # a part of a row
        means = (sums[:, width:] - sums[:, :-width]) / width
        np.maximum(off, np.minimum(means[:-1], means[1:]).max(axis=1), out=off)
    for left in range(2, pieces - 1):  # more than a row
        before, behind = sums[:, left] / left, (sums[:, -1] - sums[:, left]) / (pieces - left)
        usual = np.maximum(np.maximum(before[:-1], behind[1:]), 1.0)
        np.maximum(off, np.minimum(behind[:-1], before[1:]) / usual, out=off)
    places, heights = [], []
    for _ in range(_MOST_RUNS + 1):
        place = int(np.argmax(off))
        places.append(place + 2)
        heights.append(off[place])
        off[max(place - 2, 0) : place + 3] = 0.0
    gaps = np.array(heights[:-1]) / np.maximum(heights[1:], 1.0)
    gaps /= np.where(np.arange(_MOST_RUNS) < 1, *_RUNS_APART)
    most = int(np.argmax(gaps))
    return sorted(set(places[: most + 1])) if gaps[most] > 1 else []
