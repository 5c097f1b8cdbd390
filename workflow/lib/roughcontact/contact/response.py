"""Response of the mean gap of a fixed contact set to an increment of the load."""

import numpy as np

from roughcontact.checking import check_positive
from roughcontact.choices import Influence
from roughcontact.contact.conjugate_gradients import conjugate_gradients
from roughcontact.contact.grid import Grid
from roughcontact.contact.state import mean_product
from roughcontact.elasticity.layers import LayeredPair
from roughcontact.kernels.arrays import DOUBLE, SINGLE

MAX_STEPS = 200
MIN_SINGLE_TOLERANCE = 1e-3  # tolerance from which single precision is far more accurate than required


def linear_response(
    contact: np.ndarray,
    spacing: tuple[float, float],
    contact_modulus: float,
    tolerance: float = 1e-2,
    *,
    yielded: np.ndarray | None = None,
    influence: Influence = "sampled",
    layers: LayeredPair | None = None,
    threads: int = 1,
) -> float:
    """Return the response of the mean gap of a fixed contact set to the load: -d mean_gap / d mean_pressure.

    That is the inverse of the contact stiffness [1]_. An increment x of the pressure on the contact set C, of
    mean 1, leaves no gap there: G x = s on C. The slope s = <x, G x> is the least energy of all such
    increments. It is found by minimising, with an error of second order: `tolerance` is that of x in the
    energy norm, and the error of s is about its square.

    Yielded points respond to unloading like all others, but not to further loading: they carry the hardness,
    and x is zero there. Their overlap grows by s - G x and is flattened plastically, so that the mean gap
    falls by less: by s minus the mean over the window of (s - G x) on the yielded points. The error is then
    of first order in `tolerance`.

    Parameters
    ----------
    contact : array (ny, nx) of bool
        True where the surfaces touch.
    spacing : (dy, dx), m
        of the points.
    contact_modulus : float, Pa
        E*.
    tolerance : float
        relative, of the pressure increment in the energy norm; from 1e-3 single precision is used.
    yielded : array (ny, nx) of bool, optional
        True where a point in contact has reached the hardness, for the response to further loading.
    influence : {"sampled", "elements"}
        symbol of the operator that the contact was solved with (`roughcontact.elasticity.influence`).
    layers : LayeredPair, optional
        of the bodies (`roughcontact.elasticity.layers`); E* is then that of their surfaces.
    threads : int
        of the solve.

    Returns
    -------
    float, m/Pa
        0 for full contact, where the gap is closed and remains so.

    Raises
    ------
    ValueError
        where nothing is in contact, or nothing of it is elastic.

    References
    ----------
    .. [1] Barber (2003), Bounds on the electrical resistance between contacting elastic rough bodies, Proc.
       R. Soc. A 459, 53.

    Examples
    --------
    A wavy surface that touches along half of each wave, s = -2 lambda/(pi E*) ln sin(pi a):

    >>> import numpy as np
    >>> slope = linear_response(np.arange(512)[None, :] < 256, (1 / 512, 1 / 512), 1.0)
    >>> print(f"{slope:.2f} {-2 / np.pi * np.log(np.sin(np.pi / 4)):.2f}")
    0.22 0.22
    """
    modulus = check_positive("contact_modulus", contact_modulus, unit="Pa")
    touching = np.asarray(contact, dtype=bool)
    contact = touching if yielded is None else touching & ~yielded
    if not contact.any():
        raise ValueError(
            "no point in contact is elastic: the response of an empty contact set has no meaning"
        )
    if touching.all():
        return 0.0
    lengths = tuple(n * d for n, d in zip(contact.shape, spacing, strict=True))
    unit = float(np.sqrt(lengths[0] * lengths[1]))
    precision = SINGLE if tolerance >= MIN_SINGLE_TOLERANCE else DOUBLE
    zeros = np.zeros(contact.shape, precision)
    grid = Grid(
        zeros,
        (lengths[0] / unit, lengths[1] / unit),
        influence=influence,
        layers=layers and layers.scaled(unit),
        threads=threads,
    )

    increment = contact.astype(precision)
    increment *= 1 / float(contact.mean())
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
    if yielded is not None and yielded.any():
        even = contact * correction.dtype.type(1 / contact.mean())
        displaced = grid.halfspace.displacement(even - correction)
        energy_lower_bound -= float((energy_lower_bound - displaced[yielded]).sum(dtype=float)) / yielded.size
    return energy_lower_bound * unit / modulus
