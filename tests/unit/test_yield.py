"""What the material bears: shares beyond a hardness, first yield and the checks, against closed forms."""

import json

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine

import roughcontact as rc
from roughcontact import contact_statistics, first_yield_pressure, height_map
from roughcontact.arguments import materials
from roughcontact.contact.loads import plan_loads
from roughcontact.statistics import checks, contact_checks
from roughcontact.statistics.outcome import (
    FAILED,
    NOT_MADE,
    NOTE,
    PASSED,
    REVIEW,
    VERDICTS,
    Check,
    not_passed,
    worst_result,
)
from roughcontact.statistics.targets import add_first_yield
from roughcontact.surface.synthetic import westergaard_surface
from validation import closed_forms

MODULUS = 1e11
RADIUS, PERIOD, POINTS = 10.0, 1.0, 256  # m


def paraboloid():
    """Return a sphere per square period, as a paraboloid."""
    x = (np.arange(POINTS) + 0.5) / POINTS - 0.5
    return height_map(-(x[None, :] ** 2 + x[:, None] ** 2) / (2 * RADIUS), PERIOD / POINTS)


def hertz_load(hardness):
    """Return the mean pressure at which p0 = H under a single sphere: F = π³R²H³/(6E*²) (Johnson 1985)."""
    return np.pi**3 * RADIUS**2 * hardness**3 / (6 * MODULUS**2) / PERIOD**2


def rough(points=96):
    return self_affine((points, points), 1e-6, (8e-6, 48e-6), rms_gradient=0.03, seed=3)


def test_shares_of_load_and_area_beyond_a_hardness_under_a_sphere():
    """p = p0 √(1 - r²/a²): above H lie 1 - (H/p0)² of the area and 1 - (H/p0)³ of the load."""
    target = 0.0201 * MODULUS
    window = paraboloid()
    contact = rc.solve_contact(
        window, contact_modulus=MODULUS, mean_pressure=hertz_load(target), tolerance=1e-6
    )
    statistics = contact_statistics(contact).isel(load=0)
    peak = closed_forms.periodic_hertz(hertz_load(target), RADIUS, MODULUS, PERIOD)["max_pressure"]
    assert float(statistics["max_pressure_over_modulus"]) == pytest.approx(peak / MODULUS, rel=5e-3)
    for ratio, load, area in zip(
        statistics["hardness_over_modulus"].values,
        statistics["load_share_above_ratio"].values,
        statistics["area_share_above_ratio"].values,
        strict=True,
    ):
        below = min(ratio * MODULUS / peak, 1.0)
        assert load == pytest.approx(1 - below**3, abs=0.02)
        assert area == pytest.approx(1 - below**2, abs=0.02)
    assert "hardness" not in statistics
    assert "load_share_above_hardness" not in statistics


def test_all_of_the_load_that_flows_carries_the_hardness():
    window, hardness = rough(), 0.008 * MODULUS
    loads = [0.002 * MODULUS * 0.03, 0.1 * MODULUS * 0.03, 0.2 * MODULUS * 0.03]
    contact = rc.solve_contact(window, contact_modulus=MODULUS, mean_pressure=loads, hardness=hardness)
    statistics = contact_statistics(contact)
    assert float(statistics["hardness"]) == hardness
    pressure = contact["pressure"].values
    flowing = pressure > hardness * (1 - 1e-9)
    np.testing.assert_allclose(
        statistics["area_share_above_hardness"], flowing.sum((1, 2)) / (pressure > 0).sum((1, 2)), rtol=1e-12
    )
    np.testing.assert_allclose(
        statistics["load_share_above_hardness"] * statistics["mean_pressure"],
        hardness * statistics["yielded_area"],
        rtol=1e-9,
    )
    assert (statistics["area_share_above_hardness"] > 0).any()
    assert (np.diff(statistics["yielded_area"]) > 0).all()
    assert float(statistics["max_pressure_over_modulus"].max()) == pytest.approx(0.008, rel=1e-12)
    assert "load_share_above_ratio" not in statistics


