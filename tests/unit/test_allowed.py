"""What is allowed of a seal, a joint and a pressure: where it holds, from which load on, and the totals."""

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine

from roughcontact import evaluate
from roughcontact.arguments.answers import ALLOWED_VALUES, TOTALS
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.arguments.variables import VARIABLES
from roughcontact.report.allowed import allowed_in_words
from roughcontact.report.glance import answer_line, glance_rows
from roughcontact.statistics.allowed import compare, compared_ends, with_allowed
from roughcontact.statistics.decisions import gap_is_closed

LOADS = np.array([1.0, 2.0, 4.0, 8.0])


def power_law(exponent, factor=2.0):
    """Return a number that is 1 at a load of 3, and both ends of its interval."""
    value = (LOADS / 3) ** exponent
    return value, value / factor, value * factor


def test_a_power_law_holds_from_the_load_of_its_closed_form():
    """With (p/3)^-2, known to a factor 2, the ends pass 1 at 3/√2 and 3√2."""
    holds, bounds = compare(LOADS, power_law(-2.0), allowed=1.0)
    np.testing.assert_array_equal(holds, [0, 0, np.nan, 1])
    np.testing.assert_allclose(bounds, [3.0, 3 / 2**0.5, 3 * 2**0.5])


def test_a_number_that_rises_holds_up_to_a_load():
    holds, bounds = compare(LOADS, power_law(2.0), allowed=1.0, trend=1)
    np.testing.assert_array_equal(holds, [1, 1, np.nan, 0])
    np.testing.assert_allclose(bounds, [3.0, 3 / 2**0.5, 3 * 2**0.5])


@pytest.mark.parametrize("trend", [-1, 1])
def test_bounds_hold_where_no_power_law_passes_through_two_loads(trend):
    """A leak falls faster and faster with the load: e^-p is e^-3 at 3, the power law from 1 to 10 at 1.7."""
    loads = np.array([1.0, 10.0])
    value = np.exp(trend * loads)
    _, (_, lower, upper) = compare(
        loads, (value, 0.99 * value, 1.01 * value), allowed=np.exp(3 * trend), trend=trend
    )
    assert lower < 3 < upper


@pytest.mark.parametrize(
    ("trend", "allowed", "expected"),
    [
        (-1, 1e3, (1.0, 0.0, 1.0)),  # at all loads: perhaps at lighter ones, too
        (-1, 1e-3, (np.nan, 8.0, np.nan)),  # at none: at heavier ones, if at all
        (1, 1e3, (8.0, 8.0, np.nan)),
        (1, 1e-3, (np.nan, 0.0, 1.0)),
    ],
)
def test_beyond_the_loads_the_bounds_are_what_the_loads_prove(trend, allowed, expected):
    holds, bounds = compare(LOADS, power_law(2.0 * trend), allowed=allowed, trend=trend)
    np.testing.assert_array_equal(holds, float(allowed > 1))
    np.testing.assert_array_equal(bounds, expected)


@pytest.mark.parametrize("index", range(4))
def test_a_load_without_a_number_has_what_the_others_decide(index):
    """As a leak that was not found at one of four loads, all of which hold."""
    loads, leak = np.array([1.0, 2.0, 4.0, 8.0]), np.array([4e-2, 2e-2, 1e-2, 5e-3])
    leak[index] = np.nan
    holds, (from_load, lower, upper) = compare(loads, (leak, leak / 2, leak * 2), allowed=1.0)
    first = 2.0 if index == 0 else 1.0
    assert (from_load, lower, upper) == (first, 0.0, first)
    np.testing.assert_array_equal(holds, [np.nan if index == 0 else 1.0, 1.0, 1.0, 1.0])


def test_ends_that_are_not_known_bound_nothing_and_a_closed_gap_bounds_the_load():
    nan = np.full(4, np.nan)
    holds, bounds = compare(LOADS, (power_law(-2.0)[0], nan, nan), allowed=1.0)
    assert np.isnan(holds).all()
    np.testing.assert_allclose(bounds, [3.0, 0.0, np.nan])
    closes = np.array([4.0, 2.0, 0.0, 0.0])
    holds, bounds = compare(LOADS, (closes, closes, closes), allowed=1.0)
    np.testing.assert_allclose(bounds, [4.0, 2.0, 4.0])  # between them no power law is


