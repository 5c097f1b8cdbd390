"""Partial slip against Cattaneo, Mindlin, Deresiewicz and a wave, and the laws of Coulomb on rough maps."""

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.contact.elasticity.halfspace import HalfSpace
from roughcontact.surface.synthetic import rough_reference_surface

FRICTION, RATIO = 0.3, 0.3
SHARES = [0.2, 0.5, 0.8, 1.0]


@pytest.fixture(scope="module")
def ball():
    """Return radius and load of a Hertzian contact, and its slip."""
    points, curvature_radius, radius = 256, 2.0, 0.15
    x = (np.arange(points) - points / 2 + 0.5) / points
    height = rc.height_map(-(x[:, None] ** 2 + x[None] ** 2) / (2 * curvature_radius), 1 / points)
    load = 4 * radius**3 / (3 * curvature_radius)  # Hertz, E* = 1, of a period of area 1
    normal = rc.solve_contact(height, contact_modulus=1.0, mean_pressure=load, tolerance=1e-8)
    slip = rc.partial_slip(
        normal, friction_coefficient=FRICTION, tangential_load=SHARES, poissons_ratio=RATIO
    )
    return radius, load, normal, slip


def test_the_stick_radius_is_that_of_cattaneo(ball):
    _, _, normal, slip = ball
    points = float((normal["pressure"] > 0).sum())
    radii = np.sqrt(slip["stick"].sum(("y", "x")).values / points)
    np.testing.assert_allclose(radii, np.cbrt(1 - np.array(SHARES)), atol=0.01)


def test_the_energy_of_a_cycle_is_that_of_mindlin_and_deresiewicz(ball):
    """Johnson (1985), eq. 7.57, which follows from Mindlin's displacement by Masing's rule."""
    radius, load, _, slip = ball
    shear_modulus = 1 - RATIO  # of two like bodies with E* = 1
    s = np.array(SHARES)
    shape = 1 - (1 - s) ** (5 / 3) - 5 * s / 6 * (1 + (1 - s) ** (2 / 3))
    energy = 0.9 * (FRICTION * load) ** 2 / radius * 2 * (2 - RATIO) / shear_modulus * shape
    np.testing.assert_allclose(slip["dissipated_energy"].values[1:], energy[1:], rtol=0.02)


def test_the_energy_of_a_small_cycle_is_no_difference_of_large_ones():
    """A wave has the compliance -(λ/π E*) ln(p/p*) (Westergaard 1939); the loop is a trapezium less work."""
    amplitude, q = 1e-3, np.array([0.05, 0.2, 0.9])
    full, load = np.pi * amplitude, 0.5
    wave = rc.height_map(amplitude * np.cos(2 * np.pi * np.arange(8192) / 8192)[None], 1 / 8192)
    normal = rc.solve_contact(wave, contact_modulus=1.0, mean_pressure=load * full, tolerance=1e-4)
    slip = rc.partial_slip(normal, friction_coefficient=FRICTION, tangential_load=q, poissons_ratio=RATIO)
    lower = load * (1 - q)
    approach, work = (
        integral(load) - integral(lower)
        for integral in (lambda m: m - m * np.log(m), lambda m: m**2 / 4 - m**2 / 2 * np.log(m))
    )
    compliance = (2 - RATIO) / (2 * (1 - RATIO))
    shape = (load + lower) / 2 * approach - work
    expected = 8 * FRICTION**2 * compliance * full * amplitude * shape
    np.testing.assert_allclose(slip["dissipated_energy"], expected, rtol=0.03)


def test_a_wave_sticks_as_ciavarella_says():
    """Westergaard: sin^2 of the half-width is the load over that of full contact, stuck at the lower load."""
    points = 2048
    wave = rc.height_map(1e-3 * np.cos(2 * np.pi * np.arange(points) / points)[None], 1 / points)
    full = np.pi * 1e-3
    normal = rc.solve_contact(wave, contact_modulus=1.0, mean_pressure=0.4 * full, tolerance=1e-9)
    slip = rc.partial_slip(normal, friction_coefficient=0.5, tangential_load=[0.3, 0.75])
    stuck = slip["stick"].mean(("y", "x")).values
    expected = 2 / np.pi * np.arcsin(np.sqrt(0.4 * (1 - np.array([0.3, 0.75]))))  # of the period
    np.testing.assert_allclose(stuck, expected, atol=2 / points)


@pytest.fixture(scope="module")
def rough():
    height = rough_reference_surface(64)
    normal = rc.solve_contact(height, contact_modulus=1.0, mean_pressure=0.15, tolerance=1e-10)
    return normal, rc.partial_slip(normal, friction_coefficient=FRICTION, tangential_load=[0.3, 0.7])


