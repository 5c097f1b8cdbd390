"""The figures against the load, read back by their axes: every number lies where the reader looks for it."""

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine
from read_charts import read_chart

from roughcontact.report import load_plots
from roughcontact.report.charts import COLOURS, series_style
from roughcontact.statistics import theory
from roughcontact.surface.roughness.summits import summit_statistics

WITHIN = 0.01  # a tenth of a pixel of these axes
LOADS = np.array([1e6, 5e6, 2e8])
AREAS = np.array([0.004, 0.02, 0.5])


def numbers(**options):
    """Return statistics of three loads, E* g = 1 GPa, with intervals that reach farther up than down."""
    columns = {
        "relative_contact_area": AREAS,
        "relative_contact_area_pixels": 1.25 * AREAS,
        "relative_pressure": LOADS / 1e9,
        "mean_gap": [2e-6, 1e-6, 1e-7],
        "mean_contact_pressure": LOADS / AREAS,
        "max_pressure": [8e8, 9e8, 1e9],
    }
    for name in ("relative_contact_area", "mean_gap", "mean_contact_pressure", "max_pressure"):
        columns[f"{name}_lower"], columns[f"{name}_upper"] = (
            np.multiply(columns[name], f) for f in (0.9, 1.2)
        )
    data = xr.Dataset({name: ("load", np.asarray(values)) for name, values in columns.items()})
    return data.assign(
        mean_pressure=("load", LOADS), contact_modulus=1e10, rms_gradient=0.1, rms_height=1.5e-6, **options
    )


def near(values, tolerance=WITHIN):
    return pytest.approx(np.asarray(values), rel=tolerance)


def assert_bars(bars, x, lower, upper):
    assert bars.x == near(x)
    assert bars.y == near(lower)
    assert bars.upper == near(upper)


def assert_room(drawn, *, least=1.05, highest_ratio=3.0):
    """All marks lie within the axes, and the axes do not go on for long beyond them."""
    for axis_ends, values in (
        (drawn.x_ends, np.concatenate([mark.x for mark in drawn.marks])),
        (drawn.y_ends, np.concatenate([mark.y for mark in drawn.marks])),
    ):
        assert least < values.min() / axis_ends[0] < highest_ratio
        assert least < axis_ends[1] / values.max() < highest_ratio


def test_contact_area_and_theories_against_the_load():
    window = self_affine((64, 64), 1e-6, (8e-6, 32e-6), rms_gradient=0.1, seed=1)
    drawn = read_chart(load_plots.area_against_load(numbers(), window), log="xy")
    assert {"mean pressure (MPa)", "contact area (%)"} <= set(drawn.texts)
    assert drawn.x_ends == near([1 / 1.5, 200 * 1.5])
    assert_room(drawn, highest_ratio=6.0)  # the theories lie below these areas
    for label, areas in (("solved, corrected", AREAS), ("solved, pixels counted", 1.25 * AREAS)):
        marks = drawn.labelled(label)
        assert marks.x == near(LOADS / 1e6)
        assert marks.y == near(100 * areas)
    (bars,) = drawn.bars
    assert_bars(bars, LOADS / 1e6, 90 * AREAS, 120 * AREAS)
    solid, dashed, dotted = (
        next(line for line in drawn.lines if line.style == drawn.legend[label][1])
        for label in ("Xu et al.", "Persson", "Bush et al., low load")
    )
    for line, area in (
        (solid, theory.xu_area),
        (dashed, theory.persson_area),
        (dotted, theory.bush_gibson_thomas_area),
    ):
        reference = 100 * area(line.x / 1e3)
        assert line.x.size > 50
        assert line.y == near(reference, 0.03)
    # over all loads and a little beyond
    assert solid.x[[0, -1]] == near([1 / 1.5, 200 * 1.5])
    line = drawn.labelled("Greenwood-Williamson")
    reference = theory.greenwood_williamson_area(
        line.x * 1e6, summit_statistics(window), contact_modulus=1e10
    )
    assert line.y == near(100 * reference, 0.03)


