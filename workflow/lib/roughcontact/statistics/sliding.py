"""Friction of rubber that slides over a rough face: the work lost in it, with a bound, over the speed."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import scipy
import xarray as xr

from roughcontact.arguments.answers import AREA, FRICTION, GAP, PEAK, PRESSURE
from roughcontact.arguments.checking import check_keys, check_positive, warn_of_map
from roughcontact.arguments.kinds import facts_of, properties_of_map
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.relaxation import Relaxation, relaxation_of
from roughcontact.arguments.si import as_si
from roughcontact.arguments.variables import describe
from roughcontact.contact.flash_temperature import flash_temperature
from roughcontact.contact.loads import check_loads
from roughcontact.contact.problem import copy_to_host, nondimensionalise, warn_of_seams
from roughcontact.contact.sliding import SlidingContact, sliding_contact
from roughcontact.errors import ConvergenceError, SettingsError
from roughcontact.kernels.fourier import halfplane_weights, wavenumbers, wavevectors
from roughcontact.kernels.waves import wave_power
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.statistics.instrument_checks import shortest_measured_wave
from roughcontact.statistics.sealing.flow import flow_columns, leak_columns
from roughcontact.statistics.sealing.percolation import percolation_columns

_WAYS = {"both ways": (0.0, 180.0)}  # words -> degree
BY_AREA = "adhesive_friction_coefficient"
_ALIKE: dict[str, Any] = {"coords": "minimal", "compat": "override"}  # of courses over one window


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
    if reason := facts_of(window.attrs).reason_against("sliding_friction", properties_of_map(window.attrs)):
        raise SettingsError(reason)
    rubber = relaxation_of(relaxation, poissons_ratio=poissons_ratio)
    speeds = check_loads("speed", speed, unit="m/s")
    load = check_positive("mean_pressure", mean_pressure, unit="Pa")
    accuracy = check_positive("tolerance", tolerance, unit="relative terms")
    strength = None if shear_strength is None else check_positive("shear_strength", shear_strength, unit="Pa")
    check_keys("seal", seal, leak_columns)
    problem, window = nondimensionalise(window, threads=threads), copy_to_host(window)
    warn_of_map(window.shape, problem.gradient)
    warn_of_seams(window, problem.gradient, stacklevel=4)
    try:
        ways = (
            np.array(_WAYS.get(direction, direction) if isinstance(direction, str) else direction, float)
            .ravel()
            .tolist()
        )
    except (TypeError, ValueError):
        ways = []
    if not ways or not np.isfinite(ways).all() or len({*ways}) < len(ways):
        raise SettingsError(
            f"direction = {direction!r}: give an angle (degree), several unlike ones, or 'both ways'",
            keys=["direction"],
        )
    courses = []
    for way in ways:
        path, start, rows = np.exp(1j * math.radians(way)).round(15), None, []  # along an axis exactly
        for each in speeds:
            velocity = each * path.real, each * path.imag
            contact = sliding_contact(
                window, rubber.compliance, velocity, load, tolerance=accuracy, start=start, threads=threads
            )
            if contact.error_bound > accuracy:
                raise ConvergenceError(
                    f"speed {each:g} m/s: the error bound stopped at {contact.error_bound:.2g} after "
                    f"{contact.contacts} contacts, above the tolerance {accuracy:g}; raise it"
                )
            start, gap = contact.fields.pressure, contact.fields.gap
            maps = xr.Dataset(
                {"pressure": (("y", "x"), start.copy()), "gap": (("y", "x"), gap)}, window.coords
            )
            row = _numbers(contact, window, rubber, velocity, load)
            if seal is not None:
                open_gap = np.where(start > 0, 0.0, gap)
                passage = flow_columns(open_gap, spacing(window)) | percolation_columns(open_gap)
                row |= {name: float(leak) for name, leak in leak_columns(row[GAP], passage, **seal).items()}
            if strength is not None:
                row[BY_AREA] = strength * row[AREA] / load
            if thermal_conductivity is not None:
                warm = flash_temperature(
                    maps.expand_dims("load").assign(height=window),
                    friction_coefficient=contact.friction + row.get(BY_AREA, 0.0),
                    speed=each,
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
    contact: SlidingContact,
    window: xr.DataArray,
    rubber: Relaxation,
    velocity: tuple[float, float],
    load: float,
) -> dict[str, Any]:
    """Return the numbers of the contact at one speed by name."""
    pressure, steps = contact.fields.pressure, spacing(window)
    touching = pressure > 0
    qy, qx = wavevectors(window.shape, steps)
    length, frequency = np.hypot(qy, qx), np.abs(velocity[0] * qx + velocity[1] * qy)
    share_of_waves = contact.friction_of_waves / (contact.friction or 1.0)
    length[0, 0] = np.pi / max(steps)  # the mean has no share
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
        GAP: float(np.where(touching, 0.0, contact.fields.gap).mean()),  # within the contact it is rounding
        "friction_share_of_octave": ("octave", np.bincount(octave.ravel(), share_of_waves.ravel())),
        "friction_share_of_last_octave": float(share_of_waves[length * last_octave >= 2 * np.pi].sum()),
        "friction_share_beyond_table": float(share_of_waves[outside_table].sum()),
        "persson_friction_coefficient": persson_friction(window, rubber, velocity, load),
    }


def persson_friction(
    window: xr.DataArray, rubber: Relaxation, velocity: tuple[float, float], load: float
) -> float:
    """Return the friction of Persson (2001) for the waves of a map (y, x; m) at a velocity (vx, vy; m/s).

    mu = 1/2 sum |q| q_s P(q) |h(q)|^2 Im E*(q v)/p, q_s along the path, P = erf(1/(2 sqrt G)) the area that
    longer waves leave in contact, G = 1/8 sum |q|^2 |h(q)|^2 |E*(q v)|^2/p^2 over those.
    """
    qy, qx = wavevectors(window.shape, spacing(window))
    frequency = velocity[0] * qx + velocity[1] * qy
    length = wavenumbers(window.shape, spacing(window))
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
