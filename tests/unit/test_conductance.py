"""Conductance of a contact: spots, a regular array, strips, and what the settings say of the bodies."""

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact.arguments.maps import height_map
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.arguments.variables import describe
from roughcontact.contact.elasticity.energy import elastic_energy
from roughcontact.contact.elasticity.influence import HALF_SPACE
from roughcontact.contact.response import linear_response
from roughcontact.report.glance import Cell, _conducts, glance_units
from roughcontact.report.tables import number_tables
from roughcontact.statistics.conductance import (
    conductance_columns,
    knudsen_resistance_ratio,
    resistances_and_joint,
)
from roughcontact.statistics.contact_checks import mean_free_path
from roughcontact.surface.synthetic import rough_reference_surface, westergaard_surface
from validation import closed_forms

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
    columns = conductance_columns(2 * modulus * a / area, contact_modulus=modulus, bodies=bodies)
    assert columns["electrical_conductance"] * area == pytest.approx(4 * a / (1.7e-8 + 2e-7), rel=1e-14)
    # heat: the same with 1/k in place of ρ
    assert columns["thermal_conductance"] * area == pytest.approx(4 * a / (1 / 400 + 1 / 50), rel=1e-14)
    assert columns["conductance_per_conductivity"] * area == pytest.approx(2 * a, rel=1e-14)


@pytest.mark.parametrize("radius", [0.1, 0.15])
def test_an_array_of_round_spots(radius):
    """The error of pixels falls with their size: twice as many halve it, and what is left is small."""
    reference = closed_forms.spot_array_stiffness(radius, 1.0, 1.0)
    coarse, fine = (
        1 / linear_response(disc(n, radius), (1 / n, 1 / n), HALF_SPACE, 1e-4)[0] for n in (256, 512)
    )
    assert fine == pytest.approx(reference, rel=0.5 / (radius * 512))
    assert 2 * fine - coarse == pytest.approx(reference, rel=3e-3)


@pytest.mark.parametrize("tolerance", [0.3, 1e-2, 1e-4])
@pytest.mark.parametrize("load", [0.02, 0.3])
def test_the_bound_of_the_conductance_is_never_below_its_error(load, tolerance):
    """The truth is the energy of a flat punch on the same points, solved as a contact to 1e-9."""
    steps = (1 / 64, 1 / 64)
    surface = rough_reference_surface(64)
    touching = rc.solve_contact(surface, contact_modulus=1.0, mean_pressure=load)["contact"].values[0] > 0
    punch = height_map(np.where(touching, 0.0, -1.0), 1 / 64)
    solved = rc.solve_contact(punch, contact_modulus=1.0, mean_pressure=1e-3, tolerance=1e-9)
    assert (solved["contact"].values[0] == touching).all()
    known = 2e6 * elastic_energy(solved["pressure"].values[0], steps, HALF_SPACE)
    compliance, bound = linear_response(touching, steps, HALF_SPACE, tolerance, certify=True)
    assert abs(compliance / known - 1) <= bound < tolerance**2 + 1e-5
    assert compliance == pytest.approx(linear_response(touching, steps, HALF_SPACE, tolerance)[0], rel=1e-5)


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
    statistics = describe(rc.contact_statistics(contact, bodies=bodies))
    reference = (
        np.array([closed_forms.westergaard_stiffness(1e-6, 1e-3, 1e9, r) for r in (0.1, 0.5, 2)]) / 1e9
    )
    np.testing.assert_allclose(statistics["conductance_per_conductivity"], reference, rtol=4e-3)
    np.testing.assert_allclose(statistics["thermal_conductance"], 20 * reference, rtol=4e-3)
    assert statistics["thermal_conductance"].attrs["units"] == "W m-2 K-1"
    assert statistics["conductance_per_conductivity"][2] == np.inf
    assert "electrical_conductance" not in statistics


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
    points = np.argwhere(touching)
    offsets = points[:, None] - points[None, :]
    matrix = kernel[offsets[..., 0] % 32, offsets[..., 1] % 32]
    bordered = np.block([[matrix, np.ones((len(points), 1))], [np.ones((1, len(points))), np.zeros((1, 1))]])
    answer = np.linalg.solve(bordered, np.append(np.zeros(len(points)), touching.size))
    drop = -2 * answer[-1]  # of the mean temperatures of the two bodies, at a mean flux of 1
    conductance = rc.contact_statistics(contact)["conductance_per_conductivity"].item()
    assert conductance == pytest.approx(1 / drop, rel=2e-4)


def test_settings_of_the_bodies():
    bodies = [STEEL | {"thermal_conductivity": 50}, COPPER | {"thermal_conductivity": 400}]
    bodies_resolved = resolve({"contact": {"bodies": bodies}})[""]["contact"]["bodies"]
    columns = conductance_columns([1e14], contact_modulus=1e11, bodies=bodies_resolved)
    assert set(columns) == {"conductance_per_conductivity", "thermal_conductance"}
    assert columns["thermal_conductance"] == pytest.approx(2 * 50 * 400 / 450 * 1e3)