def test_what_one_load_decides_heavier_and_lighter_ones_share():
    """In 200 random results no load that is heavier than one that holds does not, in any order of loads."""
    random = np.random.default_rng(5)
    for _ in range(200):
        loads = random.permutation(np.geomspace(1, 100, 6))
        value = random.lognormal(size=6)
        ends = value / random.uniform(1, 3, 6), value * random.uniform(1, 3, 6)
        trend = random.choice([-1, 1])
        holds = compare(loads, (value, *ends), allowed=1.0, trend=trend)[0][np.argsort(-trend * loads)]
        decided = holds[~np.isnan(holds)]
        assert (np.diff(decided) >= 0).all()


def test_each_allowed_value_and_each_total_has_names_that_the_statistics_know():
    for allowed in ALLOWED_VALUES.values():
        assert all(number in VARIABLES for number in allowed.numbers)
    assert all(total in VARIABLES for total in TOTALS)


def joint(end, resistance):
    return {
        f"electrical_resistance{end}": ("load", resistance),
        f"thermal_resistance{end}": ("load", resistance),
    }


def test_the_totals_of_a_joint_are_ohms_law_and_fouriers():
    """1e-9 Ω m² on 4 mm² are 0.25 mΩ; 1e-5 m² K/W on 4 mm² under 5 W are 12.5 K."""
    statistics = xr.Dataset(
        joint("", [1e-9]) | {"thermal_resistance": ("load", [1e-5])}, {"mean_pressure": ("load", [1e6])}
    )
    found = with_allowed(statistics, {"joint": {"area": 4e-6, "heat_flow": 5.0}})
    assert found["total_electrical_resistance"].item() == pytest.approx(0.25e-3)
    assert found["total_thermal_resistance"].item() == pytest.approx(2.5)
    assert found["temperature_drop"].item() == pytest.approx(12.5)
    assert found["total_force"].item() == pytest.approx(4.0)
    assert found["joint_area"].item() == 4e-6  # by which the resistance is what is asked for
    by_contact = with_allowed(statistics, {"joint": None}, area=4e-6)
    assert "joint_area" not in by_contact
    assert by_contact["total_electrical_resistance"].item() == pytest.approx(0.25e-3)


def test_gas_and_film_are_in_the_totals_and_in_their_ends():
    conductance = {
        f"joint_conductance{end}": ("load", [value]) for end, value in (("", 2e4), ("_lower", 1e4))
    }
    statistics = xr.Dataset(conductance | joint("", [1.0]), {"mean_pressure": ("load", [1e6])})
    found = with_allowed(statistics, {"joint": {"area": 1e-4}})
    assert found["total_thermal_resistance"].item() == pytest.approx(0.5)
    assert found["total_thermal_resistance_upper"].item() == pytest.approx(1.0)
    assert "total_thermal_resistance_lower" not in found
    open_above = statistics.assign(joint_conductance_upper=("load", [np.nan]))
    assert with_allowed(open_above, {"joint": {"area": 1e-4}})["total_thermal_resistance_lower"].item() == 0


@pytest.fixture(scope="module")
def rubber():
    """Return a rubber seal on a rough steel seat under two loads."""

    seat = self_affine((64, 64), (1e-6, 1e-6), (8e-6, 3.2e-5), rms_height=5e-7)
    seal = {"viscosity": "1 mPa s", "pressure_difference": "0.5 bar", "width": "3 mm"}
    return evaluate(
        seat,
        contact={"bodies": ["NBR", "steel"], "mean_pressure": ["60 kPa", "1 MPa"]},
        statistics={
            "seal": seal | {"perimeter": "120 mm", "allowed_leak": "0.1 ml/h"},
            "allowed_pressure": "1 GPa",
        },
    )


def test_a_seal_says_in_all_files_whether_and_from_which_load_on_it_holds(rubber, tmp_path):
    from roughcontact import table

    np.testing.assert_allclose(rubber["total_leak_rate_x"], 0.12 * rubber["leak_rate_x"])
    assert rubber["leak_holds"].values[1] == rubber["pressure_holds"].values[0] == 1
    assert rubber["leak_holds_from"].attrs["units"] == "Pa"
    frame = table(rubber)
    assert {"leak_holds", "leak_holds_from_Pa", "leak_holds_from_upper_Pa", "allowed_leak_m3_per_s"} <= {
        *frame
    }
    assert str(allowed_in_words(rubber, "leak", 1)).startswith("leak of at most 0.100 ml/h: holds, ")
    assert str(allowed_in_words(rubber, "pressure", 1)).endswith("holds, up to 1.00 MPa at least")


