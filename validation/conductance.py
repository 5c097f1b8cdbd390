"""Conductance: a single spot, a regular array of spots, Westergaard's strips, strips on a film."""

import numpy as np

from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.elasticity.layers import conducting_pair
from roughcontact.contact.response import linear_response
from roughcontact.statistics.conductance import conductance_columns
from validation import closed_forms
from validation.lines import Section
from validation.problems import AMPLITUDE, FORCE, RADIUS, solve, solved_ridges, sphere

_RESISTIVITIES = 1.7e-8, 2.0e-7  # copper and steel, Ohm m
_CONDUCTIVITIES = 400.0, 50.0  # W m-1 K-1


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the lines of a spot, of spheres on a grid half as fine, of a row of ridges, and of strips."""
    modulus, radius, period = 1e11, 3e-6, 1e-4
    computed = conductance_columns(
        2 * modulus * radius / period**2,
        contact_modulus=modulus,
        bodies=[
            {"electrical_resistivity": resistivity, "thermal_conductivity": conductivity}
            for resistivity, conductivity in zip(_RESISTIVITIES, _CONDUCTIVITIES, strict=True)
        ],
    )
    current = 4 * radius / sum(_RESISTIVITIES)
    heat = 4 * radius * np.prod(_CONDUCTIVITIES) / sum(_CONDUCTIVITIES)
    section.compare("spot", computed["electrical_conductance"] * period**2, current, 1e-12)
    section.compare("heat", computed["thermal_conductance"] * period**2, heat, 1e-12)
    points = finest_grid // 2
    for load in (FORCE, 27 * FORCE):  # three times the radius
        (contact,) = solve(sphere(points), [load], 1e-6)
        expected = closed_forms.periodic_hertz(load, RADIUS, 1.0, 1.0)["contact_radius"]
        across, stiffness = expected * points, closed_forms.spot_array_stiffness(expected, 1.0, 1.0)
        tolerance = 0.1 / across + expected**5
        section.compare("array", 1 / contact.compliance(1e-3), stiffness, tolerance, a=expected, n=across)
    for ratio, contact in solved_ridges(finest_grid, (0.1, 0.5, 0.9)).items():
        stiffness = closed_forms.westergaard_stiffness(AMPLITUDE, 1.0, 1.0, ratio)
        section.compare(
            "strips", 1 / contact.compliance(1e-3), stiffness, 8 / finest_grid, r=ratio, n=finest_grid
        )
    touching = np.arange(finest_grid)[None, :] < finest_grid // 2
    for thickness in (0.02, 0.05):
        film, perfect = {"thickness": thickness, "thermal_conductivity": 1.0}, {"thermal_conductivity": 1e9}
        pair = conducting_pair([perfect | {"layers": [film]}, perfect], "thermal_conductivity")
        assert pair is not None
        compliance, _ = linear_response(
            touching, (1 / finest_grid,) * 2, Elasticity(pair.modulus, medium=pair), 1e-3
        )
        expected = closed_forms.film_strips_conductance(0.5, thickness)
        section.compare("film", thickness / compliance, expected, 2 / finest_grid, t=thickness, n=finest_grid)