def test_a_hardness_out_of_reach_leaves_nothing_beyond_it():
    contact = rc.solve_contact(rough(), contact_modulus=MODULUS, mean_pressure=1e7, hardness=0.5 * MODULUS)
    statistics = contact_statistics(contact).isel(load=0)
    assert (
        float(statistics["load_share_above_hardness"]) == float(statistics["area_share_above_hardness"]) == 0
    )


def test_first_yield_under_a_sphere():
    hardness = 0.006 * MODULUS
    load = first_yield_pressure(paraboloid(), contact_modulus=MODULUS, hardness=hardness)
    # the others of the lattice take a few thousandths off the load
    assert load == pytest.approx(hertz_load(hardness), rel=0.01)
    peak = closed_forms.periodic_hertz(load, RADIUS, MODULUS, PERIOD)["max_pressure"]
    assert peak == pytest.approx(hardness, rel=2e-3)


@pytest.mark.parametrize("start", [None, 1.0, 1e5, 1e12])
@pytest.mark.parametrize("ratio", [0.05, 0.3, 0.9])
def test_first_yield_under_a_wave(ratio, start):
    """The largest pressure under a wave is 2 √(p̄ p*) in partial contact, p̄ + p* beyond (Westergaard 1939)."""
    wave = westergaard_surface((1, 1024), 1e-3 / 1024, amplitude=1e-6, wavelength=1e-3)
    full = closed_forms.westergaard_full_contact_pressure(1e-6, 1e-3, MODULUS)
    hardness = 2 * np.sqrt(ratio) * full
    load = first_yield_pressure(wave, contact_modulus=MODULUS, hardness=hardness, start=start)
    assert load == pytest.approx(ratio * full, rel=2e-3)
    load_of_full_contact = first_yield_pressure(
        wave, contact_modulus=MODULUS, hardness=3.5 * full, start=start
    )
    assert load_of_full_contact == pytest.approx(2.5 * full, rel=2e-3)


def test_first_yield_of_a_flat_map_and_of_a_single_point():
    flat = height_map(np.zeros((8, 8)), 1e-6)
    assert first_yield_pressure(flat, contact_modulus=MODULUS, hardness=2e9) == pytest.approx(2e9, rel=1e-9)
    # so smooth that no load near the hardness can be told from that of a flat map
    smooth = height_map(1e-18 * np.random.default_rng(1).standard_normal((8, 8)), 1e-6)
    assert first_yield_pressure(smooth, contact_modulus=MODULUS, hardness=2e9) == pytest.approx(2e9)
    spike = flat.copy(deep=True)
    spike.values[3, 4] = 1e-3
    load = first_yield_pressure(spike, contact_modulus=MODULUS, hardness=2e9)
    assert load == pytest.approx(2e9 / 64, rel=3e-3)  # all of the load on one of 64 points


def test_a_rough_map_is_elastic_below_its_first_yield_and_flows_above():
    window, hardness = rough(), 0.012 * MODULUS
    first_yield = first_yield_pressure(window, contact_modulus=MODULUS, hardness=hardness)
    loads = [0.98 * first_yield, 1.02 * first_yield]
    below, above = rc.solve_contact(
        window, contact_modulus=MODULUS, mean_pressure=loads, hardness=hardness, reduce=contact_statistics
    )["area_share_above_hardness"].values
    assert below == 0 < above
    # the same through the statistics of a run, whatever its loads
    for loads in ([1e5], [1e9], [1e5, 1e7, 1e9]):
        solved = rc.solve_contact(
            window, contact_modulus=MODULUS, mean_pressure=loads, hardness=hardness, reduce=contact_statistics
        )
        statistics = add_first_yield(solved, window, {"tolerance": 1e-4})
        assert float(statistics["first_yield_pressure"]) == pytest.approx(first_yield, rel=5e-3)


