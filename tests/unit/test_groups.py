"""Several maps, one answer: means, intervals and differences against published numbers and other code."""

import json
import re

import numpy as np
import pytest
import xarray as xr
from scipy import optimize, special, stats

import roughcontact as rc
from roughcontact.arguments.answers import CONDUCTANCE, ENDS, GAP
from roughcontact.surface.synthetic import rough_reference_surface
from roughcontact.uncertainty import calibration
from roughcontact.uncertainty.combination import SOURCES
from roughcontact.uncertainty.differences import _of_map, case_differences, compare_all, compare_maps
from roughcontact.uncertainty.group_tables import NamedGroup, comparisons_table, groups_table, joined_groups
from roughcontact.uncertainty.random_effects import (
    adjust_over_loads,
    grubbs_outliers,
    holm,
    maps_needed,
    p_value,
    random_effects,
    student,
    welch,
)

# JCGM 100:2008, table H.9: means of ten days in µV above 10 V, standard deviations of five observations each
DAYS = [172, 116, 13, 144, 106, 31, 60, 125, 163, 41]
WITHIN = [60, 77, 111, 101, 67, 93, 80, 73, 88, 86]


def one_map(gap, *, load=(1e6,), modulus=1e9, gap_parts=None, **attrs):
    """Return the statistics of a map: its gaps, and (source -> half-width) of what makes up its interval."""
    statistics = xr.Dataset(
        {"mean_gap": ("load", np.atleast_1d(np.asarray(gap, float)))},
        {"mean_pressure": ("load", np.asarray(load, float))},
        attrs,
    ).assign(contact_modulus=modulus)
    if gap_parts is not None:
        parts = np.zeros((statistics.sizes["load"], len(SOURCES) + 1, 4))
        for source, half in gap_parts.items():
            parts[:, SOURCES.index(source), :2] = half
        statistics["mean_gap_components"] = (("load", "source", "component"), parts)
    return statistics


def group_of(gaps, **options):
    return rc.group_statistics([one_map(gap) for gap in gaps], **options)


def test_the_example_of_the_guide_with_days_for_parts():
    """Zener voltage standard: u(V) = 18 µV with 9 degrees of freedom, means that scatter by 57 µV."""
    unit = np.array([-2, -1, 0, 1, 2]) / np.std([-2, -1, 0, 1, 2], ddof=1)
    values = np.concatenate([mean + spread * unit for mean, spread in zip(DAYS, WITHIN, strict=True)])
    effects = random_effects(values[:, None], np.repeat(np.arange(10), 5).astype(str))
    assert effects.mean.item() == pytest.approx(97.1)
    assert effects.error.item() == pytest.approx(18, abs=0.5)
    assert effects.freedom.item() == 9
    assert effects.within.item() == pytest.approx(85, abs=0.5)
    assert np.sqrt(5) * np.std(DAYS, ddof=1) == pytest.approx(128, abs=0.5)  # s_a of the guide
    assert effects.between.item() == pytest.approx(43, abs=0.5)  # (128² - 85²)/5, the guide's s_A


def test_single_maps_are_student_s_interval_and_that_of_a_further_value():
    values = np.array([1.0, 1.3, 0.7, 1.1])
    effects = random_effects(values[:, None], list("abcd"))
    half = (student(effects.freedom) * effects.error).item()
    reference = stats.t.interval(0.95, 3, values.mean(), stats.sem(values))
    assert (effects.mean.item() - half, effects.mean.item() + half) == pytest.approx(reference)
    assert effects.next_map.item() == pytest.approx(np.std(values, ddof=1) * np.sqrt(1 + 1 / 4))
    as_one_part = random_effects(values[:, None], list("aaaa"))
    assert as_one_part.error.item() == effects.error.item()
    assert np.isnan(as_one_part.between.item())


@pytest.mark.parametrize("counts", [(3, 3, 3, 3), (1, 4, 2, 3, 1)])
def test_intervals_of_nested_maps_hold_what_they_say(counts):
    generator = np.random.default_rng(1)
    parts = np.repeat(np.arange(len(counts)), counts)
    size = 6000
    shape = (parts.size, size)
    values = generator.standard_normal((len(counts), size))[parts] + 0.7 * generator.standard_normal(shape)
    effects = random_effects(values, parts.astype(str))
    mean = np.abs(effects.mean) <= student(effects.freedom) * effects.error
    further = np.hypot(1.0, 0.7) * generator.standard_normal(size)
    next_map = np.abs(further - effects.mean) <= student(effects.next_map_freedom) * effects.next_map
    # exact for equal counts: 95 % within three standard errors
    room = 3 * np.sqrt(0.95 * 0.05 / size) + (0.015 if len(set(counts)) > 1 else 0.0)
    assert mean.mean() == pytest.approx(0.95, abs=room)
    assert next_map.mean() == pytest.approx(0.95, abs=room + 0.01)


def test_welch_is_that_of_scipy():
    a, b = np.array([1.0, 1.2, 0.9, 1.1]), np.array([1.6, 1.1, 1.9])
    difference, error, freedom = welch(*(random_effects(v[:, None], list("abcd")[: v.size]) for v in (a, b)))
    reference = stats.ttest_ind(b, a, equal_var=False)
    assert (difference / error).item() == pytest.approx(reference.statistic)
    assert freedom.item() == pytest.approx(reference.df)


