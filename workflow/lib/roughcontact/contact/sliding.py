"""Steady sliding of a viscoelastic half-space over a rigid rough face, with the certificate of a contact.

A face over which the half-space slides at the velocity v strains it at the frequency q v: it is displaced by
u = A p, A(q) = 2 J(q v)/|q|, with the complex compliance J = 1/E* of exp(i omega t). A is not symmetric but
monotone, S = Re A > 0, and with the norms of S the proof in `contact.certificate` holds word for word:

    ||e||_S^2 = <e, A e> <= <e, A p - h - c> <= <e, r> <= ||e||_S ||r||_{S^-1},    e = p - p*.

As A p - h = S p - (h + (S - A) p), it is the certificate of p as a contact of the symbol S on those heights.

The iteration is that of Peaceman and Rachford, in the metric of D = |A|: elastic contacts of the symbol D,
whose heights H change from one to the next, z = 2 D p - H, by

    H <- h + (D - A)/(D + A) (z + h).

A contact is the projection onto the pressures of its load in that metric, and its reflection lengthens
nothing; the other factor is |D - A|/|D + A| = tan(delta/2) < 1 at any loss angle delta (Lions and Mercier
1979, SIAM J. Numer. Anal. 16, 964). Without loss the first contact is the solution.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import spacing
from roughcontact.contact.certificate import error_bound
from roughcontact.contact.dataset import FieldsInUnits, fields_in_units, unit_of_pressure
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.grid import Grid
from roughcontact.contact.iteration import Solution
from roughcontact.contact.problem import nondimensionalise
from roughcontact.contact.solve import contact_from
from roughcontact.kernels.arrays import DOUBLE
from roughcontact.kernels.fourier import halfplane_weights, wavenumbers, wavevectors
from roughcontact.kernels.waves import wave_power

MAX_CONTACTS = 60  # for one speed; tan(delta/2) gains a factor of 10^4 in 20 of them at a loss factor of 2
INNER, FIRST = 0.1, 1e-2  # tolerance of a contact over the bound before it, and of the first one

Compliance = Callable[[np.ndarray], np.ndarray]  # 1/E* (1/Pa, complex) of angular frequencies (1/s)


class SlidingContact(NamedTuple):
    """The contact at one speed, and what its pressure dissipates."""

    fields: FieldsInUnits
    error_bound: float  # ||p - p*||_S / ||p||_S
    contacts: int  # elastic contacts that were solved
    friction: float  # mean of p du/ds along the path s of the half-space over the mean pressure
    friction_bound: float  # of the absolute error of that
    friction_of_waves: np.ndarray  # (ny, nx // 2 + 1), with the other half-plane; their sum is the friction


def sliding_contact(
    window: xr.DataArray,
    compliance: Compliance,
    velocity: tuple[float, float],
    load: float,
    *,
    tolerance: float,
    start: np.ndarray | None = None,
    threads: int = 1,
) -> SlidingContact:
    """Return the contact of a map (y, x; m) with a half-space that slides over it.

    Its `velocity` is (vx, vy; m/s), `load` the mean pressure (Pa), `start` the pressure (ny, nx; Pa) of a
    similar contact. The caller compares `error_bound` with the tolerance: it ends after `MAX_CONTACTS`.
    """
    heights, steps = window.values, spacing(window)
    sides = np.multiply(heights.shape, steps)
    unit_length = math.sqrt(math.prod(sides))

    @cache
    def symbols(ny: int, nx: int) -> tuple[np.ndarray, np.ndarray]:
        return _symbols((ny, nx), (sides[0] / ny, sides[1] / nx), compliance, velocity)

    symbol, loss = symbols(*heights.shape)
    size, storage = np.abs(symbol), symbol.real
    # any unit would do: that of a typical wave keeps the numbers near 1
    modulus = float(2 / np.median((wavenumbers(heights.shape, steps) * size).ravel()[1:]))

    def elastic(part: Callable[[np.ndarray], np.ndarray]) -> Elasticity:
        def influence(qy: np.ndarray, qx: np.ndarray, steps: tuple[float, float]) -> np.ndarray:
            shape = np.round(sides / unit_length / steps).astype(int)
            values = (modulus / unit_length * part(symbols(*shape)[0])).astype(qx.dtype)
            values[0, 0] = np.inf  # the mean, which no operator uses
            return values

        return Elasticity(modulus, influence)

    def applied(factor: np.ndarray, field: np.ndarray) -> np.ndarray:
        return np.fft.irfft2(factor * np.fft.rfft2(field), s=field.shape)

    typical, stiff = elastic(np.abs), elastic(np.real)
    reflection = np.divide(size - symbol, size + symbol, out=np.zeros_like(symbol), where=size > 0)
    pressure = np.full(heights.shape, load) if start is None else start
    level = heights + applied(size - symbol, pressure)
    bound, contacts, aim = math.inf, 0, FIRST
    while bound > tolerance and contacts < MAX_CONTACTS:
        face = window.copy(data=level)
        contact = contact_from(face, typical, start, load=load, tolerance=aim, threads=threads)
        start = pressure = contact["pressure"].values[0]
        level = heights + applied(reflection, 2 * applied(size, pressure) - level + heights)
        certified = nondimensionalise(
            window.copy(data=heights + applied(storage - symbol, pressure)), threads=threads
        )
        unit = unit_of_pressure(certified, modulus)
        grid = Grid(
            certified.heights,
            certified.lengths,
            stiff.scaled(certified.unit_length, unit),
            reference=certified.reference,
            unit=certified.scale,
            threads=threads,
        )
        state = grid.evaluate(pressure / unit)[0]
        bound = error_bound(grid, state, grid.residual(state, precision=DOUBLE))
        aim, contacts = INNER * max(min(bound, 1.0), tolerance), contacts + 1
    power = halfplane_weights(heights.shape) * wave_power(pressure)
    friction_of_waves = power * loss / load
    dissipated = np.divide(loss, storage, out=np.zeros_like(loss), where=storage > 0)
    # <p, L p> - <p*, L p*> = 2 <e, L p> - <e, L e>, L the symmetric operator of the dissipation
    error = bound * math.sqrt(float((power * storage).sum()))
    linear = 2 * error * math.sqrt(float((power * loss * dissipated).sum()))
    return SlidingContact(
        fields_in_units(Solution(state, bound, contacts), certified, stiff, threads=threads),
        bound,
        contacts,
        float(friction_of_waves.sum()),
        (linear + error**2 * float(dissipated.max())) / load,
        friction_of_waves,
    )


def _symbols(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    compliance: Compliance,
    velocity: tuple[float, float],
) -> tuple[np.ndarray, np.ndarray]:
    """Return A (m/Pa) and the symbol of the dissipation, -(q s) Im A (1/Pa), 0 at q = 0, s the unit velocity.

    A wave at the Nyquist limit of an even side runs both ways: its symbols are the means of the two.
    """
    speed = math.hypot(*velocity)
    qy, qx = wavevectors(shape, spacing)

    def waves(qy: np.ndarray, qx: np.ndarray) -> np.ndarray:
        length = np.hypot(qy, qx)
        length[length == 0] = np.inf  # the mean, which is displaced by a rule of its own
        frequency = velocity[0] * qx + velocity[1] * qy
        symbol = 2 * compliance(frequency) / length
        return np.stack([symbol, -frequency / speed * symbol.imag])

    def along_y(qx: np.ndarray) -> np.ndarray:
        values = waves(qy, qx)
        if shape[0] % 2 == 0:
            row = shape[0] // 2
            # the wave at the Nyquist limit stands for both signs of its frequency
            values[:, row] = (values[:, row] + waves(-qy[row : row + 1], qx)[:, 0]) / 2
        return values

    symbols = along_y(qx)
    if shape[1] % 2 == 0:
        symbols[:, :, -1:] = (along_y(qx[:, -1:]) + along_y(-qx[:, -1:])) / 2
    return symbols[0], symbols[1].real
