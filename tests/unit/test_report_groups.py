"""Groups on the page: cells, pictures and comparisons in words."""

import re

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact.arguments.answers import AREA
from roughcontact.report.differences import _comparison, comparison_rows, differences_in_words
from roughcontact.report.gather import comparisons, map_comparisons
from roughcontact.report.glance import Cell
from roughcontact.report.groups import (
    group_headings,
    group_picture,
    group_rows,
    surfaces_in_words,
)
from roughcontact.report.template import template
from roughcontact.uncertainty.differences import compare_all
from roughcontact.uncertainty.group_tables import NamedGroup


def named(name, factors, *, parts=None, placements=False, hardness=None):
    """Return a group of maps whose gaps differ by some factors."""
    loads = {"mean_pressure": ("load", [1e6, 4e6]), "contact_modulus": 1e9, "rms_height": 1e-6}
    loads |= {"hardness": hardness} if hardness else {}
    maps = [
        xr.Dataset(
            {
                "relative_contact_area": ("load", np.array([0.05, 0.2]) / factor),
                "mean_gap": ("load", np.array([2e-6, 1e-6]) * factor),
                "mean_contact_pressure": ("load", np.array([2e7, 2e7]) * factor),
                "max_pressure": ("load", np.fmin(np.array([5e7, 6e7]) * factor, hardness or np.nan)),
                **loads,
            }
        )
        for factor in factors
    ]
    answer = rc.group_statistics(maps, parts=parts, placements=placements)
    return NamedGroup(name, None, answer)


def test_a_group_has_its_interval_the_next_map_and_a_scatter_without_plus_minus():
    (row,) = group_rows([named("lapped", (0.9, 1.0, 1.1))])
    assert (row["name"], row["of"], row["remarks"]) == ("lapped", "3 maps", [])
    headings = [*group_headings().values()]
    cells = dict(zip(headings, row["rows"][0], strict=True))
    assert cells[headings[0]] == Cell("1.00 MPa")
    gap = cells["mean gap"]
    half = (
        4.302653 * np.std(np.log([0.9, 1.0, 1.1]), ddof=1) / np.sqrt(3)
    )  # t of 95 % for two degrees of freedom
    middle = 2 * np.exp(np.mean(np.log([0.9, 1.0, 1.1])))
    assert gap.details == f"−{middle * (1 - np.exp(-half)):.2f} +{middle * (np.exp(half) - 1):.2f}"
    assert cells["area of the next map"].text.endswith(" %")
    assert " to " in cells["area of the next map"].text
    areas = 0.05 / np.array([0.9, 1.0, 1.1])  # in percent of the mean, to second order
    assert float(cells["scatter s"].text.removesuffix(" %")) == pytest.approx(
        100 * areas.std(ddof=1) / areas.mean(), rel=0.01
    )
    assert "conductance" not in cells  # nobody has asked for it
    (asked,) = group_rows([named("lapped", (0.9, 1.0, 1.1))], columns=["conductance"])
    assert asked["rows"][0][-1] == Cell("–")  # whose maps have none


def test_an_interval_whose_ends_read_the_same_is_one_number():
    """The next map in full contact: its area is the whole window at both ends."""
    group = named("lapped", (0.9, 1.0, 1.1))
    ends = {"relative_contact_area_next_lower": 0.9999999, "relative_contact_area_next_upper": 1.0}
    ends = {name: ("load", [share, share]) for name, share in ends.items()}
    (row,) = group_rows([group._replace(answer=group.answer.assign(ends))])
    cells = dict(zip(group_headings().values(), row["rows"][0], strict=True))
    assert cells["area of the next map"].text == "100.00 %"


def test_a_group_says_the_verdicts_of_its_maps():
    group = named("lapped", (0.9, 1.0, 1.1))
    verdicts = {("1", None): "review", ("2", None): "use", ("3", None): "use", ("1", "soft"): "do not use"}
    assert group_rows([group], verdicts)[0]["of"] == "3 maps (use 2, review 1)"
    assert group_rows([group._replace(case="soft")], verdicts)[0]["of"] == "3 maps (do not use 1)"