@pytest.fixture(scope="module")
def lifted():
    """Return a smooth rubber seal, which would be tight, under loads below and above its fluid."""
    seal = {"viscosity": "1 mPa s", "pressure_difference": "5 bar", "width": "3 mm", "perimeter": "120 mm"}
    return evaluate(
        self_affine((64, 64), (1e-6, 1e-6), (8e-6, 3.2e-5), rms_height=5e-9),
        contact={"bodies": ["NBR", "steel"], "mean_pressure": ["2 MPa", "0.2 MPa"]},
        statistics={"seal": seal | {"allowed_leak": "1 ml/h"}, "requirement": {"gap": "1 um"}},
    )


@pytest.mark.parametrize("name", ALLOWED_VALUES)
def test_what_must_not_fall_below_its_limit_is_compared_by_its_reciprocal(name):
    """The ends of a reciprocal change places."""
    allowed = ALLOWED_VALUES[name]
    ends = dict(zip(("", "_lower", "_upper"), (4.0, 2.0, 5.0), strict=True))
    numbers = {f"{allowed.numbers[0]}{end}": ("load", [number]) for end, number in ends.items()}
    expected = [4, 2, 5] if allowed.sense > 0 else [1 / 4, 1 / 5, 1 / 2]
    np.testing.assert_array_equal(compared_ends(xr.Dataset(numbers), name)[:, 0], expected)


def test_what_a_fluid_lifts_does_not_hold_in_files_and_words(lifted):
    """Handbooks of seals: below the pressure of the fluid the bodies part, however closed the gap was."""
    np.testing.assert_array_equal(lifted["leak_holds"], [1, 0])
    assert lifted["leak_holds_from"] == lifted["leak_holds_from_lower"] == lifted["fluid_pressure"] == 5e5
    assert lifted["leak_holds_from_upper"] <= 2e6
    np.testing.assert_array_equal(gap_is_closed(lifted, "x"), [1, 0])
    np.testing.assert_array_equal(lifted["sealing_known"], [0, 0])  # decided
    assert lifted["leak_rate_x_lower"].notnull().all()
    np.testing.assert_array_equal(lifted["total_leak_rate_x_upper"].isnull(), [False, True])
    words = "does not hold (the fluid, at 0.500 MPa, lifts the bodies)"
    assert (
        str(allowed_in_words(lifted, "leak", 1))
        == f"leak of at most 1.00 ml/h: {words}, would hold from 0.500 MPa on (0.500 MPa to 2.00 MPa)"
    )
    (row,) = glance_rows(lifted, indices=[1])
    cell = row["sealing"]
    assert (cell.text, cell.precision) == ("leaks", "decided")
    assert (
        cell.all_details == f"the fluid, at 0.500 MPa, lifts the bodies; leak of at most 1.00 ml/h: {words}"
    )


def test_a_load_below_that_of_the_fluid_is_no_load_from_which_on_it_holds():
    """All loads hold by the gap, and the lightest one is above the fluid: at the fluid's own it may."""
    ends = {f"total_leak_rate_x{suffix}": ("load", [0.0, 0.0]) for suffix in ("", "_lower", "_upper")}
    statistics = xr.Dataset(ends | {"fluid_pressure": 2e5}, {"mean_pressure": ("load", [1e6, 2e6])})
    found = with_allowed(statistics, {"seal": {"allowed_leak": 1e-10}})
    assert [found[f"leak_holds_from{end}"].item() for end in ("", "_lower", "_upper")] == [1e6, 2e5, 1e6]


@pytest.mark.parametrize(
    ("text", "value"), [("5 mΩ cm²", 5e-7), ("5 mOhm cm2", 5e-7), ("20 µΩ·cm²", 2e-9), ("3 mOhm mm2", 3e-9)]
)
def test_a_specific_contact_resistance_is_stated_as_those_of_fuel_cells_are(text, value):
    problem = {"contact": {"bodies": ["steel", "copper"], "mean_pressure": "1 MPa"}}
    (settings,) = resolve(problem | {"statistics": {"requirement": {"contact_resistance": text}}}).values()
    assert settings["statistics"]["requirement"]["contact_resistance"] == pytest.approx(value)


