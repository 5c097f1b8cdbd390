"""Multigrid by aggregation for networks of conductances on a grid, robust to conductances of any ratio.

Near percolation aggregation converges slowly (0.95 a step seen): then a network has few paths, its sparse
factors have few entries, and it is solved directly.
"""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

_BLOCK = 2  # points per side of the blocks that confine aggregates
_STRONG = 0.05  # minimum share of the smaller diagonal for a link that joins two points to one aggregate
_COARSEST = 100  # unknowns that are solved directly
_SMOOTHING = 0.8  # of damped Jacobi: the largest eigenvalue of the scaled matrix is 2 at most
_ACCURATE = 0.25  # share of a coarse residual after the first step, below which there is no second one
_ROUNDING = 1e-26  # share of the largest diagonal below which values are rounding errors
_ROUNDING_OF_FACTORS = 1e-15  # of a unit diagonal: without it a pivot may be zero by rounding
_SYMMETRIC = {"SymmetricMode": True}  # no rows change places
_SOLVED = 1e-9  # share of the largest force below which a residual asks for no step


class Network(NamedTuple):
    """Links between points: where each starts and stops (links), its conductance, the number of points."""

    start: np.ndarray
    stop: np.ndarray
    conductance: np.ndarray
    size: int

    def inflow(self, flow: np.ndarray) -> np.ndarray:
        """Return what flows along the links into each point."""
        into, out = (np.bincount(end, flow, self.size) for end in (self.stop, self.start))
        return into - out

    def matrix(self) -> sp.csr_array:
        """Return what turns potentials into outflows (size, size)."""
        points = np.arange(self.size)
        of_points = sum(np.bincount(end, self.conductance, self.size) for end in (self.start, self.stop))
        values = np.concatenate([of_points, -self.conductance, -self.conductance])
        rows = np.concatenate([points, self.start, self.stop])
        columns = np.concatenate([points, self.stop, self.start])
        return sp.coo_array((values, (rows, columns)), shape=(self.size, self.size)).tocsr()


class _Level(NamedTuple):
    matrix: sp.csr_array
    weight: np.ndarray  # of the smoothing
    aggregate: np.ndarray  # of each point


Cycle = Callable[[np.ndarray], np.ndarray]
Solver = tuple[sp.csr_array, Cycle]


def multigrid(network: Network, coordinates: np.ndarray) -> Solver:
    """Return the matrix (n, n) of a network and a K-cycle of aggregation for it, which is not quite linear.

    Notay (2010), Electron. Trans. Numer. Anal. 37, 123, with blocks of 2 x 2 points, of which only those
    joined by strong links become one coarser point: regions on both sides of a wall remain separate. A
    coarser network has the sums of the conductances between its points: nothing is lost in rounding.
    `coordinates` (n, 2) are row and column.

    Examples
    --------
    A ring of 900 equal links, fifteen steps of conjugate gradients:

    >>> points = np.arange(900)
    >>> ring = Network(points, np.roll(points, -1), np.ones(900), 900)
    >>> matrix, cycle = multigrid(ring, np.stack([0 * points, points], axis=1))
    >>> force = np.sin(2 * np.pi * points / 900)
    >>> steps = minimised(matrix, force, cycle)
    >>> for _ in range(15):
    ...     potential, *_ = next(steps)
    >>> bool(np.abs(force - matrix @ potential).max() < 1e-6)
    True
    """
    levels: list[_Level] = []
    finest = matrix = network.matrix()
    while network.size > _COARSEST:
        coordinates, diagonal = coordinates // _BLOCK, matrix.diagonal()
        aggregate, count = _aggregates(network, diagonal, coordinates)
        if count == network.size:  # no points are joined
            break
        levels.append(_Level(matrix, _SMOOTHING * _inverse(diagonal), aggregate))
        representative = np.empty(count, int)
        representative[aggregate] = np.arange(network.size)  # any member has the place of its block
        coordinates = coordinates[representative]
        network = _coarser(network, aggregate, count)
        matrix = network.matrix()
    solve_coarsest = factorised(matrix)

    def cycle(residual: np.ndarray, depth: int = 0) -> np.ndarray:
        """Return the correction of one cycle, from a level downwards."""
        if depth == len(levels):
            return solve_coarsest(residual)
        level = levels[depth]
        correction = level.weight * residual
        coarse_residual = np.bincount(level.aggregate, residual - level.matrix @ correction)
        correction += coarse_solution(coarse_residual, depth + 1)[level.aggregate]
        correction += level.weight * (residual - level.matrix @ correction)
        return correction

    def coarse_solution(residual: np.ndarray, depth: int) -> np.ndarray:
        """Return two steps of conjugate gradients, or one, preconditioned by the cycle of a level."""
        if depth == len(levels):
            return cycle(residual, depth)
        steps = minimised(levels[depth].matrix, residual, lambda rest: cycle(rest, depth))
        solution, _, rest = next(steps)
        return solution if rest @ rest <= _ACCURATE**2 * (residual @ residual) else next(steps)[0]

    return finest, cycle


