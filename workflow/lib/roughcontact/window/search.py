"""Search for the part of a map that makes the best periodic window: which position, which size.

Every candidate gets a score (`roughcontact.window.score`), and the lowest one wins.
"""

import math
from typing import NamedTuple

import numpy as np

from roughcontact.window.lay import lay_period
from roughcontact.window.score import WEIGHTS, Ranges, score_parts
from roughcontact.window.sides import band_points, is_friendly

SHORTEST_SIDE = 0.7  # of the largest rectangle's: windows with shorter sides are not tried
_SIDES = 5  # tried along each axis
_PLACES = 5  # tried along each axis
_WHOLE_PERIODS = 0.1  # of a lay period: what a side may be off a whole number of them


class Candidate(NamedTuple):
    """A part of the map that may become the window.

    Attributes
    ----------
    start : (row, column)
        its first point.
    sides : (rows, columns)
        of the window, without its bands.
    score : float
        the lower the better.
    parts : dict
        of the score, before weighting.
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
    """Return the best place for each size of the periodic window, the best of all first.

    Sides are at least 0.7 of those of the largest rectangle; along an axis with a lay period
    (`roughcontact.window.lay`) they are whole numbers of it, to a tenth, where such a side transforms well.
    Places are spread evenly over the map. The largest rectangle itself is always among the candidates.

    Parameters
    ----------
    values : array (ny, nx), m
        NaN where missing; no candidate has such a point.
    filled : array (ny, nx)
        not 0 where a point was filled in.
    largest : (start, sides), points
        of the window in the largest rectangle, rows first.
    fade : float
        share of the side over which the ends are blended.

    Returns
    -------
    list of Candidate

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
    # rounded, so that rounding errors do not decide between equals
    score = np.where(good, np.round(sum(WEIGHTS[name] * part for name, part in parts.items()), 9), np.inf)
    found: dict[tuple, Candidate] = {}
    for place in _best_places(rows, columns, score):
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
    """Return the ranges that are tried along an axis; the last is that of the largest rectangle."""
    start, longest = largest
    places = []
    for side in _tried_sides(longest, period):
        band = band_points(side, fade)
        places += [(first, side, band) for first in _first_points(points - side - band)]
    places.append((start, longest, band_points(longest, fade)))
    return Ranges(*np.array(places).T)


def _tried_sides(longest: int, period: float | None) -> list[int]:
    """Return the sides that are tried along an axis, the longest first."""
    sides = [n for n in range(longest, math.ceil(SHORTEST_SIDE * longest) - 1, -1) if is_friendly(n)]
    if period is not None:
        sides = [n for n in sides if abs(n / period - round(n / period)) <= _WHOLE_PERIODS] or sides
    picked = np.linspace(0, len(sides) - 1, min(_SIDES, len(sides))).round().astype(int)
    return [sides[i] for i in picked]


def _first_points(spare: int) -> list[int]:
    """Return the first points along an axis on which a window leaves so many points over."""
    return np.unique(np.linspace(0, spare, _PLACES).round().astype(int)).tolist() if spare >= 0 else []


def _best_places(rows: Ranges, columns: Ranges, score: np.ndarray) -> list[tuple[int, int]]:
    """Return which pair of ranges is the largest rectangle, and which is the best of each size."""
    places = [(rows.first.size - 1, columns.first.size - 1)]
    for ny in np.unique(rows.side):
        for nx in np.unique(columns.side):
            these, those = np.nonzero(rows.side == ny)[0], np.nonzero(columns.side == nx)[0]
            some = score[np.ix_(these, those)]
            row, column = np.unravel_index(np.argmin(some), some.shape)
            places.append((int(these[row]), int(those[column])))
    return places
