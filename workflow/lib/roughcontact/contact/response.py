"""Response of the mean gap of a fixed contact set to an increment of the load."""

import numpy as np

from roughcontact.contact.conjugate_gradients import conjugate_gradients
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.grid import Grid
from roughcontact.contact.state import mean_product
from roughcontact.kernels.arrays import DOUBLE, SINGLE

MAX_STEPS = 200
MIN_SINGLE_TOLERANCE = 1e-3  # tolerance from which single precision is far more accurate than required


def linear_response(
    contact: np.ndarray,
    spacing: tuple[float, float],
    elasticity: Elasticity,
    tolerance: float = 1e-2,
    *,
    yielding: np.ndarray | None = None,
    certify: bool = False,
    threads: int = 1,
) -> tuple[float, float]:
    """Return -d mean_gap / d mean_pressure (m/Pa) of a contact set (ny, nx; bool), and its relative error.

    It is the inverse stiffness (Barber 2003, Proc. R. Soc. A 459, 53). An increment x of mean 1 on the
    contact set leaves no gap there, G x = s; s = <x, G x> is the least energy of all such increments, with an
    error of second order in `tolerance`, that of x in the energy norm. Points of `yielding` carry the
    hardness, and x is zero there: their overlap grows by s - G x, the mean of which over the window is taken
    off, with an error of first order. 0 for full contact.

    The error is a proven bound where it is to `certify` that nothing yields, else NaN. x differs from the
    exact increment by e, which has no mean and is zero outside the contact: s is too large by ||e||_G^2 =
    <e, G x - c>, with any constant c, at most ||r||_{G^-1}^2 of any field r that is G x - c on the contact. r
    is its interpolation, from a fresh application of G; the rounding is added.
    """
    touching = np.asarray(contact, dtype=bool)
    contact = touching if yielding is None else touching & ~yielding
    if not contact.any():
        raise ValueError(
            "no point in contact is elastic: the response of an empty contact set has no meaning"
        )
    if touching.all():
        return 0.0, 0.0  # in full contact the gap cannot change
    ly, lx = (n * d for n, d in zip(contact.shape, spacing, strict=True))
    unit = float(np.sqrt(ly * lx))
    precision = SINGLE if tolerance >= MIN_SINGLE_TOLERANCE else DOUBLE
    zeros = np.zeros(contact.shape, precision)
    grid = Grid(zeros, (ly / unit, lx / unit), elasticity.scaled(unit), threads=threads)

    increment = contact.astype(precision)
    increment *= 1 / float(contact.mean())  # a load of mean 1 on the contact alone
    residual = grid.halfspace.displacement(increment)
    del increment
    residual *= contact
    energy = float(residual[contact].mean(dtype=float))  # <x, G x> of the even increment x
    steps = conjugate_gradients(
        grid,
        residual,
        # without a name here, so that no more maps than necessary are in memory
        grid.precondition_on(contact, residual - contact * residual.dtype.type(energy)),
        contact,
    )
    for step, (correction, rz) in enumerate(steps):
        energy_lower_bound = energy - mean_product(residual, correction)  # <x - d, G (x - d)>
        if rz <= tolerance**2 * energy_lower_bound or step == MAX_STEPS:
            break
    response, bound = energy_lower_bound, np.nan
    if certify or yielding is not None:
        del residual, steps
        correction -= contact * correction.dtype.type(1 / contact.mean())  # now -x
        dent = grid.halfspace.displacement(correction)
    if yielding is not None:
        response -= float((response + dent[yielding]).sum(dtype=float)) / yielding.size
    elif certify:
        response = mean_product(correction, dent)
        dent -= dent[contact].mean(dtype=float)
        dent *= contact
        extension = grid.interpolator(precision)
        extension.prolong(dent, extension.field)
        rounding = float(np.finfo(precision).eps) * np.log2(contact.size)  # of two transforms
        bound = float(grid.halfspace.pressure_spectrum(extension.field)[1] / response + rounding)
    return response * unit / elasticity.modulus, bound
