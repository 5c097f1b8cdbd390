"""The largest roughness that meets a requirement: by the laws of elastic bodies, and solved again."""

import numpy as np
import pytest
from known_surfaces import self_affine

import roughcontact as rc
from roughcontact import SettingsError
from roughcontact.evaluation.requirement import with_largest_roughness
from roughcontact.report.allowed import allowed_in_words
from roughcontact.statistics.allowed import with_allowed

BODIES = [{"youngs_modulus": "2 GPa", "poissons_ratio": 0.4, "thermal_conductivity": 0.25}] * 2
LOAD = 2e7
# what is required -> its number, the power of the factor on elastic heights at the load over the factor, and
# the tolerance
NUMBERS = {
    "gap": ("mean_gap", 1, 0.005),
    "contact_area": ("relative_contact_area", 0, 0.01),
    "thermal_resistance": ("thermal_resistance", 0, 0.02),
}


def rough(seed, points=32):
    shortest = 4e-6 if points < 64 else 8e-6
    return self_affine((points, points), 1.5e-6, (shortest, 40e-6), rms_height=3e-7, seed=seed)


def evaluated(height, *, load=LOAD, bodies=BODIES, sources=(), **statistics):
    options = {"uncertainty": {"sources": list(sources)}, "statistics": statistics}
    return rc.evaluate(height, bodies=bodies, mean_pressure=np.ravel(load).tolist(), **options)


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("seed", range(5))
def test_heights_of_the_largest_roughness_just_meet_the_requirement(seed, name):
    variable, power, tolerance = NUMBERS[name]
    factor = np.geomspace(0.5, 2, 5)[seed]
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


SEAL = {"viscosity": "1 mPa s", "pressure_difference": "1 bar", "width": "2 mm", "perimeter": "100 mm"}
CURVE = {  # what is required -> its number, and how well that of scaled heights is to meet it
    "gap": ("mean_gap", 0.005),
    "contact_area": ("relative_contact_area", 0.01),
    "thermal_resistance": ("thermal_resistance", 0.02),
    "leak": ("total_leak_rate_x", 0.03),
}


@pytest.mark.parametrize(
    "seed", [4, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 1, 2, 3, 5, 6, 7, 8, 9))]
)
def test_close_loads_tell_the_largest_roughness_without_a_solution(seed):
    """Heights 0.5 to 2 times as large: what they need by the curve of the map as it is, solved again."""
    rng = np.random.default_rng(seed)
    gradient, hurst = float(10 ** rng.uniform(-1.5, -1)), rng.uniform(0.5, 0.9)
    height = self_affine((128, 128), 1e-6, (8e-6, 64e-6), rms_gradient=gradient, hurst=hurst, seed=seed)
    load, factor = 5e7 * gradient, np.geomspace(0.5, 2, 10)[seed]
    asked = {"seal": SEAL} if seed in (0, 5, 9) else {}
    curve = evaluated(height, load=load * 1.3 ** np.arange(-3.0, 4.0), **asked)

    def of_scaled(factor, names):
        scaled = evaluated(height * factor, load=load, **asked)
        return {name: max(float(scaled[each][0]) for each in each_of) for name, each_of in names.items()}

    names = {key: {name, name.replace("rate_x", "rate_y")} for key, (name, _) in CURVE.items()}
    names = {key: each for key, each in names.items() if asked or key != "leak"}
    for name, wanted in of_scaled(factor, names).items():
        settings = {"requirement": {name: wanted}, "seal": {"perimeter": 0.1}}
        stated = with_allowed(curve, settings)

        def elsewhere(_, at, stated=stated):
            assert at != pytest.approx(load)
            return stated.isel(load=[3])

        found = with_largest_roughness(stated, settings, elsewhere, linear=True)
        again = of_scaled(float(found[f"{name}_largest_Sq"][3] / found["Sq"]), {name: names[name]})
        assert again[name] == pytest.approx(wanted, rel=CURVE[name][1]), name


def test_an_allowed_value_elsewhere_is_no_requirement():
    found = evaluated(rough(0), allowed_pressure="10 GPa", requirement={"gap": "<= 1 um"})
    assert "pressure_holds" in found
    assert [name for name in found if str(name).endswith("_largest_Sq")] == ["gap_largest_Sq"]