@pytest.mark.parametrize("index", [0, 1])
def test_the_conditions_of_coulomb_hold(rough, index):
    normal, slip = rough
    pressure = normal["pressure"].values[0]
    traction, stick = (slip[name].values[index] for name in ("shear_traction", "stick"))
    unit = FRICTION * pressure.max()
    assert (np.abs(traction) <= FRICTION * pressure + 1e-9 * unit).all()
    slipping = (pressure > 0) & (stick == 0)
    np.testing.assert_allclose(traction[slipping], FRICTION * pressure[slipping], rtol=1e-12)
    assert traction.mean() == pytest.approx(float(slip["tangential_load"][index]) * FRICTION * 0.15, rel=1e-6)
    # the stuck points have moved as one, the slipping ones less
    moved = HalfSpace((64, 64), (1.0, 1.0)).displacement(traction)
    together = moved[stick == 1].mean()
    np.testing.assert_allclose(moved[stick == 1], together, atol=1e-6 * np.abs(moved).max())
    assert (moved[slipping] <= together + 1e-6 * np.abs(moved).max()).all()


def test_the_bound_is_not_below_the_error(rough):
    normal, exact = rough
    body = HalfSpace((64, 64), (1.0, 1.0))

    def norm(field):
        return np.sqrt((field * body.displacement(field)).mean())

    for tolerance in (1e-2, 1e-3, 1e-4):
        loose = rc.solve_contact(
            normal["height"], contact_modulus=1.0, mean_pressure=0.15, tolerance=tolerance
        )
        slip = rc.partial_slip(loose, friction_coefficient=FRICTION, tangential_load=[0.3, 0.7])
        for index in (0, 1):
            reference = exact["shear_traction"].values[index]
            traction = slip["shear_traction"].values[index]
            assert norm(traction - reference) / norm(traction) <= float(slip["tangential_error_bound"][index])


def test_what_has_no_meaning_is_refused(rough):
    normal, _ = rough
    with pytest.raises(rc.SettingsError, match="friction_coefficient"):
        rc.partial_slip(normal, friction_coefficient=0.0, tangential_load=0.5)
    with pytest.raises(rc.SettingsError, match=r"1\.2: is Q/\(mu P\), at most 1"):
        rc.partial_slip(normal, friction_coefficient=0.3, tangential_load=1.2)
    for load in ("5 N", 0.0, [], None):
        with pytest.raises(rc.SettingsError, match=r"tangential_load .* 1 is full slip"):
            rc.partial_slip(normal, friction_coefficient=0.3, tangential_load=load)
    with pytest.raises(rc.SettingsError, match=r"poissons_ratio = 'steel': give a number"):
        rc.partial_slip(normal, friction_coefficient=0.3, tangential_load=0.5, poissons_ratio="steel")
    with pytest.raises(rc.SettingsError, match=r"poissons_ratio = 0\.7: must lie above -1"):
        rc.partial_slip(normal, friction_coefficient=0.3, tangential_load=0.5, poissons_ratio=0.7)
    hard = rc.solve_contact(normal["height"], contact_modulus=1.0, mean_pressure=0.1, hardness=1.0)
    with pytest.raises(rc.SettingsError, match="the contact has a hardness"):
        rc.partial_slip(hard, friction_coefficient=0.3, tangential_load=0.5)
    film = {"thickness": 0.02, "youngs_modulus": 3.0, "poissons_ratio": 0.3}
    bodies = [{"youngs_modulus": 1.0, "poissons_ratio": 0.3, "layers": [film]}]
    coated = rc.solve_contact(normal["height"], bodies=bodies, mean_pressure=0.1)
    with pytest.raises(rc.SettingsError, match="the contact has layers"):
        rc.partial_slip(coated, friction_coefficient=0.3, tangential_load=0.5)


def test_the_rule_of_the_approach_makes_no_difference():
    """What the mean of the displacement is has no part in slip."""
    height, energies = rough_reference_surface(64), []
    for rule in ("zero", "lattice"):
        normal = rc.solve_contact(height, contact_modulus=1.0, mean_pressure=0.1, zero_frequency=rule)
        slip = rc.partial_slip(
            normal, friction_coefficient=FRICTION, tangential_load=[0.4, 1.0], poissons_ratio=RATIO
        )
        energies.append(slip["dissipated_energy"].values)
        assert (slip["dissipated_energy"] > 0).all()
    np.testing.assert_allclose(energies[1], energies[0], rtol=1e-9)


def test_the_stiffness_is_the_slope_of_the_load_over_the_displacement(ball):
    _, load, normal, _ = ball
    near = rc.partial_slip(
        normal, friction_coefficient=FRICTION, tangential_load=[0.45, 0.5, 0.55], poissons_ratio=RATIO
    )
    displacement = near["tangential_displacement"].values
    slope = 0.1 * FRICTION * load / (displacement[2] - displacement[0])
    np.testing.assert_allclose(near["tangential_stiffness"].values[1], slope, rtol=0.02)


@pytest.mark.parametrize("share", [0.3, 1.0])
def test_the_uniform_pressure_under_a_flat_map_slips_without_an_error(share):
    flat = rc.solve_contact(rc.height_map(np.zeros((6, 5)), 1e-6), contact_modulus=1e9, mean_pressure=1e6)
    slip = rc.partial_slip(flat, friction_coefficient=0.3, tangential_load=[share])
    assert slip["tangential_error_bound"].item() == 0
    np.testing.assert_allclose(slip["shear_traction"], 0.3 * share * 1e6, rtol=1e-12)
