"""A rigorous bound of the pressure error, nearly sharp, from one fresh application of the operator.

Let p be feasible (0 <= p <= cap, mean(p) given), v = G p - h, c any constant, w = v - c, and r any field with
r = w where 0 < p < cap, r <= w where p = 0, r >= w where p = cap. With e = p - p*, the variational inequality
of the solution p* gives <e, v*> >= 0, so ||e||_G^2 = <e, v - v*> <= <e, w> <= <e, r>, because e <= 0 where
p = 0 and e >= 0 at the cap. By Cauchy and Schwarz

    ||p - p*||_G <= ||r||_{G^-1} = ( sum_{q != 0} |q|/2 |r_q|^2 )^(1/2),

all in dimensionless form (`roughcontact.elasticity.halfspace`); ||.||_G is the norm of the elastic energy,
without the mean. The freedom of r off the free contact makes the bound sharp: its energy is least where r
continues w as `roughcontact.contact.interpolation` does. So r is that interpolation, projected onto w where
it would violate it.
"""

from math import log2, sqrt

import numpy as np

from roughcontact.contact.grid import Grid, Residual
from roughcontact.contact.state import State, norm
from roughcontact.elasticity.halfspace import HalfSpace
from roughcontact.kernels.arrays import DOUBLE, SINGLE, count_of, namespace, precision_of

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
    projected = xp.where(state.pressure > 0, gap, xp.minimum(gap, xp.zeros_like(gap)))
    size = norm(projected, projected)
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
    """Return the relative error, in the energy norm, that rounding can hide. The precision is the state's.

    The error of a Fourier transform is white, of relative size eps sqrt(log2 n) [1]_. That of the transform
    of the pressure, whose mean counts although q = 0 is left out, is an error of the pressure: a white field
    of standard deviation s has ||.||_G = s sqrt(mean 2/|q|). That of the transform back is an error of the
    separation, where such a field has ||.||_{G^-1} = s sqrt(mean |q|/2). In partial contact this one is
    nearly all of the floor. In full contact and at the hardness, where the pressure is nearly uniform and
    ||p||_G far less than its root mean square, the others are: that one, and `rounding_by_unit`.

    References
    ----------
    .. [1] Schatzman (1996), Accuracy of the discrete Fourier transform and the fast Fourier transform, SIAM
       J. Sci. Comput. 17, 1150.
    """
    if state.norm == 0:
        return 0.0
    precision = precision or precision_of(state.separation)
    of_pressure = state.pressure_size * sqrt(halfspace.compliances[0])
    of_separation = state.size * sqrt(halfspace.mean_stiffness)
    of_transforms = sqrt(log2(count_of(state.pressure))) * (of_pressure + of_separation) / state.norm
    return _EPS[precision] * of_transforms + rounding_by_unit(halfspace, state, precision)


def rounding_by_unit(halfspace: HalfSpace, state: State, precision: str) -> float:
    """Return the relative error, in the energy norm, by which a result in a precision may miss its state.

    When the pressure gets its unit, after the certificate, each value is rounded by eps/2, as the unit is.
    On a regular map all points of a kind are rounded alike, so that no more is known of the sum e than
    ||e||_G <= sqrt(max 2/|q|) eps ||p||, with the root mean square ||p||. A hardness is rounded, too: what
    the points at it bear more or less, the k free ones of n make up for, each by up to eps mean(p) n/k; the
    root mean square of that over the grid is sqrt(n/k) times as much.
    """
    of_values = state.pressure_size * sqrt(halfspace.compliances[1] / state.free_share)
    return _EPS[precision] * of_values / state.norm
