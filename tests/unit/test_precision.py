"""How well an answer is known: the number in the files and the words on page and screen are one statement."""

import html
import math
import re

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact.arguments.answers import ANSWERS, AREA
from roughcontact.arguments.quantities import Unit
from roughcontact.report.glance import glance_rows, interval_cell
from roughcontact.results.collect import table
from roughcontact.statistics.precision import add_precision, precision_in_words
from roughcontact.surface.synthetic import rough_reference_surface

NOT_INCLUDED = "uncertainty of the hardness not included"


@pytest.fixture(scope="module")
def statistics():
    contact = {"contact_modulus": "1 GPa", "relative_pressure": [0.02, 0.1, 0.4], "hardness": "0.5 GPa"}
    return rc.evaluate(rough_reference_surface(64), contact=contact)


@pytest.mark.cases
def test_words_follow_the_ends_of_the_interval(lower, upper, words):
    assert precision_in_words(1.0, lower, upper) == words


def test_an_interval_that_rests_on_a_property_says_so():
    """Where all of the contact flows the area is p/H, and its lower end that of this hardness."""
    metal = {
        "youngs_modulus": "200 GPa",
        "poissons_ratio": 0.3,
        "thermal_conductivity": 50,
        "hardness": "2 GPa",
    }
    contact = {"bodies": [metal, metal], "relative_pressure": [1e-4, 0.02]}
    result = rc.evaluate(0.1 * rough_reference_surface(64), contact=contact)
    flows = result["load_share_above_hardness"].values > 0
    assert flows.tolist() == [False, True]
    for cells, limited in zip(glance_rows(result), flows, strict=True):
        area, pressure, gap, *_, conductance = (cells[name] for name in ANSWERS)
        for cell in (area, pressure):
            assert [*map(str, cell.remarks)] == [NOT_INCLUDED] * int(limited), cell
            assert cell.known.endswith(f", {NOT_INCLUDED}") == limited
        assert gap.remarks == ()
        assert conductance.remarks[-1] == ("conductivity", True)


def test_a_gap_that_is_closed_everywhere_is_known():
    gaps = {"mean_gap": [0.0, 0.0], "mean_gap_lower": [0.0, 0.0], "mean_gap_upper": [0.0, 1e-9]}
    precision = add_precision(xr.Dataset({name: ("load", values) for name, values in gaps.items()}))
    np.testing.assert_equal(precision["mean_gap_known"].values, [0.0, np.nan])
    assert precision_in_words(0.0, 0.0, 0.0) == "to ± 10 %"
    assert precision_in_words(0.0, 0.0, 1e-9) == "worse than a factor of 10"


def test_the_files_hold_the_half_width_over_the_value(statistics):
    frame = table(statistics)
    for answer in ("relative_contact_area", "mean_contact_pressure", "mean_gap", "max_pressure"):
        value, lower, upper = (statistics[f"{answer}{suffix}"].values for suffix in ("", "_lower", "_upper"))
        expected = [
            max(v - low, high - v) / v if v > 0 else np.nan
            for v, low, high in zip(value, lower, upper, strict=True)
        ]
        np.testing.assert_allclose(statistics[f"{answer}_known"], expected, rtol=1e-12)
        np.testing.assert_array_equal(frame[f"{answer}_known"], statistics[f"{answer}_known"])
    combined = statistics["relative_contact_area_uncertainty"].sel(source="combined")
    np.testing.assert_allclose(
        statistics["relative_contact_area_known"], combined / statistics["relative_contact_area"]
    )


def test_the_page_says_what_the_files_say(statistics):
    for load, cells in enumerate(glance_rows(statistics)):
        known = float(statistics["relative_contact_area_known"][load])
        if known <= 0.3:
            assert cells[AREA].precision == f"to ± {max(10, 5 * math.ceil(20 * known))} %"
        else:
            assert not re.match(r"to ±", html.unescape(cells[AREA].precision))


def test_a_yes_or_no_is_known_where_its_interval_lies_on_one_side():
    names = {
        "critical_constriction_x_lower": [0.0, 1e-7, 0.0],
        "critical_constriction_x_upper": [0.0, 2e-7, 1e-7],
    }
    names |= {"max_pressure": [1e9, 5e8, 5e8], "max_pressure_lower": [9e8, 4e8, 4e8]}
    names |= {"max_pressure_upper": [1e9, 9e8, 1e9]}
    names |= {f"critical_constriction_y_{side}": [0.0, 0.0, 0.0] for side in ("lower", "upper")}
    numbers = xr.Dataset({name: ("load", values) for name, values in names.items()} | {"hardness": 1e9})
    numbers = numbers.assign_coords(mean_pressure=("load", [3e6, 2e6, 1e6]))
    everywhere = numbers.assign(max_pressure_parts=(("member", "load"), [[1e9, 5e8, 1e9], [1e9, 6e8, 2e8]]))
    for answer in ("sealing_known", "yield_known"):  # 1 MPa is decided by 2 MPa
        np.testing.assert_array_equal(add_precision(everywhere)[answer], [0.0, 0.0, 0.0])
        np.testing.assert_array_equal(add_precision(everywhere.isel(load=[0, 2]))[answer], [0.0, np.nan])


def test_without_an_interval_nothing_is_said():
    numbers = xr.Dataset({"mean_gap": ("load", [1e-6])}, {"mean_pressure": ("load", [1e6])})
    assert not [name for name in add_precision(numbers) if str(name).endswith("_known")]


@pytest.mark.cases
def test_a_mean_gap_of_some_atoms_is_closed(value, lower, upper, closed):
    ends = {"mean_gap": [value], "mean_gap_lower": [lower], "mean_gap_upper": [upper]}
    numbers = {name: np.array(each) for name, each in ends.items()}
    cell = interval_cell(numbers, "mean_gap", {"mean_gap": Unit(1e9, "nm")}, 0)
    assert (cell.text == "closed (< 1 nm)") is closed
    assert ("up to" in cell.details) is (closed and upper > 1e-9)  # finer than atoms nothing is said
