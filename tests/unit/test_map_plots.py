"""Pictures of maps and profiles, read back: extent, colours, frame of the window, what is out of range."""

import gc
import html
import json
import re
import weakref
from urllib.parse import unquote

import numpy as np
import pytest
from read_charts import read_chart

from roughcontact.arguments.maps import height_map
from roughcontact.arguments.quantities import Unit
from roughcontact.report import map_plots
from roughcontact.report.charts import COLOURS
from roughcontact.report.panel import _frame


def reading(chart):
    """Return what a script reads values of a picture by."""
    source = chart.source()
    return json.loads(html.unescape(re.search("data-reading='([^']*)'", unquote(source))[1]))


def arrows(chart):
    """Return how many arrows say that there are values beyond the colours."""
    source = chart.source()
    return len(re.findall(r'<path d="M[^"]*L[^"]*z" fill="#', unquote(source)))


def rough(shape, spacing):
    return height_map(np.random.default_rng(1).standard_normal(shape) * 1e-6 + 5e-3, spacing)


def test_a_height_map_has_its_extent_and_its_range():
    """Heights are counted from their mean; a thousandth at either end may lie beyond the colours."""
    height = rough((30, 50), (3e-6, 2e-6))
    chart = map_plots.height_map(height, rectangle=(20e-6, 30e-6, 40e-6, 45e-6))
    read = reading(chart)
    assert read["x"] == ["x (µm)", 0.0, pytest.approx(100.0)]
    assert read["y"] == ["y (µm)", 0.0, pytest.approx(90.0)]
    percentiles = 1e6 * np.percentile(height.values - height.values.mean(), [0.1, 99.9])
    assert read["value"] == ["height (µm)", *map(pytest.approx, percentiles)]
    assert read["points"] == [50, 30]
    assert read["bad"][1] == "not measured"
    assert arrows(chart) == 2
    frame = next(line for line in read_chart(chart).lines if line.colour == "#d00000")
    assert (frame.x.min(), frame.x.max()) == (pytest.approx(20, abs=0.3), pytest.approx(60, abs=0.3))
    assert (frame.y.min(), frame.y.max()) == (pytest.approx(30, abs=0.3), pytest.approx(75, abs=0.3))


def test_the_frame_is_the_part_that_was_solved():
    """A window of a part and its mirror images is twice as long along each side as the part."""
    window = height_map(np.zeros((40, 60)), (3e-6, 2e-6)).assign_attrs(
        window_offset_x=5e-6, window_offset_y=7e-6
    )
    assert _frame(window) == pytest.approx((5e-6, 7e-6, 120e-6, 120e-6))
    assert _frame(window.drop_attrs()) == pytest.approx((0, 0, 120e-6, 120e-6))
    mirrored = window.assign_attrs(periodisation="mirror")
    assert _frame(mirrored) == pytest.approx((5e-6, 7e-6, 60e-6, 60e-6))


@pytest.mark.parametrize(("points", "is_pixelated"), [(200, True), (300, False)])
def test_of_a_coarse_map_every_point_is_a_rectangle(points, is_pixelated):
    source = unquote(map_plots.height_map(height_map(np.eye(points), 1e-6)).source())
    assert ("image-rendering" in source) == is_pixelated


@pytest.mark.parametrize(("ratio", "in_scale"), [(4.0, True), (4.1, False), (0.25, True), (0.24, False)])
def test_a_long_map_says_that_it_is_not_to_scale(ratio, in_scale):
    chart = map_plots.height_map(height_map(np.eye(10), (ratio * 1e-6, 1e-6)))
    assert reading(chart)["y"][0] == "y (µm)" + ("" if in_scale else ", not to scale")
    width, height = (
        float(value)
        for value in re.search(r'<image width="([\d.]+)" height="([\d.]+)"', unquote(chart.source())).groups()
    )
    assert height / width == pytest.approx(ratio if in_scale else 1.0, rel=0.01)
    assert max(width / 240, height / 330) == pytest.approx(1.0, rel=0.01)


