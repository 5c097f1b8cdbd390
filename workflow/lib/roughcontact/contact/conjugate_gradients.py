"""An accurate correction on a fixed set of points, for where one application of the inverse is too rough.

That happens where the extension is poor: on grids of few cells or of sizes with large prime factors, with
pixels far longer than wide, with contacts and gaps of a few pixels.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from roughcontact.contact.state import mean_product
from roughcontact.kernels.array_api import mean
from roughcontact.kernels.arrays import precision_of

MOST_STEPS = 40
REDUCTION = 0.1  # of the residual


def conjugate_gradients(grid, residual, product, chosen) -> Iterator[tuple]:
    """Yield ever better solutions d of P G P d = P `residual`, and the square <r, M r> of what is left of it.

    Preconditioned conjugate gradients (Hestenes and Stiefel 1952), from d = 0; P keeps the `chosen` points
    and takes the mean off. `product` is M `residual`, of the last preconditioning. Two applications a step;
    ends where rounding leaves no further step. The steps change one array d.
    """
    xp = residual.__array_namespace__()

    def centred(field):
        return xp.where(chosen, field - mean(field[chosen]), xp.zeros_like(field))

    remainder, preconditioned = centred(residual), centred(product)
    direction, solution = preconditioned, xp.zeros_like(remainder)
    rz = mean_product(remainder, preconditioned)
    while True:
        yield solution, rz
        displaced = centred(grid.halfspace.displacement(direction))
        curvature = mean_product(direction, displaced)
        if not (curvature > 0 and rz > 0):
            return
        length = rz / curvature
        solution += length * direction
        remainder = centred(remainder - length * displaced)
        preconditioned = centred(grid.precondition_on_last_set(remainder))
        before, rz = rz, mean_product(remainder, preconditioned)
        direction = preconditioned + rz / before * direction


def accurate(grid, product):
    """Return `product` with a field that, subtracted from the pressure, takes most of the residual away."""
    residual, unsettled = grid.last_residual(precision_of(product.field))
    steps = conjugate_gradients(grid, residual, product.field, unsettled)
    correction, first = next(steps)
    for _, rz in islice(steps, MOST_STEPS):
        if rz <= REDUCTION**2 * first:
            break
    return replace(product, field=correction, mean=0.0)


def is_slow(bound: float, before: float) -> bool:
    """Return whether a step lowered the bound by so little that an accurate correction is worth its price."""
    return bool(np.isfinite(before) and bound > 0.5 * before)