def test_holm_by_hand_and_power_by_simulation():
    adjusted = holm([np.array([p]) for p in (0.01, 0.02, 0.03, 0.04)])
    assert [p_value.item() for p_value in adjusted] == [0.04, 0.06, 0.06, 0.06]
    # of two families the first is out of the way only when all of it is
    assert [p_value.tolist() for p_value in holm([np.array([0.01, 0.5]), np.array([0.02])])] == [
        [0.02, 0.5],
        [0.04],
    ]
    count = maps_needed(1.0, 1.5)
    generator = np.random.default_rng(5)
    power = {}
    for n in (count - 1, count):
        a, b = generator.standard_normal((2, n, 20000))
        power[n] = np.mean(stats.ttest_ind(a, b + 1.5).pvalue < 0.05)
    assert power[count - 1] < 0.9 + 0.01
    assert power[count] > 0.9 - 0.01


@pytest.mark.parametrize(("count", "limit"), [(4, 1.496), (6, 1.973), (10, 2.482)])
def test_the_limit_of_grubbs_is_that_of_iso_5725(count, limit):
    """ISO 5725-2:1994, table 5, one largest or smallest, upper 1 %."""

    def off(distance):
        """Whether a number at so many standard deviations from the mean stands off the rest."""

        def with_one(far):
            return np.r_[np.linspace(-1, 1, count - 1), far]

        far = optimize.brentq(lambda far: stats.zscore(with_one(far), ddof=1)[-1] - distance, 1, 200)
        return bool(grubbs_outliers(with_one(far)[:, None])[-1, 0])

    assert not off(limit - 0.003)
    assert off(limit + 0.002)


@pytest.mark.filterwarnings("error")
def test_subwindows_without_numbers_have_no_deviations():
    parts = (("member", "load"), np.full((9, 2), np.nan))
    map_ = xr.Dataset(
        {"mean_gap": ("load", [1.0, 2.0]), "mean_gap_parts": parts, "mean_pressure": ("load", [1.0, 2.0])}
    )
    *_, deviations = _of_map("mean_gap", map_, None, of_place=False)
    assert deviations.shape == (2, 0)


def test_none_stands_off_from_maps_at_a_physical_limit():
    """Equal areas, as where all of the contact flows, have no scatter to compare with."""
    assert grubbs_outliers(np.array([[1.0], [1.1], [0.9], [1.05], [3.0]])).any()
    assert not grubbs_outliers(np.array([[1.0], [1.0], [1.0], [1.0], [1.01]])).any()


def test_what_maps_share_is_added_once_and_the_window_to_pairs_of_faces_alone():
    gaps = np.array([1.0, 1.1, 0.9, 1.05]) * 1e-6
    shared = {"discretisation": 0.03, "instrument": 0.04}
    without_window, maps = (
        [one_map(gap, gap_parts={key: gap * np.expm1(u) for key, u in parts.items()}) for gap in gaps]
        for parts in (shared, shared | {"window": 0.9})
    )
    shared_result, bare = rc.group_statistics(without_window), group_of(gaps)
    scatter = np.log(bare["mean_gap_upper"] / bare["mean_gap"]).item()
    assert np.log(shared_result["mean_gap_upper"] / shared_result["mean_gap"]).item() == pytest.approx(
        np.hypot(scatter, 0.05)
    )
    placed = rc.group_statistics(maps, placements=True)
    further = np.log(bare["mean_gap_next_upper"] / bare["mean_gap"]).item()
    of_pair = np.log(placed["mean_gap_upper"] / placed["mean_gap"]).item()
    assert of_pair == pytest.approx(np.sqrt(further**2 + 0.05**2 + 0.9**2))
    assert placed["mean_gap_upper"].item() == placed["mean_gap_next_upper"].item()


def test_two_placements_reach_from_end_to_end_of_their_intervals():
    maps = [one_map(gap, gap_parts={"window": 0.3 * gap}) for gap in (1.0, 2.0)]
    group = rc.group_statistics(maps, placements=True)
    assert [group[f"mean_gap_{side}"].item() for side in ("lower", "upper")] == pytest.approx([0.7, 2.6])


def test_an_unbounded_map_leaves_the_group_unbounded():
    maps = [one_map(gap, gap_parts={"discretisation": 0.01 * gap}) for gap in (1.0, 1.1, 0.9)]
    maps[1]["mean_gap_components"][:, SOURCES.index("unresolved"), 1] = np.nan
    group = rc.group_statistics(maps)
    assert np.isnan(group["mean_gap_upper"].item())
    assert group["mean_gap_lower"].item() > 0


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("count", [2, 3])
def test_maps_with_a_closed_gap_are_closed_and_reach_as_far_as_each(count):
    """Neither a gap of zero nor the conductance of full contact has a logarithm to be averaged on."""
    closed = {
        GAP: [1e-6, 0.0],
        f"{GAP}_lower": [5e-7, 0.0],
        f"{GAP}_upper": [2e-6, 3e-9],
        CONDUCTANCE: [2.0, np.inf],
        f"{CONDUCTANCE}_lower": [1.0, 50.0],
        f"{CONDUCTANCE}_upper": [4.0, np.inf],
    }
    columns = {name: ("load", values) for name, values in closed.items()}
    maps = [one_map([1e-6, 0.0], load=(1e6, 1e8)).assign(columns) for _ in range(count)]
    maps[1] = maps[1].assign(mean_gap_upper=("load", [2e-6, 7e-9]))
    closed_group = rc.group_statistics(maps).isel(load=1)
    gap, conductance = ([closed_group[f"{name}{end}"].item() for end in ENDS] for name in (GAP, CONDUCTANCE))
    assert gap == [0.0, 0.0, 7e-9]
    assert conductance == [np.inf, 50.0, np.inf]
    assert closed_group["mean_gap_of_maps"].values.tolist() == [0.0] * count