def test_first_yield_for_some_hardnesses_is_read_off_the_loads():
    window = rough()
    loads = 0.03 * MODULUS * np.array([0.5, 0.001, 0.1, 0.005, 0.02])
    solved = rc.solve_contact(window, contact_modulus=MODULUS, mean_pressure=loads, reduce=contact_statistics)
    yield_pressures = add_first_yield(solved, window, {})["first_yield_pressure_by_ratio"]
    reached = [
        ratio
        for ratio in yield_pressures["hardness_over_modulus"].values
        if yield_pressures.sel(hardness_over_modulus=ratio) > 0
    ]
    assert reached == [0.03]
    for ratio in reached:
        exact = first_yield_pressure(window, contact_modulus=MODULUS, hardness=ratio * MODULUS)
        assert float(yield_pressures.sel(hardness_over_modulus=ratio)) == pytest.approx(exact, rel=0.1)
    assert np.isnan(yield_pressures.sel(hardness_over_modulus=0.1))  # beyond the loads


def per_load(modulus, mean, largest, **further):
    """Return statistics of loads with these pressures over the modulus."""
    columns = {
        "mean_contact_pressure": modulus * np.atleast_1d(mean),
        "max_pressure": modulus * np.atleast_1d(largest),
    } | further
    dataset = xr.Dataset({name: ("load", np.atleast_1d(values)) for name, values in columns.items()})
    loads = 1e6 * (1 + np.arange(dataset.sizes["load"]))
    return dataset.assign(contact_modulus=modulus).assign_coords(mean_pressure=("load", loads))


@pytest.mark.parametrize(
    ("modulus", "mean", "largest", "outcome", "words"),
    [
        # the report that began it: 24.7 GPa at the peak, 2 to 10 GPa in the mean, in steel
        (1.154e11, [0.017, 0.087], [0.08, 0.214], REVIEW, "At every load metals would flow"),
        (1.154e11, [0.005, 0.0101], [0.01, 0.03], REVIEW, "At 1 of 2 loads, from 2.00 MPa on, metals"),
        (1.154e11, [0.005, 0.01], [0.01, 0.0301], REVIEW, "from 2.00 MPa on"),
        (1.154e11, [0.005, 0.01], [0.01, 0.03], NOT_MADE, "Not made: no hardness is stated"),
        (1.154e11, 1e-5, 1e-4, NOT_MADE, "State the hardness"),
        (1.154e11, [0.05, 0.101], [0.1, 0.2], FAILED, "from 2.00 MPa on, the contact is beyond what any"),
        (1e8, 0.05, 0.1, REVIEW, "At 1.00 MPa metals would flow"),
        (5e6, 0.9, 2.0, NOT_MADE, "rubber-like solids (E* below 100 MPa) bear that"),
        (5e6, 1.1, 2.0, REVIEW, "More than rubber bears"),
        # 115000, which is steel in MPa: only the yield of a metal casts doubt on a gel
        (1.154e5, 0.02, 0.06, NOT_MADE, "If it was given in MPa, it is 115 GPa, and metals flow there"),
        (1.154e5, 0.005, 0.01, NOT_MADE, "rubber-like solids (E* below 100 MPa) bear that"),
    ],
)
def test_without_a_hardness_the_pressure_is_judged_by_what_materials_bear(
    modulus, mean, largest, outcome, words
):
    check = contact_checks.plasticity(per_load(modulus, mean, largest))
    assert check.outcome == outcome
    assert words in check.sentence


@pytest.mark.parametrize("modulus", [1e4, 5e6, 1e9, 1e11])
@pytest.mark.parametrize("mean", 10.0 ** np.arange(-8, 2))
def test_a_check_that_was_not_made_is_never_green(modulus, mean):
    assert contact_checks.plasticity(per_load(modulus, mean, 2 * mean)).outcome != PASSED


