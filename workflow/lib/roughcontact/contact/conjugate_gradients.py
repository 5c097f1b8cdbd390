"""An accurate correction on a fixed active set, where one application of the inverse is too inaccurate.

That is where the interpolation is poor: on grids of few cells, with pixels far longer than wide, with
contacts and gaps of a few pixels.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from roughcontact.contact.grid import Grid, PreconditionedResidual
from roughcontact.contact.state import mean_product
from roughcontact.kernels.array_api import mean
from roughcontact.kernels.arrays import Array, namespace, precision_of

MAX_STEPS = 40
REDUCTION = 0.1  # of the residual


def conjugate_gradients(
    grid: Grid, residual: Array, preconditioned: Array, active: Array
) -> Iterator[tuple[Array, float]]:
    """Yield ever better solutions of the operator equation on a fixed active set.

    Solves C G C d = C `residual` from d = 0, where C keeps the active points and subtracts their mean [1]_.
    `preconditioned` is M `residual`; `active` must be the active set of the last residual of the grid. Two
    applications a step; ends where rounding leaves no further step. All steps change one array d.

    Yields
    ------
    solution : array (ny, nx)
        d.
    rz : float
        the square <r, M r> of the remaining residual.

    References
    ----------
    .. [1] Hestenes and Stiefel (1952), J. Res. Natl. Bur. Stand. 49, 409.
    """
    xp = namespace(residual)
    inside, places = xp.astype(active, residual.dtype), xp.nonzero(xp.reshape(active, (-1,)))[0]

    def centred(field: Array) -> Array:
        """Take the mean off the active points, in place, and everything off the others."""
        field -= mean(xp.take(xp.reshape(field, (-1,)), places))
        field *= inside
        return field

    left, z = centred(xp.asarray(residual, copy=True)), centred(xp.asarray(preconditioned, copy=True))
    del residual, preconditioned
    direction, solution = z, xp.zeros_like(left)
    rz = mean_product(left, z)
    while True:
        yield solution, rz
        displaced = centred(grid.halfspace.displacement(direction))
        curvature = mean_product(direction, displaced)
        if not (curvature > 0 and rz > 0):
            return
        length = rz / curvature
        displaced *= length
        left -= displaced
        del displaced, z  # no more large maps in memory than necessary
        solution += length * direction
        left = centred(left)
        z = centred(grid.precondition_on_last_set(left))
        before, rz = rz, mean_product(left, z)
        direction *= rz / before
        direction += z


def corrected_accurately(grid: Grid, correction: PreconditionedResidual) -> PreconditionedResidual:
    """Return a more accurate correction for the last residual of the grid; its `mean` is zero."""
    residual, active = grid.last_residual(precision_of(correction.field))
    steps = conjugate_gradients(grid, residual, correction.field, active)
    solution, first = next(steps)
    for _, rz in islice(steps, MAX_STEPS):
        if rz <= REDUCTION**2 * first:
            break
    return replace(correction, field=solution, mean=0.0)


def gains_little(bound: float, before: float) -> bool:
    """Return whether a step lowered the error bound so little that an accurate correction pays off."""
    return bool(np.isfinite(before) and bound > 0.5 * before)
