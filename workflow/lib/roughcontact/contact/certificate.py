"""A rigorous bound of the pressure error, nearly sharp, from one fresh application of the operator.

Let p be feasible (p >= 0, mean(p) given), v = G p - h, c any constant, w = v - c, and r = w where p > 0,
r = min(w, 0) elsewhere. With e = p - p*, the variational inequality of the solution p* gives <e, v*> >= 0, so
||e||_G^2 = <e, v - v*> <= <e, w> <= <e, r>, because e = -p* <= 0 where p = 0. By Cauchy and Schwarz

    ||p - p*||_G <= ||r||_{G^-1} = ( sum_{q != 0} |q|/2 |r_q|^2 )^(1/2),

all in dimensionless form (`roughcontact.halfspace`); ||.||_G is the norm of the elastic energy, without the
mean.
"""

import numpy as np

from roughcontact.contact.state import State, norm

# The residual is transformed in single precision: its norm is then known to this relative accuracy.
_SINGLE_SLACK = 1e-4


def residual(state: State) -> np.ndarray:
    """Return r (ny, nx): the gap where the pressure is positive, its negative part elsewhere."""
    return np.where(state.pressure > 0, state.gap, np.minimum(state.gap, 0))


def error_bound(halfspace, state: State) -> float:
    """Return a bound of ||p - p*||_G / ||p||_G for the pressure of `state`; one operator application."""
    remainder = residual(state).astype(np.float32, copy=False)
    return relative_bound(halfspace, state, norm(remainder, halfspace.pressure(remainder)))


def relative_bound(halfspace, state: State, residual_norm: float) -> float:
    """Return the bound of the relative error that belongs to the norm ||r||_{G^-1} of the residual.

    What rounding hides in the residual is added, so that the bound holds down to the floor.
    """
    if (
        state.norm == 0
    ):  # a uniform pressure: right where it leaves no residual, else no relative error exists
        return 0.0 if residual_norm == 0 else np.inf
    return residual_norm * (1 + _SINGLE_SLACK) / state.norm + rounding_floor(halfspace, state)


def rounding_floor(halfspace, state: State, dtype=None) -> float:
    """Return the relative error that the rounding of one application can hide, in the precision of the gap.

    The error of a Fourier transform is white, of relative size eps sqrt(log2 n) (Schatzman 1996, SIAM J. Sci.
    Comput. 17, 1150); a white field of standard deviation s has ||.||_{G^-1} = s sqrt(mean |q| / 2).
    """
    if state.norm == 0:
        return 0.0
    deviation = np.finfo(dtype or state.gap.dtype).eps * np.sqrt(np.log2(state.gap.size)) * state.size
    return float(deviation * np.sqrt(halfspace.mean_wavenumber / 2) / state.norm)
