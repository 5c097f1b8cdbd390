"""A sphere on a layer with a rigid base, by an integral equation, and the stresses below a wave."""

import numpy as np

from roughcontact.arguments.maps import height_map
from roughcontact.contact.elasticity.layers import Layer, Material, Stack
from roughcontact.contact.elasticity.subsurface import subsurface_stress
from roughcontact.contact.solve import solve_contact
from roughcontact.statistics.contact_geometry import relative_contact_area
from validation.layered_sphere import sphere_on_layer
from validation.layered_wave import layered_wave_stresses
from validation.lines import Section
from validation.problems import PHASE

THICKNESS, RADIUS = 0.1, 1.0  # over the period: what the neighbours press decays as exp(-q t) on a rigid base
RATIOS = (0.5, 1.0, 1.6)  # contact radius over thickness
POISSONS_RATIOS = (0.5, 0.3)
# layers (|q| t, E, nu) from the surface inwards, and base (E, nu)
STACKS = {
    "a hard coating": ([(0.2, 10.0, 0.2)], (1.0, 0.3)),
    "a coating on a soft bond": ([(0.2, 10.0, 0.2), (0.1, 0.1, 0.45)], (1.0, 0.3)),
    "a rubber sheet on a rigid base": ([(1.0, 1.0, 0.5)], None),
}


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the lines of a sphere on a grid half as fine, and of a wave."""
    points = finest_grid // 2
    distance = [(np.arange(points) + phase) / points - 0.5 for phase in PHASE]
    height = height_map(-(distance[0][:, None] ** 2 + distance[1] ** 2) / (2 * RADIUS), 1 / points)
    for nu in POISSONS_RATIOS:
        sheet = {"thickness": THICKNESS, "youngs_modulus": 1 - nu**2, "poissons_ratio": nu}
        for ratio in RATIOS:
            expected = sphere_on_layer(ratio * THICKNESS, RADIUS, THICKNESS, nu)
            contact = solve_contact(
                height,
                bodies=[{"base": "rigid", "layers": [sheet]}],
                mean_pressure=expected.force,
                tolerance=1e-6,
            )
            across = ratio * THICKNESS * points
            area = relative_contact_area(contact["pressure"].values[0] > 0)
            fields = {"nu": nu, "ratio": ratio, "n": across}
            radius = np.sqrt(area / np.pi)
            section.compare("radius", radius, ratio * THICKNESS, 0.1 / across, **fields)
            approach = -float(contact["approach"][0])  # the crest lies at h = 0
            section.compare("approach", approach, expected.approach, 1e-3, **fields)
    for name, (layers, base) in STACKS.items():
        _wave(section, name, layers, base)


def _wave(
    section: Section, name: str, layers: list[tuple[float, float, float]], base: tuple[float, float] | None
) -> None:
    """Add the line of the stresses of a stack below a pressure wave, from the surface to below the layers."""
    points = 64
    wave = np.cos(2 * np.pi * np.arange(points) / points)[None, :]
    unit = points / (2 * np.pi)  # 1/q
    stack = Stack(tuple(Layer(t * unit, Material(*own)) for t, *own in layers), base and Material(*base))
    stress_at = subsurface_stress(wave, (1.0, 1.0), body=stack)
    computed, expected, face = [], [], 0.0
    for number, thickness in enumerate([*(t for t, _, _ in layers), *([] if base is None else [2.0])]):
        depths = np.linspace(0.1, 1, 10) * thickness
        stresses = [stress_at(depth * unit, number) for depth in depths]
        # the shear is largest a quarter of the wave beside the crest
        computed += [[one[2, 0, 0], one[4, 0, points // 4], one[0, 0, 0]] for one in stresses]
        expected += list(layered_wave_stresses(face + depths, layers, base).T)
        face += thickness
    section.compare("stress", computed, expected, 1e-12, stack=name)
