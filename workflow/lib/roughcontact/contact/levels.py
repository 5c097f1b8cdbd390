"""Nested grids: a coarse solution is a cheap first guess for the next finer grid.

Coarse heights are block means, measured to need fewer iterations than injection and Fourier truncation. How a
coarse pressure comes onto the finer grid: `roughcontact.kernels.refine`.
"""

import numpy as np

from roughcontact.kernels import kernels_for

COARSEST = 32  # cells along an axis: below that a level costs more overhead than it saves


def coarsening_factors(shape, lengths) -> tuple[int, int]:
    """Return the factors (fy, fx) by which a grid is coarsened; (1, 1) where it is the coarsest.

    An axis is halved (or divided by 3 or 5 where it is odd) while it stays at least `COARSEST` / 2 cells
    long. Where one pitch is finer than the other, that axis alone is coarsened, until the cells are about
    square.
    """
    pitch = [length / n for length, n in zip(lengths, shape, strict=True)]
    finest = min(p for p, n in zip(pitch, shape, strict=True) if n > 1)
    factors = []
    for n, p in zip(shape, pitch, strict=True):
        divisor = next((f for f in (2, 3, 5) if n % f == 0 and n // f >= COARSEST // 2), 1)
        factors.append(divisor if p <= 1.5 * finest else 1)
    if max(shape) <= COARSEST:
        return 1, 1
    return factors[0], factors[1]


def hierarchy(heights: np.ndarray, lengths) -> list[tuple[np.ndarray, tuple[int, int]]]:
    """Return [(heights, factors to the next coarser), ...] from the finest grid to the coarsest.

    The coarse heights are in single precision, which is all their tolerance asks for.
    """
    levels = []
    while True:
        factors = coarsening_factors(heights.shape, lengths)
        levels.append((heights, factors))
        if factors == (1, 1):
            return levels
        coarse = np.empty([n // f for n, f in zip(heights.shape, factors, strict=True)], dtype=np.float32)
        kernels_for(heights).block_mean(heights, factors, coarse)
        heights = coarse