def test_one_map_is_what_it_was_and_two_are_a_range():
    single = one_map(2e-6).assign(mean_gap_lower=("load", [1e-6]), mean_gap_upper=("load", [5e-6]))
    group = rc.group_statistics([single])
    assert [group[f"mean_gap{suffix}"].item() for suffix in ("_lower", "", "_upper")] == [1e-6, 2e-6, 5e-6]
    pair = group_of([1e-6, 4e-6])
    assert [pair[f"mean_gap{suffix}"].item() for suffix in ("_lower", "", "_upper")] == pytest.approx(
        [1e-6, 2e-6, 4e-6]
    )
    assert np.isnan(pair["mean_gap_next_upper"].item())
    assert json.loads(pair.attrs["remarks"])[0].startswith(
        "Two maps: a range, from the lowest to the highest of"
    )
    shared = [one_map(gap, gap_parts={"instrument": 1e-7}) for gap in (1e-6, 4e-6)]
    wider = rc.group_statistics(shared)  # the ends lie outside the maps, and the remark says why
    assert wider["mean_gap_lower"].item() < 0.999e-6 < 4.001e-6 < wider["mean_gap_upper"].item()
    assert "and what these share" in json.loads(wider.attrs["remarks"])[0]
    _, skipped = compare_all({"one": group_of([1e-6]), "two": pair})
    assert skipped[0].startswith("one has a single map")
    of_two_parts = group_of([1e-6, 4e-6, 2e-6], parts=["a", "a", "b"])
    assert json.loads(of_two_parts.attrs["remarks"])[0].startswith("Two parts: a range")


def test_maps_with_an_interval_tell_how_they_are_expected_to_scatter():
    """Two variances averaged by their degrees of freedom (Smyth 2004), on the logarithm of the gap."""
    groups, gaps = calibration.table()["groups"], np.array([1.0, 1.2])
    maps = [one_map(gap, gap_parts={"window": 0.5 * gap}) for gap in gaps]
    answer = rc.group_statistics(maps)
    expected = (np.log(1.5) - np.log(0.5)) / 2 / groups["half_width"]["mean_gap"]
    freedom = groups["freedom"]["mean_gap"]
    variance = (freedom * expected**2 + np.log(gaps).var(ddof=1)) / (freedom + 1)
    factor = stats.t.ppf(0.975, freedom + 1)
    for key, square in (("", variance / 2), ("next_", variance * 1.5)):
        ends = [answer[f"mean_gap_{key}{side}"].item() for side in ("lower", "upper")]
        width = factor * np.sqrt(square)
        assert np.log(ends) == pytest.approx(np.log(gaps).mean() + width * np.array([-1, 1]))
    assert json.loads(answer.attrs["remarks"])[0].startswith("Two maps: their interval rests on")
    of_parts = rc.group_statistics([*maps, one_map(1.1)], parts=["a", "a", "b"])
    assert of_parts["mean_gap_next_lower"].isnull().all()  # the bank knows places, not workpieces


def test_a_load_that_all_maps_have_stays_beside_those_of_targets():
    def targeted(*targets):
        loads = np.array([1e6, 3e6, *targets])
        return one_map(1e6 / loads, load=loads)

    maps = [targeted(4.1e6, 9e6), targeted(5e6, 8e6), targeted(6e6, 7e6)]
    group = rc.group_statistics(maps)
    assert {1e6, 3e6} <= {*group["mean_pressure"].values}
    assert group["mean_gap"].sel(load=group["mean_pressure"] == 3e6).item() == pytest.approx(1 / 3)
    comparison = rc.compare_groups(
        group, rc.group_statistics([map_.assign(mean_gap=2 * map_["mean_gap"]) for map_ in maps])
    )
    assert 3e6 in comparison["mean_pressure"]


def test_bodies_of_finite_size_on_maps_of_different_size_are_no_group():
    def pressed(size):
        pressure = np.array([1e-3, 2e-3]) / size
        radius = ("load", [1e-6, 2e-6])
        return one_map([2.0, 1.0], load=pressure).assign(force=("load", [1e-3, 2e-3]), contact_radius=radius)

    assert rc.group_statistics([pressed(4e-9) for _ in range(3)]).sizes["load"] == 2
    with pytest.raises(rc.SettingsError, match="maps differ in size"):
        rc.group_statistics([pressed(4e-9), pressed(4e-9), pressed(6e-9)])
    small, large = (rc.group_statistics([pressed(size)] * 3) for size in (4e-9, 6e-9))
    assert rc.compare_groups(small, small)["ratio"].values.tolist() == [[1.0, 1.0]]
    with pytest.raises(rc.SettingsError, match="maps differ in size"):
        rc.compare_groups(small, large)
    endless = rc.group_statistics([one_map([gap, 1.0], load=(2e5, 6e5)) for gap in (2.0, 3.0, 4.0)])
    for group_a, group_b in ((small, endless), (endless, small)):
        with pytest.raises(rc.SettingsError, match="a body of finite size and one without end"):
            rc.compare_groups(group_a, group_b)


def test_other_loads_are_interpolated_within_the_common_range_alone():
    """A power law is a line in logarithms, which is met exactly."""
    loads = [(1e6, 4e6, 9e6), (2e6, 8e6), (1.5e6, 3e6, 6e6)]
    maps = [one_map(1e-6 * (np.array(load) / 1e6) ** -0.5, load=load) for load in loads]
    group = rc.group_statistics(maps)
    pressure = group["mean_pressure"].values
    assert (pressure[0], pressure[-1]) == pytest.approx((2e6, 6e6))
    np.testing.assert_allclose(group["mean_gap"], 1e-6 * (pressure / 1e6) ** -0.5, rtol=1e-12)
    assert "compared from 2.00 MPa to 6.00 MPa" in json.loads(group.attrs["remarks"])[0]


