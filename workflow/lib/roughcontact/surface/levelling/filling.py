"""Filling of missing points by a harmonic surface, the smoothest one that matches the rim of each hole."""

from collections.abc import Sequence

import numpy as np

from roughcontact.arguments.maps import dimensions
from roughcontact.errors import HeightMapError

_TOLERANCE = 1e-10  # residual of the Laplace equation, relative to its right-hand side
_MAX_ITERATIONS = 500  # for a wide hole; tens are usual
_WIDE_HOLE_RADIUS = 8  # pixels from rim to middle; for wider holes the fast Poisson solver is faster


def find_holes(missing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return labels (ny, nx) and sizes (points) of holes: missing points connected by edges, off the border.

    The labels are 1 ... n, 0 elsewhere; an axis of one point has no border.
    """
    from scipy import ndimage

    labels, count = ndimage.label(missing)
    open_to_border = np.zeros(count + 1, dtype=bool)
    for axis, points in enumerate(missing.shape):
        if points > 1:
            open_to_border[labels.take([0, -1], axis)] = True
    open_to_border[0] = True  # label 0 is what was measured
    labels = np.where(open_to_border, 0, np.cumsum(~open_to_border)).astype(labels.dtype)[labels]
    return labels, np.bincount(labels.ravel(), minlength=1)[1:]


def fill_harmonic(values: np.ndarray, labels: np.ndarray, spacing: Sequence[float]) -> np.ndarray:
    """Return the map (ny, nx; m) with the holes of `find_holes` filled by the solution of Laplace's equation.

    Narrow holes are solved by conjugate gradients, whose number of iterations grows with the width of the
    hole; wide ones are preconditioned by a fast Poisson solver on their bounding box (Buzbee, Dorr, George
    and Golub 1971, SIAM J. Numer. Anal. 8, 722).
    """
    inside = labels > 0
    if not inside.any():
        return values.copy()
    if dimensions(values.shape) == 1:
        return _fill_profile(values, inside)
    from scipy import ndimage

    # heights and weights are scaled to avoid underflow
    offset, scale = np.nanmin(values), np.ptp(values[~np.isnan(values)]) or 1.0
    wy, wx = (min(spacing) / np.asarray(spacing)) ** 2
    result = values - offset
    result /= scale
    # with points farther from their rim
    wide_holes = np.unique(labels[ndimage.binary_erosion(inside, iterations=_WIDE_HOLE_RADIUS)])
    narrow = inside & ~np.isin(labels, wide_holes)
    if narrow.any():
        result[narrow] = _solve_narrow(result, narrow, (wy, wx))
    boxes = ndimage.find_objects(labels) if wide_holes.size else []
    for hole in wide_holes:
        # one row and column more on each side: the rim
        box = tuple(slice(s.start - 1, s.stop + 1) for s in boxes[hole - 1])
        subarray, mask = result[box], labels[box] == hole
        subarray[mask] = _solve_wide(subarray, mask, (wy, wx))
    result *= scale
    result += offset
    np.copyto(result, values, where=~inside)  # measured heights come back without rounding
    return result


def _fill_profile(values: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Return a profile with its holes filled by straight lines."""
    flat, is_measured = values.ravel(), ~np.isnan(values.ravel())
    result = values.copy()
    result[inside] = np.interp(np.flatnonzero(inside), np.flatnonzero(is_measured), flat[is_measured])
    return result


def _right_hand_side(values: np.ndarray, mask: np.ndarray, weights: Sequence[float]) -> np.ndarray:
    """Return the weighted sum of known neighbours of each point of `mask`, which excludes the border."""
    rim, (wy, wx) = np.where(mask | np.isnan(values), 0.0, values), weights
    around = wy * (rim[:-2, 1:-1] + rim[2:, 1:-1]) + wx * (rim[1:-1, :-2] + rim[1:-1, 2:])
    return around[mask[1:-1, 1:-1]]


def _solve_narrow(values: np.ndarray, mask: np.ndarray, weights: Sequence[float]) -> np.ndarray:
    """Return the heights at the points of `mask`, from one sparse system for all narrow holes."""
    from scipy import sparse
    from scipy.sparse import linalg

    wy, wx = weights
    count = int(mask.sum())
    number = np.full(mask.shape, -1)
    number[mask] = np.arange(count)
    below = mask[:-1] & mask[1:]
    right = mask[:, :-1] & mask[:, 1:]
    start = np.concatenate([number[:-1][below], number[:, :-1][right]])
    stop = np.concatenate([number[1:][below], number[:, 1:][right]])
    weight = np.repeat([-wy, -wx], [below.sum(), right.sum()])
    del number, below, right  # memory may not hold more than is needed of a large map
    upper = sparse.coo_array((weight, (start, stop)), shape=(count, count)).tocsr()
    matrix = (upper + upper.T + sparse.diags_array(np.full(count, 2 * (wy + wx)))).tocsr()
    rhs = _right_hand_side(values, mask, weights)
    solution, status = linalg.cg(matrix, rhs, rtol=_TOLERANCE, maxiter=2000)
    # where the iteration does not converge, at the price of memory
    return linalg.spsolve(matrix.tocsc(), rhs) if status else solution


def _solve_wide(values: np.ndarray, mask: np.ndarray, weights: Sequence[float]) -> np.ndarray:
    """Return the heights in one hole; `values` and `mask` are its bounding box plus one point of rim."""
    from scipy.fft import dstn, idstn, next_fast_len
    from scipy.sparse import linalg

    wy, wx = weights
    box = mask[1:-1, 1:-1]
    # a larger box is as good: take one with a fast transform
    larger = [next_fast_len(n + 1, real=True) - 1 for n in box.shape]
    # eigenvalues of the five-point Laplace operator under a sine transform
    symbol_y, symbol_x = (
        4 * weight * np.sin(np.pi * np.arange(1, n + 1) / (2 * n + 2)) ** 2
        for weight, n in zip(weights, larger, strict=True)
    )
    symbol = symbol_y[:, None] + symbol_x
    box_in_larger = np.pad(box, [(0, n - m) for n, m in zip(larger, box.shape, strict=True)])
    field = np.zeros(mask.shape)  # includes a rim of zeros, so that all points have neighbours

    def operator(vector):
        field[mask] = vector
        inner = field[1:-1, 1:-1]
        result = 2 * (wy + wx) * inner
        result -= wy * (field[:-2, 1:-1] + field[2:, 1:-1])
        result -= wx * (field[1:-1, :-2] + field[1:-1, 2:])
        return result[box]

    def precondition(vector):
        residual = np.zeros(larger)
        residual[box_in_larger] = vector
        residual = dstn(residual, type=1, overwrite_x=True)
        residual /= symbol
        return idstn(residual, type=1, overwrite_x=True)[box_in_larger]

    rhs = _right_hand_side(values, mask, weights)
    shape = rhs.size, rhs.size
    solution, status = linalg.cg(
        linalg.LinearOperator(shape, operator, dtype=float),
        rhs,
        rtol=_TOLERANCE,
        maxiter=_MAX_ITERATIONS,
        M=linalg.LinearOperator(shape, precondition, dtype=float),
    )
    if not status:
        return solution
    raise HeightMapError(
        f"a hole of {rhs.size} missing points could not be filled (Laplace equation, {_MAX_ITERATIONS} "
        "iterations): set level.fill to 'none', or cut the map to its measured part"
    )
