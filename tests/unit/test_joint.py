"""Heat through a joint: gas between plates and over a Gaussian gap, a film in series with the spots."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ndtri

import roughcontact as rc
from roughcontact.statistics.conductance import gas_columns, resistances_and_joint
from roughcontact.surface.synthetic import rough_reference_surface

AIR = {"gas_conductivity": 0.026, "temperature_jump": "0.37 um"}


def test_gas_between_plates_conducts_as_a_layer():
    result = gas_columns(np.full((4, 8), 2e-6), conductivity=0.026, jump=0.37e-6)["gas_conductance"]
    assert result == pytest.approx(0.026 / 2.37e-6, rel=1e-14)


def test_gas_over_a_gaussian_gap_is_the_integral():
    """Heights with a normal distribution, cut off where they touch a plane three deviations above."""
    mean, deviation, jump = 3e-6, 1e-6, 0.37e-6
    quantiles = ndtri((np.arange(2**21) + 0.5) / 2**21)
    gap = np.maximum(mean + deviation * quantiles, 0.0).reshape(2**10, 2**11)
    expected, _ = quad(
        lambda z: np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi) / (mean + deviation * z + jump),
        -mean / deviation,
        12,
        epsabs=0,
        epsrel=1e-12,
    )
    result = gas_columns(gap, conductivity=0.026, jump=jump)["gas_conductance"]
    assert result == pytest.approx(0.026 * expected, rel=1e-6)


def test_a_film_lies_in_series_with_the_spots_and_gas_beside_them():
    spots = {"thermal_conductance": np.array([2e4, np.inf])}
    columns = {"relative_contact_area": np.array([0.1, 1.0]), "gas_conductance": np.array([5e3, 0.0])}
    with_film, bare = (
        resistances_and_joint(spots | columns, {"gas_conductivity": 0.026} | film)["joint_conductance"]
        for film in ({"film_thickness": 1e-6, "film_conductivity": 2.0}, {})
    )
    np.testing.assert_allclose(with_film, [5e3 + 1 / (1 / 2e4 + 5e-7 / 0.1), 2e6])
    np.testing.assert_allclose(bare, [2.5e4, np.inf])


def test_the_statistics_have_the_joint():
    steel = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "thermal_conductivity": 50.0}
    height = rough_reference_surface(64) * 1e-3
    contact = rc.solve_contact(
        height.assign_attrs(units="m"), bodies=[steel, steel], mean_pressure=[1e8, 1e9]
    )
    film = {"film_thickness": "50 nm", "film_conductivity": 2.0}
    numbers = rc.contact_statistics(contact, bodies=[steel, steel], joint=AIR | film)
    gap = contact["gap"].where(contact["pressure"] == 0, 0.0)
    gas = 0.026 * (1 / (gap + 0.37e-6)).where(gap > 0, 0.0).mean(("y", "x"))
    np.testing.assert_allclose(numbers["gas_conductance"], gas, rtol=1e-12)
    assert (numbers["joint_conductance"] > numbers["gas_conductance"]).all()
    assert "joint_conductance" not in rc.contact_statistics(contact, joint=AIR)  # conductivities are unknown
    assert "gas_conductance" not in rc.contact_statistics(contact, bodies=[steel, steel])


def test_a_film_has_the_resistance_of_the_area_that_is_stated():
    """Where the area is corrected for the grid as well."""
    steel = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "thermal_conductivity": 50.0}
    film = {"film_thickness": "50 nm", "film_conductivity": 2.0}
    numbers = rc.evaluate(
        rough_reference_surface(64).assign_attrs(units="m"),
        contact={"bodies": [steel, steel], "relative_pressure": [0.02, 0.1]},
        statistics={"joint": AIR | film},
        uncertainty={"sources": ["solver", "discretisation"]},
    )
    area = numbers["relative_contact_area"]
    assert (area != numbers["relative_contact_area_as_solved"]).all()
    spots = 1 / (1 / numbers["thermal_conductance"] + 50e-9 / 2.0 / area)
    np.testing.assert_allclose(numbers["joint_conductance"], spots + numbers["gas_conductance"], rtol=1e-9)


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        ({"gas_conductivity": 0.026}, "joint.gas_conductivity: needs temperature_jump, or leave both out"),
        (
            AIR | {"film_thickness": "5 nm"},
            "joint.film_thickness: needs film_conductivity, or leave both out",
        ),
        (AIR | {"film": "5 nm"}, "joint has film: takes allowed_resistance, "),
    ],
)
def test_half_of_a_joint_is_refused(joint, message):
    contact = rc.solve_contact(rough_reference_surface(64), contact_modulus=1.0, mean_pressure=0.1)
    with pytest.raises(rc.SettingsError, match=message):
        rc.contact_statistics(contact, joint=joint)
