"""Stresses below the surface: a pressure wave, solved ridges and a Hertz contact, and rough maps."""

import numpy as np
import xarray as xr
from scipy.optimize import minimize_scalar

from roughcontact.contact.solve import solve_contact
from roughcontact.elasticity.subsurface import subsurface_stress, tresca, von_mises
from roughcontact.maps import height_map, spacing
from roughcontact.references import closed_forms, depth_integral, synthetic
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.statistics.subsurface import stress_columns, with_subsurface_yield
from roughcontact.statistics.targets import target_loads
from roughcontact.validation import hertz
from roughcontact.validation.lines import Evidence, Line, Part, compare, compare_largest

TITLE = "Stress below the surface"
_POINTS = 64  # of the wave, for which the answer is exact
_RIDGES, _LOAD = 0.01, 0.2  # amplitude over wavelength, load over that of complete contact
_VOLUME = 0.005  # how exact the volume above a yield stress is stated to be
_STATED = "the accuracy that is stated for it"

_TESTS = "tests/unit/test_subsurface.py"
WAVE = Evidence(
    "e^(−qz) √((1 − 2ν)² + 3(qz)²)",
    "Johnson (1985), sec. 13.2, plane strain",
    "references.closed_forms.wave_von_mises",
    f"{_TESTS}::test_stresses_are_in_equilibrium",
)
SHEAR = Evidence(
    "e^(−qz) max(2qz, 1 − 2ν + qz)",
    "Johnson (1985), sec. 13.2, plane strain",
    "references.closed_forms.wave_tresca",
    f"{_TESTS}::test_wave",
)
VOLUME = Evidence(
    "[W₀(−k/√3) − W₋₁(−k/√3)]/q, Lambert's W, ν = 0.5",
    "√3 qz e^(−qz) of Johnson (1985), sec. 13.2, solved for the depth",
    "references.closed_forms.wave_volume_above",
    f"{_TESTS}::test_volume_above_yield_of_a_wave",
)
RIDGES = Evidence(
    "σ of P = 2p* cosh t (√(r + sinh²t) − sinh t) below the crest, t = πz/λ, r = 0.2, ν = 0.3",
    "Westergaard (1939) for the pressure; Johnson (1985), sec. 13.2, for the stresses",
    "references.closed_forms.westergaard_von_mises",
    f"{_TESTS}::test_stresses_below_ridges_are_those_of_their_waves",
)
ROUGH = Evidence(
    "Σ Δz × share of the points above the limit, hundreds of depths, ν = 0.3",
    "Johnson (1985), sec. 3.2: potentials of Boussinesq, by complex transforms",
    "references.depth_integral.volume_above",
    f"{_TESTS}::test_sum_over_depths_has_the_volume_of_a_wave",
)
YIELD = Evidence(
    "the load whose p₀ is Y/0.62, ν = 0.3",
    "Johnson (1985), sec. 6.1: p₀ = 1.6 Y; lattice corrections as of the repeated sphere",
    "references.closed_forms.hertz_von_mises, references.closed_forms.periodic_hertz",
    f"{_TESTS}::test_closed_form_of_hertz_has_the_numbers_of_johnson",
)
SPHERE = Evidence(
    "|σr − σz|/p₀ on the axis; 0.62 at 0.48 a for ν = 0.3",
    "Johnson (1985), eq. (3.45) and sec. 3.4",
    "references.closed_forms.hertz_von_mises",
    f"{_TESTS}::test_closed_form_of_hertz_has_the_numbers_of_johnson",
)