def test_loads_of_a_map_far_apart_are_said_to_tell_little():
    """The gap between them follows its stiffness, here that of gap = u ln(P/p)."""
    maps = []
    for scale, load in ((1e-6, (1e6, 1e7, 1e8)), (1.2e-6, (2e6, 2e7, 1e8)), (1.1e-6, (1e6, 1e7, 1e8))):
        pressure = np.array(load)
        data = one_map(scale * np.log(4e8 / pressure), load=load)
        maps.append(data.assign(contact_stiffness=("load", pressure / scale)))
    group = rc.group_statistics(maps)
    assert "loads of a map that are 10 times apart" in json.loads(group.attrs["remarks"])[1]
    expected = np.array([[1e-6], [1.2e-6], [1.1e-6]]) * np.log(4e8 / group["mean_pressure"].values)
    np.testing.assert_allclose(group["mean_gap_of_maps"], expected, rtol=0.03)


def test_a_map_that_stands_off_is_named_and_stays():
    gaps = [1.0, 1.01, 0.99, 1.02, 0.98, 3.0]
    group = group_of(gaps, names=["a", "b", "c", "d", "e", "chipped"])
    assert group["stands_off"].values.ravel().tolist() == [0, 0, 0, 0, 0, 1]
    assert json.loads(group.attrs["remarks"]) == [
        "chipped stands off the others (Grubbs's test, 1 %) at 1 of 1 loads; it is included."
    ]
    assert group["mean_gap"].item() == pytest.approx(np.exp(np.mean(np.log(gaps))))


@pytest.mark.cases
def test_maps_that_do_not_answer_the_same_question(changes, message):
    attrs = {"band_shortest": 1e-6, "band_reason": "grid", "measured_by": "optical profiler"}
    maps = [one_map(1e-6, **attrs), one_map(1e-6, **attrs | changes)]
    with pytest.raises(rc.SettingsError) as caught:
        rc.group_statistics(maps, names=["a", "b"], group="g")
    assert message in str(caught.value)


def of_map(gap, rms_height):
    return one_map([gap, 0.8 * gap], load=(1e6, 2e6)).assign(rms_height=rms_height)


def test_copies_are_no_further_maps_of_a_group():
    maps = [of_map(1.0, 0.3), of_map(1.1, 0.31), of_map(1.0, 0.3).isel(load=[1, 0])]
    with pytest.raises(
        rc.SettingsError, match="group g: a and c have the same results, as copies of one map"
    ):
        rc.group_statistics(maps, names=["a", "b", "c"], group="g")
    # the numbers of another map may meet them at a load
    maps[2] = of_map(1.0, 0.29)
    assert rc.group_statistics(maps, names=["a", "b", "c"]).sizes["map"] == 3
    assert rc.group_statistics(maps)["map"].values.tolist() == ["1", "2", "3"]
    # two placements of a face on a smooth one are no copies
    assert rc.group_statistics([maps[0]] * 2, placements=True).sizes["map"] == 2


def test_groups_that_share_a_map_are_not_compared():
    group_a = rc.group_statistics([of_map(1.0, 0.3), of_map(1.1, 0.31)], names=["a", "b"])
    group_b = rc.group_statistics([of_map(2.0, 0.6), of_map(1.1, 0.31)], names=["c", "d"])
    with pytest.raises(rc.SettingsError, match="b of the first and d of the second have the same results"):
        rc.compare_groups(group_a, group_b)
    comparisons, omissions = compare_all({"one": group_a, "other": group_b})
    assert comparisons == {}
    assert omissions[0].startswith("b of one and d of other have the same results")
    assert rc.compare_groups(group_a, group_a, paired=True)["outcome"].size  # the same maps under two cases


def test_different_instruments_in_a_stated_band_are_a_group():
    attrs = {"band_shortest": 1e-6, "band_reason": "window.shortest_wavelength"}
    maps = [one_map(1e-6, **attrs, measured_by=kind) for kind in ("optical profiler", "stylus profiler")]
    assert rc.group_statistics(maps).sizes["map"] == 2


def test_groups_scale_with_the_units():
    generator = np.random.default_rng(3)
    gaps = np.exp(0.2 * generator.standard_normal(5))
    group, scaled_group = group_of(gaps), group_of(1e-6 * gaps)
    for suffix in ("", "_lower", "_upper", "_next_lower", "_next_upper", "_of_maps"):
        np.testing.assert_allclose(
            scaled_group[f"mean_gap{suffix}"], 1e-6 * group[f"mean_gap{suffix}"], rtol=1e-12
        )
    assert scaled_group["mean_gap_between"].item() == pytest.approx(group["mean_gap_between"].item())


def test_areas_have_the_scale_of_their_effort():
    areas = np.array([0.05, 0.1, 0.2, 0.6])
    maps = [one_map(1.0).assign(relative_contact_area=("load", [area])) for area in areas]
    area = rc.group_statistics(maps)["relative_contact_area"].item()
    assert area == pytest.approx(special.erf(np.exp(np.mean(np.log(special.erfinv(areas))))))
    assert rc.group_statistics(maps)["relative_contact_area_next_upper"].item() <= 1.0


