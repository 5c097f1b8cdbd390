"""An accurate correction on a fixed set of points, for where one application of the inverse is too rough.

That happens where the extension is poor: on grids of few cells or of sizes with large prime factors, with
pixels far longer than wide, with contacts and gaps of a few pixels.
"""

from dataclasses import replace

import numpy as np

from roughcontact.contact.state import mean_product

MOST_STEPS = 40
REDUCTION = 0.1  # of the residual


def conjugate_gradients(grid, product):
    """Return `product` with a field that, subtracted from the pressure, takes most of the residual away.

    Preconditioned conjugate gradients (Hestenes and Stiefel 1952) for P G P d = r of mean zero, where P keeps
    the unsettled points of `product` and takes the mean off. Two applications a step.
    """
    residual, unsettled = grid.last_residual(product.field.dtype)
    xp = residual.__array_namespace__()

    def centred(field):
        return xp.where(unsettled, field - field.dtype.type(xp.mean(field[unsettled], dtype=xp.float64)), 0)

    remainder, preconditioned = centred(residual), centred(product.field)
    correction = xp.zeros_like(remainder)
    direction = preconditioned
    rz = mean_product(remainder, preconditioned)
    enough = REDUCTION**2 * rz
    for _ in range(MOST_STEPS):
        displaced = centred(grid.halfspace.displacement(direction))
        curvature = mean_product(direction, displaced)
        if not (curvature > 0 and rz > enough):
            break
        length = residual.dtype.type(rz / curvature)
        correction += length * direction
        remainder -= length * displaced
        remainder = centred(remainder)
        preconditioned = centred(grid.precondition_on_last_set(remainder))
        before, rz = rz, mean_product(remainder, preconditioned)
        direction = preconditioned + residual.dtype.type(rz / before) * direction
    return replace(product, field=correction, mean=0.0)


def is_slow(bound: float, before: float) -> bool:
    """Return whether a step lowered the bound by so little that an accurate correction is worth its price."""
    return bool(np.isfinite(before) and bound > 0.5 * before)
