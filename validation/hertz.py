"""One sphere in a square period: Hertz, with what the neighbours in the lattice change, and bodies alone."""

from typing import Any

import numpy as np

from roughcontact.arguments.maps import height_map
from roughcontact.contact.elasticity.closed_forms import hertz_ellipse
from roughcontact.contact.solve import solve_contact
from roughcontact.evaluation.evaluate import evaluate
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.surface.synthetic import westergaard_surface
from validation import closed_forms
from validation.lines import Section
from validation.problems import FORCE, RADIUS, solve, sphere


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the lines of a sphere on a grid half as fine."""
    points = finest_grid // 2
    height = sphere(points)
    expected = closed_forms.periodic_hertz(FORCE, RADIUS, 1.0, 1.0)
    (contact,) = solve(height, [FORCE], 1e-7)
    across = expected["contact_radius"] * points
    beyond = (expected["contact_radius"] ** 3) ** 2  # s², which the first order leaves out
    for name, value, tolerance in (
        ("contact_radius", np.sqrt(contact.area / np.pi), 0.2 / across),
        ("max_pressure", contact.pressure.max(), across**-2),
        ("approach", -contact.approach, 0.1 * across**-2),  # the crest lies at h = 0
        ("energy", contact.energy, 0.2 * across**-2),
    ):
        section.compare(name, value, expected[name], tolerance + beyond, n=across)
    free = solve_contact(
        height, contact_modulus=1.0, mean_pressure=FORCE, tolerance=1e-7, zero_frequency="lattice"
    )
    section.compare(
        "alone",
        -float(free["approach"][0]),
        closed_forms.hertz(FORCE, RADIUS, 1.0)["approach"],
        0.1 * across**-2 + 2 * expected["contact_radius"] ** 3,
        n=across,
    )
    _bodies_of_finite_size(section, points)
    _wider_than_its_map(section, points)


def _bodies_of_finite_size(section: Section, points: int) -> None:
    """Add the lines of a sphere, an ellipsoid and a flat punch without neighbours."""
    y = ((np.arange(points) + 0.5) / points - 0.5)[:, None]
    x = y.T
    radius, force = 10.0, 4 * 0.3**3 / 30
    solver: dict[str, Any] = {"boundary": "free", "contact_modulus": 1.0, "tolerance": 1e-7}
    ball = solve_contact(height_map(-(x**2 + y**2) / (2 * radius), 1 / points), force=force, **solver)
    known = closed_forms.hertz(force, radius, 1.0)
    across = known["contact_radius"] * points
    area = relative_contact_area(ball["contact"].values[0] > 0)
    section.compare("free_radius", np.sqrt(area / np.pi), known["contact_radius"], 0.2 / across, n=across)
    section.compare(
        "free_approach", -float(ball["approach"][0]), known["approach"], 0.1 * across**-2, n=across
    )
    radii = (10.0, 4.0)
    ellipsoid = height_map(-(x**2) / (2 * radii[0]) - y**2 / (2 * radii[1]), 1 / points)
    approach = -float(solve_contact(ellipsoid, force=force, **solver)["approach"][0])
    ellipse = hertz_ellipse(force, radii, 1.0)
    across = ellipse["minor"] * points
    section.compare("free_ellipse", approach, ellipse["approach"], 0.1 * across**-2, n=across)
    inside = np.hypot(x, y) < 0.3
    punch = solve_contact(height_map(np.where(inside, 0.0, -0.1), 1 / points), force=1e-3, **solver)
    radius = float(np.sqrt(inside.mean() / np.pi))
    stiffness = 1e-3 / -float(punch["approach"][0])
    section.compare("free_punch", stiffness, 2 * radius, 0.15 / (radius * points), n=radius * points)


def _wider_than_its_map(section: Section, points: int) -> None:
    """Add the lines of ridges on a ball that is wider (form.local_scale), half closed in the middle."""
    force, radius, ratio = 50.0, 0.05, 0.5
    smooth = closed_forms.hertz(force, radius, 1e11)
    a = wavelength = smooth["contact_radius"]  # so that the spots count, too
    amplitude = smooth["max_pressure"] / ratio * wavelength / (np.pi * 1e11)
    answer = evaluate(
        westergaard_surface((4, points), wavelength / points, amplitude=amplitude, wavelength=wavelength),
        level={"form": "mean", "outlier_threshold": None},
        window={"method": "raw"},
        contact={"contact_modulus": 1e11, "force": force, "tolerance": 1e-7},
        form={"radius": [radius], "local_scale": True},
        uncertainty={"sources": []},
    )
    share, stiffness = closed_forms.westergaard_under_hertz(ratio)
    spots = np.pi * a**2 * stiffness * np.pi / wavelength  # p*/(D E*) = π/λ
    area, conductance = (
        answer[f"local_{name}"].item() for name in ("contact_area", "conductance_per_conductivity")
    )
    section.compare("local_area", area / (np.pi * a**2), share, 4 / points, n=points)
    section.compare("local_conductance", conductance / a, 1 / (a / spots + 1 / 2), 4 / points, n=points)
