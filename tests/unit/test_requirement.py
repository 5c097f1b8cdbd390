"""The largest roughness that meets a requirement: by the laws of elastic bodies, and solved again."""

import numpy as np
import pytest
from known_surfaces import self_affine

import roughcontact as rc
from roughcontact import SettingsError
from roughcontact.report.allowed import allowed_in_words

BODIES = [{"youngs_modulus": "2 GPa", "poissons_ratio": 0.4, "thermal_conductivity": 0.25}] * 2
LOAD = 2e7
# what is required -> its number, the power of the factor on elastic heights at the load over the factor, and
# the tolerance
NUMBERS = {
    "gap": ("mean_gap", 1, 0.005),
    "contact_area": ("relative_contact_area", 0, 0.01),
    "thermal_resistance": ("thermal_resistance", 0, 0.02),
}


def rough(seed):
    return self_affine((32, 32), 1.5e-6, (4e-6, 40e-6), rms_height=3e-7, seed=seed)


def evaluated(height, *, load=LOAD, bodies=BODIES, sources=(), **statistics):
    options = {"uncertainty": {"sources": list(sources)}, "statistics": statistics}
    return rc.evaluate(height, bodies=bodies, mean_pressure=[load], **options)


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("seed", range(10))
def test_heights_of_the_largest_roughness_just_meet_the_requirement(seed, name):
    variable, power, tolerance = NUMBERS[name]
    factor = np.geomspace(0.5, 2, 10)[seed]
    height = rough(seed)
    # elastic: heights s times as large at p are these at p/s (Johnson 1985, by the scales of the problem)
    wanted = factor**power * float(evaluated(height, load=LOAD / factor)[variable][0])
    found = evaluated(height, requirement={name: wanted})
    assert float(found[f"{name}_largest_Sq"][0] / found["Sq"]) == pytest.approx(factor, rel=tolerance)
    scaled = evaluated(height * float(found[f"{name}_largest_Sq"][0] / found["Sq"]))
    assert float(scaled[variable][0]) == pytest.approx(wanted, rel=tolerance)


def test_a_leak_of_the_largest_roughness_is_what_is_allowed():
    seal = {"viscosity": "1 mPa s", "pressure_difference": "1 bar", "width": "2 mm", "perimeter": "100 mm"}
    height, options = rough(3), {"seal": seal, "load": 4e6}
    leak = evaluated(height, **options)
    largest = max(float(leak[f"total_leak_rate_{axis}"][0]) for axis in "xy")
    found = evaluated(height, requirement={"leak": 3 * largest}, **options)
    factor = float(found["leak_largest_Sq"][0] / found["Sq"])
    assert 1.1 < factor < 3 ** (1 / 3) * 1.01  # at equal gap factors leaks rise by the cube
    scaled = evaluated(height * factor, **options)
    assert max(float(scaled[f"total_leak_rate_{axis}"][0]) for axis in "xy") == pytest.approx(
        3 * largest, rel=0.03
    )


def test_an_allowed_value_elsewhere_is_no_requirement():
    found = evaluated(rough(0), allowed_pressure="10 GPa", requirement={"gap": "<= 1 um"})
    assert "pressure_holds" in found
    assert [name for name in found if str(name).endswith("_largest_Sq")] == ["gap_largest_Sq"]


def test_with_a_hardness_the_heights_solved_again_meet_the_requirement():
    hard = [{**BODIES[0], "hardness": "0.15 GPa"}] * 2
    height = rough(1)
    required = 0.8 * float(evaluated(height, bodies=hard)["relative_contact_area"][0])
    found = evaluated(height, bodies=hard, requirement={"contact_area": required})
    factor = float(found["contact_area_largest_Sq"][0] / found["Sq"])
    assert factor > 1.05
    scaled = evaluated(height * factor, bodies=hard)
    assert float(scaled["relative_contact_area"][0]) == pytest.approx(required, rel=0.01)


def test_the_interval_of_the_number_is_that_of_the_roughness():
    height = rough(2)
    found = evaluated(height, sources=["window", "discretisation"], requirement={"gap": "<= 0.6 um"})
    lower, value, upper = (float(found[f"gap_largest_Sq{end}"][0]) for end in ("_lower", "", "_upper"))
    assert lower < value < upper
    # the number is as well known, in proportion, where it is what is allowed
    for sq, end in ((lower, "_upper"), (upper, "_lower")):
        scaled = evaluated(height * (sq / float(found["Sq"])))
        share = float(found[f"mean_gap{end}"][0] / found["mean_gap_as_solved"][0])
        assert float(scaled["mean_gap"][0]) * share == pytest.approx(0.6e-6, rel=0.01)
    assert "of this texture" in allowed_in_words(found, "gap", 0)
    assert found["gap_holds"].dims == ("load",)


@pytest.mark.parametrize(
    ("requirement", "message"),
    [
        ({"gap": ">= 1 um"}, r"requirement.gap = '>= 1 um': is a limit of the other side; write <= 1 um"),
        ({"contact_area": "<= 0.2"}, r"requirement.contact_area = '<= 0.2': is a limit of the other side"),
        ({"gap": "<= 1 MPa"}, r"requirement.gap = .*unknown length unit 'MPa'"),
        ({"leak": "<= 1 ml/h"}, "requirement.leak: needs the perimeter of the seal"),
        ({"contact_resistance": "10 uOhm mm2"}, "requirement.contact_resistance: needs the electrical"),
    ],
)
def test_a_requirement_that_says_nothing_is_refused(requirement, message):
    with pytest.raises(SettingsError, match=message):
        evaluated(rough(0), requirement=requirement)


def test_units_are_those_of_people():
    found = evaluated(rough(0), requirement={"thermal_resistance": "≤ 2 mm² K/W", "contact_area": ">= 0.01"})
    assert float(found["allowed_thermal_resistance"]) == pytest.approx(2e-6)
    assert float(found["allowed_contact_area"]) == 0.01