def test_outcomes_in_words():
    near, same, wide = [1.0, 1.001, 0.999], [1.0, 1.001, 1.002], [1.0, 2.0, 0.5]
    groups = {name: group_of(gaps) for name, gaps in (("near", near), ("same", same), ("wide", wide))}
    comparisons, _ = compare_all(groups)
    words = {pair: comparison["outcome"].item() for pair, comparison in comparisons.items()}
    assert words["near", "same"].startswith("do not differ by more than 0.")
    assert words["near", "wide"].startswith("inconclusive: ")
    assert words["near", "wide"].endswith(" more maps per group needed")
    far = rc.compare_groups(groups["near"], group_of([2.0, 2.01, 1.99]))
    assert far["outcome"].item() == "differ"
    assert far["ratio_lower"].item() < 2.0 < far["ratio_upper"].item()
    with pytest.raises(rc.SettingsError, match="has a single map"):
        rc.compare_groups(groups["near"], group_of([1.0]))


def test_what_two_groups_share_cancels_and_the_solver_does_not():
    def made(factor):
        maps = [
            one_map(gap * factor, gap_parts={"instrument": 0.3 * gap * factor, "solver": 1e-3 * gap * factor})
            for gap in (1.0, 1.0, 1.0)
        ]
        return rc.group_statistics(maps)

    comparison = rc.compare_groups(made(1.0), made(1.5))
    assert np.log(comparison["ratio_upper"] / comparison["ratio"]).item() == pytest.approx(
        np.hypot(1e-3, 1e-3), rel=2e-3
    )


@pytest.mark.parametrize(("correlation", "max_share"), [(0.0, 0.06), (0.97, 0.05)])
def test_loads_that_go_together_count_less_and_keep_the_level(correlation, max_share):
    """Equal groups of five, four loads: false alarms of any load in 5 %, no fewer than by Holm."""
    generator, count, loads = np.random.default_rng(8), 5, 4
    mixed = np.linalg.cholesky(correlation + (1 - correlation) * np.eye(loads))
    a, b = generator.standard_normal((2, 3000, count, loads)) @ mixed.T
    p_single = stats.ttest_ind(a, b, axis=1, equal_var=False).pvalue
    share = np.mean(np.array([adjust_over_loads(p).min() for p in p_single]) < 0.05)
    by_holm = np.mean(loads * p_single.min(axis=1) < 0.05)
    assert by_holm <= share < max_share
    assert share > 1.4 * by_holm if correlation else share >= by_holm


def test_p_values_are_adjusted_for_all_pairs():
    groups = {str(k): group_of(np.array([1.0, 1.1, 0.9]) * (1 + k / 4)) for k in range(3)}
    comparisons, _ = compare_all(groups)
    assert len(comparisons) == 3
    p_single = [rc.compare_groups(groups[a], groups[b])["p_value"].item() for a, b in comparisons]
    assert [comparison["p_value"].item() for comparison in comparisons.values()] == pytest.approx(
        [p_value.item() for p_value in holm([np.array([p]) for p in p_single])]
    )


@pytest.mark.parametrize(("difference", "error", "expected"), [(0, 0, 1), (1, 0, 0), (1, np.nan, np.nan)])
def test_maps_that_do_not_scatter_differ_certainly_or_not_at_all(difference, error, expected):
    p = p_value(*np.array([[difference], [error], [4.0]]))
    np.testing.assert_array_equal(p, [expected])


def test_padding_of_a_run_whose_other_cases_have_a_budget_changes_no_interval():
    plain = [one_map(gap) for gap in (1.0, 1.1, 0.9)]
    undefined = {f"mean_gap_{side}": ("load", [np.nan]) for side in ("lower", "upper")}
    padded = [one_map(gap, gap_parts={"solver": np.nan}).assign(undefined) for gap in (1.0, 1.1, 0.9)]
    expected, actual = rc.group_statistics(plain), rc.group_statistics(padded)
    assert np.isfinite(actual["mean_gap_upper"]).all()
    xr.testing.assert_allclose(
        actual[["mean_gap_lower", "mean_gap_upper"]], expected[["mean_gap_lower", "mean_gap_upper"]]
    )


def areas(half_width, **constants):
    """Return a group of three maps of 7 % contact, which share an error of an instrument."""
    maps = [
        xr.Dataset({"relative_contact_area": ("load", [area])}, {"mean_pressure": ("load", [5e4])})
        for area in (0.071, 0.073, 0.074)
    ]
    parts = np.zeros((1, len(SOURCES) + 1, 4))
    parts[:, SOURCES.index("instrument"), :2] = half_width
    components = {"relative_contact_area_components": (("load", "source", "component"), parts)}
    return rc.group_statistics(
        [data.assign(components).assign(contact_modulus=8e6, **constants) for data in maps]
    )


def test_an_area_that_nothing_bounds_ends_at_the_whole_and_not_at_load_over_hardness():
    unbounded = areas(np.nan, hardness=9e5)
    assert unbounded["relative_contact_area_lower"].item() == pytest.approx(5e4 / 9e5)
    assert unbounded["relative_contact_area_upper"].item() == 1
    bounded = areas(1e-3)  # without a hardness only the whole limits it
    assert 0.06 < bounded["relative_contact_area_lower"].item() < 0.072
    assert 0.074 < bounded["relative_contact_area_upper"].item() < 0.085


def test_maps_that_flow_are_known_together_no_worse_than_each():
    """The hardness bounds what other places may have: no more scatter is to be expected."""
    hardness, below = 1.2e9, 6e7
    parts = np.zeros((1, len(SOURCES) + 1, 4))
    parts[:, SOURCES.index("window"), :2] = below, 6e9
    flowing = xr.Dataset(
        {
            "max_pressure": ("load", [hardness]),
            "max_pressure_components": (("load", "source", "component"), parts),
        },
        {"mean_pressure": ("load", [5e4])},
    ).assign(contact_modulus=1e11, hardness=hardness)
    group = rc.group_statistics([flowing, flowing, flowing])
    assert group["max_pressure_upper"].item() == hardness
    assert hardness - below < group["max_pressure_lower"].item() < hardness