def test_pressures_and_gaps_share_their_colours_among_loads():
    """But for one in 200 of the points in contact, or apart, which may lie above the highest colour."""
    height = height_map(np.zeros((20, 40)), 1e-6)
    pressure = np.zeros((20, 40))
    pressure[:10] = np.arange(1, 401).reshape(10, 40) * 1e6
    gap = np.where(pressure > 0, 0.0, 2e-6)
    gap[-1, 0] = 9e-6  # a pit
    weak, wide = pressure / 2, 1.5 * gap
    highest, widest = map_plots.common_limits([(pressure, gap), (weak, wide)])
    assert highest == pytest.approx(np.percentile(np.arange(1, 401), 99.5) * 1e6)
    assert widest == pytest.approx(3e-6)
    assert map_plots.common_limits([(0 * pressure, gap)]) == (1.0, 2e-6)
    for of_load, above in ((pressure, 1), (weak, 0)):
        source = map_plots.pressure_map(height, of_load, highest=highest)
        assert reading(source)["value"] == ["pressure (MPa)", 0.0, pytest.approx(highest / 1e6)]
        assert reading(source)["bad"][1] == "no contact"
        assert arrows(source) == above
    colour_range = reading(map_plots.pressure_map(height, weak))["value"]
    assert colour_range[2] == pytest.approx(highest / 2e6)
    for options, last in (({"widest": widest}, 3.0), ({}, 2.0)):
        source = map_plots.gap_map(height, gap, pressure, **options)
        read = reading(source)
        assert (read["value"], read["bad"][1]) == (["gap (µm)", 0.0, pytest.approx(last)], "contact")
        assert arrows(source) == 1


def test_full_contact_has_the_colours_of_the_heights():
    height = rough((4, 5), 1e-6)
    read = reading(map_plots.gap_map(height, np.zeros((4, 5)), np.ones((4, 5))))
    assert read["value"][2] == pytest.approx(1e6 * np.ptp(height.values))


@pytest.mark.parametrize(("shape", "axis"), [((1, 60), "x"), ((60, 1), "y")])
def test_profiles_are_lines_along_their_length(shape, axis):
    height = rough(shape, 2e-6) - 5e-3
    drawn = read_chart(map_plots.height_map(height, along=Unit(1e3, "mm")))
    assert {f"{axis} (mm)", "height (µm)"} <= set(drawn.texts)
    (line,) = drawn.lines
    room = 0.06 * 1e6 * np.ptp(height.values)
    assert drawn.y_ends == pytest.approx([line.y.min() - room, line.y.max() + room], abs=0.02)
    assert drawn.x_ends == pytest.approx([0, 2e-3 * 59], abs=1e-4)
    assert line.x == pytest.approx(2e-3 * np.arange(60), abs=2e-4)
    assert line.y == pytest.approx(1e6 * height.values.ravel(), abs=0.02)
    gap = np.abs(np.sin(np.arange(60.0))).reshape(shape) * 1e-6
    faces = read_chart(map_plots.gap_map(height, gap, np.zeros(shape)))
    for label, values in (("rough surface", height.values), ("deformed surface", height.values + gap)):
        assert faces.labelled(label).y == pytest.approx(1e6 * values.ravel(), abs=0.02)
    load = read_chart(map_plots.pressure_map(height, 3e6 * np.ones(shape) * np.arange(60).reshape(shape)))
    assert load.lines[0].colour == COLOURS[1]
    assert load.lines[0].y == pytest.approx(3.0 * np.arange(60), abs=1)
    assert "pressure (MPa)" in load.texts


def test_what_is_drawn_is_not_kept():
    """Garbage is looked for rarely, and each map that lives on takes as much memory as the one drawn."""
    chart = map_plots.height_map(rough((32, 32), 1e-6))
    (values,) = (weakref.ref(step["values"]) for name, step in chart.steps if name == "values")
    gc.disable()
    try:
        assert chart.source()
        del chart
        assert values() is None
    finally:
        gc.enable()