def test_elastic_theories_are_not_drawn_beside_asperities_that_yield():
    """At these loads A = p/H, which is far above them; the axis ends at full contact."""
    for shares, drawn_to in (([0.0, 0.05, 0.6], LOADS[1]), ([0.3, 0.5, 0.6], None)):
        statistics = numbers().assign(load_share_above_hardness=("load", shares))
        drawn = read_chart(load_plots.area_against_load(statistics, None), log="xy")
        assert ("Persson" in drawn.legend) == load_plots.has_theories(statistics) == (drawn_to is not None)
        if drawn_to is not None:
            solid = next(line for line in drawn.lines if line.style == drawn.legend["Xu et al."][1])
            assert solid.x.max() == near(1.5 * drawn_to / 1e6)
        assert drawn.y_ends[1] == near(100.0)


def compared(results, styles=None):
    """Return what a chart of several surfaces shows, by default in as many colours."""
    styles = styles or {name: series_style(index) for index, name in enumerate(results)}
    return read_chart(load_plots.compare_areas(results, styles), log="xy")


def test_surfaces_side_by_side():
    loads = {"ground": LOADS, "lapped": 2 * LOADS}
    results = {name: numbers().assign(mean_pressure=("load", load)) for name, load in loads.items()}
    drawn = compared(results)
    assert "mean pressure (MPa)" in drawn.texts
    assert "Persson" not in drawn.legend  # over the pressure itself there is no line that fits all
    assert_room(drawn)
    for (name, load), bars in zip(loads.items(), drawn.bars, strict=True):
        marks = drawn.labelled(name)
        assert marks.x == near(load / 1e6)
        assert marks.y == near(100 * AREAS)
        (line,) = [line_drawn for line_drawn in drawn.lines if line_drawn.colour == marks.colour]
        assert (line.x, line.y) == (near(marks.x), near(marks.y))
        assert bars.colour == marks.colour
        assert_bars(bars, load / 1e6, 90 * AREAS, 120 * AREAS)


def test_an_interval_down_to_nothing_does_not_squeeze_what_is_drawn():
    nothing = np.full(LOADS.size, 1e-12)
    statistics = numbers().assign(relative_contact_area_lower=("load", nothing))
    alone = read_chart(load_plots.area_against_load(statistics, None), log="xy")
    for drawn in (compared({"ground": statistics}), alone):
        assert 100 * AREAS.min() / drawn.y_ends[0] == near(20, 0.5)


def test_every_surface_of_many_has_a_mark_of_its_own():
    results = {f"s-{k}": numbers() * (1 - k / 100) for k in range(20)}
    drawn = compared(results)
    assert [drawn.legend[name][0] for name in results] == [COLOURS[k % len(COLOURS)] for k in range(20)]


def test_surfaces_are_colours_and_cases_are_line_styles():
    names = [(surface, case) for case in range(2) for surface in range(2)]
    styles = {f"{surface} · {case}": series_style(surface, case) for surface, case in names}
    drawn = compared(dict.fromkeys(styles, numbers()), styles)
    seen = [(line.colour, line.style) for line in drawn.lines]
    assert seen == [(COLOURS[surface], "6 3" if case else "") for surface, case in names]
    assert seen == [(style["colour"], style["dash"]) for style in styles.values()]
    # marks are filled, or not
    assert [drawn.legend[name] for name in styles] == [
        (COLOURS[surface], "none" if case else COLOURS[surface]) for surface, case in names
    ]


def test_gap_against_the_load():
    drawn = read_chart(load_plots.gap_against_load(numbers()), log="xy")
    assert {"mean gap (µm)", "mean pressure (MPa)"} <= set(drawn.texts)
    assert_room(drawn)
    marks = drawn.labelled("mean gap")
    assert (marks.x, marks.y) == (near(LOADS / 1e6), near([2.0, 1.0, 0.1]))
    assert_bars(drawn.bars[0], LOADS / 1e6, [1.8, 0.9, 0.09], [2.4, 1.2, 0.12])
    assert drawn.labelled("rms height").y == near([1.5, 1.5])


