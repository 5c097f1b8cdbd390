"""The load at which a contact reaches what is wanted of it."""

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.arguments.maps import height_map
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.statistics.sealing.connectivity import percolates
from roughcontact.statistics.subsurface import stress_columns
from roughcontact.statistics.targets import target_loads, wanted_loads
from roughcontact.surface.synthetic import rough_reference_surface, westergaard_surface
from validation import closed_forms

ROUGH = rough_reference_surface(64)
D, WAVELENGTH, MODULUS = 1e-6, 1e-3, 1e9
FULL = closed_forms.westergaard_full_contact_pressure(D, WAVELENGTH, MODULUS)


def solved(load, **options):
    """Return the statistics of the rough map at a load."""
    contact = rc.solve_contact(ROUGH, contact_modulus=1.0, mean_pressure=load, **options)
    return rc.contact_statistics(contact, flow="never")


@pytest.fixture(scope="module")
def wave():
    return westergaard_surface((1, 4096), WAVELENGTH / 4096, amplitude=D, wavelength=WAVELENGTH)


@pytest.mark.parametrize("ratio", [0.05, 0.4, 0.9])
def test_area_and_gap_of_a_wave(wave, ratio):
    """Westergaard: the area (2/π) asin √r and the gap D (1 − r + r ln r) belong to the load r p*."""
    area = float(closed_forms.westergaard_contact_share(ratio))
    gap = float(closed_forms.westergaard_mean_gap(D, ratio))
    by_area, by_gap = target_loads(wave, contact_modulus=MODULUS, target_area=area, target_gap=gap)
    assert by_area / FULL == pytest.approx(ratio, rel=4 / (area * 4096) + 2e-3)
    assert by_gap / FULL == pytest.approx(ratio, rel=1e-3)


def test_the_contact_has_the_area_and_the_gap_that_were_wanted():
    loads = target_loads(ROUGH, contact_modulus=1.0, target_area=[0.1, 0.5, 0.95], target_gap=[2e-2, 2e-3])
    for load, target in zip(loads[:3], (0.1, 0.5, 0.95), strict=True):
        assert solved(load)["relative_contact_area"].item() == pytest.approx(target, rel=4e-3)
    for load, target in zip(loads[3:], (2e-2, 2e-3), strict=True):
        assert solved(load)["mean_gap"].item() == pytest.approx(target, rel=1e-3)


def test_the_gap_closes_at_the_load_and_not_before():
    loads = target_loads(ROUGH, contact_modulus=1.0, target="percolation")
    assert 1 <= len(loads) <= 2
    for axis, load in zip("xy", loads if len(loads) == 2 else loads * 2, strict=True):
        name = f"gap_percolates_{axis}"
        assert solved(load)[name].item() == 0
        assert solved(load * (1 - 3e-4))[name].item() == 1


def test_ridges_are_closed_across_at_once_and_along_at_full_contact(wave):
    (along,) = target_loads(wave, contact_modulus=MODULUS, target=["percolation"])
    assert along == pytest.approx(FULL, rel=1e-3)


def test_first_yield_below_the_surface():
    bodies = [{"poissons_ratio": 0.3, "yield_stress": 0.25}, {"poissons_ratio": 0.3, "yield_stress": 0.5}]
    (load,) = target_loads(ROUGH, contact_modulus=1.0, target="first_yield", bodies=bodies)
    pressure = rc.solve_contact(ROUGH, contact_modulus=1.0, mean_pressure=load)["pressure"].values[0]
    columns = stress_columns(pressure, (1 / 64, 1 / 64), poissons_ratio=0.3)
    assert columns["max_von_mises_stress"] == pytest.approx(0.25, rel=2e-3)


def test_first_yield_of_a_wave_by_its_hardness(wave):
    """The largest pressure is 2 √(p̄ p*)."""
    (load,) = target_loads(wave, contact_modulus=MODULUS, target="first_yield", hardness=0.6 * FULL)
    assert load / FULL == pytest.approx(0.09, rel=5e-3)


def test_a_hardness_limits_the_pressure_on_the_way():
    (load,) = target_loads(ROUGH, contact_modulus=1.0, target_area=0.6, hardness=0.4)
    assert solved(load, hardness=0.4)["relative_contact_area"].item() == pytest.approx(0.6, rel=4e-3)
    assert load < 0.4


def test_units_do_not_matter():
    (reference,) = target_loads(ROUGH, contact_modulus=1.0, target_area=0.3)
    small = height_map(1e-6 * ROUGH.values, 1e-6 / 64)
    (load,) = target_loads(small, contact_modulus=1e11, target_area=0.3)
    assert load / 1e11 == pytest.approx(reference, rel=1e-6)


@pytest.mark.cases
def test_targets_that_no_load_reaches(targets, words):
    with pytest.raises(rc.SettingsError, match=words):
        target_loads(ROUGH, contact_modulus=1.0, **targets)


def test_a_flat_map_has_no_load_to_find():
    with pytest.raises(rc.HeightMapError, match="leave target, target_area and target_gap out"):
        target_loads(height_map(np.zeros((8, 8)), 1e-6), contact_modulus=1e9, target_area=0.5)


def test_loads_of_the_settings():
    def loads_of(**contact):
        settings = resolve({"contact": {"contact_modulus": 1e9} | contact})[""]["contact"]
        return wanted_loads(height_map(1e-6 * ROUGH.values, 1e-6 / 64), settings)

    assert len(loads_of()) == 8
    (load,) = loads_of(target_area=0.3)
    loads = loads_of(mean_pressure=["2 MPa"], target_area=0.3)
    assert loads == [2e6, load]
    assert len(loads_of(target_area=[0.1, 0.3], target="percolation")) >= 3
    assert not percolates(np.zeros((2, 2), bool))[0]


def test_a_gap_that_is_closed_at_any_load_is_said_to_be_so():
    """A plateau with a pit: no path leads around the period from the first touch on."""
    heights = np.zeros((16, 16))
    heights[4:7, 5:9] = -1e-6
    settings = {"contact_modulus": 1e9, "target": "percolation"}
    with pytest.raises(
        rc.SettingsError, match=r"^target: .* as soon as the surfaces touch.* give mean_pressure"
    ):
        wanted_loads(height_map(heights, 1e-6), settings)
    assert wanted_loads(height_map(heights, 1e-6), settings | {"mean_pressure": [1e5]}) == [1e5]


def test_first_yield_in_the_settings_needs_a_limit():
    with pytest.raises(rc.SettingsError, match="first_yield needs the yield_stress of a body"):
        resolve({"contact": {"contact_modulus": 1e9, "target": "first_yield"}})
    assert resolve({"contact": {"contact_modulus": 1e9, "hardness": "2 GPa", "target": "first_yield"}})


def test_the_load_of_first_yield_stands_before_those_at_which_the_gap_closes():
    """Of the latter there are one or two, and placements of two faces are joined load by load."""
    names, bodies = ["percolation", "first_yield"], {"contact_modulus": 1.0, "hardness": 1.0}
    loads, loads_reversed = (target_loads(ROUGH, target=order, **bodies) for order in (names, names[::-1]))
    assert loads == loads_reversed
    assert loads[0] == target_loads(ROUGH, target="first_yield", **bodies)[0]
