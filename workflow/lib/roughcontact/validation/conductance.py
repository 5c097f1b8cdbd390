"""Conductance: a single spot, a regular array of spots, Westergaard's strips."""

import numpy as np

from roughcontact.contact.response import linear_response
from roughcontact.contact.solve import solve_contact
from roughcontact.maps import height_map, spacing
from roughcontact.references import closed_forms
from roughcontact.statistics.conductance import conductance_columns
from roughcontact.validation import hertz, waves
from roughcontact.validation.lines import Evidence, Part, compare

TITLE = "Conductance"
_RESISTIVITIES = 1.7e-8, 2.0e-7  # copper and steel, Ohm m
_CONDUCTIVITIES = 400.0, 50.0  # W m-1 K-1

_TESTS = "tests/unit/test_conductance.py"
SPOT = Evidence(
    "G = 4a/(ρ₁ + ρ₂)",
    "Holm (1967), Electric Contacts, § 3; Barber (2003), Proc. R. Soc. A 459, 53",
    "statistics.conductance.conductance_columns",
    f"{_TESTS}::test_a_single_spot_conducts_as_holm_has_it",
)
HEAT = Evidence(
    "G = 4a k₁k₂/(k₁ + k₂)",
    "Carslaw and Jaeger (1959), Conduction of Heat in Solids, § 8.2: 1/(4ka) on either side",
    "statistics.conductance.conductance_columns",
    f"{_TESTS}::test_a_single_spot_conducts_as_holm_has_it",
)
ARRAY = Evidence(
    "E*/K = L² [(1 + 3s)/(2a) − 3.900265/(πL)], s = 0.639 (a/L)³",
    "2E*a of a punch, Johnson (1985), eq. (3.36); lattice sums of Glasser and Zucker (1980)",
    "references.closed_forms.spot_array_stiffness",
    f"{_TESTS}::test_array_of_spots_is_the_slope_of_the_repeated_sphere",
)
STRIPS = Evidence(
    "K = p*/(D ln(1/r))",
    "Westergaard (1939), differentiated; K/E* by Barber (2003)",
    "references.closed_forms.westergaard_stiffness",
    f"{_TESTS}::test_westergaards_strips",
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
    modulus, radius, period = 1e11, 3e-6, 1e-4
    found = conductance_columns(
        2 * modulus * radius / period**2,
        contact_modulus=modulus,
        bodies=[
            {"electrical_resistivity": resistivity, "thermal_conductivity": conductivity}
            for resistivity, conductivity in zip(_RESISTIVITIES, _CONDUCTIVITIES, strict=True)
        ],
    )
    lines = [
        compare(
            "One spot of 3 µm between copper and steel: conductance, S",
            found["electrical_conductance"] * period**2,
            4 * radius / sum(_RESISTIVITIES),
            tolerance=1e-12,
            reason="rounding",
            evidence=SPOT,
        ),
        compare(
            "One spot of 3 µm, 400 and 50 W/(m K): thermal conductance, W/K",
            found["thermal_conductance"] * period**2,
            4 * radius * np.prod(_CONDUCTIVITIES) / sum(_CONDUCTIVITIES),
            tolerance=1e-12,
            reason="rounding",
            evidence=HEAT,
        ),
    ]
    points = finest_grid // 2
    x = (np.arange(points) + 0.27) / points - 0.5
    sphere = height_map(-(x[None, :] ** 2 + x[:, None] ** 2) / (2 * hertz.RADIUS), 1 / points)
    for load in (hertz.FORCE, 27 * hertz.FORCE):  # three times the radius
        contact = solve_contact(sphere, contact_modulus=1.0, mean_pressure=load, tolerance=1e-6)
        touching = contact["pressure"].values[0] > 0
        known = closed_forms.periodic_hertz(load, hertz.RADIUS, 1.0, 1.0)["contact_radius"]
        across = known * points
        lines.append(
            compare(
                f"Array of spots, a/L = {known:.3f}: conductance per conductivity × L",
                1 / linear_response(touching, spacing(sphere), 1.0, 1e-3),
                closed_forms.spot_array_stiffness(known, 1.0, 1.0),
                tolerance=0.1 / across + known**5,
                reason=f"0.1/n, n = {across:.0f} points per radius, and (a/L)⁵ of the closed form",
                evidence=ARRAY,
            )
        )
    full = closed_forms.westergaard_full_contact_pressure(waves.AMPLITUDE, 1.0, 1.0)
    _, ridge = waves.ridge(finest_grid)
    for ratio in (0.1, 0.5, 0.9):
        contact = solve_contact(ridge, contact_modulus=1.0, mean_pressure=ratio * full, tolerance=1e-8)
        touching = contact["pressure"].values[0] > 0
        lines.append(
            compare(
                f"Ridges, r = {ratio:g}: conductance per conductivity × λ",
                1 / linear_response(touching, spacing(ridge), 1.0, 1e-3),
                closed_forms.westergaard_stiffness(waves.AMPLITUDE, 1.0, 1.0, ratio),
                tolerance=8 / finest_grid,
                reason=f"8/n, n = {finest_grid}: the contact is known to one point",
                evidence=STRIPS,
            )
        )
    text = (
        "What a contact conducts is its stiffness in other units. A round spot conducts a current as "
        "Holm's, and heat as Carslaw and Jaeger's; spots in a square period help one another; Westergaard's "
        "ridges touch in strips."
    )
    return Part("conductance", TITLE, text, lines)
