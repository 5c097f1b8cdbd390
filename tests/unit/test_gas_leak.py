"""A gas that leaks: it expands on its way, and slips in narrow places."""

import numpy as np
import pytest
import xarray as xr

from roughcontact.statistics.contact_checks import fluid
from roughcontact.statistics.sealing.flow import leak_columns
from roughcontact.statistics.sealing.gas import path_at_mean_pressure, slip_factor

PLATES = {"flow_factor_xx": 1.0, "flow_factor_yy": 1.0, "critical_constriction_x": 1e-6}
PLATES |= {"critical_constriction_y": 0.0}
AIR = {"viscosity": 1.8e-5, "pressure_difference": 3e5, "width": 1e-2}


def test_an_ideal_gas_leaks_the_difference_of_the_squares_of_its_pressures():
    liquid = leak_columns(1e-6, PLATES, **AIR)["leak_rate_x"]
    gas = leak_columns(1e-6, PLATES, **AIR, outlet_pressure=1e5)["leak_rate_x"]
    assert gas / liquid * 3e5 == pytest.approx((4e5**2 - 1e5**2) / (2 * 1e5))


@pytest.mark.parametrize(("inverse", "flow"), [(0.1, 2.03), (1.0, 1.539), (10.0, 2.77)])
def test_slip_is_that_of_the_linearised_boltzmann_equation(inverse, flow):
    """Flow of a gas between plates by the inverse Knudsen number √π/2 h/λ: Cercignani and Daneri (1963)."""
    height = 2 / np.pi**0.5 * inverse
    assert slip_factor(height, 1.0) * inverse / 6 == pytest.approx(flow, rel=0.01)


def test_slip_of_a_wide_gap_is_maxwells_and_none_without_a_path_or_a_gap():
    """1 + 6 σ Kn with the slip coefficient 1.016 · 2/√π of a wall that reflects diffusely."""
    assert slip_factor(1e-4, 1e-7) == pytest.approx(1 + 6 * 1.0162 * 2 / np.pi**0.5 * 1e-3, rel=1e-5)
    np.testing.assert_array_equal(slip_factor([0.0, 1e-6], 0.0), [1, 1])
    assert slip_factor(0.0, 1e-7) == pytest.approx(1)


def test_a_gas_slips_at_the_mean_pressure_in_the_narrowest_place():
    gas = leak_columns(1e-6, PLATES, **AIR, outlet_pressure=1e5)
    slipping = leak_columns(1e-6, PLATES, **AIR, outlet_pressure=1e5, mean_free_path=68e-9)
    path = path_at_mean_pressure(
        {"seal_mean_free_path": 68e-9, "seal_pressure_difference": 3e5, "seal_outlet_pressure": 1e5}
    )
    assert path == pytest.approx(68e-9 / 2.5)
    assert slipping["leak_rate_x"] / gas["leak_rate_x"] == pytest.approx(slip_factor(1e-6, path))
    assert slipping["leak_rate_y"] == pytest.approx(gas["leak_rate_y"])


@pytest.mark.cases
def test_the_check_of_the_fluid(seal, outcome, text):
    attrs = {f"seal_{key}": value for key, value in (AIR | seal).items()}
    columns = {"leak_rate_x": [1e-9], "critical_constriction_x": [1e-6], "critical_constriction_y": [0.0]}
    statistics = xr.Dataset(
        {name: ("load", values) for name, values in columns.items()},
        {"mean_pressure": ("load", [1e6]), "fluid_pressure": attrs["seal_pressure_difference"]},
        attrs,
    )
    check = fluid(statistics)
    assert check.outcome == outcome
    assert text in check.sentence