def test_paired_maps_are_compared_map_by_map():
    gaps = np.array([1.0, 2.0, 4.0])
    group_a = group_of(gaps, names=["a", "b", "c"])
    group_b = group_of((gaps * [1.1, 1.11, 1.09])[::-1], names=["c", "b", "a"])
    comparison = rc.compare_groups(group_a, group_b, paired=True)
    reference = stats.ttest_1samp(np.log([1.1, 1.11, 1.09]), 0.0)
    assert comparison["p_value"].item() == pytest.approx(reference.pvalue)
    assert comparison["outcome"].item() == "differ"
    assert rc.compare_groups(group_a, group_b)["outcome"].item() != "differ"
    with pytest.raises(rc.SettingsError, match="not of the same maps"):
        rc.compare_groups(group_a, group_of(gaps), paired=True)


def area_map(area, *, shared=0.0, load=1e6):
    """Return the statistics of a map of one contact area, with a relative error that all maps share."""
    statistics = xr.Dataset({"relative_contact_area": ("load", [area])}, {"mean_pressure": ("load", [load])})
    statistics = statistics.assign(contact_modulus=1e9)
    components = np.zeros((1, len(SOURCES) + 1, 4))
    components[:, SOURCES.index("discretisation"), :2] = shared * area
    statistics["relative_contact_area_components"] = (("load", "source", "component"), components)
    return statistics


def test_a_ratio_to_full_contact_is_as_uncertain_as_the_other_area():
    """Full contact has no error: the ratio has that of the first area, by Student's t of four maps."""
    areas = [0.75, 0.82, 0.72, 0.81]
    partial, full = (rc.group_statistics([area_map(area) for area in maps]) for maps in (areas, [1.0] * 4))
    area = rc.compare_groups(partial, full).sel(quantity="relative_contact_area")
    logs = np.log(areas)
    half = stats.t.ppf(0.975, 3) * logs.std(ddof=1) / 2
    width = np.log(area["ratio_upper"] / area["ratio_lower"]).item()
    assert width == pytest.approx(2 * half, rel=1e-2)


def test_what_two_areas_share_moves_the_smaller_more():
    """A shared error of 20 % of a small area and 2 % of one near the whole leaves 18 % of their ratio."""
    differences = case_differences(area_map(0.05, shared=0.2), area_map(0.95, shared=0.02))
    area = differences.sel(quantity="relative_contact_area", load=0)
    assert np.log(area["ratio_upper"] / area["ratio"]).item() == pytest.approx(0.18, abs=0.02)


def test_groups_under_two_cases_are_compared_at_the_loads_that_they_share():
    def under(loads, factor=1.0, **attrs):
        maps = [one_map(np.full(len(loads), gap * factor), load=loads, **attrs) for gap in (1.0, 2.0, 4.0)]
        return rc.group_statistics(maps, group="g")

    groups = {"first": under((1e6, 2e6)), "apart": under((4.95e3, 9.9e3)), "again": under((2e6, 5e6), 3.0)}
    groups["stiffer"] = under((2e6, 4e6), modulus=2e9)  # the same loads, relative to the modulus
    comparisons, omissions = compare_all(
        groups, cases=[("first", name) for name in ("apart", "again", "stiffer")]
    )
    assert [
        (*pair, comparison["mean_pressure"].values.tolist()) for pair, comparison in comparisons.items()
    ] == [("first", "again", [2e6]), ("first", "stiffer", [1e6, 2e6])]
    assert comparisons["first", "again"]["ratio"].item() == pytest.approx(3.0)
    (message,) = omissions
    assert message.startswith("first and apart: no load in common, first begins at 1")


def test_maps_of_two_cases_are_not_compared_between_two_loads_alone():
    def under(*loads):
        """Return maps with gaps that fall ever faster with the load: equal under both cases."""
        pressure = 1e6 * np.array(loads)
        maps = [one_map(gap * np.exp(-pressure / 4e6), load=pressure) for gap in (1.0, 2.0, 4.0)]
        return rc.group_statistics(maps, group="g")

    groups = {"a": under(1, 4), "b": under(2, 3, 8), "c": under(*np.geomspace(1.1, 7, 12))}
    comparisons, (message,) = compare_all(groups, cases=[("a", "b"), ("b", "c")])
    assert message.startswith("a and b: no load in common, and a has two loads alone")
    np.testing.assert_allclose(comparisons["b", "c"]["ratio"], 1.0, atol=0.1)


def test_groups_of_the_same_places_are_compared_place_by_place():
    gaps, factors = np.array([1.0, 2.0, 4.0]), [1.1, 1.11, 1.09]
    groups = {
        "new": group_of(gaps, names=["a", "b", "c"]),
        "worn": group_of((gaps * factors)[::-1], names=["c2", "b2", "a2"]),
    }
    pairs = [("a", "a2"), ("b", "b2"), ("c2", "c")]  # in either direction
    reference = stats.ttest_1samp(np.log(factors), 0.0).pvalue
    comparisons, _ = compare_all(groups, same_area_pairs=pairs)
    assert comparisons["new", "worn"]["p_value"].item() == pytest.approx(reference)
    incomplete, (message,) = compare_all(groups, same_area_pairs=pairs[:2])
    assert incomplete["new", "worn"]["p_value"].item() > 10 * reference
    assert message.startswith("new and worn place by place: not all maps have one of their place")


