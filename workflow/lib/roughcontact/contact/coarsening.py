"""How a grid is coarsened: the factors to the next coarser one, grid by grid, and the stencil of neighbours.

There are two uses. Nested iteration solves coarser problems, whose cells are whole: an axis is divided by a
factor of its number of cells. The interpolation needs coarser grids of any kind: cells are halved, whatever
their number, and the last one along an axis may lack a part. Along both axes at a time where cells are about
square, along the finer axis alone where they are not.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from roughcontact.kernels.protocol import Factors, Weights

# Ratio of the pitches above which the lines along the finer axis are taken as contacts of their own.
ELONGATED = 3.0
SMALLEST = 4  # cells along an axis up to which a hierarchy goes
_SQUARE = 1.5  # ratio of the pitches up to which cells count as square


class Coarsening(NamedTuple):
    """One coarser grid of a hierarchy.

    Attributes
    ----------
    shape : (ny, nx)
        of the coarser grid.
    pitches : (dy, dx)
        of its cells, those that lack a part not counted.
    factors : (fy, fx)
        from the next finer grid to this one.
    collapses_lines : bool
        whether each cell is a whole line of the finer grid.
    """

    shape: tuple[int, int]
    pitches: tuple[float, float]
    factors: Factors
    collapses_lines: bool


def pitches_of(shape: tuple[int, int], lengths: tuple[float, float]) -> tuple[float, float]:
    """Return the pitches (dy, dx) of a grid.

    Parameters
    ----------
    shape : (int, int)
        cells along y and x.
    lengths : (float, float)
        Ly and Lx of the periodic cell.

    Returns
    -------
    tuple of float
        in the unit of the lengths.
    """
    return lengths[0] / shape[0], lengths[1] / shape[1]


def has_square_cells(pitches: tuple[float, float], shape: tuple[int, int]) -> bool:
    """Return whether the cells of a grid are about square, and no profile.

    Parameters
    ----------
    pitches : (float, float)
        dy and dx of the cells.
    shape : (int, int)
        cells along y and x.

    Returns
    -------
    bool
    """
    return min(shape) > 1 and max(pitches) <= _SQUARE * min(pitches)


def whole_factors(
    pitches: tuple[float, float], shape: tuple[int, int], *, divisors: tuple[int, ...], smallest: int
) -> Factors:
    """Return the factors (fy, fx) to a coarser grid of whole cells; (1, 1) where there is none.

    An axis is divided while it keeps at least `smallest` cells. One whose pitch is finer is coarsened alone,
    until the cells are about square.

    Parameters
    ----------
    pitches : (float, float)
        dy and dx of the cells.
    shape : (int, int)
        cells along y and x.
    divisors : tuple of int
        of an axis, the preferred one first.
    smallest : int
        cells that an axis keeps at least.

    Returns
    -------
    tuple of int
    """
    finest = min(p for p, n in zip(pitches, shape, strict=True) if n > 1)
    factors = []
    for n, p in zip(shape, pitches, strict=True):
        divisor = next((f for f in divisors if n % f == 0 and n // f >= smallest), 1)
        factors.append(divisor if p <= _SQUARE * finest else 1)
    return factors[0], factors[1]


def halving_factors(pitches: tuple[float, float], shape: tuple[int, int]) -> tuple[Factors, bool]:
    """Return the factors (fy, fx) to the next coarser grid, and whether that makes cells of lines.

    Where pixels are far longer than wide, a line whose whole length is short against the distance to the next
    is a contact of its own, coupled to the others by its load alone: a residual that is constant along it
    must stay constant across its gaps. So its one cell takes the mean over its contact.

    Parameters
    ----------
    pitches : (float, float)
        dy and dx of the cells.
    shape : (int, int)
        cells along y and x.

    Returns
    -------
    factors : tuple of int
        1 along an axis that stays as it is.
    collapses_lines : bool
        whether each coarser cell is a whole line.
    """
    (ny, nx), (dy, dx) = shape, pitches
    finest = min(p for p, n in zip(pitches, shape, strict=True) if n > 1)
    short = ny if dy < dx else nx
    if min(shape) > 1 and short <= SMALLEST and max(pitches) > ELONGATED * finest:
        return ((ny, 1) if dy < dx else (1, nx)), True
    fy, fx = (2 if n > 1 and p <= _SQUARE * finest else 1 for n, p in zip(shape, pitches, strict=True))
    return (fy, fx), False


@lru_cache(maxsize=64)
def hierarchy(shape: tuple[int, int], lengths: tuple[float, float]) -> tuple[Coarsening, ...]:
    """Return the grids coarser than `shape`, the finest first.

    Parameters
    ----------
    shape : (int, int)
        cells along y and x.
    lengths : (float, float)
        Ly and Lx of the periodic cell.

    Returns
    -------
    tuple of Coarsening
        empty where the grid is as small as the coarsest may be.

    Examples
    --------
    >>> [grid.shape for grid in hierarchy((16, 35), (1.0, 2.1875))]
    [(8, 18), (4, 9), (2, 5), (1, 3)]
    """
    grids: list[Coarsening] = []
    pitches = pitches_of(shape, lengths)
    while True:
        (fy, fx), collapses = halving_factors(pitches, shape)
        if max(shape) <= SMALLEST and not collapses:
            return tuple(grids)
        pitches = pitches[0] * fy, pitches[1] * fx
        shape = -(-shape[0] // fy), -(-shape[1] // fx)
        grids.append(Coarsening(shape, pitches, (fy, fx), collapses))


def has_separate_lines(grids: tuple[Coarsening, ...]) -> bool:
    """Return whether lines become cells in a hierarchy: they are contacts of their own.

    Parameters
    ----------
    grids : tuple of Coarsening
        a hierarchy.

    Returns
    -------
    bool
    """
    return any(grid.collapses_lines for grid in grids)


@lru_cache(maxsize=64)
def stencil(pitches: tuple[float, float], shape: tuple[int, int]) -> Weights:
    """Return the weights of a neighbour across y, across x, and diagonal; those of all eight sum to 1.

    They go with the inverse cube of the distance, as the kernel of G^-1 does.

    Parameters
    ----------
    pitches : (float, float)
        dy and dx of the cells.
    shape : (int, int)
        cells along y and x.

    Returns
    -------
    tuple of float
        zero across an axis of a single cell.
    """
    dy, dx = pitches
    weights = np.array([dy**-3.0, dx**-3.0, np.hypot(dy, dx) ** -3.0])
    weights *= [shape[0] > 1, shape[1] > 1, min(shape) > 1]
    weights /= 2 * weights[0] + 2 * weights[1] + 4 * weights[2]
    across_y, across_x, diagonal = weights.tolist()
    return across_y, across_x, diagonal
