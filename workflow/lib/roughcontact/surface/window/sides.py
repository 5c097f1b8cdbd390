"""Sides of windows: numbers of points that have a fast Fourier transform and can be halved often."""

import math

import numpy as np

from roughcontact.kernels.fourier import has_few_factors

# The solver halves a grid while both sides are even; a side should reach about this number of points.
_COARSEST_SIDE = 32
# Loss of length accepted for one further halving, as a share of the side.
_HALVING_BENEFIT = 0.02


def is_friendly(side: int) -> bool:
    """Return whether a side has no prime factor above 5, or is at most 32 points long.

    Examples
    --------
    >>> [side for side in range(30, 46) if is_friendly(side)]
    [30, 31, 32, 36, 40, 45]
    """
    return math.isfinite(_side_score(side))


def friendly_sides(longest: int, *, fade: float = 0.0) -> np.ndarray:
    """Return the best side of a window that fits into n points, for each n = 0 ... longest.

    It is the largest without a prime factor above 5; one that can be halved once more (down to 32) may be 2 %
    shorter. The blending band of a cross-fade, `fade` times the side, must fit as well.
    """
    sides = np.zeros(longest + 1, dtype=int)
    best, best_score = 0, -math.inf
    for points in range(1, longest + 1):
        side = _largest_side(points, fade)
        score = _side_score(side)
        if score >= best_score:
            best, best_score = side, score
        sides[points] = best
    return sides


def band_points(side: int, fade: float, *, length: int | None = None) -> int:
    """Return the number of points of the blending band, `fade` times the side; 0 for one point: no seam.

    Examples
    --------
    >>> band_points(90, 0.1), band_points(1, 0.5), band_points(90, 0.1, length=100)
    (9, 0, 10)
    """
    band = round(fade * side) if side > 1 else 0
    # centred in the length: a mirrored map would else have another window
    return band + (length - side - band) % 2 if band and length else band


def _largest_side(points: int, fade: float) -> int:
    """Return the largest side that, together with its band, fits into a number of points."""
    # an upper limit, which rounding of the band may lower by a point or two
    side = int(points / (1 + fade)) + 1
    while side > 1 and side + band_points(side, fade) > points:
        side -= 1
    return side


def _side_score(side: int) -> float:
    """Return the logarithm of a side less a penalty for missing halvings; -inf for a prime factor above 5."""
    if side <= _COARSEST_SIDE:
        return math.log(side)
    if not has_few_factors(side):
        return -math.inf
    coarsest = side
    while coarsest % 2 == 0 and coarsest > _COARSEST_SIDE:
        coarsest //= 2
    # for each missing factor of two the side may be two percent shorter
    return math.log(side) - _HALVING_BENEFIT * max(0.0, math.log2(coarsest / _COARSEST_SIDE))