def part(*, finest_grid: int) -> Part:
    """Return the lines of this part.

    Parameters
    ----------
    finest_grid : int
        points along the finest grid.

    Returns
    -------
    Part
    """
    wave = np.cos(2 * np.pi * np.arange(_POINTS) / _POINTS)[None, :]
    reduced = np.linspace(0, 4, 17)
    lines = []
    for ratio in (0.0, 0.3, 0.5):
        stress_at = subsurface_stress(wave, (1.0, 1.0), poissons_ratio=ratio)
        lines.append(
            compare_largest(
                f"Pressure wave, ν = {ratio:g}: largest stress of von Mises, depths to 4/q",
                [von_mises(stress_at(z * _POINTS / (2 * np.pi))).max() for z in reduced],
                closed_forms.wave_von_mises(reduced, ratio),
                tolerance=1e-12,
                reason="rounding: exact for each wave",
                evidence=WAVE,
            )
        )
        lines.append(
            compare_largest(
                f"Pressure wave, ν = {ratio:g}: largest stress of Tresca, depths to 4/q",
                [tresca(stress_at(z * _POINTS / (2 * np.pi))).max() for z in reduced],
                closed_forms.wave_tresca(reduced, ratio),
                tolerance=1e-12,
                reason="rounding: exact for each wave",
                evidence=SHEAR,
            )
        )
    row = np.cos(2 * np.pi * np.arange(finest_grid) / finest_grid)[None, :]
    for limit in (0.1, 0.3, 0.5, 0.6):
        found = stress_columns(row, (1.0, 1.0), poissons_ratio=0.5, yield_stress=limit)
        lines.append(
            compare(
                f"Pressure wave: volume above {limit:g} of its amplitude × q",
                found["volume_above_yield"] * 2 * np.pi / finest_grid,
                closed_forms.wave_volume_above(limit),
                tolerance=_VOLUME,
                reason=_STATED,
                evidence=VOLUME,
            )
        )
    lines += _elongated(finest_grid // 4)
    lines += _rough(shortest=2, load=0.05) + _rough(shortest=8, load=0.5)
    points = finest_grid // 4
    sphere = _sphere(points)
    known = closed_forms.periodic_hertz(hertz.FORCE, hertz.RADIUS, 1.0, 1.0)
    contact = solve_contact(sphere, contact_modulus=1.0, mean_pressure=hertz.FORCE, tolerance=1e-5)
    across = known["contact_radius"] * points
    beside = hertz.FORCE / known["max_pressure"]
    for ratio in (0.3, 0.5):
        found = stress_columns(contact["pressure"].values[0], spacing(sphere), poissons_ratio=ratio)
        best = minimize_scalar(
            lambda z, ratio=ratio: -closed_forms.hertz_von_mises(z, ratio), bounds=(0.1, 2), method="bounded"
        )
        lines += [
            compare(
                f"Sphere, ν = {ratio:g}: largest stress of von Mises / p₀",
                found["max_von_mises_stress"] / known["max_pressure"],
                -best.fun,
                measure="absolute",
                tolerance=beside + 0.1 * across**-2,
                reason=f"the mean pressure of the copies, {beside:.2g} p₀, and 0.1/n², n = {across:.0f}",
                evidence=SPHERE,
            ),
            compare(
                f"Sphere, ν = {ratio:g}: its depth / a",
                found["max_von_mises_depth"] / known["contact_radius"],
                best.x,
                tolerance=0.02,
                reason="the search ends within 1 % of the place, where the stress is flat",
                evidence=SPHERE,
            ),
            compare(
                f"Sphere, ν = {ratio:g}: largest stress of Tresca / p₀",
                found["max_tresca_stress"] / known["max_pressure"],
                -best.fun,
                measure="absolute",
                tolerance=beside + 0.1 * across**-2,
                reason="as of von Mises: on the axis two principal stresses are equal",
                evidence=SPHERE,
            ),
        ]
    text = (
        "The stresses below each wave of the pressure have a closed form, and their sum is taken at depths "
        "in equal ratios, refined around the largest stress. Below ridges, in a window ten times as long as "
        "wide, that is Westergaard's, below a sphere Hertz's, and so are the loads at which a body yields "
        "there. Below rough maps a sum over hundreds of depths gives the volume above a yield stress."
    )
    return Part("subsurface", TITLE, text, [*lines, *_first_yield(max(64, finest_grid // 8))])


def _sphere(points: int) -> xr.DataArray:
    """Return the sphere of the Hertz lines, with a summit that lies on no point."""
    x = (np.arange(points) + 0.27) / points - 0.5
    return height_map(-(x[None, :] ** 2 + x[:, None] ** 2) / (2 * hertz.RADIUS), 1 / points)


def _elongated(points: int) -> list[Line]:
    """Return the lines of a window ten times as long as wide, with one wave along its length."""
    shape, step = (points // 10, points), 1 / points
    wave = np.cos(2 * np.pi * np.arange(points) * step) * np.ones((shape[0], 1))
    limit = 0.95 * np.sqrt(3) / np.e
    below_wave = stress_columns(wave, (step, step), poissons_ratio=0.5, yield_stress=limit)
    full = closed_forms.westergaard_full_contact_pressure(_RIDGES, 1.0, 1.0)
    ridges = synthetic.westergaard_surface(shape, step, amplitude=_RIDGES, wavelength=1.0)
    contact = solve_contact(ridges, contact_modulus=1.0, mean_pressure=_LOAD * full, tolerance=1e-5)
    found = stress_columns(contact["pressure"].values[0], (step, step), poissons_ratio=0.3)
    best = minimize_scalar(
        lambda z: -closed_forms.westergaard_von_mises(z, _LOAD, 0.3), bounds=(0.01, 0.5), method="bounded"
    )
    bodies = [{"poissons_ratio": 0.3, "yield_stress": -best.fun * full}, {}]
    (searched,) = target_loads(
        ridges, contact_modulus=1.0, target="first_yield", bodies=bodies, tolerance=1e-5
    )
    pixels = 3 / points
    return [
        compare(
            "Pressure wave along a window 10:1: volume above 0.95 of its largest stress × q",
            below_wave["volume_above_yield"] * 2 * np.pi,
            closed_forms.wave_volume_above(limit),
            tolerance=_VOLUME,
            reason=_STATED,
            evidence=VOLUME,
        ),
        compare(
            "Ridges across a window 10:1: largest stress of von Mises / p*",
            found["max_von_mises_stress"] / full,
            -best.fun,
            tolerance=pixels / 10,
            reason=f"0.3/n, n = {points} points: the contact ends on a whole pixel",
            evidence=RIDGES,
        ),
        compare(
            "Ridges across a window 10:1: its depth / λ",
            found["max_von_mises_depth"],
            best.x,
            tolerance=0.01,
            reason="the search ends within 1 % of the place, where the stress is flat",
            evidence=RIDGES,
        ),
        compare(
            "Ridges across a window 10:1: load of first yield, searched for / p*",
            searched / full,
            _LOAD,
            tolerance=pixels,
            reason=f"3/n, n = {points} points: of the stress, whose second power the load is, and the search",
            evidence=RIDGES,
        ),
    ]


def _rough(*, shortest: int, load: float) -> list[Line]:
    """Return the lines of a rough map with waves down to so many points, at a load over E*."""
    points = 64
    height = synthetic.self_affine_surface(
        (points, points), 1.0, hurst=0.5, shortest=shortest, longest=points / 2, rms_gradient=1.0, seed=1
    )
    contact = solve_contact(height, contact_modulus=1.0, mean_pressure=load, tolerance=1e-5)
    pressure, steps, ratio = contact["pressure"].values[0], (1.0, 1.0), 0.3
    largest = stress_columns(pressure, steps, poissons_ratio=ratio)["max_von_mises_stress"]
    shares = (0.6, 0.8, 0.95)
    limits = [share * largest for share in shares]
    summed, volumes = depth_integral.volume_above(pressure, steps, poissons_ratio=ratio, limits=limits)
    lines = [
        compare(
            f"Rough map, waves from {shortest} points: largest stress of von Mises / E*",
            largest,
            summed,
            tolerance=1e-3,
            reason="a depth beside that of the largest stress, on either side",
            evidence=ROUGH,
        )
    ]
    for share, limit, volume in zip(shares, limits, volumes, strict=True):
        found = stress_columns(pressure, steps, poissons_ratio=ratio, yield_stress=limit)
        lines.append(
            compare(
                f"Rough map, waves from {shortest} points: volume above {share:g} of it, in points",
                found["volume_above_yield"],
                volume,
                tolerance=_VOLUME,
                reason=_STATED,
                evidence=ROUGH,
            )
        )
    return lines


def _first_yield(points: int) -> list[Line]:
    """Return the lines of the load at which a body begins to yield below a sphere."""
    ratio, sphere = 0.3, _sphere(points)
    known = closed_forms.periodic_hertz(hertz.FORCE, hertz.RADIUS, 1.0, 1.0)
    largest = -minimize_scalar(
        lambda z: -closed_forms.hertz_von_mises(z, ratio), bounds=(0.1, 2), method="bounded"
    ).fun
    bodies = [{"poissons_ratio": ratio, "yield_stress": largest * known["max_pressure"]}, {}]
    loads = [hertz.FORCE / 2, 2 * hertz.FORCE]
    solved = solve_contact(sphere, contact_modulus=1.0, mean_pressure=loads, tolerance=1e-5)
    between = with_subsurface_yield(contact_statistics(solved, bodies=bodies, flow="never"), bodies)
    (searched,) = target_loads(
        sphere, contact_modulus=1.0, target="first_yield", bodies=bodies, tolerance=1e-5
    )
    beside = hertz.FORCE / known["max_pressure"]
    across = known["contact_radius"] * points
    return [
        compare(
            f"Sphere, ν = {ratio:g}: load of first yield below the surface, {word} / Johnson's",
            load / hertz.FORCE,
            1.0,
            tolerance=3 * (beside + 0.1 * across**-2) / largest,
            reason=f"three times that of the stress, whose third power the load is, n = {across:.2g}",
            evidence=YIELD,
        )
        for word, load in (
            ("between two loads", between["first_subsurface_yield_pressure"].item()),
            ("searched for", searched),
        )
    ]