def test_the_first_and_the_third_state_of_the_same_places_are_compared_place_by_place():
    gaps, factors = np.array([1.0, 2.0, 4.0]), np.array([1.1, 1.11, 1.09])
    groups = {
        state: group_of(gaps * factors**power, names=[f"{area_name}{power}" for area_name in "abc"])
        for power, state in enumerate(("new", "run-in", "worn"))
    }
    pairs = [(f"{area_name}{power}", f"{area_name}{power + 1}") for power in (1, 0) for area_name in "abc"]
    comparisons, omissions = compare_all(groups, same_area_pairs=pairs)
    p_values = [pair["p_value"].item() for pair in comparisons.values()]
    assert p_values == pytest.approx([3 * stats.ttest_1samp(np.log(factors), 0.0).pvalue] * 3)
    assert not omissions


@pytest.fixture(scope="module")
def cases():
    """The same map under two moduli at the same relative pressure, and under another form."""

    def solved(modulus, **level):
        return rc.evaluate(
            rough_reference_surface(64).isel(x=slice(48), y=slice(48)),
            contact={"contact_modulus": modulus, "relative_pressure": [0.05, 0.2]},
            statistics={"flow": "never"},
            level=level,
        )

    return solved("1 GPa"), solved("30 GPa"), solved("1 GPa", form="polynomial", order=3)


def test_cases_that_are_equal_by_construction_differ_by_nothing(cases):
    case_a, case_b, _ = cases
    difference = case_differences(case_a, case_b).sel(quantity="relative_contact_area")
    single_width = case_a["relative_contact_area_upper"] / case_a["relative_contact_area"] - 1
    width = (difference["ratio_upper"] - difference["ratio_lower"]).values
    assert (np.abs(difference["ratio"] - 1) < 1e-9).all()
    assert ((difference["ratio_lower"] <= 1) & (difference["ratio_upper"] >= 1)).all()
    # the solver is left: its tolerance is 1e-4
    assert (width < 2e-3).all()
    assert (width < 0.05 * single_width.values).all()


def test_cases_that_change_the_map_keep_what_they_do_not_share(cases):
    case_a, _, case_c = cases
    difference = case_differences(case_a, case_c).sel(quantity="mean_gap")
    independent = case_differences(*(data.drop_vars("mean_gap_components") for data in (case_a, case_c)))
    independent = independent.sel(quantity="mean_gap")
    width, independent_width = (
        np.log(table["ratio_upper"] / table["ratio_lower"]).values for table in (difference, independent)
    )
    assert (width > 0).all()
    assert (width < independent_width).all()


@pytest.fixture(scope="module")
def repeats():
    """A place measured three times, the last time a fifth rougher."""
    area = rough_reference_surface(64).isel(x=slice(48), y=slice(48))
    generator = np.random.default_rng(4)

    def measured(factor=1.0):
        return rc.evaluate(
            factor * area + 0.002 * float(area.std()) * generator.standard_normal(area.shape),
            contact={"contact_modulus": "1 GPa", "mean_pressure": ["30 MPa", "120 MPa"]},
            statistics={"flow": "never"},
        )

    return measured(), measured(), measured(1.2)


def test_a_repeat_differs_by_nothing_that_both_share(repeats):
    original, repetition, rougher = repeats
    pairs = {("first", "again"): (original, repetition), ("first", "rougher"): (original, rougher)}
    comparisons, omissions = compare_maps(pairs)
    assert omissions == []
    same, rougher_ratio = (
        comparison.sel(quantity="relative_contact_area") for comparison in comparisons.values()
    )
    single_width = np.log(
        original["relative_contact_area_upper"] / original["relative_contact_area_lower"]
    ).values
    assert (np.log(same["ratio_upper"] / same["ratio_lower"]).values < single_width / 4).all()
    assert ((same["ratio_lower"] < 1) & (same["ratio_upper"] > 1) & (same["p_value"] > 0.05)).all()
    assert same["outcome"].values[-1].startswith("do not differ by more than ")
    # the area goes with the inverse of the gradient where it is small, with less of it where it is not
    assert rougher_ratio["ratio_lower"].values[0] < 0.85
    assert 1 / 1.2 < rougher_ratio["ratio_upper"].values[0] < 1
    assert rougher_ratio["outcome"].values[-1] == "differ"


def test_wear_of_one_place_is_known_better_than_that_of_all_places(repeats):
    """Its ratio is that of the maps without their noise, solved on their own."""
    original, _, _ = repeats
    place = rough_reference_surface(64).isel(x=slice(48), y=slice(48))
    flattened = place.clip(max=float(place.quantile(0.8)))
    settings = {"contact": {"contact_modulus": "1 GPa", "mean_pressure": ["30 MPa", "120 MPa"]}}
    settings |= {"statistics": {"flow": "never"}}
    worn = rc.evaluate(flattened, **settings)
    ratios = {}
    for pairs_of_place in ((), [("new", "worn")]):
        comparisons, _ = compare_maps({("new", "worn"): (original, worn)}, of_place=pairs_of_place)
        ratios[bool(pairs_of_place)] = comparisons["new", "worn"]
    bare = rc.evaluate(place, **settings, uncertainty={"sources": ["discretisation"]})
    for name in ("relative_contact_area", "mean_gap"):
        anywhere, here = (ratios[key].sel(quantity=name) for key in (False, True))
        widths = [np.log(each["ratio_upper"] / each["ratio_lower"]).values for each in (anywhere, here)]
        assert (widths[1] < 0.7 * widths[0]).all(), name
        truth = (worn[name] / bare[name]).values
        assert (here["ratio_lower"].values <= truth).all(), name
        assert (truth <= here["ratio_upper"].values).all(), name


