"""Friction in the statistics: stick and slip, the coefficient from the area, flash temperatures."""

import json
import re

import numpy as np
import pytest
import yaml

import roughcontact as rc
from roughcontact.report.facts import number_facts
from roughcontact.report.glance import slip_in_words
from roughcontact.results.collect import Entry, collect_statistics
from roughcontact.surface.synthetic import rough_reference_surface

STEEL = {"youngs_modulus": 210e9, "poissons_ratio": 0.3, "thermal_conductivity": 50.0}
COPPER = {"youngs_modulus": 120e9, "poissons_ratio": 0.34, "thermal_conductivity": 400.0}
NO_SOURCES = {"sources": []}


def statistics_with(friction, **contact):
    chosen = {"bodies": [STEEL, COPPER], "relative_pressure": [0.05, 0.1]} | contact
    return rc.evaluate(
        rough_reference_surface(64), contact=chosen, statistics={"friction": friction}, uncertainty=NO_SOURCES
    )


def test_the_settings_add_the_friction_of_each_load(tmp_path):
    shares = [0.3, 0.6, 1.0]
    statistics = statistics_with({"coefficient": 0.2, "tangential_load": shares, "shear_strength": "200 MPa"})
    assert statistics["stick_share"].dims == ("load", "tangential_load")
    assert (np.diff(statistics["stick_share"].values) < 0).all()
    assert (statistics["stick_share"][:, -1] == 0).all(), "the whole contact slips"
    assert slip_in_words(statistics, 1).endswith("at Q = 0.600 μP, full slip.")
    # of the results of a run, too, unless cases differ in them
    files = [tmp_path / name for name in ("one.nc", "other.nc")]
    for file, loads in zip(files, (shares, [0.2, 0.4, 0.9]), strict=True):
        statistics.assign_coords(tangential_load=loads).to_netcdf(file)
    one, other = (Entry(surface="a", case=str(file), statistics=file) for file in files)
    np.testing.assert_array_equal(collect_statistics([one])["tangential_load"], shares)
    assert slip_in_words(collect_statistics([one, other]).isel(case=0, surface=0), 1) == ""
    area, load = statistics["relative_contact_area"].values, statistics["mean_pressure"].values
    np.testing.assert_allclose(statistics["friction_coefficient"].values, 2e8 * area / load)


def test_stick_costs_nothing_unasked():
    assert not {"stick_share", "friction_coefficient"} & set(statistics_with(None).variables)


def test_the_interval_of_friction_is_that_of_the_area():
    statistics = rc.evaluate(
        rough_reference_surface(64),
        contact={"contact_modulus": 1e9, "relative_pressure": 0.1},
        statistics={"friction": {"shear_strength": 1e6}},
        uncertainty={"sources": ["solver", "discretisation"]},  # which corrects the area
    )
    assert (statistics["relative_contact_area"] != statistics["relative_contact_area_as_solved"]).all()
    for suffix in ("", "_lower", "_upper"):
        expected = 1e6 * statistics[f"relative_contact_area{suffix}"] / statistics["mean_pressure"]
        np.testing.assert_allclose(statistics[f"friction_coefficient{suffix}"].values, expected.values)


@pytest.mark.cases
def test_impossible_friction_is_refused(friction, text):
    with pytest.raises(rc.SettingsError, match=text):
        statistics_with(friction)


def test_sliding_needs_both_conductivities():
    with pytest.raises(rc.SettingsError, match="thermal_conductivity of both bodies"):
        statistics_with(
            {"coefficient": 0.2, "speed": 1.0}, bodies=[{"youngs_modulus": 1e9, "poissons_ratio": 0.3}] * 2
        )


def test_sliding_on_layers_is_refused():
    layer = {"thickness": 2e-5, "youngs_modulus": 3e9, "poissons_ratio": 0.4, "thermal_conductivity": 0.2}
    bodies, sliding = [STEEL | {"layers": [layer]}, STEEL], {"coefficient": 0.2, "speed": 1.0}
    with pytest.raises(rc.SettingsError, match=r"friction\.speed = 1\.0: .* without layers"):
        statistics_with(sliding, bodies=bodies)
    contact = rc.solve_contact(rough_reference_surface(64), bodies=bodies, mean_pressure=1e7)
    with pytest.raises(rc.SettingsError, match="without layers"):
        rc.contact_statistics(contact, friction=sliding, bodies=bodies)


@pytest.mark.cases
def test_friction_in_a_wrong_unit_is_doubted(friction, text):
    statistics = statistics_with(friction, relative_pressure=0.1)
    doubts = {reason["check"]: reason["text"] for reason in json.loads(statistics.attrs["reasons"])}
    assert text in doubts.get("Units", "")
    assert bool(text) == ("Units" in doubts)


def test_flash_temperatures_are_proportional_to_a_slow_speed():
    slow, fast = (statistics_with({"coefficient": 0.2, "speed": speed}) for speed in (0.1, 1.0))
    for name in ("mean_flash_temperature", "max_flash_temperature"):
        np.testing.assert_allclose(fast[name].values, 10 * slow[name].values)
        assert (slow[name] > 0).all()


@pytest.mark.parametrize("options", [{}, {"coefficient": 0.2}])
def test_sliding_of_a_shear_strength_heats_by_the_corrected_area(options):
    friction = {"shear_strength": "10 MPa", "speed": "1 m/s"} | options
    statistics = rc.evaluate(
        rough_reference_surface(64),
        contact={"bodies": [STEEL, COPPER], "relative_pressure": 0.1},
        statistics={"friction": friction},
        uncertainty={"sources": ["solver", "discretisation"]},  # which corrects the area
    )
    unit = statistics_with({"coefficient": 1.0, "speed": "1 m/s"}, relative_pressure=0.1)
    coefficient = options.get("coefficient", statistics["friction_coefficient"].values)
    for name in ("mean_flash_temperature", "max_flash_temperature"):
        np.testing.assert_allclose(statistics[name].values, coefficient * unit[name].values, rtol=1e-6)
    friction = "of the stated coefficient" if options else "by the shear strength"
    assert number_facts(statistics)["Flash temperature"] == f"from the heat of the friction {friction}"


def test_stick_and_slip_of_bodies_that_flow_are_refused_before_the_solve():
    wanted = {"coefficient": 0.2, "tangential_load": 0.5}
    with pytest.raises(rc.SettingsError, match="are of elastic bodies") as caught:
        statistics_with(wanted, bodies=["steel", "copper"])
    elastic = yaml.safe_load(re.search(r"\{.*\}", str(caught.value))[0])  # as the sentence says
    assert "stick_share" in statistics_with(wanted, bodies=[elastic, elastic])


def test_stick_and_slip_of_coated_bodies_are_refused_before_the_solve():
    film = {"thickness": 2e-6, "youngs_modulus": 3e9, "poissons_ratio": 0.3}
    steel, coated = (
        {"youngs_modulus": 1e9, "poissons_ratio": 0.3} | coating for coating in ({}, {"layers": [film]})
    )
    with pytest.raises(rc.SettingsError, match="those of half-spaces, without layers"):
        statistics_with({"coefficient": 0.2, "tangential_load": 0.5}, bodies=[coated, steel])