def test_a_gap_that_closes_leaves_the_axis_to_those_that_are_open():
    closed = numbers().assign(mean_gap=("load", [2e-6, 1e-6, 0.0]), mean_gap_lower=("load", [np.nan, 0, 0]))
    drawn = read_chart(load_plots.gap_against_load(closed), log="xy")
    assert drawn.labelled("mean gap").y == near([2.0, 1.0])
    assert drawn.y_ends == near([0.12 / 1.6, 2.4 * 1.6])  # from the upper end of the closed one


def test_pressures_against_the_load_end_at_the_hardness():
    drawn = read_chart(load_plots.pressure_against_load(numbers(hardness=1e9)), log="xy")
    assert {"pressure in contact (MPa)", "mean pressure (MPa)"} <= set(drawn.texts)
    assert_room(drawn)
    largest, mean = drawn.labelled("largest"), drawn.labelled("mean over the contact")
    assert (largest.x, largest.y) == (near(LOADS / 1e6), near([800, 900, 1000]))
    assert (mean.x, mean.y) == (near(LOADS / 1e6), near([250, 250, 400]))
    assert drawn.labelled("hardness").y == near([1000, 1000])
    # the last is the hardness, which is taken as exact
    assert_bars(drawn.bars[0], LOADS[:2] / 1e6, [720, 810], [960, 1000])
    assert_bars(drawn.bars[1], LOADS / 1e6, [225, 225, 360], [300, 300, 480])
    soft = read_chart(load_plots.pressure_against_load(numbers()), log="xy")
    assert "hardness" not in soft.legend
    assert soft.bars[0].upper == near([960, 1080, 1200])


def test_distributions_are_shares_by_a_factor_of_e():
    """Of 50, 30 and 20 % of the contact in three bins of a factor of e, and of 100 % in one of them."""
    bounds = 1e8 * np.exp(np.arange(-2.0, 5))
    bins = np.column_stack([np.append(0, bounds[1:-1]), bounds[1:]])
    widths = np.diff(bins, axis=1).ravel()
    statistics = numbers().isel(load=slice(2))
    statistics["pressure_bin_bounds"] = (("pressure_bin", "bound"), bins)
    shares = np.array([[0, 0, 0.5, 0.3, 0.2, 0], [0, 0, 0, 1.0, 0, 0]])
    statistics["pressure_density"] = (("load", "pressure_bin"), shares / widths)
    drawn = read_chart(load_plots.pressure_distribution(statistics, [0, 1]), log="x")
    assert {"contact pressure p (MPa)", "share of the contact per factor e"} <= set(drawn.texts)
    # the bins that hold some of the contact, and room for the last step and the legend
    assert drawn.x_ends == near([100, 100 * np.exp(3) * 1.15])
    assert drawn.y_ends == pytest.approx([0, 1.05], abs=0.01)
    for label, heights in (("1.00 MPa", [0.5, 0.3, 0.2]), ("5.00 MPa", [0.0, 1.0, 0.0])):
        line = drawn.labelled(label)
        inside = np.searchsorted(line.x, 100 * np.exp([0.5, 1.5, 2.5]))  # ends of steps behind the middles
        assert line.y[inside] == pytest.approx(heights, abs=0.01)
    means = [line for line in drawn.lines if line.style]
    assert [line.x[0] for line in means] == near([250, 250])
    assert drawn.legend["mean over the contact"][0] == means[1].colour
    nothing = statistics.assign(pressure_density=0 * statistics["pressure_density"])
    empty = read_chart(load_plots.pressure_distribution(nothing, [0, 1]), log="x")
    assert empty.x_ends == near(1e-6 * bounds[[1, -1]] * [1, 1.15])


def test_bars_are_explained_where_there_are_any():
    gap = numbers().drop_vars(["relative_contact_area_lower", "relative_contact_area_upper"])
    assert load_plots.bars_in_words(gap) == load_plots.bars_in_words(gap, "relative_contact_area") == ""
    assert load_plots.bars_in_words(gap, "mean_gap", "relative_contact_area") == "Bars: the ±."
    gap = gap.assign(mean_gap_upper=("load", [2e-6, np.nan, 1e-6]))
    assert load_plots.bars_in_words(gap, "mean_gap") == "Bars: the ±; an arrow: nothing bounds it upwards."
