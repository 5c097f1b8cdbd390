"""Multigrid by smoothed aggregation for networks on a grid, robust to conductances of any ratio."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

_BLOCK = 3  # points per side of the blocks that confine aggregates: so the coarse networks remain sparse
_STRONG = 0.05  # minimum share of the smaller diagonal for a link that joins two points to one aggregate
_COARSEST = 100  # unknowns that are solved directly; for more, threads of linear algebra spin
_SMOOTHING = 2 / 3  # of damped Jacobi: the largest eigenvalue of the scaled matrix is 2 at most
_ROUNDING = 1e-26  # share of the largest diagonal below which values are squares of rounding errors
_SOLVED = 1e-9  # share of the largest force below which a residual asks for no step


class _Level(NamedTuple):
    matrix: sp.csr_array
    weight: np.ndarray  # (n, 1)
    prolong: sp.csr_array
    restrict: sp.csr_array


Cycle = Callable[[np.ndarray], np.ndarray]


def multigrid(root: sp.csr_array, coordinates: np.ndarray) -> tuple[sp.csr_array, Cycle]:
    """Return the matrix root' root (n, n) of a network and a V-cycle of smoothed aggregation for it.

    Vaněk, Mandel and Brezina (1996), Computing 56, 179, with blocks of 3 x 3 points, of which only those
    joined by strong links become one coarser point: regions on both sides of a wall remain separate. `root`
    (links, n) has the root of the conductance at the end of a link and less that at its start; `coordinates`
    (n, 2) are row and column. Coarser matrices are products of a coarser `root`: a weak link beside strong
    ones is not lost in rounding.

    Examples
    --------
    A ring of 900 equal links; fifteen steps of x += M (b - A x):

    >>> points = np.arange(900)
    >>> ends = sp.coo_array((np.ones(900), (points, np.roll(points, -1)))).tocsr()
    >>> root = (ends - sp.eye_array(900)).tocsr()
    >>> matrix, cycle = multigrid(root, np.stack([0 * points, points], axis=1))
    >>> b, x = np.sin(2 * np.pi * points / 900)[:, None], np.zeros((900, 1))
    >>> for _ in range(15):
    ...     x = x + cycle(b - matrix @ x)
    >>> bool(np.abs(b - matrix @ x).max() < 1e-6)
    True
    """
    levels: list[_Level] = []
    transpose = root.T.tocsr()
    finest = matrix = transpose @ root
    while matrix.shape[0] > _COARSEST:
        points = np.arange(matrix.shape[0])
        aggregate, count = _aggregates(matrix, coordinates // _BLOCK)
        if count == points.size:  # no points are joined
            break
        # half the sum of the sizes in a row: the diagonal of a network, and never less than half the largest
        # eigenvalue of the scaled matrix (Gershgorin)
        weight = _SMOOTHING * _inverse(abs(matrix).sum(axis=1) / 2)
        constant = sp.csr_array((np.ones(points.size), aggregate, np.append(points, points.size)))
        across = root @ constant  # nothing inside an aggregate
        across.eliminate_zeros()
        smooth = sp.diags_array(weight) @ (transpose @ across)
        prolong = (constant - smooth).tocsr()
        levels.append(_Level(matrix, weight[:, None], prolong, prolong.T.tocsr()))
        root = (across - root @ smooth).tocsr()
        root = root[np.diff(root.indptr) > 0]
        transpose = root.T.tocsr()
        matrix = transpose @ root
        representative = np.empty(count, int)
        representative[aggregate] = points  # any member has the place of its block
        coordinates = coordinates[representative] // _BLOCK
    # scaled to a unit diagonal: conductances range over many powers of ten
    scaling = np.sqrt(_inverse(matrix.diagonal()))
    values, vectors = np.linalg.eigh(scaling[:, None] * matrix.toarray() * scaling)
    is_regular = values > values.size * np.finfo(float).eps  # the others are constants, which are free
    modes = scaling[:, None] * vectors[:, is_regular] / np.sqrt(values[is_regular])

    def cycle(residual: np.ndarray, depth: int = 0) -> np.ndarray:
        """Return the correction of one V-cycle, from a level downwards."""
        if depth == len(levels):
            return modes @ (modes.T @ residual)
        level = levels[depth]
        correction = level.weight * residual
        # two steps down, two up: the cycle is symmetric
        correction += level.weight * (residual - level.matrix @ correction)
        correction += level.prolong @ cycle(
            level.restrict @ (residual - level.matrix @ correction), depth + 1
        )
        for _ in range(2):
            correction += level.weight * (residual - level.matrix @ correction)
        return correction

    return finest, cycle


def minimised(
    matrix: sp.csr_array, forces: np.ndarray, precondition: Cycle
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield ever better x (n, columns), changed in place, of matrix x = forces, by conjugate gradients.

    They are preconditioned; with x comes the decrease (columns) of the energy x A x - 2 b x, inf where
    rounding makes a step impossible.
    """
    solution, residual = np.zeros_like(forces), forces.copy()
    limit = _SOLVED * np.abs(forces).max(axis=0, initial=0.0)
    direction = correction = precondition(residual)
    product = _products(residual, correction)
    while True:
        image = matrix @ direction
        curvature = _products(direction, image)
        step = np.divide(product, curvature, out=np.zeros_like(product), where=curvature > 0)
        solution += step * direction
        residual -= step * image
        # no descent is possible but for rounding
        stuck = step <= 0
        if stuck.any():  # a maximum takes as long as a fifth of a cycle
            stuck &= np.abs(residual).max(axis=0, initial=0.0) > limit
        yield solution, np.where(stuck, np.inf, step * product)
        correction = precondition(residual)
        previous, product = product, _products(residual, correction)
        share = np.divide(product, previous, out=np.zeros_like(product), where=previous > 0)
        direction = correction + share * direction


def _products(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the scalar product of each pair of columns."""
    return np.einsum("ij,ij->j", a, b)


def _inverse(diagonal: np.ndarray) -> np.ndarray:
    """Return the inverse of a diagonal, 0 where its values are rounding errors."""
    return np.divide(
        1.0, diagonal, out=np.zeros_like(diagonal), where=diagonal > _ROUNDING * diagonal.max(initial=0)
    )


def _aggregates(matrix: sp.csr_array, blocks: np.ndarray) -> tuple[np.ndarray, int]:
    """Return the aggregate of each unknown, and the number of aggregates."""
    links = matrix.tocoo()
    row, column = links.coords
    diagonal = matrix.diagonal()
    joins = (-links.data > _STRONG * np.minimum(diagonal[row], diagonal[column])) & (
        blocks[row] == blocks[column]
    ).all(axis=1)
    graph = sp.coo_array((np.ones(int(joins.sum()), bool), (row[joins], column[joins])), shape=matrix.shape)
    count, aggregate = connected_components(graph, directed=False)
    return aggregate, int(count)
