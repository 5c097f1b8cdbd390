"""Nested iteration: a coarse solution is a cheap first guess for the next finer grid.

Briggs, Henson and McCormick (2000), A Multigrid Tutorial, chapter 3. Coarse heights are block means, which
were measured to need fewer iterations than injection and Fourier truncation.
"""

from collections.abc import Sequence

import numpy as np

from roughcontact.contact.coarsening import grid_pitches, has_square_cells, whole_factors
from roughcontact.contact.grid import Grid
from roughcontact.contact.iteration import first_guess_on_grid
from roughcontact.kernels.arrays import SINGLE, Array, as_precision, empty, like_array, to_numpy
from roughcontact.kernels.choose import kernels_for
from roughcontact.kernels.protocol import Factors

COARSEST = 64  # cells along an axis: below that a grid costs more overhead than it saves
# A grid half as fine gives a far better first guess for the finest grid than one a quarter as fine. For the
# other grids, where cells are square, the difference is small.
FINEST_DIVISORS, DIVISORS = (2, 3, 5), (4, 2, 3, 5)
COARSE_TOLERANCE = 0.03  # of all grids but the finest: a tighter one resolves points that the next grid moves


def nested_heights(heights: Array, lengths: tuple[float, float]) -> list[tuple[Factors, Array]]:
    """Return [(factors, heights), ...] of the grids coarser than that of `heights`, the finest first.

    The factors are those to the next finer grid; `lengths` (Ly, Lx) are those of the periodic cell.
    """
    levels: list[tuple[Factors, Array]] = []
    while max(heights.shape) > COARSEST:
        pitches = grid_pitches(heights.shape, lengths)
        divisors = DIVISORS if levels and has_square_cells(pitches, heights.shape) else FINEST_DIVISORS
        factors = whole_factors(pitches, heights.shape, divisors=divisors, smallest=COARSEST // 2)
        if factors == (1, 1):  # a prime number of cells: no coarser grid of whole ones
            break
        coarse = empty(heights, SINGLE, tuple(n // f for n, f in zip(heights.shape, factors, strict=True)))
        kernels_for(heights).block_mean(heights, factors, coarse)
        levels.append((factors, coarse))
        heights = coarse
    return levels


def first_guess(
    grids: Sequence[Grid], factors: Sequence[Factors], load: float, fluctuation: Array
) -> tuple[Array, int]:
    """Return a first guess (float32) of the pressure on the finest grid, and the steps on the others.

    Each grid starts from the refined pressure of the next coarser one, the coarsest from the highest part of
    the full-contact pressure, of the `fluctuation` on that grid; `load` is the dimensionless mean pressure.
    """
    pressure, steps = _highest_part(fluctuation, load), 0
    for number in range(len(grids) - 1, 0, -1):
        coarse_pressure, iterations = first_guess_on_grid(
            grids[number], pressure, load, tolerance=COARSE_TOLERANCE
        )
        steps += iterations
        coarse_pressure = as_precision(coarse_pressure, SINGLE, copy=False)  # a stiff grid finishes in double
        finer = grids[number - 1]
        pressure = empty(coarse_pressure, SINGLE, finer.shape)
        finer.refine(coarse_pressure, factors[number - 1], pressure)
    return pressure, steps


def _highest_part(field: Array, mean: float) -> Array:
    """Return what of a field lies above the level that leaves a prescribed mean, zero elsewhere."""
    values = to_numpy(field).astype(float)  # single precision has no digits for a load on one point
    falling = np.sort(values, axis=None)[::-1]
    # the level where so many points lie above it; for the right number none of the others does
    levels = (np.cumsum(falling) - mean * falling.size) / np.arange(1, falling.size + 1)
    level = levels[max(int((levels <= falling).sum()), 1) - 1]
    return like_array(np.clip(values - level, 0, None).astype(SINGLE), field)