def test_two_maps_are_a_range_and_parts_have_a_scatter_of_their_own():
    pair, nested = group_rows(
        [named("two", (1.0, 1.2)), named("nested", (1.0, 1.1, 1.2, 1.3, 0.9, 0.8), parts=list("aabbcc"))]
    )
    gap = pair["rows"][0][[*group_headings()].index("mean_gap")]
    assert gap.details == "range 2.00 to 2.40 µm"
    assert pair["rows"][0][2] == Cell("–")
    assert pair["remarks"][0].startswith("Two maps: a range")
    assert nested["of"] == "6 maps of 3 parts"
    assert nested["rows"][0][3].text.startswith("parts ")
    assert ", maps " in nested["rows"][0][3].text


def test_placements_and_differences_in_words():
    groups = [named("lapped", (0.9, 1.0, 1.1)), named("ground", (1.9, 2.0, 2.1))]
    (pair,) = group_rows([named("seal", (0.9, 1.0, 1.1), placements=True)])
    assert pair["of"] == "3 placements of two faces"
    compared, omissions = compare_all({group.label: group.answer for group in groups})
    assert omissions == []
    (rows,) = comparison_rows(compared, groups)
    assert (rows["first"], rows["second"]) == ("lapped", "ground")
    row = rows["rows"][-1]
    assert (row["quantity"], rows["loads"][0], row["outcomes"]) == (
        "largest pressure",
        "1.00 MPa",
        ["differ", "differ"],
    )
    low, high = (float(bound) for bound in row["cells"][0].details.split(" to "))
    assert low < float(row["cells"][0].text) < high
    loads = {name: ("load", [0.01, 0.04]) for name in ("force", "contact_radius")}
    (of_bodies,) = comparison_rows(
        compared, [], {group.label: group.answer.assign(loads) for group in groups}
    )
    assert of_bodies["loads"] == ["10.0 mN", "40.0 mN"]
    # two loads with the same answer have it once
    assert re.fullmatch(r"Contact area, ground against lapped: [^;]*\.", differences_in_words([rows]))


def test_a_case_with_a_single_map_left_does_not_hide_the_differences_of_the_others():
    maps = {"a": (1.0,), "b": (0.9, 1.0, 1.2), "c": (1.8, 2.0, 2.3)}
    comparisons_found, omissions = comparisons(
        [named("g", gaps)._replace(case=case) for case, gaps in maps.items()]
    )
    assert list(comparisons_found) == [("g · b", "g · c")]
    assert [text.partition(" has a single map")[0] for text in omissions] == ["g · a", "g · a"]


def test_maps_of_a_place_are_adjusted_over_the_pairs_of_a_case():
    def gap(value):
        bounds = {
            f"mean_gap_{bound}": ("load", [value * factor])
            for bound, factor in (("lower", 0.9), ("upper", 1.1))
        }
        return xr.Dataset({"mean_gap": ("load", [value]), **bounds, "mean_pressure": ("load", [1e6])})

    maps = {"new": gap(1.0), "worn": gap(1.2)}
    single_case, _ = map_comparisons({"": maps}, {}, [("new", "worn")])
    reference = single_case["new", "worn"]["p_value"].item()
    assert 0 < reference < 0.05
    two_cases, omissions = map_comparisons({"soft": maps, "hard": maps}, {}, [("new", "worn")])
    assert list(two_cases) == [("new · soft", "worn · soft"), ("new · hard", "worn · hard")]
    assert not omissions
    for comparison in two_cases.values():
        assert comparison["p_value"].item() == pytest.approx(reference)


def test_a_gap_finer_than_atoms_is_no_multiple_of_another():
    groups = [named("lapped", (0.9e-10, 1.0e-10, 1.1e-10)), named("ground", (1.9e-6, 2.0e-6, 2.1e-6))]
    (rows,) = comparison_rows(compare_all({group.label: group.answer for group in groups})[0], groups)
    of_gap = next(row for row in rows["rows"] if row["quantity"] == "mean gap")
    assert of_gap["outcomes"] == [""] * len(of_gap["cells"])
    assert of_gap["cells"] == [Cell("–", "closed (< 1 nm)")] * len(of_gap["cells"])


