"""The figures of the error budget, read back: each part is in percent of the value, at its load."""

import numpy as np
import pytest
import xarray as xr
from read_charts import read_chart

from roughcontact import evaluate, self_affine_surface
from roughcontact.report.budget_plots import beyond_in_words, largest_parts, present_sources, shown_budget

SOURCES = ["solver", "discretisation", "window", "material", "combined"]
LOADS = np.array([1e6, 4e6])


@pytest.fixture
def numbers():
    """Statistics of two loads; the gap is closed at the second one."""
    result = xr.Dataset(
        {"mean_pressure": ("load", LOADS), "contact_modulus": 1e11}, coords={"source": SOURCES}
    )
    for name, values in (
        ("relative_contact_area", [0.1, 0.4]),
        ("mean_gap", [2e-6, 0.0]),
        ("max_pressure", [1e8, 2e8]),
        ("mean_contact_pressure", [1e7, 1e7]),
    ):
        value = np.array(values)
        result[name] = ("load", value)
        # 2 and 3 % of the pixel size and of the window, no part of the others
        shares = [0.0, 0.02, 0.03, np.nan, 0.05]
        result[f"{name}_uncertainty"] = (("load", "source"), np.outer(value, shares))
        result[f"{name}_lower"], result[f"{name}_upper"] = ("load", 0.96 * value), ("load", 1.05 * value)
    return result


def test_parts_are_drawn_in_percent_of_the_value_at_their_load(numbers):
    images = dict(shown_budget(numbers)["images"])
    assert list(images) == ["contact area", "pressure in contact", "mean gap", "largest pressure"]
    for title, image in images.items():
        drawn = read_chart(image, log="xy")
        assert {"mean pressure (MPa)", "± in percent of the value", title} <= set(drawn.texts)
        loads = LOADS[:1] if title == "mean gap" else LOADS  # of nothing there is no share
        *parts, up, down = drawn.lines
        drawn_parts = [line for line in parts if line.x.size]
        assert [line.y for line in drawn_parts] == [pytest.approx(share, rel=0.006) for share in (2.0, 3.0)]
        for line in (*drawn_parts, up, down):
            assert line.x == pytest.approx(loads / 1e6, rel=0.02)
        assert (up.style, up.y) == ("", pytest.approx(5.0, rel=0.02))
        assert (down.style != "", down.y) == (True, pytest.approx(4.0, rel=0.02))
        assert [(mark.colour, mark.y) for mark in drawn.marks] == [
            (line.colour, pytest.approx(line.y)) for line in drawn_parts
        ]


@pytest.mark.parametrize("sources", [["solver", "window"], ["solver", "material"]])
def test_other_maps_have_a_column_where_the_window_is_a_source(sources):
    surface = self_affine_surface((64, 64), 1e-6, hurst=0.8, shortest=8e-6, longest=2e-5, rms_height=1e-7)
    contact = {"contact_modulus": 1e9, "mean_pressure": 5e6, "contact_modulus_uncertainty": 0.1}
    result = evaluate(surface, contact=contact, uncertainty={"sources": sources})
    budget, about = shown_budget(result, [0]), ["of the next map"] if "window" in sources else []
    assert [words.lower() for words in beyond_in_words(result)] == about
    assert budget["intervals"]["header"][2:] == ["the ±", *about, "this map"]


def test_what_is_not_in_the_interval_is_named(numbers):
    budget = shown_budget(numbers)
    assert budget["notes"][:1] == ["Not in the ±: instrument, modulus and load, hardness, unresolved waves."]
    assert largest_parts(numbers) == "for the contact area: window"


def test_a_source_without_words_stands_by_its_name(numbers):
    """A file of another version may have one; its place among the others says nothing."""
    first, *others = SOURCES
    renamed = numbers.assign_coords(source=[first, "humidity", *others[1:]])
    assert present_sources(renamed.isel(source=[4, 0, 1, 2, 3])) == ["solver", "humidity", "window"]
    titles = dict(shown_budget(renamed)["images"])
    assert {"solver", "humidity", "window"} <= set(read_chart(titles["contact area"], log="xy").texts)
    assert (
        largest_parts(numbers.assign_coords(source=["solver", "grid", "humidity", *SOURCES[3:]]))
        == "for the contact area: humidity"
    )
