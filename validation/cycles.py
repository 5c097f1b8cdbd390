"""After the load, and under a tangential one: closed forms, and the laws of both on rough maps."""

import numpy as np

from roughcontact.arguments.maps import height_map
from roughcontact.contact.elasticity.halfspace import HalfSpace
from roughcontact.contact.partial_slip import partial_slip
from roughcontact.contact.solve import solve_contact
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.statistics.unloading import unload
from roughcontact.surface.synthetic import rough_reference_surface
from validation import closed_forms
from validation.axisymmetric import ring_contact, rings
from validation.lines import Section

_FRICTION, _RATIO = 0.3, 0.3
_HARDNESS = 0.4  # of the rough map, over E*: a quarter of the area carries it at the largest load


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the lines of a flattened summit, spheres that yield or slip, a wave, and rough maps."""
    points = max(128, finest_grid // 8)
    _flattened_summit(section, points)
    _yielding_sphere(section, points)
    _rough_cycle(section)
    _slipping_sphere(section, points)
    _slipping_wave(section, finest_grid)
    _coulomb(section)


def _paraboloid(points: int, curvature_radius: float) -> np.ndarray:
    x = (np.arange(points) - points / 2 + 0.5) / points
    return -(x[:, None] ** 2 + x[None] ** 2) / (2 * curvature_radius)


def _flattened_summit(section: Section, points: int) -> None:
    """Add the lines of a summit that carries the hardness over its whole contact, and is unloaded."""
    hardness, load, shares = 0.002, 6e-5, np.array([0.5, 0.2, 0.05])
    height = height_map(np.maximum(_paraboloid(points, 2.0), -0.04), 1 / points)
    # by the rule `lattice` the approach is that of an isolated contact
    loaded = solve_contact(
        height,
        contact_modulus=1.0,
        mean_pressure=[load / 4, load / 2, load],
        hardness=hardness,
        tolerance=1e-8,
        zero_frequency="lattice",
    )
    for approach, force in zip(loaded["approach"].values, loaded["mean_pressure"].values, strict=True):
        flattened = closed_forms.flattened_summit_approach(force, 2.0, hardness, 1.0)
        n = float(np.sqrt(force / hardness / np.pi)) * points
        section.compare("loading", -approach, flattened, 0.3 / n, share=force / load, n=n)
    unloaded = unload(loaded, mean_pressure=[load, *(load * shares)])
    areas = (unloaded["pressure"].values > 0).mean((1, 2))
    recovered = unloaded["approach"].values - unloaded["approach"].values[0]
    radius = float(np.sqrt(load / hardness / np.pi))
    for index, share in enumerate(shares, start=1):
        inside = closed_forms.flattened_summit_radius(share)
        n = radius * points
        section.compare("summit", np.sqrt(areas[index] / areas[0]), inside, 0.5 / n, share=share, n=n)
        recovery = 2 * hardness * radius * np.sqrt(1 - inside**2)
        section.compare("recovery", recovered[index], recovery, 0.1 / n, share=share, n=n)


def _yielding_sphere(section: Section, points: int) -> None:
    """Add the lines of a sphere between elastic and flattened, loaded and unloaded, beside rings."""
    curvature_radius, radius, shares = 2.0, 0.1, (0.5, 0.1)
    load = 4 * radius**3 / (3 * curvature_radius)
    n = radius * points
    hertz_pressure = 2 * radius / (np.pi * curvature_radius)
    height = height_map(np.maximum(_paraboloid(points, curvature_radius), -0.04), 1 / points)
    body = rings(np.linspace(0, 0.14, 701))
    shape = -(body.radius**2) / (2 * curvature_radius)
    for ratio in (1.2, 1.6, 2.5):
        hardness = hertz_pressure / ratio
        loaded = solve_contact(
            height,
            contact_modulus=1.0,
            mean_pressure=load,
            hardness=hardness,
            tolerance=1e-8,
            zero_frequency="lattice",
        )
        top = ring_contact(body, shape, load, hardness=hardness, period=1.0)
        section.compare("yielding", -float(loaded["approach"][0]), top.approach, 0.02 / n, ratio=ratio, n=n)
        unloaded = unload(loaded, mean_pressure=[load, *(load * share for share in shares)], tolerance=1e-8)
        volume = float(unloaded["plastic_volume"])
        section.compare("volume", volume, body.area @ top.depth, 0.2 / n, ratio=ratio, n=n)
        for index, share in enumerate(shares, start=1):
            back = ring_contact(body, shape - top.depth, share * load, period=1.0)
            recovered = float(unloaded["approach"][index] - unloaded["approach"][0])
            lifted = top.approach - back.approach
            section.compare("lifted", recovered, lifted, 0.02 / n, ratio=ratio, share=share, n=n)
            touching = np.sqrt(float((unloaded["pressure"][index] > 0).sum()) / np.pi) / n
            edge = np.sqrt(body.area @ (back.pressure > 0) / np.pi) / radius
            section.compare("retreat", touching, edge, 0.5 / n, ratio=ratio, share=share, n=n)


def _rough_cycle(section: Section) -> None:
    """Add the lines of a rough map that is loaded until a quarter of it flows, and unloaded."""
    loads = (0.12 * np.linspace(0.01, 1, 40) ** 1.5).tolist()
    height = rough_reference_surface(64)
    up = solve_contact(height, contact_modulus=1.0, mean_pressure=loads, hardness=_HARDNESS, tolerance=1e-8)
    for tolerance in (1e-6, 1e-8):
        down = unload(up, mean_pressure=loads[::-1], tolerance=tolerance)
        top = unload(up, mean_pressure=loads[-1], tolerance=tolerance, peak_pressure=loads[-1])
        again = top["pressure"].values[0]
        loaded = solve_contact(
            height, contact_modulus=1.0, mean_pressure=loads[-1], hardness=_HARDNESS, tolerance=tolerance
        )["pressure"].values[0]
        difference = np.linalg.norm(again - loaded) / np.linalg.norm(loaded)
        section.compare("returned", difference, 0.0, 2 * tolerance, solved=tolerance)
    excess = max(float(down["pressure"].max()) / _HARDNESS - 1, 0.0)
    section.compare("limit", excess, 0.0, 1e-5)
    areas = [contact_statistics(way, flow="never")["relative_contact_area"].values for way in (up, down)]
    section.compare("area", max(float((areas[0] - areas[1][::-1]).max()), 0.0), 0.0, 1e-12)
    work = [abs(np.trapezoid(way["mean_pressure"].values, way["approach"].values)) for way in (up, down)]
    section.compare("energy", float(down["dissipated_energy"]), work[0] - work[1], 5e-3, loads=len(loads))


def _slipping_sphere(section: Section, points: int) -> None:
    """Add the lines of a Hertzian contact under a tangential load."""
    curvature_radius, radius, shares = 2.0, 0.15, [0.2, 0.5, 0.8]
    load = 4 * radius**3 / (3 * curvature_radius)  # Hertz, E* = 1, of a period of area 1
    height = height_map(_paraboloid(points, curvature_radius), 1 / points)
    normal = solve_contact(height, contact_modulus=1.0, mean_pressure=load, tolerance=1e-8)
    slip = partial_slip(normal, friction_coefficient=_FRICTION, tangential_load=shares, poissons_ratio=_RATIO)
    in_contact, n = float((normal["pressure"] > 0).sum()), radius * points
    for index, share in enumerate(shares):
        stuck = np.sqrt(float(slip["stick"][index].sum()) / in_contact)
        section.compare("sphere", stuck, closed_forms.cattaneo_stick_radius(share), 0.4 / n, share=share, n=n)
        energy = closed_forms.mindlin_deresiewicz_energy(
            share, _FRICTION * load, radius, shear_modulus=1 - _RATIO, poissons_ratio=_RATIO
        )
        lost = float(slip["dissipated_energy"][index])
        section.compare(
            "cycle", lost / energy, 1.0, max((0.75 if share > 0.3 else 2) / n, 0.015), share=share, n=n
        )


def _slipping_wave(section: Section, points: int) -> None:
    """Add the lines of ridges under a tangential load."""
    full, ratio = np.pi * 1e-3, 0.4
    wave = height_map(1e-3 * np.cos(2 * np.pi * np.arange(points) / points)[None], 1 / points)
    normal = solve_contact(wave, contact_modulus=1.0, mean_pressure=ratio * full, tolerance=1e-9)
    shares = [0.3, 0.75]
    slip = partial_slip(normal, friction_coefficient=0.5, tangential_load=shares)
    for index, share in enumerate(shares):
        # the contact at the lower load sticks
        stuck = closed_forms.westergaard_contact_share(ratio * (1 - share))
        section.compare("wave", float(slip["stick"][index].mean()), stuck, 2 / points, share=share, n=points)


def _coulomb(section: Section) -> None:
    """Add the conditions of Coulomb on a rough map, to ten times the tolerance of the solver."""
    load = 0.15
    normal = solve_contact(
        rough_reference_surface(64), contact_modulus=1.0, mean_pressure=load, tolerance=1e-10
    )
    pressure = normal["pressure"].values[0]
    for share in (0.3, 0.7):
        slip = partial_slip(normal, friction_coefficient=_FRICTION, tangential_load=share)
        traction, stick = (slip[name].values[0] for name in ("shear_traction", "stick"))
        bound = _FRICTION * pressure
        unit = bound.max()
        moved = HalfSpace((64, 64), (1.0, 1.0)).displacement(traction)
        together = moved[stick == 1].mean()
        slipping = (pressure > 0) & (stick == 0)
        broken = {
            "no traction above mu p": np.max(np.abs(traction) - bound) / unit,
            "slip at mu p": np.max(np.abs(traction - bound)[slipping]) / unit,
            "the stuck move as one": np.ptp(moved[stick == 1]) / np.abs(moved).max(),
            "slip follows the load": np.max(moved[slipping] - together) / np.abs(moved).max(),
        }
        for condition, excess in broken.items():
            section.compare("coulomb", max(float(excess), 0.0), 0.0, 1e-6, share=share, condition=condition)