def test_pressures_at_the_hardness_have_no_interval_and_no_difference():
    limited = [
        named(name, gaps, hardness=5.4e7)
        for name, gaps in (("lapped", (0.9, 1.0, 1.1)), ("ground", (1.9, 2.0, 2.1)))
    ]
    lapped, ground = group_rows(limited, columns=["max_pressure"])
    peak = [*group_headings(["max_pressure"])].index("max_pressure")
    assert [cells[peak].details == "the hardness as stated" for cells in ground["rows"]] == [True, True]
    assert [cells[peak].details == "the hardness as stated" for cells in lapped["rows"]] == [
        False,
        True,
    ]
    (rows,) = comparison_rows(compare_all({group.label: group.answer for group in limited})[0], limited)
    assert rows["rows"][-1]["outcomes"][1] == ""
    assert rows["rows"][-1]["cells"][1] == Cell("–", "both the hardness")
    upper = limited[0].answer["max_pressure_next_upper"]
    assert upper.values == pytest.approx([5.4e7, 5.4e7])  # of the first load the hardness ends the interval
    upper_bounds = named("lapped", (0.9, 1.0, 1.1)).answer["max_pressure_next_upper"]
    assert (upper_bounds > 6e7).all()


def test_surfaces_whose_area_is_unknown_at_the_load_have_no_line():
    areas = xr.Dataset({AREA: ("load", [0.1, np.nan]), "mean_pressure": ("load", [1e6, 1e8])})
    surfaces = areas.assign(contact_modulus=1e9)
    assert surfaces_in_words({"a": (surfaces, 1), "b": (surfaces, 1)}) == ""
    assert "10.0 % of all 2" in surfaces_in_words({"a": (surfaces, 0), "b": (surfaces, 0)})


@pytest.mark.parametrize(
    ("outcomes", "words"),
    [(["differ", "", "closed"], "differ at 1; closed at 3"), (["", "closed"], "closed at 2")],
)
def test_outcomes_that_are_others_at_some_loads_stand_with_their_loads(outcomes, words):
    row = {"quantity": "mean gap", "cells": [Cell("1")] * len(outcomes), "outcomes": outcomes}
    pair = {"first": "A", "second": "B", "loads": ["1", "2", "3"][: len(outcomes)], "rows": [row]}
    table = str(template("ratios.html").module.ratios([pair], "Differences"))
    assert re.findall(r'<td class="text">([^<]*)</td>', table) == [words]


@pytest.mark.parametrize(("outcomes", "columns"), [([], 1), ([""], 1), (["differ"], 2)])
def test_comparisons_without_an_outcome_have_no_column_for_it(outcomes, columns):
    row = {"quantity": "mean gap", "cells": [Cell("–", "closed (< 1 nm)")], "outcomes": outcomes}
    pair = {"first": "A", "second": "B", "loads": ["1 MPa"], "rows": [row]}
    table = str(template("ratios.html").module.ratios([pair], "Differences"))
    assert ("outcome</th>" in table) == (columns > 1)
    assert table.count("<td") == columns


def test_a_long_outcome_is_said_once_where_the_quantity_before_has_the_same():
    outcome = "inconclusive: about 9 more maps per group needed, and smaller errors that all maps share"
    rows = [
        {"quantity": name, "cells": [Cell("1")], "outcomes": [text]}
        for name, text in (("area", outcome), ("pressure", outcome), ("gap", "differ"), ("peak", "differ"))
    ]
    pair = {"first": "A", "second": "B", "loads": ["1 MPa"], "rows": rows}
    table = str(template("ratios.html").module.ratios([pair], "Differences"))
    shown = re.findall(r'<td class="text">([^<]*)</td>', table)
    assert shown == [outcome, "as above", "differ", "differ"]


def test_pictures_show_every_map():
    groups = [named("lapped", (0.9, 1.0, 1.1)), named("ground", (1.9, 2.0, 2.1))]
    marks = group_picture(groups).count("scale(3.4)")
    assert marks == 2 * (3 * 2 + 2) + 2  # of two groups three maps and a mean at two loads, and the legend


@pytest.mark.parametrize("gaps", [[0.05, 0.2], [0.0, 0.2]])
def test_a_closed_gap_of_all_maps_is_closed(gaps):
    group = named("one", (1.0, 1.1, 1.2)).answer
    maps = [group.isel(map=k).drop_vars(["map", "part"]) for k in range(3)]
    maps = [map_data.assign(mean_gap=("load", gaps)) for map_data in maps]
    statistics = rc.group_statistics([map_data[["mean_gap", "contact_modulus"]] for map_data in maps])
    assert statistics["mean_gap"].values == pytest.approx(gaps)


