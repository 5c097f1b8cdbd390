"""Coarsening of grids: the factors from each grid to the next coarser one, and the stencil of neighbours.

Nested iteration divides an axis by a factor of its number of cells, the interpolation halves any. Cells that
are about square are coarsened along both axes, others along the finer one. `shape` (ny, nx) counts cells,
`lengths` (Ly, Lx) are those of the periodic cell, `pitches` (dy, dx) of the cells.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from roughcontact.kernels.protocol import Factors, Weights

# Ratio of the pitches above which lines along the finer axis are treated as contacts of their own.
ELONGATED = 3.0
MIN_CELLS = 4  # along an axis, of the coarsest grid of a hierarchy
_SQUARE = 1.5  # ratio of the pitches up to which cells count as square


class Coarsening(NamedTuple):
    """One coarser grid of a hierarchy.

    `shape` (ny, nx): of the coarser grid; `pitches` (dy, dx): of its complete cells; `factors` (fy, fx): from
    the next finer grid to this one; `collapses_lines`: whether each cell is a whole line of the finer grid.
    """

    shape: tuple[int, int]
    pitches: tuple[float, float]
    factors: Factors
    collapses_lines: bool


def grid_pitches(shape: tuple[int, int], lengths: tuple[float, float]) -> tuple[float, float]:
    """Return the pitches (dy, dx) of a grid, in the unit of the lengths."""
    return lengths[0] / shape[0], lengths[1] / shape[1]


def has_square_cells(pitches: tuple[float, float], shape: tuple[int, int]) -> bool:
    """Return whether a grid has cells that are about square, and is no profile."""
    return min(shape) > 1 and max(pitches) <= _SQUARE * min(pitches)


def whole_factors(
    pitches: tuple[float, float], shape: tuple[int, int], *, divisors: tuple[int, ...], smallest: int
) -> Factors:
    """Return the factors (fy, fx) to a coarser grid of whole cells; (1, 1) where there is none.

    An axis is divided by one of the `divisors`, the preferred one first, while it keeps at least `smallest`
    cells. One whose pitch is finer is coarsened alone, until the cells are about square.
    """
    finest = min(p for p, n in zip(pitches, shape, strict=True) if n > 1)
    factors = []
    for n, p in zip(shape, pitches, strict=True):
        divisor = next((f for f in divisors if n % f == 0 and n // f >= smallest), 1)
        factors.append(divisor if p <= _SQUARE * finest else 1)
    return factors[0], factors[1]


def halving_factors(pitches: tuple[float, float], shape: tuple[int, int]) -> tuple[Factors, bool]:
    """Return the factors (fy, fx) to the next coarser grid, and whether its cells are whole lines."""
    (ny, nx), (dy, dx) = shape, pitches
    finest = min(p for p, n in zip(pitches, shape, strict=True) if n > 1)
    # a short line of long pixels is a contact of its own, coupled by its load alone: its residual must stay
    # constant across its gaps
    short = ny if dy < dx else nx
    if min(shape) > 1 and short <= MIN_CELLS and max(pitches) > ELONGATED * finest:
        return ((ny, 1) if dy < dx else (1, nx)), True
    fy, fx = (2 if n > 1 and p <= _SQUARE * finest else 1 for n, p in zip(shape, pitches, strict=True))
    return (fy, fx), False


@lru_cache(maxsize=64)
def hierarchy(shape: tuple[int, int], lengths: tuple[float, float]) -> tuple[Coarsening, ...]:
    """Return the grids coarser than `shape`, the finest first; none where that is the coarsest size."""
    grids: list[Coarsening] = []
    pitches = grid_pitches(shape, lengths)
    while True:
        (fy, fx), collapses = halving_factors(pitches, shape)
        if max(shape) <= MIN_CELLS and not collapses:
            return tuple(grids)
        pitches = pitches[0] * fy, pitches[1] * fx
        shape = -(-shape[0] // fy), -(-shape[1] // fx)
        grids.append(Coarsening(shape, pitches, (fy, fx), collapses))


def has_separate_lines(grids: tuple[Coarsening, ...]) -> bool:
    """Return whether a hierarchy has cells that are whole lines, each a contact of its own."""
    return any(grid.collapses_lines for grid in grids)


@lru_cache(maxsize=64)
def stencil(pitches: tuple[float, float], shape: tuple[int, int]) -> Weights:
    """Return the weights of a neighbour across y, across x, and diagonal; those of all eight sum to 1.

    They are proportional to the inverse cube of the distance, as the kernel of G^-1 is, and zero across an
    axis of a single cell.
    """
    dy, dx = pitches
    weights = np.array([dy**-3.0, dx**-3.0, np.hypot(dy, dx) ** -3.0])
    weights *= [shape[0] > 1, shape[1] > 1, min(shape) > 1]
    weights /= 2 * weights[0] + 2 * weights[1] + 4 * weights[2]
    across_y, across_x, diagonal = weights.tolist()
    return across_y, across_x, diagonal
