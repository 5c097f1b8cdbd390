"""A rigorous bound of the pressure error, nearly sharp, from one fresh application of the operator.

Let p be feasible (0 <= p <= cap, mean(p) given), w = G p - h - c with any constant c, and r = w where 0 < p <
cap, r <= w where p = 0, r >= w where p = cap. With e = p - p* the variational inequality gives <e, v*> >= 0,
so ||e||_G^2 = <e, v - v*> <= <e, w> <= <e, r>, and by Cauchy and Schwarz

    ||p - p*||_G <= ||r||_{G^-1} = ( sum_{q != 0} |q|/2 |r_q|^2 )^(1/2),

all dimensionless, without the mean. The energy of r is least where it continues w as the interpolation does,
so r is that interpolation, projected onto w where it would violate it.
"""

from math import log2, sqrt

import numpy as np

from roughcontact.contact.elasticity.halfspace import HalfSpace
from roughcontact.contact.grid import Grid, Residual
from roughcontact.contact.state import State, norm
from roughcontact.kernels.arrays import DOUBLE, SINGLE, get_precision, n_elements, namespace

# The residual is transformed in single precision: its norm is then known to this relative accuracy.
_SINGLE_SLACK = 1e-4
_EPS = {precision: float(np.finfo(precision).eps) for precision in (SINGLE, DOUBLE)}


def error_bound(grid: Grid, state: State, residual: Residual) -> float:
    """Return a bound of ||p - p*||_G / ||p||_G for the pressure of `state`.

    `residual` is the interpolated residual of the state. At most half an application of G^-1 is needed.
    """
    return relative_bound(grid.halfspace, state, grid.residual_norm(state, residual))


def bound_without_transform(grid: Grid, state: State) -> float:
    """Return a coarser bound, from ||r||_{G^-1}^2 <= mean(r^2) max|q|/2, for a residual of rounding alone.

    It is never below `error_bound`.
    """
    gap = state.gap
    xp = namespace(gap)
    projection = xp.where(state.pressure > 0, gap, xp.minimum(gap, xp.zeros_like(gap)))
    size = norm(projection, projection)
    return relative_bound(grid.halfspace, state, size * sqrt(grid.halfspace.largest_stiffness))


def relative_bound(halfspace: HalfSpace, state: State, residual_norm: float) -> float:
    """Return the bound of the relative error that belongs to the norm ||r||_{G^-1} of the residual.

    The error that rounding hides in the residual is added, so that the bound holds down to the floor. It is
    infinite for a uniform pressure with a residual, which has no relative error.
    """
    if state.norm == 0:
        # a uniform pressure: exact without a residual, otherwise without relative error
        return 0.0 if residual_norm == 0 else np.inf
    return residual_norm * (1 + _SINGLE_SLACK) / state.norm + rounding_floor(halfspace, state)


def rounding_floor(halfspace: HalfSpace, state: State, precision: str | None = None) -> float:
    """Return the relative error, in the energy norm, that rounding (in the precision of the state) hides.

    The error of a Fourier transform is white, of relative size eps sqrt(log2 n) (Schatzman 1996, SIAM J. Sci.
    Comput. 17, 1150): of the transform of the pressure ||.||_G = s sqrt(mean 2/|q|), of the transform back
    ||.||_{G^-1} = s sqrt(mean |q|/2), nearly all of the floor in partial contact.
    """
    if state.norm == 0:
        return 0.0
    precision = precision or get_precision(state.separation)
    of_pressure = state.pressure_size * sqrt(halfspace.compliances[0])
    of_separation = state.size * sqrt(halfspace.mean_stiffness)
    of_transforms = sqrt(log2(n_elements(state.pressure))) * (of_pressure + of_separation) / state.norm
    return _EPS[precision] * of_transforms + rounding_by_unit(halfspace, state, precision)


def rounding_by_unit(halfspace: HalfSpace, state: State, precision: str) -> float:
    """Return the relative error, in the energy norm, by which a result in a precision may miss its state."""
    # each value is rounded by eps/2 when the pressure gets its unit, as the unit is; the k free of n points
    # make up for what those at the hardness bear more or less, up to eps mean(p) n/k
    of_values = state.pressure_size * sqrt(halfspace.compliances[1] / state.free_share)
    return _EPS[precision] * of_values / state.norm