@pytest.mark.parametrize(
    ("ratio", "cell_texts"),
    [
        ((0.8263, 0.641, 1.0742), ("0.83", "0.641 to 1.07")),
        ((1.00001, 1.00000999, 1.00001001), ("1.0000", "")),  # certain at these digits
        ((1.5, np.nan, np.nan), ("1.50", "")),
        ((12.3, 4.56, 40.2), ("12.3", "4.56 to 40.2")),
        ((18.0, 0.0803, 4883.0), ("18", "0.0803 to 4880")),
        ((18.0, 4.03, np.nan), ("18", "4.03 or more")),
    ],
)
def test_a_ratio_and_its_ends_have_the_digits_that_the_interval_carries(ratio, cell_texts):
    names = ("ratio", "ratio_lower", "ratio_upper")
    comparison = xr.Dataset({name: ("load", [value]) for name, value in zip(names, ratio, strict=True)})
    comparison = comparison.assign(outcome=("load", ["differ"]))
    assert _comparison(comparison, "mean_gap", [""])["cells"] == [Cell(*cell_texts)]


def test_several_surfaces_are_answered_in_one_line():
    """What is allowed comes first, then yes or no, then the least and the largest number, by surface."""
    loads = {"mean_pressure": ("load", [1e6, 2e6]), "contact_modulus": 1e9, "rms_height": 1e-6}
    loads |= {name: ("load", [2.0, 1.0]) for name in ("mean_gap", "mean_contact_pressure", "max_pressure")}

    def at(index, surfaces):
        return {name: (data, index) for name, data in surfaces.items()}

    areas = {name: xr.Dataset(loads | {AREA: ("load", [0.01, a])}) for name, a in (("a", 0.3), ("b", 0.1))}
    assert surfaces_in_words(at(1, areas)) == "At 2.00 MPa: contact area from 10.0 % (b) to 30.0 % (a)."
    joints = {
        name: data.assign(joint_area=1e-4, thermal_conductance=("load", [1e4, value]))
        for (name, data), value in zip(areas.items(), (2e4, 4e4), strict=True)
    }
    heat = "At 2.00 MPa: thermal conductance from 20.0 kW/(m² K) (a) to 40.0 kW/(m² K) (b)"
    assert surfaces_in_words(at(1, joints)) == f"{heat}."
    currents = {
        name: data.assign(total_electrical_resistance=("load", [1.0, 1e-3])) for name, data in joints.items()
    }
    assert surfaces_in_words(at(1, currents)) == f"{heat}; resistance of the joint 1.00 mΩ of all 2."
    closed = {f"gap_percolates_{axis}": ("load", [1.0, 0.0]) for axis in "xy"}
    leaks = {f"leak_rate_{axis}": ("load", [1e-9, 0.0]) for axis in "xy"}
    leaks |= {f"critical_constriction_{axis}": ("load", [1e-7, 0.0]) for axis in "xy"}
    seals = {name: data.assign(closed | leaks) for name, data in areas.items()}
    assert surfaces_in_words(at(0, areas)) == "At 1.00 MPa: contact area 1.00 % of all 2."
    assert surfaces_in_words(at(1, seals)) == "At 2.00 MPa: seals for all 2."
    heavier = seals["b"].assign_coords(mean_pressure=("load", [1e6, 3e6]))
    assert surfaces_in_words(at(1, seals | {"b": heavier})) == (
        "At 2.00 MPa to 3.00 MPa, each at its own load: seals for all 2."
    )
    wide = {f"critical_constriction_{axis}_upper": ("load", [1e-6, 1e-6]) for axis in "xy"}
    wide |= {f"critical_constriction_{axis}_lower": ("load", [0.0, 0.0]) for axis in "xy"}
    unsure = seals | {"b": seals["b"].assign(wide)}
    assert surfaces_in_words(at(1, unsure)) == "At 2.00 MPa: seals for a, seals (not decided) for b."
    limit = {"allowed_leak": 1e-9, "leak_holds": ("load", [0.0, 1.0])}
    allowed = {
        "a": seals["a"].assign(limit),
        "b": seals["b"].assign(limit | {"leak_holds": ("load", [0.0] * 2)}),
    }
    expected = "At 2.00 MPa leak of at most 3.60 ml/h: holds for a, does not hold for b."
    assert surfaces_in_words(at(1, allowed)) == expected
    many = {f"{name}{index}": data for name, data in allowed.items() for index in range(3)}
    assert surfaces_in_words(at(1, many)).endswith("holds for 3 of 6, does not hold for 3 of 6.")