def with_hardness(share):
    """Return statistics of loads of which such shares of the load carry a hardness of 300 MPa."""
    columns = {"load_share_above_hardness": share, "area_share_above_hardness": 0.9 * np.array(share)}
    statistics = per_load(4.3e9, [0.05] * len(share), [3e8 / 4.3e9] * len(share), **columns)
    return statistics.assign(hardness=3e8, rms_gradient=0.1, first_yield_pressure=1.5e6)


def test_with_a_hardness_any_point_that_carries_it_asks_for_a_look():
    check = contact_checks.plasticity(with_hardness([0.0, 0.0]))
    assert check.outcome == PASSED
    assert check.sentence == (
        "No point carries the hardness of 300 MPa: at most 100 % of it. First yield at a mean pressure of "
        "1.50 MPa."
    )
    check = contact_checks.plasticity(with_hardness([0.0, 0.02, 0.3]))
    assert check.outcome == REVIEW
    assert check.sentence.startswith(
        "At 2 of 3 loads, from 2.00 MPa on, points carry the hardness of 300 MPa and flow: up to 30.0 % of "
        "the load on 27.0 % of the contact area."
    )
    assert "Plasticity index E* g / H = 1.4" in check.sentence
    flags = [contact_checks.yielding(with_hardness([0.0, 0.02]).isel(load=load)) for load in (0, 1)]
    assert flags == ["", "asperities yield"]


def test_the_verdict_on_a_load_is_that_of_its_own_checks():
    window = rough()
    problem = {"contact_modulus": MODULUS, "hardness": 0.1 * MODULUS}
    loads = [1e-3 * MODULUS, 1e-4 * MODULUS]
    solved = rc.solve_contact(window, **problem, mean_pressure=loads, reduce=contact_statistics)
    written = checks.add_verdicts(solved, window)
    above, below = json.loads(written.attrs["verdicts"])
    assert above == ["use", []]
    assert below[0] == "review"
    assert [reason for reason in below[1] if reason.startswith("Points in contact: Fewer than 100")]
    worst = checks.surface_checks(
        solved, height={}, levelled=window.attrs, window=window.attrs, points=window.size
    )
    assert VERDICTS[worst_result(worst)] == "review"
    assert written["verdict"].dtype == np.int8
    words = written["verdict"].attrs["flag_meanings"].split()
    assert [words[code].replace("_", " ") for code in written["verdict"].values] == [above[0], below[0]]
    assert written["verdict"].attrs["flag_values"].tolist() == [0, 1, 2]
    listed = {entry["check"]: entry for entry in json.loads(written.attrs["reasons"])}
    assert listed["Points in contact"]["loads"] == [1]
    for load, (_, reasons) in enumerate((above, below)):
        concerned = [name for name, entry in listed.items() if load in entry["loads"]]
        assert concerned == [reason.partition(":")[0].partition(" (")[0] for reason in reasons]


def test_a_load_beyond_all_materials_is_a_reason_and_full_contact_is_none():
    window = rough()
    solved = rc.solve_contact(
        window, contact_modulus=MODULUS, mean_pressure=[1e-3 * MODULUS, MODULUS], reduce=contact_statistics
    )
    written = checks.add_verdicts(solved, window)
    listed = {entry["check"]: entry for entry in json.loads(written.attrs["reasons"])}
    assert 1 in listed["Plasticity"]["loads"]
    assert "Load range" not in listed  # full contact is no doubt
    assert written["verdict"].values[1] == 2


def test_words_of_a_load_without_a_hardness():
    def words(modulus, mean, largest):
        return contact_checks.yielding(per_load(modulus, mean, largest).isel(load=0))

    assert words(1e11, 0.01, 0.03) == ""
    assert words(1e11, 0.011, 0.03) == "metals would yield"
    assert words(1e11, 0.01, 0.031) == "metals would yield"
    assert words(1e11, 0.11, 0.2) == "any material would yield"
    assert words(5e6, 0.11, 0.2) == ""