def test_a_flat_map_constricts_nothing():
    contact = rc.solve_contact(height_map(np.zeros((8, 8)), 1e-6), contact_modulus=1e9, mean_pressure=1e6)
    statistics = rc.contact_statistics(contact, bodies=[{"electrical_resistivity": 1e-7}] * 2)
    assert statistics["electrical_conductance"].item() == np.inf


def one_spot(radius: float, resistivity: float, period: float = 1e-4) -> xr.Dataset:
    """Return what the statistics say of a round spot in each period of both lengths, by Holm's ρ/(2a)."""
    conductance = 2 * radius / resistivity / period**2
    numbers = {
        "electrical_conductance": conductance,
        "conductance_per_conductivity": conductance * resistivity,
        "relative_contact_area": np.pi * radius**2 / period**2,
    }
    return xr.Dataset({name: ("load", [value]) for name, value in numbers.items()})


@pytest.mark.parametrize(
    ("ratio", "wexler"),
    # Holm's resistance falls to 9π²/128 = 0.69 of it at most (Wexler 1966), Sharvin's outgrows it
    [(1e-6, 1.0), (0.01, 1.0 + 0.01 * 8 / (3 * np.pi)), (1.0, 0.79 + 0.849), (100.0, 0.66 + 84.9)],
)
def test_small_spots_add_sharvins_resistance_to_holms(ratio, wexler):
    assert knudsen_resistance_ratio(ratio) == pytest.approx(wexler, rel=0.01)


def test_the_mean_free_path_counts_for_spots_of_its_size():
    copper = 1.7e-8
    path = 7e-16 / copper  # 41 nm; measured and computed ones of copper: 39 nm
    large, small = (mean_free_path(one_spot(radius, copper)) for radius in (100 * path, path))
    assert (large.outcome, small.outcome) == ("passed", "review")
    assert "a radius of 41 nm at the least" in small.sentence
    assert "go 41 nm without a collision (Knudsen number 1.0), which adds up to 63.4 % to" in small.sentence
    # Sharvin: 4ρλ/(3πa²) over ρ/(2a)
    sharvin = 4 * copper * path / (3 * np.pi * path**2) / (copper / (2 * path))
    assert knudsen_resistance_ratio(1.0) - 1.83 / 2.33 == pytest.approx(sharvin)
    assert mean_free_path(one_spot(path, copper).drop_vars("electrical_conductance")) is None
    through_layers = one_spot(path, copper).assign(conductance_per_conductivity=("load", [np.nan]))
    assert mean_free_path(through_layers) is None


def test_resistances_are_those_of_the_conductances_with_their_ends():
    numbers = one_spot(1e-6, 2e-8).assign_coords(mean_pressure=("load", [1e6]))
    base = "conductance_per_conductivity"
    bounds = {f"{base}_lower": ("load", [0.0]), f"{base}_upper": 3 * numbers[base]}
    columns = resistances_and_joint({name: values.values for name, values in numbers.items()}, None)
    numbers = numbers.assign(electrical_resistance=("load", columns["electrical_resistance"]))
    assert numbers["electrical_resistance"].item() * 1e8 == pytest.approx(2e-8 / (2 * 1e-6))
    budget = xr.Dataset(bounds, coords=numbers.coords)
    result = rc.with_uncertainty(numbers, budget)
    assert result["electrical_conductance_upper"].item() == pytest.approx(3 * 2 * 1e-6 / 2e-8 / 1e-8)
    assert result["electrical_resistance_lower"].item() == pytest.approx(2e-8 / (2 * 1e-6) * 1e-8 / 3)
    assert np.isnan(result["electrical_resistance_upper"].item())  # it may not conduct at all
    unbounded = rc.with_uncertainty(numbers, budget.assign({f"{base}_upper": ("load", [np.nan])}))
    assert unbounded["electrical_resistance_lower"].item() == 0
    nothing = rc.with_uncertainty(numbers, budget.assign(dict.fromkeys(bounds, ("load", [np.nan]))))
    assert np.isnan(nothing["electrical_resistance_lower"].item())


def test_what_has_no_interval_says_so_with_the_digits_of_the_area():
    """Behind a film the conductance is of another problem than the stiffness: its ± is not known."""
    area = "relative_contact_area"
    numbers = xr.Dataset(
        {
            area: ("load", [0.933]),
            f"{area}_lower": ("load", [0.153]),
            f"{area}_upper": ("load", [1.0]),
            "electrical_conductance": ("load", [945831e9]),
            "electrical_resistance": ("load", [1 / 945831e9]),
            "mean_pressure": ("load", [1e6]),
        }
    )
    cell = _conducts(numbers, glance_units([numbers])[0], 0)
    assert cell == Cell(
        "946000 GS/m²", "no ±, current", further=("0.001057\N{NO-BREAK SPACE}µΩ\N{NO-BREAK SPACE}mm²",)
    )
    *_, table = number_tables(numbers, [[]])
    titles = [title for title, *_ in table["header"]]
    assert titles[1:] == ["electrical conductance, no ±", "specific contact resistance, no ±"]
    assert table["rows"][0]["cells"][1:] == ["946000", "0.001057"]
    without_interval = numbers.drop_vars([f"{area}_lower", f"{area}_upper"])  # nothing has a ± there
    assert "no ±" not in _conducts(without_interval, glance_units([numbers])[0], 0).details
