"""A sphere on a layer with a rigid base, by an integral equation that has neither grid nor period."""

import numpy as np

from roughcontact.contact.solve import solve_contact
from roughcontact.maps import height_map
from roughcontact.references.layered_sphere import sphere_on_layer
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.validation.lines import Part
from roughcontact.validation.problems import PHASE

THICKNESS, RADIUS = 0.1, 1.0  # over the period: what the neighbours press decays as exp(-q t) on a rigid base
RATIOS = (0.5, 1.0, 1.6)  # contact radius over thickness
POISSONS_RATIOS = (0.5, 0.3)


def add_lines(part: Part, *, finest_grid: int) -> None:
    """Add the lines of a sphere on a grid half as fine."""
    points = finest_grid // 2
    distance = [(np.arange(points) + phase) / points - 0.5 for phase in PHASE]
    height = height_map(-(distance[0][:, None] ** 2 + distance[1] ** 2) / (2 * RADIUS), 1 / points)
    for nu in POISSONS_RATIOS:
        sheet = {"thickness": THICKNESS, "youngs_modulus": 1 - nu**2, "poissons_ratio": nu}
        for ratio in RATIOS:
            known = sphere_on_layer(ratio * THICKNESS, RADIUS, THICKNESS, nu)
            contact = solve_contact(
                height,
                bodies=[{"base": "rigid", "layers": [sheet]}],
                mean_pressure=known.force,
                tolerance=1e-6,
            )
            across = ratio * THICKNESS * points
            area = relative_contact_area(contact["pressure"].values[0] > 0)
            words = {"nu": nu, "ratio": ratio, "n": across}
            radius = np.sqrt(area / np.pi)
            part.compare("radius", radius, ratio * THICKNESS, 0.1 / across, **words)
            approach = -float(contact["approach"][0])  # the crest lies at h = 0
            part.compare("approach", approach, known.approach, 1e-3, **words)