def test_maps_of_a_place_are_compared_at_the_same_mean_pressures():
    def solved(loads, factor):
        """Gaps go with the load to the -1/2, which the logarithms interpolate without error."""
        gap, wide = factor * np.asarray(loads, float) ** -0.5, {"solver": 0.02 * factor}
        return one_map(gap, load=loads, gap_parts=wide)

    new, worn = solved([1e6, 4e6, 8e6], 1.0), solved([1.5e6, 3e6, 6e6], 1.2)
    pairs = {("new", "worn"): (new, worn), ("new", "far"): (new, solved([1e7, 2e7], 1.0))}
    comparisons, omissions = compare_maps(pairs)
    (table,) = comparisons.values()
    assert 1.5e6 <= table["mean_pressure"].values.min() < table["mean_pressure"].values.max() <= 6e6
    assert table["ratio"].values.ravel() == pytest.approx(1.2, rel=1e-9)
    assert omissions[0].startswith("new and far: no load in common, far begins at 10")


def test_maps_of_a_place_with_other_waves_are_not_compared():
    fine, coarse = (one_map(1e-6, band_shortest=shortest) for shortest in (1e-6, 4e-6))
    comparisons, omissions = compare_maps({("new", "worn"): (fine, coarse)})
    assert comparisons == {}
    assert "the shortest of new is 1.00 µm, that of worn 4.00 µm" in omissions[0]


def test_tables_and_dataset_of_several_groups():
    answers = [
        NamedGroup("lapped", None, group_of([1.0, 1.1, 0.9])),
        NamedGroup("ground", None, group_of([2.0, 2.2], names=["left", "right"])),
    ]
    joined = joined_groups(answers)
    assert joined["mean_gap_of_maps"].dims == ("group", "load", "map")
    assert joined.sel(group="ground")["map_name"].values.tolist() == ["left", "right", ""]
    assert joined["maps"].values.tolist() == [3, 2]
    table = groups_table(answers)
    contract = [
        "group",
        "maps",
        "mean_pressure_Pa",
        *(f"mean_gap{suffix}" for suffix in ("", "_lower", "_upper")),
    ]
    assert {*contract, "mean_gap_next_lower", "mean_gap_next_upper"} <= {*table.columns}
    assert table["group"].tolist() == ["lapped", "ground"]
    rows = comparisons_table(compare_all({group.label: group.answer for group in answers})[0])
    assert rows.columns.tolist() == [
        *("first", "second", "quantity", "mean_pressure_Pa"),
        *("ratio", "ratio_lower", "ratio_upper", "p_value", "outcome"),
    ]


def test_no_difference_below_a_hundredth_of_a_percent_is_named():
    once = group_of([1.0, 1.1, 0.9])
    comparison = rc.compare_groups(once, once, paired=True)
    assert set(comparison["outcome"].values.ravel()) == {"do not differ by more than 0.0100 %"}


def test_what_all_maps_share_is_named_with_what_makes_it_smaller():
    """Welch's interval is narrow; the errors of the pixels, alike but of other size, are not."""
    gaps = [1.0, 1.001, 0.999]
    fine = rc.group_statistics([one_map(gap, gap_parts={"discretisation": 0.01}) for gap in gaps])
    coarse = rc.group_statistics([one_map(gap, gap_parts={"discretisation": 0.4}) for gap in gaps])
    outcome = rc.compare_groups(fine, coarse)["outcome"].item()
    of_pixels = "smaller errors that all maps share (above 10.0 %): measure with pixels half as large"
    assert outcome == f"inconclusive: about 1 more map per group needed, and {of_pixels}"


def test_what_scatters_more_than_all_maps_share_asks_for_more_maps():
    fine, coarse = (
        rc.group_statistics([one_map(gap, gap_parts={"discretisation": part}) for gap in (1.0, 1.9, 0.6)])
        for part in (0.01, 0.4)
    )
    outcome = rc.compare_groups(fine, coarse)["outcome"].item()
    assert re.match("inconclusive: (about|more than) [0-9]+ more maps .*, and smaller errors that", outcome)


@pytest.mark.parametrize("wrong", [[], np.zeros((4, 4)), [np.zeros((4, 4))]], ids=["none", "array", "arrays"])
def test_a_group_of_something_else_than_statistics_is_refused(wrong):
    with pytest.raises(rc.SettingsError, match="give the statistics of one or more maps"):
        rc.group_statistics(wrong)


def test_numbers_without_an_end_are_not_compared_and_warn_of_nothing(recwarn):
    """In full contact a conductance is infinite, and infinity less infinity is no number."""
    flat = [
        rc.evaluate(
            rc.height_map(np.full((20, 20), height), 1e-6, unit="m"), contact_modulus=1e11, mean_pressure=1e6
        )
        for height in (0, 1)
    ]
    group = rc.group_statistics(flat, placements=True)
    for paired in (False, True):
        second = group if paired else group.assign_coords(map=["a", "b"], content=("map", ["", ""]))
        comparison = rc.compare_groups(group, second, paired=paired)
        outcome = comparison["outcome"].sel(quantity=CONDUCTANCE).item()
        assert outcome == "inconclusive: no interval"
        assert np.isnan(comparison["p_value"].sel(quantity=CONDUCTANCE).item())
    assert not [warning for warning in recwarn if issubclass(warning.category, RuntimeWarning)]
