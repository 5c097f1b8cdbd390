"""Friction of rubber that slides over a rough face: the work lost in it, with a bound, over the speed.

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
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from roughcontact.arguments.answers import AREA, FRICTION, GAP, PEAK, PRESSURE
from roughcontact.arguments.checking import check_applies, check_positive, warn_of_map
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.relaxation import Relaxation, relaxation_of
from roughcontact.arguments.si import as_si
from roughcontact.arguments.variables import describe
from roughcontact.contact.certificate import error_bound
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.flash_temperature import flash_temperature
from roughcontact.contact.grid import Grid
from roughcontact.contact.loads import check_loads
from roughcontact.contact.problem import copy_to_host, nondimensionalise, warn_of_seams
from roughcontact.contact.solve import contact_from
from roughcontact.errors import ConvergenceError, SettingsError
from roughcontact.kernels.arrays import DOUBLE
from roughcontact.kernels.fourier import halfplane_weights, wavenumbers, wavevectors
from roughcontact.kernels.waves import wave_power
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.statistics.contact_statistics import leaks_of_seal
from roughcontact.statistics.instrument_checks import shortest_measured_wave
from roughcontact.statistics.sealing.flow import flow_columns
from roughcontact.statistics.sealing.percolation import percolation_columns

MAX_CONTACTS = 60  # for one speed; tan(delta/2) gains a factor of 10^4 in 20 of them at a loss factor of 2
INNER, FIRST = 0.1, 1e-2  # tolerance of a contact over the bound before it, and of the first one
BOTH_WAYS = (0.0, 180.0)  # degree
BY_AREA = "adhesive_friction_coefficient"
_ALIKE: dict[str, Any] = {"coords": "minimal", "compat": "override"}  # of courses over one window

Velocity = tuple[float, float]  # of the half-space over the face (vx, vy; m/s)
Compliance = Callable[[np.ndarray], np.ndarray]  # 1/E* (1/Pa, complex) of angular frequencies (1/s)


class SlidingContact(NamedTuple):
    """The contact at one speed, and what its pressure dissipates."""

    pressure: np.ndarray  # (ny, nx; Pa)
    gap: np.ndarray  # (ny, nx; m)
    error_bound: float  # ||p - p*||_S / ||p||_S
    contacts: int  # elastic contacts that were solved
    friction: float  # mean of p du/ds along the path s of the half-space over the mean pressure
    friction_bound: float  # of the absolute error of that
    friction_of_waves: np.ndarray  # (ny, nx // 2 + 1), with the other half-plane; their sum is the friction


@as_si
def sliding_friction(
    window: xr.DataArray,
    *,
    relaxation: Any,
    speed: float | str | Sequence[float | str],
    mean_pressure: float | str,
    direction: float | str | Sequence[float | str] = 0.0,
    poissons_ratio: float = 0.5,
    shear_strength: float | str | None = None,
    seal: Mapping[str, float] | None = None,
    thermal_conductivity: Sequence[float | str] | None = None,
    tolerance: float = 1e-4,
    fields: bool = True,
    threads: int = 1,
) -> xr.Dataset:
    """Return friction and contact of rubber that slides steadily over a rigid rough face, over the speed.

    The waves of the face strain the rubber as it passes, and the work that is lost in it is friction [1]_.
    The rubber is a linear viscoelastic half-space at one temperature, the contact without friction of its
    own; slopes are small, as in all contacts here.

    Parameters
    ----------
    window : DataArray (y, x), m
        as for `solve_contact`: a single rough face.
    relaxation : name, path, DataFrame or mapping
        a rubber of `compounds.tsv`; storage and loss modulus over frequency, a table with headings as
        `frequency (Hz)`, `storage_modulus (MPa)`, `loss_modulus (MPa)`; or a Prony series of Young's modulus,
        `long_time_modulus` (Pa), `moduli` (Pa), `times` (s). A mapping may have the name or the table as
        `table`, and with `wlf` (C1, C2), the `reference_temperature` and the `temperature` the rubber at
        another one.
    speed : float or sequence of float, m/s
        each contact starts from the one before: best in rising order.
    mean_pressure : float, Pa
        nominal pressure.
    direction : float, str or sequence of float, degree
        in which the rubber slides over the face, from x towards y: one, several, or "both ways", 0 and 180,
        which differ on a face that leans.
    poissons_ratio : float
        of the rubber.
    shear_strength : float, Pa, optional
        of the contact area: adds the friction that it alone would make, which is not part of the other.
    seal : mapping, optional
        as for `contact_statistics`: adds the leak.
    thermal_conductivity : sequence of two, W/(m K), optional
        of face and rubber: adds `max_flash_temperature` (K), an upper limit, that of slow sliding
        (`flash_temperature`), by which the friction warms the contact; the rubber here stays as it is.
    tolerance : float
        largest `error_bound` of the pressure, in the norm of the stored energy.
    fields : bool
        keep `pressure` and `gap`.
    threads : int
        of the solver.

    Returns
    -------
    Dataset
        over `speed`, and `direction` where there are several: `hysteretic_friction_coefficient` and the
        proven bound of its error by the solver, `hysteretic_friction_bound`; `error_bound`; area, pressures
        and gap as `contact_statistics` has them; the share of the friction that each octave of wavelengths
        makes, `friction_share_of_octave`, the last one that was measured, up to `last_octave_wavelength` (m),
        `friction_share_of_last_octave`, and frequencies outside the table, `friction_share_beyond_table`; and
        `persson_friction_coefficient` [1]_.
        The attribute `relaxation_misfit` is the rms relative difference of the table from a causal material.

    Raises
    ------
    SettingsError
        for a relaxation, speed or load that does not serve, and a map of two rough faces.
    HeightMapError
        as `solve_contact`.
    ConvergenceError
        where a speed misses the tolerance.

    References
    ----------
    .. [1] B. N. J. Persson (2001), Theory of rubber friction and contact mechanics, J. Chem. Phys. 115, 3840.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> rubber = {"long_time_modulus": 1.0, "moduli": [9.0], "times": [1.0]}
    >>> sliding = sliding_friction(rough_reference_surface(64), relaxation=rubber, speed=[0.001, 0.1, 10.0],
    ...                            mean_pressure=0.1)
    >>> sliding["hysteretic_friction_coefficient"].values.round(3)
    array([0.109, 0.085, 0.001])
    """
    check_applies("sliding_friction", window.attrs)
    rubber = relaxation_of(relaxation, poissons_ratio=poissons_ratio)
    speeds = check_loads("speed", speed, unit="m/s")
    load = check_positive("mean_pressure", mean_pressure, unit="Pa")
    accuracy = check_positive("tolerance", tolerance, unit="relative terms")
    strength = None if shear_strength is None else check_positive("shear_strength", shear_strength, unit="Pa")
    problem, window = nondimensionalise(window, threads=threads), copy_to_host(window)
    warn_of_map(window.shape, problem.gradient)
    warn_of_seams(window, problem.gradient, stacklevel=4)
    directions = np.ravel(np.array(BOTH_WAYS if str(direction) == "both ways" else direction, object))
    ways = pd.to_numeric(pd.Series(directions), errors="coerce").to_numpy(float).tolist()
    if not ways or not np.isfinite(ways).all() or len({*ways}) < len(ways):
        raise SettingsError(
            f"direction = {direction!r}: give an angle (degree), several unlike ones, or 'both ways'",
            keys=["direction"],
        )
    courses = []
    for way in ways:
        path, start, rows = np.exp(1j * math.radians(way)).round(15), None, []  # along an axis exactly
        for sliding_speed in speeds:
            velocity = sliding_speed * path.real, sliding_speed * path.imag
            contact = sliding_contact(
                window, rubber.compliance, velocity, load, tolerance=accuracy, start=start, threads=threads
            )
            if contact.error_bound > accuracy:
                raise ConvergenceError(
                    f"speed {sliding_speed:g} m/s: the error bound stopped at {contact.error_bound:.2g} "
                    f"after {contact.contacts} contacts, above the tolerance {accuracy:g}; raise it"
                )
            start, gap = contact.pressure, contact.gap
            maps = xr.Dataset(
                {"pressure": (("y", "x"), start.copy()), "gap": (("y", "x"), gap)}, window.coords
            )
            row = _numbers(contact, window, rubber, velocity, load)
            if seal is not None:
                passage = flow_columns(gap, spacing(window)) | percolation_columns(gap)
                row |= leaks_of_seal(row | passage, seal)[0]
            if strength is not None:
                row[BY_AREA] = strength * row[AREA] / load
            if thermal_conductivity is not None:
                warm = flash_temperature(
                    maps.expand_dims("load").assign(height=window),
                    friction_coefficient=contact.friction + row.get(BY_AREA, 0.0),
                    speed=sliding_speed,
                    thermal_conductivity=thermal_conductivity,
                )
                row["max_flash_temperature"] = warm["max_flash_temperature"].item()
            rows.append(maps.assign(row) if fields else xr.Dataset(row))
        courses.append(xr.concat(rows, xr.Variable("speed", speeds), **_ALIKE))
    over = xr.concat(courses, xr.Variable("direction", ways), **_ALIKE)
    over["octave_wavelength"] = "octave", 2 * max(spacing(window)) * 2.0 ** np.arange(over.sizes["octave"])
    over["last_octave_wavelength"] = 2 * shortest_measured_wave(window)
    attributes = {"relaxation_misfit": rubber.misfit, "tolerance": accuracy}
    over = over.assign_coords(mean_pressure=load).assign_attrs(attributes)
    return describe(over if len(ways) > 1 else over.squeeze("direction"))


def _numbers(
    contact: SlidingContact, window: xr.DataArray, rubber: Relaxation, velocity: Velocity, load: float
) -> dict[str, Any]:
    """Return the numbers of the contact at one speed by name."""
    pressure, steps = contact.pressure, spacing(window)
    touching = pressure > 0
    qy, qx = wavevectors(window.shape, steps)
    length, frequency = np.hypot(qy, qx), np.abs(velocity[0] * qx + velocity[1] * qy)
    length[0, 0] = np.pi / max(steps)  # of the mean, which has no share
    share_of_waves = contact.friction_of_waves / (contact.friction or 1.0)
    # octaves of wavelengths from two pixels on; the few shorter waves, oblique ones, count to the first
    octave = np.maximum(0, np.ceil(np.log2(np.pi / max(steps) / length) - 1e-9)).astype(int)
    last_octave = 2 * shortest_measured_wave(window) * (1 + 1e-9)
    outside_table = (frequency < rubber.frequencies[0]) | (frequency > rubber.frequencies[1])
    return {
        FRICTION: contact.friction,
        "hysteretic_friction_bound": contact.friction_bound,
        "error_bound": contact.error_bound,
        "contacts_solved": contact.contacts,
        AREA: relative_contact_area(touching),
        PRESSURE: float(pressure[touching].mean()),
        PEAK: float(pressure.max()),
        GAP: float(contact.gap.mean()),
        "friction_share_of_octave": ("octave", np.bincount(octave.ravel(), share_of_waves.ravel())),
        "friction_share_of_last_octave": float(share_of_waves[length * last_octave >= 2 * np.pi].sum()),
        "friction_share_beyond_table": float(share_of_waves[outside_table].sum()),
        "persson_friction_coefficient": persson_friction(window, rubber, velocity, load),
    }


def persson_friction(window: xr.DataArray, rubber: Relaxation, velocity: Velocity, load: float) -> float:
    """Return the friction of Persson (2001) for the waves of a map (y, x; m) at a velocity (vx, vy; m/s).

    mu = 1/2 sum |q| q_s P(q) |h(q)|^2 Im E*(q v)/p, q_s along the path, P = erf(1/(2 sqrt G)) the area that
    longer waves leave in contact, G = 1/8 sum |q|^2 |h(q)|^2 |E*(q v)|^2/p^2 over those.
    """
    qy, qx = wavevectors(window.shape, spacing(window))
    length, frequency = np.hypot(qy, qx), velocity[0] * qx + velocity[1] * qy
    modulus = rubber.contact_modulus(frequency)
    power = halfplane_weights(window.shape) * wave_power(window.values)
    # waves of one length, which differ in direction, are met together
    _, index = np.unique(length, return_inverse=True)
    steps = np.bincount(index.ravel(), (length**2 * power * np.abs(modulus) ** 2).ravel())
    stress = np.cumsum(steps) / (8 * load**2)
    with np.errstate(divide="ignore"):
        area = scipy.special.erf(1 / (2 * np.sqrt(stress)))
    along = length * frequency / math.hypot(*velocity) * power * modulus.imag / (2 * load)
    return float((np.bincount(index.ravel(), along.ravel()) * area).sum())


def sliding_contact(
    window: xr.DataArray,
    compliance: Compliance,
    velocity: Velocity,
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
    lengths = sides[0] / unit_length, sides[1] / unit_length

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
    # a flat face bears the load evenly, and has no wave for the error to be relative to
    bound, contacts, aim = math.inf if np.ptp(heights) > 0 else 0.0, 0, FIRST
    while bound > tolerance and contacts < MAX_CONTACTS:
        face = window.copy(data=level)
        contact = contact_from(face, typical, start, load=load, tolerance=aim, threads=threads)
        start = pressure = contact["pressure"].values[0]
        level = heights + applied(reflection, 2 * applied(size, pressure) - level + heights)
        raised = heights + applied(storage - symbol, pressure)
        grid = Grid(
            (raised - raised.mean()) / unit_length, lengths, stiff.scaled(unit_length), threads=threads
        )
        state = grid.evaluate(pressure / modulus)[0]
        bound = error_bound(grid, state, grid.residual(state, precision=DOUBLE))
        aim, contacts = INNER * max(min(bound, 1.0), tolerance), contacts + 1
    power = halfplane_weights(heights.shape) * wave_power(pressure)
    friction_of_waves = power * loss / load
    loss_tangent = np.divide(loss, storage, out=np.zeros_like(loss), where=storage > 0)
    # <p, L p> - <p*, L p*> = 2 <e, L p> - <e, L e>, L the symmetric operator of the dissipation
    error = bound * math.sqrt(float((power * storage).sum()))
    linear = 2 * error * math.sqrt(float((power * loss * loss_tangent).sum()))
    gap = applied(symbol, pressure) - heights
    return SlidingContact(
        pressure,
        np.where(pressure > 0, 0.0, gap - gap[pressure > 0].mean()),  # within the contact it is rounding
        bound,
        contacts,
        float(friction_of_waves.sum()),
        (linear + error**2 * float(loss_tangent.max())) / load,
        friction_of_waves,
    )


def _symbols(
    shape: tuple[int, int], spacing: tuple[float, float], compliance: Compliance, velocity: Velocity
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
