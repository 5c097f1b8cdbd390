"""One sphere in a square period: Hertz, with what the neighbours in the lattice change."""

import numpy as np

from roughcontact.contact.solve import solve_contact
from validation import closed_forms
from validation.lines import Part
from validation.problems import FORCE, RADIUS, solve, sphere


def add_lines(part: Part, *, finest_grid: int) -> None:
    """Add the lines of a sphere on a grid half as fine."""
    points = finest_grid // 2
    height = sphere(points)
    known = closed_forms.periodic_hertz(FORCE, RADIUS, 1.0, 1.0)
    (contact,) = solve(height, [FORCE], 1e-7)
    across = known["contact_radius"] * points
    beyond = (known["contact_radius"] ** 3) ** 2  # s², which the first order leaves out
    for name, value, tolerance in (
        ("contact_radius", np.sqrt(contact.area / np.pi), 0.2 / across),
        ("max_pressure", contact.pressure.max(), across**-2),
        ("approach", -contact.approach, 0.1 * across**-2),  # the crest lies at h = 0
        ("energy", contact.energy, 0.2 * across**-2),
    ):
        part.compare(name, value, known[name], tolerance + beyond, n=across)
    free = solve_contact(
        height, contact_modulus=1.0, mean_pressure=FORCE, tolerance=1e-7, zero_frequency="lattice"
    )
    part.compare(
        "alone",
        -float(free["approach"][0]),
        closed_forms.hertz(FORCE, RADIUS, 1.0)["approach"],
        0.1 * across**-2 + 2 * known["contact_radius"] ** 3,
        n=across,
    )
