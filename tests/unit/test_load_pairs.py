"""Two loads are the same, or are not, for every comparison alike."""

import itertools

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact.report.differences import case_rows
from roughcontact.results.comparison import compare_statistics
from roughcontact.statistics.load_pairs import (
    SAME_LOAD,
    common_loads,
    interpolated,
    paired_loads,
    slopes_of,
)
from roughcontact.uncertainty.differences import compare_maps

LOADS = np.array([1e6, 2e6, 5e6])


def result(loads, factor=1.0, **more):
    """Return the statistics of a map whose numbers are powers of the load, times a factor."""
    loads = np.asarray(loads, float)
    numbers = {
        "relative_contact_area": factor * loads / 1e8,
        "mean_contact_pressure": factor * loads**0.1,
        "mean_gap": factor * loads**-0.5,
        "max_pressure": factor * loads**0.2,
    }
    columns = {name: ("load", values) for name, values in numbers.items()}
    ends = {"lower": 0.9, "upper": 1.1}
    columns |= {
        f"{name}_{end}": ("load", numbers[name] * way) for name in numbers for end, way in ends.items()
    }
    return xr.Dataset({**columns, "contact_modulus": 1e9, **more}, {"mean_pressure": ("load", loads)})


@pytest.mark.parametrize(("shift", "same"), [(0.5 * SAME_LOAD, True), (3 * SAME_LOAD, False)])
def test_every_comparison_takes_the_same_loads_for_the_same(shift, same):
    first, second = result(LOADS), result(LOADS * (1 + shift), 2.0)
    assert paired_loads(first, second)[0].size == (3 if same else 0)
    runs = compare_statistics(first, second, share=0.01)
    assert ("mean_pressure" in set(runs["quantity"])) == (not same)
    (row,) = case_rows({"one": first, "two": second})
    assert bool(row["loads"]) == same
    group = rc.group_statistics([first, second])
    interpolates = any("interpolated" in text for text in [group.attrs["remarks"]])
    assert interpolates == (not same)
    compared, skipped = compare_maps({("one", "two"): (first, second)})
    assert skipped == []
    gaps = compared["one", "two"].sel(quantity="mean_gap")["ratio"].values
    exact = 2 * (1 + shift) ** -0.5  # of the loads themselves
    assert (np.abs(gaps / exact - 1) < 1e-12).all() == same


@pytest.mark.parametrize("order", itertools.permutations(range(3)))
def test_loads_are_paired_by_what_they_are(order):
    first, second = result(LOADS), result(LOADS[list(order)])
    mine, partners = paired_loads(first, second)
    np.testing.assert_array_equal(LOADS[mine], LOADS[list(order)][partners])
    assert mine.tolist() == [0, 1, 2]


def test_relative_loads_pair_where_more_of_them_agree_and_the_rest_by_pressure():
    stiff = result([2e6, 4e6, 1e7, 3e5], contact_modulus=2e9)
    soft = result([1e6, 2e6, 5e6, 3e5])
    assert [indices.tolist() for indices in paired_loads(soft, stiff)] == [[0, 1, 2, 3], [0, 1, 2, 3]]
    equally_stiff = result([2e6, 4e6, 1e7, 3e5])
    assert [indices.tolist() for indices in paired_loads(soft, equally_stiff)] == [[1, 3], [0, 3]]


def test_stated_loads_are_paired_as_stated_only_where_all_have_them():
    first = result([1e6, 2e6, 3e6], place=("load", [1, 0, 2]))
    second = result([4e6, 5e6, 6e6], place=("load", [0, 1, 2]))
    places = [indices.tolist() for indices in paired_loads(first, second, as_stated=True)]
    assert places == [[1, 0, 2], [0, 1, 2]]
    assert paired_loads(first, second.isel(load=[0, 1]), as_stated=True)[0].size == 0


def test_of_states_far_apart_no_load_between_is_interpolated():
    """First yield is at a thousandth of the loads of a target, which are other ones for each map."""
    maps = [result([2e4, 1.3e7 * factor, 2.7e7 * factor]) for factor in (1.0, 1.02, 1.05)]
    loads = common_loads("group", "abc", maps)
    assert loads[0] == 2e4
    assert ((loads[1:] >= 1.3e7) & (loads[1:] <= 2.7e7)).all()
    assert loads[-1] == 2.7e7


def test_between_loads_a_power_law_stays_one():
    loads = common_loads("both", "ab", [result(LOADS), result([1e6, 3e6, 5e6])])
    assert loads.tolist() == [1e6, 3e6, 5e6]  # of four, as many as either has
    powers = interpolated(np.log(LOADS) * 0 + LOADS, loads, np.log(LOADS))  # a line over ln p
    np.testing.assert_allclose(powers, np.log(loads), rtol=1e-12)
    with pytest.raises(rc.SettingsError, match="no load in common, b begins at 6"):
        common_loads("both", "ab", [result(LOADS), result([6e6])])


def test_between_loads_ten_times_apart_the_gap_follows_its_stiffness():
    """Of the law gap = u ln(P/p) the stiffness is p/u; without it the gap is off by 4 %."""
    loads, between = 1e6 * np.array([1.0, 10.0, 100.0]), 1e6 * np.array([3.0, 30.0])
    gap = 1e-6 * np.log(4e8 / loads)
    law = result(loads, mean_gap=("load", gap), contact_stiffness=("load", loads / 1e-6))
    found = np.exp(interpolated(loads, between, np.log(gap), slopes_of("mean_gap", law)))
    np.testing.assert_allclose(found, 1e-6 * np.log(4e8 / between), rtol=0.02)
    yielding = law.assign(loading_stiffness=("load", loads / 2e-6))
    np.testing.assert_allclose(slopes_of("mean_gap", yielding), 2 * slopes_of("mean_gap", law))
    assert slopes_of("mean_gap", law.drop_vars("contact_stiffness")) is None


def test_slopes_that_are_not_known_or_too_steep_leave_a_monotone_curve():
    loads, between = np.array([1.0, 10.0, 100.0, 1000.0]), np.geomspace(1.0, 100.0, 50)
    gap = np.array([0.0, -1.0, -9.0, -np.inf])  # logarithms; the last one is closed
    found = interpolated(loads, between, gap, np.array([np.nan, -1e3, np.nan, np.nan]))
    assert (np.diff(found) < 0).all()
    assert np.isinf(interpolated(loads, np.array([300.0]), gap, np.full(4, np.nan))).all()