def test_what_was_not_made_neither_helps_nor_harms():
    passed, unmade, look = (Check("a", outcome, "A.") for outcome in (PASSED, NOT_MADE, REVIEW))
    assert worst_result([passed, unmade]) == PASSED
    assert worst_result([unmade, look, passed]) == REVIEW
    assert worst_result([unmade]) == REVIEW
    assert not_passed([passed, unmade, look]) == [look]


@pytest.mark.parametrize(
    ("modulus", "loads", "outcome", "words"),
    [
        (115.0, [1e6], REVIEW, "did you mean 115 GPa or 115 MPa?"),
        (1.15e11, [1.0, 1e6], REVIEW, "At 1 of 2 loads the mean pressure is implausible: 1.00 Pa is next"),
        (1.15e11, [1e12], REVIEW, "more than any contact bears"),
        (1.15e11, [1e6, 1e8], PASSED, "115 GPa and loads of 1.00 MPa to 100 MPa"),
        (2e4, [50.0], PASSED, "20.0 kPa and loads of 50.0 Pa"),
        (1.0, [0.01], NOT_MADE, "in units of it"),
    ],
)
def test_moduli_and_loads_that_no_material_has(modulus, loads, outcome, words):
    statistics = per_load(modulus, [0.01] * len(loads), [0.02] * len(loads))
    check = contact_checks.units(statistics.assign_coords(mean_pressure=("load", loads)))
    assert check.outcome == outcome
    assert words in check.sentence


def test_a_plan_stays_below_the_hardness():
    window = rough()
    every = plan_loads(window, contact_modulus=MODULUS, hardness=1e20)  # up to nearly full contact
    first_share = every[0] / plan_loads(window, contact_modulus=MODULUS, relative_pressure=1.0)[0]
    hardness = 1.1 * every[0] * 0.05 / first_share
    expected = [load for load in every if load < hardness]
    assert 0 < len(expected) < len(every)
    assert plan_loads(window, contact_modulus=MODULUS, hardness=hardness) == expected
    # what was asked for is not left out in silence
    with pytest.raises(
        rc.SettingsError,
        match=r"relative_pressure = 1 is a mean pressure of .* Pa here, .* stay below 0\.055",
    ):
        plan_loads(window, contact_modulus=MODULUS, hardness=hardness, relative_pressure=[0.01, 1.0])
    below = plan_loads(window, contact_modulus=MODULUS, hardness=hardness, relative_pressure=[0.01, 0.0549])
    assert max(below) < hardness
    with pytest.raises(
        rc.SettingsError, match=r"is below all planned loads .* by the rms gradient .* check the units"
    ):
        plan_loads(window, contact_modulus=MODULUS, hardness=0.9 * every[0])


def test_the_ranges_hold_one_another():
    soft, hard = materials.METALS
    assert materials.MIN_HARDNESS < soft < hard < materials.MAX_HARDNESS
    assert materials.SOFTEST < materials.GEL < materials.RUBBER < materials.STIFFEST < materials.RIGID


def test_a_stated_hardness_that_is_reached_is_no_reason_to_review():
    window, hardness = rough(), 0.012 * MODULUS
    first_yield = first_yield_pressure(window, contact_modulus=MODULUS, hardness=hardness)
    solved = rc.solve_contact(
        window,
        contact_modulus=MODULUS,
        mean_pressure=3 * first_yield,
        hardness=hardness,
        reduce=contact_statistics,
    )
    check_list = checks.surface_checks(
        solved, height={}, levelled={}, window=window.attrs, points=window.size
    )
    (plasticity,) = (check for check in check_list if check.name == "Plasticity")
    assert plasticity.outcome == NOTE
    assert "carry the hardness of 1200 MPa" in plasticity.sentence
