"""Stresses below the surface: a pressure wave, and a solved Hertz contact."""

import numpy as np
from scipy.optimize import minimize_scalar

from roughcontact.contact.solve import solve_contact
from roughcontact.elasticity.subsurface import subsurface_stress, von_mises
from roughcontact.maps import height_map, spacing
from roughcontact.references import closed_forms
from roughcontact.statistics.subsurface import stress_columns
from roughcontact.validation import hertz
from roughcontact.validation.lines import Evidence, Part, compare, compare_largest

TITLE = "Stress below the surface"
_POINTS = 64  # of the wave, for which the answer is exact

_TESTS = "tests/unit/test_subsurface.py"
WAVE = Evidence(
    "e^(−qz) √((1 − 2ν)² + 3(qz)²)",
    "Johnson (1985), sec. 13.2, plane strain",
    "references.closed_forms.wave_von_mises",
    f"{_TESTS}::test_stresses_are_in_equilibrium",
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
    points = finest_grid // 4
    x = (np.arange(points) + 0.27) / points - 0.5
    sphere = height_map(-(x[None, :] ** 2 + x[:, None] ** 2) / (2 * hertz.RADIUS), 1 / points)
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
        ]
    text = (
        "The stresses below each wave of the pressure have a closed form, and their sum is taken at depths "
        "in equal ratios, refined around the largest stress. Below a sphere that is Hertz's."
    )
    return Part("subsurface", TITLE, text, lines)
