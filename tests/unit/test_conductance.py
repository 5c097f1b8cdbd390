"""Conductance of a contact: spots, a regular array, strips, and what the settings say of the bodies."""

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.configuration.resolve import resolve
from roughcontact.contact.response import linear_response
from roughcontact.maps import height_map
from roughcontact.references import closed_forms
from roughcontact.references.synthetic import rough_reference_surface, westergaard_surface
from roughcontact.statistics.conductance import conductance_columns
from roughcontact.variables import describe

STEEL = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
COPPER = {"youngs_modulus": 1.2e11, "poissons_ratio": 0.34}


def disc(points, radius):
    """Return where the cell centres of a square of side 1 lie inside a disc."""
    x = (np.arange(points) + 0.27) / points - 0.5
    return np.hypot(x[:, None], x[None, :]) < radius


def test_a_single_spot_conducts_as_holm_has_it():
    """A round spot between two half-spaces conducts 4a/(ρ1 + ρ2); a punch has the stiffness 2 E* a."""
    a, modulus, area = 3e-6, 1e11, 1e-8
    bodies = [
        {"electrical_resistivity": 1.7e-8, "thermal_conductivity": 400.0},
        {"electrical_resistivity": 2e-7, "thermal_conductivity": 50.0},
    ]
    found = conductance_columns(2 * modulus * a / area, contact_modulus=modulus, bodies=bodies)
    assert found["electrical_conductance"] * area == pytest.approx(4 * a / (1.7e-8 + 2e-7), rel=1e-14)
    # heat: the same with 1/k in place of ρ
    assert found["thermal_conductance"] * area == pytest.approx(4 * a / (1 / 400 + 1 / 50), rel=1e-14)
    assert found["conductance_per_conductivity"] * area == pytest.approx(2 * a, rel=1e-14)


@pytest.mark.parametrize("radius", [0.1, 0.15])
def test_an_array_of_round_spots(radius):
    """The error of pixels falls with their size: twice as many halve it, and what is left is small."""
    known = closed_forms.spot_array_stiffness(radius, 1.0, 1.0)
    coarse, fine = (1 / linear_response(disc(n, radius), (1 / n, 1 / n), 1.0, 1e-4) for n in (256, 512))
    assert fine == pytest.approx(known, rel=0.5 / (radius * 512))
    assert 2 * fine - coarse == pytest.approx(known, rel=3e-3)


def test_array_of_spots_is_the_slope_of_the_repeated_sphere():
    force, step = 1e-6, 1e-4
    low, high = (closed_forms.periodic_hertz(force * f, 10.0, 1.0, 1.0) for f in (1 - step, 1 + step))
    slope = 2 * step * force / (high["approach"] - low["approach"])
    radius = closed_forms.periodic_hertz(force, 10.0, 1.0, 1.0)["contact_radius"]
    assert closed_forms.spot_array_stiffness(radius, 1.0, 1.0) == pytest.approx(slope, rel=1e-8)


def test_westergaards_strips():
    wave = westergaard_surface((1, 2048), 1e-3 / 2048, amplitude=1e-6, wavelength=1e-3)
    full = closed_forms.westergaard_full_contact_pressure(1e-6, 1e-3, 1e9)
    bodies = [{"thermal_conductivity": 20.0}] * 2
    contact = rc.solve_contact(wave, contact_modulus=1e9, mean_pressure=[0.1 * full, 0.5 * full, 2 * full])
    found = describe(rc.contact_statistics(contact, bodies=bodies))
    known = np.array([closed_forms.westergaard_stiffness(1e-6, 1e-3, 1e9, r) for r in (0.1, 0.5, 2)]) / 1e9
    np.testing.assert_allclose(found["conductance_per_conductivity"], known, rtol=4e-3)
    np.testing.assert_allclose(found["thermal_conductance"], 20 * known, rtol=4e-3)
    assert found["thermal_conductance"].attrs["units"] == "W m-2 K-1"
    assert found["conductance_per_conductivity"][2] == np.inf
    assert "electrical_conductance" not in found


def test_heat_flows_through_touching_points_only():
    """The conductance from Laplace's equation below the contact: no flux where the surfaces do not touch.

    In a half-space T(z) = Σ T(q) e^(-|q| z), the flux into it |q| T(q) k: the same operator as that of
    elasticity, whose answer for the solved contact is found here by solving the dense system.
    """
    height = rough_reference_surface(64).coarsen(x=2, y=2).mean()
    contact = rc.solve_contact(height, contact_modulus=1.0, mean_pressure=0.1, tolerance=1e-8)
    touching = contact["pressure"].values[0] > 0
    q = 2 * np.pi * np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(32, 1 / 32)], indexing="ij"))
    q[0, 0] = np.inf
    kernel = np.fft.ifft2(1 / q).real  # temperature by unit flux, both bodies alike: k = 1
    places = np.argwhere(touching)
    apart = places[:, None] - places[None, :]
    matrix = kernel[apart[..., 0] % 32, apart[..., 1] % 32]
    bordered = np.block([[matrix, np.ones((len(places), 1))], [np.ones((1, len(places))), np.zeros((1, 1))]])
    answer = np.linalg.solve(bordered, np.append(np.zeros(len(places)), touching.size))
    drop = -2 * answer[-1]  # of the mean temperatures of the two bodies, at a mean flux of 1
    found = rc.contact_statistics(contact)["conductance_per_conductivity"].item()
    assert found == pytest.approx(1 / drop, rel=2e-4)


def test_settings_of_the_bodies():
    bodies = [STEEL | {"thermal_conductivity": 50}, COPPER | {"thermal_conductivity": 400}]
    found = resolve({"contact": {"bodies": bodies}})[""]["contact"]["bodies"]
    columns = conductance_columns([1e14], contact_modulus=1e11, bodies=found)
    assert set(columns) == {"conductance_per_conductivity", "thermal_conductance"}
    assert columns["thermal_conductance"] == pytest.approx(2 * 50 * 400 / 450 * 1e3)


def test_one_body_alone_does_not_conduct():
    bodies = [STEEL, COPPER | {"electrical_resistivity": 1.7e-8}]
    with pytest.raises(rc.SettingsError) as caught:
        resolve({"contact": {"bodies": bodies}})
    assert "contact.bodies[0].electrical_resistivity: missing, though the other body has it" in str(
        caught.value
    )


def test_a_flat_map_constricts_nothing():
    contact = rc.solve_contact(height_map(np.zeros((8, 8)), 1e-6), contact_modulus=1e9, mean_pressure=1e6)
    found = rc.contact_statistics(contact, bodies=[{"electrical_resistivity": 1e-7}] * 2)
    assert found["electrical_conductance"].item() == np.inf
