"""Accurate solutions on a fixed active set: the response of a contact to an increment of the load."""

from collections.abc import Iterator

from roughcontact.contact.grid import Grid
from roughcontact.contact.state import mean_product
from roughcontact.kernels.array_api import mean
from roughcontact.kernels.arrays import Array, namespace


def conjugate_gradients(
    grid: Grid, residual: Array, initial_z: Array, active: Array
) -> Iterator[tuple[Array, float]]:
    """Yield d (ny, nx), changed in place from d = 0, and <r, M r> of the remainder, for C G C d = C r.

    C keeps the active points and subtracts their mean (Hestenes and Stiefel 1952, J. Res. Natl. Bur. Stand.
    49, 409); `initial_z` is M r, `active` the active set of the last residual. Two applications a step.
    """
    xp = namespace(residual)
    inside, active_points = xp.astype(active, residual.dtype), xp.nonzero(xp.reshape(active, (-1,)))[0]

    def centred(field: Array) -> Array:
        """Take the mean off the active points, in place, and everything off the others."""
        field -= mean(xp.take(xp.reshape(field, (-1,)), active_points))
        field *= inside
        return field

    current_residual, z = (centred(xp.asarray(field, copy=True)) for field in (residual, initial_z))
    del residual, initial_z
    direction, solution = z, xp.zeros_like(current_residual)
    rz = mean_product(current_residual, z)
    while True:
        yield solution, rz
        displacement = centred(grid.halfspace.displacement(direction))
        curvature = mean_product(direction, displacement)
        if not (curvature > 0 and rz > 0):
            return
        length = rz / curvature
        displacement *= length
        current_residual -= displacement
        del displacement, z  # no more large maps in memory than necessary
        solution += length * direction
        current_residual = centred(current_residual)
        z = centred(grid.precondition_on(None, current_residual))
        previous_rz, rz = rz, mean_product(current_residual, z)
        direction *= rz / previous_rz
        direction += z