HARD = [{**BODIES[0], "hardness": "0.15 GPa"}] * 2


@pytest.mark.parametrize("load", [LOAD, [0.5 * LOAD, LOAD, 2 * LOAD]])
def test_with_a_hardness_it_is_the_factor_of_a_bisection(load):
    """Where a hardness stays the curve of other loads does not tell, close as they may be."""
    height, index = rough(1), np.size(load) // 2

    def area(factor):
        return float(evaluated(height * factor, bodies=HARD)["relative_contact_area"][0])

    required = 0.8 * area(1.0)
    found = evaluated(height, load=load, bodies=HARD, requirement={"contact_area": required})
    factor = float(found["contact_area_largest_Sq"][index] / found["Sq"])
    low, high = 0.5, 2.0
    while high / low > 1.001:
        middle = np.sqrt(low * high)
        low, high = (middle, high) if area(middle) > required else (low, middle)
    assert 1.05 < factor == pytest.approx(low, rel=0.004)


def test_layers_have_the_law_of_the_curve():
    """Displacements of layers are in proportion to the pressure, too: curve and search agree."""
    layer = {"thickness": "1 um", "youngs_modulus": "8 GPa", "poissons_ratio": 0.3}
    plain = {"youngs_modulus": "2 GPa", "poissons_ratio": 0.4}
    bodies, asked = [plain | {"layers": [layer]}, plain], {"gap": "0.55 um", "pressure": "0.6 GPa"}
    by_curve = evaluated(rough(4), load=LOAD * 1.3 ** np.arange(-3.0, 4.0), bodies=bodies, requirement=asked)
    solved = evaluated(rough(4), bodies=bodies, requirement=asked)
    for name in asked:
        key = f"{name}_largest_Sq"
        assert float(by_curve[key][3]) == pytest.approx(float(solved[key][0]), rel=0.01), name


def test_a_gas_is_solved_for_as_its_temperature_jump_stays():
    gas = {"joint": {"gas_conductivity": 0.026, "temperature_jump": "0.37 um"}}
    height, limit = rough(5, points=96), {"thermal_resistance": 2e-6}
    loads = LOAD * 1.3 ** np.arange(-1.0, 2.0)
    by_curve = evaluated(height, load=loads, requirement=limit, **gas)
    factor = float(by_curve["thermal_resistance_largest_Sq"][1] / by_curve["Sq"])
    again = evaluated(height * factor, requirement=limit, **gas)
    assert float(again["joint_resistance"][0]) == pytest.approx(2e-6, rel=0.01)


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
    assert "of this texture with its S- and L-filter" in str(allowed_in_words(found, "gap", 0))
    assert found["gap_holds"].dims == ("load",)


@pytest.mark.slow
def test_close_loads_have_the_ends_of_their_own():
    """The ± of the map at p/s is that of heights s times as large at p, to a twentieth of its width.

    Both are of few loads each, and extended to the others.
    """
    sources, loads = ["window", "discretisation"], LOAD * 1.35 ** np.arange(-4.0, 5.0)
    height, limit = 2 * rough(2, points=96), 9e-7
    found = evaluated(height, load=loads, sources=sources, requirement={"gap": limit})
    for end, opposite in (("_lower", "_upper"), ("_upper", "_lower")):
        factor = float(found[f"gap_largest_Sq{end}"][4] / found["Sq"])
        scaled = evaluated(height * factor, sources=sources)
        width = float(scaled["mean_gap_upper"][0] - scaled["mean_gap_lower"][0])
        assert float(scaled[f"mean_gap{opposite}"][0]) == pytest.approx(limit, abs=width / 20)


@pytest.mark.cases
def test_a_requirement_that_says_nothing_is_refused(requirement, message):
    with pytest.raises(SettingsError, match=message):
        evaluated(rough(0), requirement=requirement)


def test_units_are_those_of_people():
    found = evaluated(rough(0), requirement={"thermal_resistance": "≤ 2 mm² K/W", "contact_area": ">= 0.01"})
    assert float(found["allowed_thermal_resistance"]) == pytest.approx(2e-6)
    assert float(found["allowed_contact_area"]) == 0.01