def test_a_profile_does_not_tell_whether_a_leak_holds():
    """Endless ridges block a gap, or let all of it through: of neither does a seal hold what it may leak."""
    profile = self_affine((64, 64), (1e-6, 1e-6), (8e-6, 3.2e-5), rms_height=5e-7)[:1]
    seal = {"viscosity": 1e-3, "pressure_difference": 1e4, "width": 3e-3}
    seal |= {"perimeter": 0.1, "allowed_leak": 3e-10}
    contact = {"bodies": ["NBR", "steel"], "mean_pressure": "100 kPa"}
    result = evaluate(profile, lay="across", contact=contact, statistics={"seal": seal})
    assert "leak_holds" not in result
    assert result.attrs["halved"] == "contact area"
    line = answer_line(result, 0, glance_rows(result)[0], alone=True)
    assert line == "At 100 kPa: sealing not judged (a profile does not tell)."


def numbers_of(holds, crossing, lower, upper):
    columns = {"mean_pressure": [1e6, 5e6], "leak_holds": [holds, holds]}
    ends = dict(zip(("", "_lower", "_upper"), (crossing, lower, upper), strict=True))
    return xr.Dataset(
        {name: ("load", values) for name, values in columns.items()}
        | {f"leak_holds_from{end}": value for end, value in ends.items()}
        | {"allowed_leak": 1 / 3.6e9, "contact_modulus": 1e11}
    )


@pytest.mark.parametrize(
    ("numbers", "text"),
    [
        ((1, 1.8e6, 1.2e6, 3.4e6), "holds, from 1.80 MPa on (1.20 MPa to 3.40 MPa)"),
        ((0, 1.8e6, 1.2e6, np.nan), "does not hold, would hold from 1.80 MPa on (at least 1.20 MPa)"),
        ((np.nan, 1.8e6, 0.0, 3.4e6), "not decided, would be from 1.80 MPa on (at most 3.40 MPa)"),
        (
            (np.nan, 1e6, 0.0, 3.4e6),
            "not decided, would be from 1.00 MPa or less on (decided from 3.40 MPa on)",
        ),
        ((0, np.nan, 5e6, np.nan), "does not hold, would hold beyond the loads solved (at least 5.00 MPa)"),
    ],
)
def test_the_answer_in_words(numbers, text):
    assert str(allowed_in_words(numbers_of(*numbers), "leak", 0)) == f"leak of at most 1.00 ml/h: {text}"


def test_the_leak_in_words_is_that_which_is_compared_where_the_smaller_one_is_known_less():
    """A gap along y that is closed for certain leaks next to nothing, more than one along x that is not."""
    numbers = numbers_of(np.nan, 5e6, 1e6, np.nan)
    per_hour = {"x": (1e-5, 0.0, 2.2), "y": (9e-5, 0.0, 3.6e-4)}
    for axis, ends in per_hour.items():
        for suffix, leak in zip(("", "_lower", "_upper"), ends, strict=True):
            numbers[f"total_leak_rate_{axis}{suffix}"] = "load", np.full(2, leak / 3.6e9)
    bounds = compared_ends(numbers, "leak") * 3.6e9
    np.testing.assert_allclose(bounds[:, 0], [9e-5, 0.0, 2.2])
    assert str(allowed_in_words(numbers, "leak", 0, brief=True)) == (
        "leak 9.0×10⁻⁵ (0 to 2.2) ml/h of at most 1.00 ml/h: not decided"
    )


def test_a_crossing_below_the_loads_solved_is_no_load_from_which_on_a_seal_holds():
    """The fluid bounds it from below, and the loads from above: what leaks nothing at any is not told."""
    numbers = numbers_of(np.nan, 1e6, 2e5, np.nan).assign(fluid_pressure=2e5)
    assert str(allowed_in_words(numbers, "leak", 0)).endswith(
        "not decided, would be from 1.00 MPa or less on"
    )


def test_a_number_that_holds_at_all_loads_says_up_to_which_one_for_certain():
    from_loads = {"": 5e6, "_lower": 3e6, "_upper": np.nan}
    numbers = xr.Dataset({f"pressure_holds_from{end}": load for end, load in from_loads.items()})
    numbers = numbers.assign(allowed_pressure=2e9, contact_modulus=1e11, pressure_holds=("load", [1, np.nan]))
    numbers = numbers.assign_coords(mean_pressure=("load", [1e6, 5e6]))
    assert str(allowed_in_words(numbers, "pressure", 1)).endswith(
        "not decided, would be up to 5.00 MPa at least (decided up to 3.00 MPa)"
    )
