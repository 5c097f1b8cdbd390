"""Search for the position and size of the best periodic window of a map.

Every candidate has a score (`roughcontact.window.score`); the candidate with the lowest score is chosen.
"""

import math
from typing import NamedTuple

import numpy as np

from roughcontact.window.lay import lay_period
from roughcontact.window.score import WEIGHTS, Ranges, score_parts
from roughcontact.window.sides import band_points, is_friendly

MIN_SIDE_SHARE = 0.7  # of the side of the largest rectangle
_SIDES_PER_AXIS = 5
_POSITIONS_PER_AXIS = 5
_PERIOD_TOLERANCE = 0.1  # in lay periods: deviation of a side from a whole number of periods


class Candidate(NamedTuple):
    """A candidate for the window: first point (row, column), sides without the blending bands, and score.

    A lower score is better; `parts` are its terms without their weights.
    """

    start: tuple[int, int]
    sides: tuple[int, int]
    score: float
    parts: dict[str, float]


def search_window(
    values: np.ndarray,
    filled: np.ndarray,
    largest: tuple[tuple[int, int], tuple[int, int]],
    *,
    fade: float,
) -> list[Candidate]:
    """Return the best position of each size of the periodic window, sorted by score.

    Sides are at least 0.7 of those of the largest rectangle. Along an axis with a lay period
    (`roughcontact.window.lay`) they are whole multiples of it, to a tenth of a period, if such a side has a
    fast Fourier transform. Positions are spread evenly over the map. The window `largest` (start, sides) in
    the largest rectangle is always a candidate; no candidate contains a missing point (NaN). `fade` is the
    share of the side over which the ends are blended.

    Examples
    --------
    >>> import numpy as np
    >>> period = 15
    >>> waves = np.cos(2 * np.pi * np.arange(95) / period) + np.zeros((95, 1))
    >>> best = search_window(waves, np.zeros((95, 95)), ((0, 0), (81, 81)), fade=0.0)[0]
    >>> best.sides[1] / period
    5.0
    """
    start, sides = largest
    used = tuple(slice(s, s + n + band_points(n, fade)) for s, n in zip(start, sides, strict=True))
    rows, columns = (
        _ranges(points, (start[axis], sides[axis]), lay_period(values[used], axis), fade)
        for axis, points in enumerate(values.shape)
    )
    parts, good = score_parts(values, filled, rows, columns, math.prod(sides))
    # rounded, so that rounding errors do not decide between equal scores
    score = np.where(good, np.round(sum(WEIGHTS[name] * part for name, part in parts.items()), 9), np.inf)
    found: dict[tuple, Candidate] = {}
    for place in _best_pairs(rows, columns, score):
        if np.isfinite(score[place]):
            row, column = place
            candidate = Candidate(
                (int(rows.first[row]), int(columns.first[column])),
                (int(rows.side[row]), int(columns.side[column])),
                float(score[place]),
                {name: float(part[place]) for name, part in parts.items()},
            )
            found.setdefault((candidate.start, candidate.sides), candidate)
    return sorted(found.values(), key=lambda candidate: candidate.score)


def _ranges(points: int, largest: tuple[int, int], period: float | None, fade: float) -> Ranges:
    """Return the candidate ranges along an axis; the last is that of the largest rectangle."""
    start, longest = largest
    places = []
    for side in _tried_sides(longest, period):
        band = band_points(side, fade)
        places += [(first, side, band) for first in _first_points(points - side - band)]
    places.append((start, longest, band_points(longest, fade)))
    return Ranges(*np.array(places).T)


def _tried_sides(longest: int, period: float | None) -> list[int]:
    """Return the candidate sides along an axis, the longest first."""
    sides = [n for n in range(longest, math.ceil(MIN_SIDE_SHARE * longest) - 1, -1) if is_friendly(n)]
    if period is not None:
        sides = [n for n in sides if abs(n / period - round(n / period)) <= _PERIOD_TOLERANCE] or sides
    picked = np.linspace(0, len(sides) - 1, min(_SIDES_PER_AXIS, len(sides))).round().astype(int)
    return [sides[i] for i in picked]


def _first_points(spare: int) -> list[int]:
    """Return the candidate first points along an axis with `spare` points outside the window."""
    return (
        np.unique(np.linspace(0, spare, _POSITIONS_PER_AXIS).round().astype(int)).tolist()
        if spare >= 0
        else []
    )


def _best_pairs(rows: Ranges, columns: Ranges, score: np.ndarray) -> list[tuple[int, int]]:
    """Return the index pairs of the largest rectangle and of the best candidate of each size."""
    places = [(rows.first.size - 1, columns.first.size - 1)]
    for ny in np.unique(rows.side):
        for nx in np.unique(columns.side):
            these, those = np.nonzero(rows.side == ny)[0], np.nonzero(columns.side == nx)[0]
            some = score[np.ix_(these, those)]
            row, column = np.unravel_index(np.argmin(some), some.shape)
            places.append((int(these[row]), int(those[column])))
    return places
