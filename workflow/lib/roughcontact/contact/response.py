"""How the mean gap of a fixed contact set answers to a little more load."""

import numpy as np

from roughcontact.contact.contact_set import ContactSet, centred
from roughcontact.contact.problem import check_positive
from roughcontact.contact.state import total_product
from roughcontact.halfspace import HalfSpace


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
    halfspace = HalfSpace(contact.shape, tuple(length / unit for length in lengths), threads=threads)
    contact_set = ContactSet(halfspace, contact)

    increment = np.full(contact_set.points.size, contact.size / contact_set.points.size)
    displaced = contact_set.take(contact_set.displacement(increment))
    remainder = centred(displaced)
    product = contact_set.precondition(remainder)
    direction, rz = -product, total_product(remainder, product)
    for _ in range(200):
        if rz <= tolerance**2 * total_product(increment, displaced):
            break
        moved = contact_set.take(contact_set.displacement(direction))
        length = rz / total_product(direction, moved)
        increment += length * direction
        displaced += length * moved
        remainder = centred(displaced)
        product = contact_set.precondition(remainder)
        rz_before, rz = rz, total_product(remainder, product)
        direction = rz / rz_before * direction - product
    return total_product(increment, displaced) / contact.size * unit / modulus
