"""Nested grids: a coarse solution is a cheap first guess for the next finer grid.

Coarse heights are block means, measured to need fewer iterations than injection and Fourier truncation. How a
coarse pressure comes onto the finer grid: `roughcontact.kernels.array_api.refine`.
"""

from roughcontact.contact.interpolation import coarsening, pitches_of
from roughcontact.kernels.arrays import SINGLE, empty
from roughcontact.kernels.choose import kernels_for

COARSEST = 64  # cells along an axis: below that a level costs more overhead than it saves


def coarsening_factors(shape, lengths) -> tuple[int, int]:
    """Return the factors (fy, fx) by which a grid is coarsened; (1, 1) where it is the coarsest."""
    if max(shape) <= COARSEST:
        return 1, 1
    return coarsening(pitches_of(shape, lengths), shape, smallest=COARSEST // 2)


def hierarchy(heights, lengths) -> list:
    """Return [(factors, heights), ...] of the grids coarser than that of `heights`, the finest first.

    The factors are those to the next finer grid.
    """
    levels = []
    while True:
        factors = coarsening_factors(heights.shape, lengths)
        if factors == (1, 1):
            return levels
        coarse = empty(heights, SINGLE, tuple(n // f for n, f in zip(heights.shape, factors, strict=True)))
        kernels_for(heights).block_mean(heights, factors, coarse)
        levels.append((factors, coarse))
        heights = coarse
