"""Stresses below the surface: a pressure wave, solved ridges and a Hertz contact, and rough maps."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from roughcontact.contact.elasticity.subsurface import subsurface_stress, tresca, von_mises
from roughcontact.contact.solve import solve_contact
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.statistics.subsurface import add_subsurface_yield, stress_columns
from roughcontact.statistics.targets import target_loads
from roughcontact.surface import synthetic
from validation import closed_forms, depth_integral
from validation.lines import Section
from validation.problems import FORCE, RADIUS, solve, sphere

_POINTS = 64  # of the wave, for which the answer is exact
_RIDGES, _LOAD = 0.01, 0.2  # amplitude over wavelength, load over that of complete contact
_VOLUME = 0.005  # how exact the volume above a yield stress is stated to be
_HERTZ = closed_forms.periodic_hertz(FORCE, RADIUS, 1.0, 1.0)
_COPIES = FORCE / _HERTZ["max_pressure"]  # mean pressure of the repeated sphere over the largest one


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the lines of waves, of ridges and a sphere on grids a quarter as fine, and of two rough maps."""
    _wave(section, finest_grid)
    _elongated(section, finest_grid // 4)
    _rough(section, shortest=2, load=0.05)
    _rough(section, shortest=8, load=0.5)
    _sphere(section, finest_grid // 4)
    _first_yield(section, max(64, finest_grid // 8))


def _largest(stress: Callable[[float], ArrayLike], low: float, high: float) -> tuple[float, float]:
    """Return where between two depths a stress is largest, and the stress there."""
    best = minimize_scalar(lambda z: -np.asarray(stress(z)), bounds=(low, high), method="bounded")
    return best.x, -best.fun


def _largest_below_sphere(ratio: float) -> tuple[float, float]:
    """Return depth over contact radius and value over p₀ of the largest stress below a Hertz contact."""
    return _largest(lambda z: closed_forms.hertz_von_mises(z, ratio), 0.1, 2)


def _wave(section: Section, points: int) -> None:
    """Add the lines of a pressure wave: stresses over depth, volumes on a row of so many points."""
    wave = np.cos(2 * np.pi * np.arange(_POINTS) / _POINTS)[None, :]
    reduced = np.linspace(0, 4, 17)
    for ratio in (0.0, 0.3, 0.5):
        stress_at = subsurface_stress(wave, (1.0, 1.0), poissons_ratio=ratio)
        stresses = [stress_at(z * _POINTS / (2 * np.pi)) for z in reduced]
        for name, measure, expected in (
            ("wave von Mises", von_mises, closed_forms.wave_von_mises),
            ("wave Tresca", tresca, closed_forms.wave_tresca),
        ):
            computed = [measure(stress).max() for stress in stresses]
            section.compare(name, computed, expected(reduced, ratio), 1e-12, ratio=ratio)
    row = np.cos(2 * np.pi * np.arange(points) / points)[None, :]
    for limit in (0.1, 0.3, 0.5, 0.6):
        columns = stress_columns(row, (1.0, 1.0), poissons_ratio=0.5, yield_stress=limit)
        volume = columns["volume_above_yield"] * 2 * np.pi / points
        section.compare("wave volume", volume, closed_forms.wave_volume_above(limit), _VOLUME, limit=limit)


def _elongated(section: Section, points: int) -> None:
    """Add the lines of a window ten times as long as wide, with one wave along its length."""
    shape, step = (points // 10, points), 1 / points
    wave = np.cos(2 * np.pi * np.arange(points) * step) * np.ones((shape[0], 1))
    limit = 0.95 * np.sqrt(3) / np.e
    below_wave = stress_columns(wave, (step, step), poissons_ratio=0.5, yield_stress=limit)
    volume = below_wave["volume_above_yield"] * 2 * np.pi
    section.compare("long volume", volume, closed_forms.wave_volume_above(limit), _VOLUME)
    full = closed_forms.westergaard_full_contact_pressure(_RIDGES, 1.0, 1.0)
    ridges = synthetic.westergaard_surface(shape, step, amplitude=_RIDGES, wavelength=1.0)
    (contact,) = solve(ridges, [_LOAD * full], 1e-5)
    computed = stress_columns(contact.pressure, (step, step), poissons_ratio=0.3)
    depth, stress = _largest(lambda z: closed_forms.westergaard_von_mises(z, _LOAD, 0.3), 0.01, 0.5)
    bodies = [{"poissons_ratio": 0.3, "yield_stress": stress * full}, {}]
    (searched,) = target_loads(
        ridges, contact_modulus=1.0, target="first_yield", bodies=bodies, tolerance=1e-5
    )
    section.compare(
        "ridges stress", computed["max_von_mises_stress"] / full, stress, 3 / points / 10, n=points
    )
    section.compare("ridges depth", computed["max_von_mises_depth"], depth, 0.01)
    section.compare("ridges yield", searched / full, _LOAD, 3 / points, n=points)


def _rough(section: Section, *, shortest: int, load: float) -> None:
    """Add the lines of a rough map with waves down to so many points, at a load over E*."""
    points, steps, ratio = 64, (1.0, 1.0), 0.3
    height = synthetic.self_affine_surface(
        (points, points), 1.0, hurst=0.5, shortest=shortest, longest=points / 2, rms_gradient=1.0, seed=1
    )
    (contact,) = solve(height, [load], 1e-5)
    pressure = contact.pressure
    largest = stress_columns(pressure, steps, poissons_ratio=ratio)["max_von_mises_stress"]
    shares = (0.6, 0.8, 0.95)
    limits = [share * largest for share in shares]
    summed, volumes = depth_integral.volume_above(pressure, steps, poissons_ratio=ratio, limits=limits)
    section.compare("rough stress", largest, summed, 1e-3, shortest=shortest)
    for share, limit, volume in zip(shares, limits, volumes, strict=True):
        computed = stress_columns(pressure, steps, poissons_ratio=ratio, yield_stress=limit)
        fields = {"shortest": shortest, "share": share}
        section.compare("rough volume", computed["volume_above_yield"], volume, _VOLUME, **fields)


def _sphere(section: Section, points: int) -> None:
    """Add the lines of the largest stresses below a sphere, and of their depth."""
    (contact,) = solve(sphere(points), [FORCE], 1e-5)
    across = _HERTZ["contact_radius"] * points
    tolerance = _COPIES + 0.1 * across**-2
    for ratio in (0.3, 0.5):
        computed = stress_columns(contact.pressure, contact.pixel, poissons_ratio=ratio)
        depth, stress = _largest_below_sphere(ratio)
        for name, value, expected, allowed in (
            (
                "sphere von Mises",
                computed["max_von_mises_stress"] / _HERTZ["max_pressure"],
                stress,
                tolerance,
            ),
            ("sphere depth", computed["max_von_mises_depth"] / _HERTZ["contact_radius"], depth, 0.02),
            ("sphere Tresca", computed["max_tresca_stress"] / _HERTZ["max_pressure"], stress, tolerance),
        ):
            section.compare(name, value, expected, allowed, ratio=ratio, copies=_COPIES, n=across)


def _first_yield(section: Section, points: int) -> None:
    """Add the lines of the load at which a body begins to yield below a sphere."""
    ratio, height = 0.3, sphere(points)
    _, stress = _largest_below_sphere(ratio)
    bodies = [{"poissons_ratio": ratio, "yield_stress": stress * _HERTZ["max_pressure"]}, {}]
    loads = [FORCE / 2, 2 * FORCE]
    solved = solve_contact(height, contact_modulus=1.0, mean_pressure=loads, tolerance=1e-5)
    between = add_subsurface_yield(contact_statistics(solved, bodies=bodies, flow="never"), bodies)
    (searched,) = target_loads(
        height, contact_modulus=1.0, target="first_yield", bodies=bodies, tolerance=1e-5
    )
    across = _HERTZ["contact_radius"] * points
    tolerance = 3 * (_COPIES + 0.1 * across**-2) / stress
    for how, load in (
        ("between two loads", between["first_subsurface_yield_pressure"].item()),
        ("searched for", searched),
    ):
        section.compare("yield", load / FORCE, 1.0, tolerance, ratio=ratio, how=how, n=across)