def factorised(matrix: sp.csr_array) -> Cycle:
    """Return the solution by sparse factors of a network's matrix, one point of each part of it held at 0.

    The fewer paths a gap has, the fewer entries do the factors have: some 40 a point where it is wide open,
    6 where it is about to close.
    """
    size, diagonal = matrix.shape[0], matrix.diagonal()
    _, part = connected_components(matrix, directed=False)
    by_part = np.lexsort((-diagonal, part))  # first its point with the largest conductance
    is_held = np.zeros(size, bool)
    is_held[by_part[np.unique(part[by_part], return_index=True)[1]]] = True
    free = np.flatnonzero(~is_held)
    if not free.size:
        return np.zeros_like
    # scaled to a unit diagonal, as conductances range over many powers of ten
    with np.errstate(divide="ignore"):
        scaling = sp.diags_array(np.where(diagonal[free] > 0, diagonal[free] ** -0.5, 0.0))
    scaled = scaling @ matrix[free][:, free] @ scaling + _ROUNDING_OF_FACTORS * sp.eye_array(free.size)
    factors = splu(scaled.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=_SYMMETRIC)

    def solve(force: np.ndarray) -> np.ndarray:
        solution = np.zeros(size)
        solution[free] = scaling @ factors.solve(scaling @ force[free])
        return solution

    return solve


def minimised(
    matrix: sp.csr_array, force: np.ndarray, precondition: Cycle
) -> Iterator[tuple[np.ndarray, float, np.ndarray]]:
    """Yield ever better x (n), changed in place, of matrix x = force, by flexible conjugate gradients.

    With x come the decrease of the energy x A x - 2 b x, inf where rounding makes a step impossible, and the
    residual. The preconditioner need not be linear (Notay 2000, SIAM J. Sci. Comput. 22, 1444).
    """
    solution, residual = np.zeros_like(force), force.copy()
    limit = _SOLVED * np.abs(force).max(initial=0.0)
    direction = correction = precondition(residual)
    product = float(residual @ correction)
    while True:
        image = matrix @ direction
        curvature = float(direction @ image)
        step = product / curvature if curvature > 0 else 0.0
        solution += step * direction
        residual -= step * image
        # no descent is possible but for rounding
        stuck = step <= 0 and np.abs(residual).max(initial=0.0) > limit
        yield solution, math.inf if stuck else step * product, residual
        correction = precondition(residual)
        share = -step * float(image @ correction) / product if product > 0 else 0.0
        product = float(residual @ correction)
        direction = correction + share * direction


def _inverse(diagonal: np.ndarray) -> np.ndarray:
    """Return the inverse of a diagonal, 0 where its values are rounding errors."""
    return np.divide(
        1.0, diagonal, out=np.zeros_like(diagonal), where=diagonal > _ROUNDING * diagonal.max(initial=0)
    )


def _aggregates(network: Network, diagonal: np.ndarray, blocks: np.ndarray) -> tuple[np.ndarray, int]:
    """Return the aggregate of each point, and the number of aggregates."""
    start, stop, conductance, size = network
    row, column = (blocks[start] == blocks[stop]).T
    joins = row & column & (conductance > _STRONG * np.minimum(diagonal[start], diagonal[stop]))
    graph = sp.coo_array((np.ones(int(joins.sum()), bool), (start[joins], stop[joins])), shape=(size, size))
    count, aggregate = connected_components(graph, directed=False)
    return aggregate, int(count)


def _coarser(network: Network, aggregate: np.ndarray, count: int) -> Network:
    """Return the network of the aggregates, in which parallel links are one."""
    start, stop = aggregate[network.start], aggregate[network.stop]
    leaves = start != stop
    parallel = network.conductance[leaves], (start[leaves], stop[leaves])
    links = sp.coo_array(parallel, shape=(count, count)).tocsr().tocoo()
    return Network(links.row, links.col, links.data, count)
