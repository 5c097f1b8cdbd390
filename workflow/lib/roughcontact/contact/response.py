"""How the mean gap of a fixed contact set answers to a little more load."""

import numpy as np

from roughcontact.contact.grid import Grid
from roughcontact.contact.problem import check_positive
from roughcontact.contact.state import mean_product


def linear_response(
    contact: np.ndarray,
    spacing: tuple[float, float],
    contact_modulus: float,
    tolerance: float = 1e-2,
    *,
    threads: int = 1,
) -> float:
    """Return -d mean_gap / d mean_pressure (m Pa-1) of a fixed contact set, the inverse contact stiffness.

    An increment x of the pressure on the contact set C, of mean 1, leaves no gap there: G x = s on C. The
    slope s = <x, G x> is the least energy of all such increments. It is found by minimising, with an error of
    second order: `tolerance` is that of x in the energy norm, s is good to about its square.

    Parameters
    ----------
    contact
        boolean map (ny, nx), True where the surfaces touch.
    spacing
        (dy, dx) in m.
    contact_modulus
        E* in Pa.

    Returns
    -------
    float
        0 for full contact, where the gap is closed and stays so.

    Raises
    ------
    ValueError
        where nothing is in contact.
    """
    modulus = check_positive("contact_modulus", contact_modulus, unit="Pa")
    contact = np.asarray(contact, dtype=bool)
    if not contact.any():
        raise ValueError("no point is in contact: the response of an empty contact set has no meaning")
    if contact.all():
        return 0.0
    lengths = tuple(n * d for n, d in zip(contact.shape, spacing, strict=True))
    unit = float(np.sqrt(lengths[0] * lengths[1]))
    grid = Grid(np.zeros(contact.shape), tuple(length / unit for length in lengths), threads=threads)
    share = contact.mean()

    increment = contact / share
    displaced = grid.halfspace.displacement(increment).copy()
    remainder = _centred(displaced, contact)
    product, rz = _preconditioned(grid, remainder, contact)
    direction = -product
    for _ in range(200):
        if rz <= tolerance**2 * mean_product(increment, displaced):
            break
        moved = grid.halfspace.displacement(direction)
        length = rz / mean_product(direction, moved)
        increment += length * direction
        displaced += length * moved
        remainder = _centred(displaced, contact)
        product, rz_after = _preconditioned(grid, remainder, contact)
        direction = rz_after / rz * direction - product
        rz = rz_after
    return mean_product(increment, displaced) * unit / modulus


def _preconditioned(grid, remainder, contact):
    """Return M r, of mean zero on the contact, and <r, M r>."""
    product = _centred(grid.precondition_on(contact, remainder), contact)
    return product, mean_product(remainder, product)


def _centred(field, contact):
    """Return `field` on the contact less its mean there, and zero elsewhere."""
    return np.where(contact, field - field[contact].mean(), 0)
