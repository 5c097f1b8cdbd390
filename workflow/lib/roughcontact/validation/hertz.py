"""One sphere in a square period: Hertz, with what the neighbours in the lattice change."""

from functools import partial

import numpy as np

from roughcontact.contact.solve import solve_contact
from roughcontact.elasticity.energy import elastic_energy
from roughcontact.maps import height_map, spacing
from roughcontact.references import closed_forms
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.validation.lines import Evidence, Part, compare

TITLE = "Hertz, alone and repeated"
RADIUS, FORCE = 10.0, 1e-5  # of a period and of E* times its area: a_H = 0.0422 periods

_TESTS = "tests/unit/test_reference.py"
LATTICE = Evidence(
    "a = a_H (1 − s), p₀ = p₀_H (1 + 2s), δ = a_H²/R (1 + 8s/5) − 3.900265 F/(πE*L), U = (2/5) F a_H²/R (1 "
    "+ 5s/2) − 3.900265 F²/(2πE*L), s = 0.639 (a_H/L)³",
    "Johnson (1985), eqs. (4.22) to (4.24); lattice sums of Glasser and Zucker (1980)",
    "references.closed_forms.periodic_hertz",
    f"{_TESTS}::test_lattice_constant_by_an_ewald_sum",
)
ALONE = Evidence(
    "δ = a²/R, a³ = 3FR/(4E*), with 3.900265 p̄L/(πE*) for q = 0",
    "Johnson (1985), eq. (4.23); lattice sum as above",
    "references.closed_forms.hertz",
    f"{_TESTS}::test_hertz_energy_is_the_work_of_the_force",
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
    points = finest_grid // 2
    x = (np.arange(points) + 0.27) / points - 0.5
    height = height_map(-(x[None, :] ** 2 + x[:, None] ** 2) / (2 * RADIUS), 1 / points)
    known = closed_forms.periodic_hertz(FORCE, RADIUS, 1.0, 1.0)
    solve = partial(solve_contact, height, contact_modulus=1.0, mean_pressure=FORCE, tolerance=1e-7)
    contact, free = solve(), solve(zero_frequency="lattice")
    pressure = contact["pressure"].values[0]
    across = known["contact_radius"] * points
    found = {
        "contact_radius": np.sqrt(relative_contact_area(pressure > 0) / np.pi),
        "max_pressure": pressure.max(),
        "approach": -float(contact["approach"][0]),  # the crest lies at h = 0
        "energy": elastic_energy(pressure, spacing(height), contact_modulus=1.0),
    }
    allowed = {
        "contact_radius": (0.2 / across, "0.2/n"),
        "max_pressure": (across**-2, "1/n²"),
        "approach": (0.1 * across**-2, "0.1/n²"),
        "energy": (0.2 * across**-2, "0.2/n²"),
    }
    words = {
        "contact_radius": "contact radius / L",
        "max_pressure": "largest pressure / E*",
        "approach": "approach / L, q = 0: zero",
        "energy": "energy / (E* L³)",
    }
    radius = f"n = {across:.0f} points per contact radius"
    # s² is what the first order leaves out
    beyond = (known["contact_radius"] ** 3) ** 2
    lines = [
        compare(
            f"Repeated sphere: {words[name]}",
            found[name],
            known[name],
            tolerance=allowed[name][0] + beyond,
            reason=f"{allowed[name][1]}, {radius}",
            evidence=LATTICE,
        )
        for name in found
    ]
    single = closed_forms.hertz(FORCE, RADIUS, 1.0)["approach"]
    lines.append(
        compare(
            "Sphere alone: approach / L, q = 0: lattice",
            -float(free["approach"][0]),
            single,
            tolerance=0.1 * across**-2 + 2 * known["contact_radius"] ** 3,
            reason=f"0.1/n², {radius}, and 2 (a/L)³ of the neighbours",
            evidence=ALONE,
        )
    )
    text = (
        "A sphere (as a paraboloid, a_H = 0.042 L) in a square period L. The first lines allow for the "
        "neighbours to first order; the last one takes their shift out, so that the approach must be that "
        "of a sphere alone."
    )
    return Part("hertz", TITLE, text, lines)
