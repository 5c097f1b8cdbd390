"""Laws that levelling, filling and the window keep for any map."""

import json
from collections import Counter
from typing import get_args

import numpy as np
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from roughcontact import height_map, level, periodic_window, solve_contact
from roughcontact.arguments.choices import WindowMethod
from roughcontact.surface.levelling.filling import fill_harmonic, find_holes
from roughcontact.surface.levelling.forms import form_from_record
from roughcontact.surface.roughness import parameters
from roughcontact.surface.window import periodisation
from roughcontact.surface.window.rectangle import largest_rectangle
from roughcontact.surface.window.sides import friendly_sides
from roughcontact.uncertainty.budget_inputs import budget_inputs

quick = settings(max_examples=60, deadline=None)

shapes = st.tuples(st.integers(1, 14), st.integers(2, 16))
pitches = st.tuples(st.floats(0.1, 10), st.floats(0.1, 10))


def lengths(limit):
    """Return numbers up to a limit whose squares are not lost to underflow, as no surface's are."""
    return st.floats(-limit, limit).map(lambda number: number if abs(number) >= 1e-100 else 0.0)


@st.composite
def maps(draw, missing=False):
    shape = draw(shapes)
    values = draw(arrays(float, shape, elements=lengths(1)))
    if missing:
        lost = draw(arrays(bool, shape, elements=st.booleans()))
        lost.flat[draw(st.integers(0, lost.size - 1))] = False
        values = np.where(lost, np.nan, values)
    return height_map(values, draw(pitches))


def leaves_heights(height, form, order):
    """Return whether a map has the four points for each term without which a polynomial is refused."""
    if form != "polynomial":
        return True
    ny, nx = height.shape
    terms = sum(j + i <= order for j in range(ny) for i in range(nx))
    return np.isfinite(height.values).sum() >= 4 * terms


@quick
@given(maps(missing=True), st.sampled_from(["mean", "plane", "polynomial"]), st.integers(1, 3), st.booleans())
def test_form_and_residual_make_up_the_map(height, form, order, robust):
    assume(leaves_heights(height, form, order))
    levelled = level(
        height, form=form, order=order, robust=robust, outlier_threshold=None, fill="none", max_missing=1
    )
    record = json.loads(levelled.attrs["form_removed"])
    removed_form = form_from_record(record, height["y"].values, height["x"].values)
    scale = max(1.0, np.abs(removed_form).max())
    np.testing.assert_allclose((levelled.values + removed_form), height.values, atol=1e-9 * scale)
    np.testing.assert_array_equal(np.isnan(levelled.values), np.isnan(height.values))


@quick
@given(maps(), st.sampled_from(["plane", "polynomial"]))
def test_levelling_twice_changes_nothing(height, form):
    assume(leaves_heights(height, form, 2))
    once = level(height, form=form, outlier_threshold=None)
    twice = level(once, form=form, outlier_threshold=None)
    np.testing.assert_allclose(twice.values, once.values, atol=1e-10)


@quick
@given(maps(), lengths(3), lengths(3), lengths(100))
def test_a_tilt_makes_no_difference(height, slope_y, slope_x, offset):
    y, x = height["y"].values[:, None], height["x"].values[None, :]
    tilted = height.copy(data=height.values + slope_y * y + slope_x * x + offset)
    plain = level(height, outlier_threshold=None)
    np.testing.assert_allclose(level(tilted, outlier_threshold=None).values, plain.values, atol=1e-9)


@quick
@given(maps(missing=True))
def test_filling_obeys_the_maximum_principle(height):
    values = height.values
    labels, sizes = find_holes(np.isnan(values))
    filled = fill_harmonic(values, labels, (1.0, 2.0))
    assert sizes.sum() == np.count_nonzero(labels)
    heights = values[~np.isnan(values)]
    inside = filled[labels > 0]
    tolerance = 1e-7 * (np.ptp(heights) + np.abs(heights).max())
    assert ((inside >= heights.min() - tolerance) & (inside <= heights.max() + tolerance)).all()
    np.testing.assert_array_equal(filled[labels == 0], values[labels == 0])


@quick
@given(arrays(bool, shapes))
def test_rectangle_is_good_and_nothing_beside_it_is_larger(good):
    sides = friendly_sides(max(good.shape))
    y0, x0, height, width = largest_rectangle(good, sides)
    assert good[y0 : y0 + height, x0 : x0 + width].all()
    longest_row = max(
        (len(run) for row in good for run in "".join(".x"[int(c)] for c in row).split(".")), default=0
    )
    assert sides[height] * sides[width] >= sides[min(longest_row, good.shape[1])] * sides[1]


@quick
@given(maps(missing=True), st.sampled_from(get_args(WindowMethod)), st.floats(0, 0.5))
def test_any_window_is_whole_and_its_record_true(height, method, width):
    levelled = level(height, outlier_threshold=None, max_missing=1)
    try:
        window = periodic_window(levelled, method=method, width=width, min_share=0)
    except ValueError as error:
        assert "no two neighbouring points" in str(error) or "missing" in str(error)  # noqa: PT017
        return
    assert np.isfinite(window.values).all()
    assert window["filled"].shape == window.shape
    assert 0 < window.attrs["window_share"] <= 1
    gradient = parameters.rms_gradient(window)
    assert abs(window.attrs["rms_gradient_after"] - gradient) <= 1e-12 * max(gradient, 1e-300)


def count_of_largest_rectangles(measured):
    """Return how many rectangles without a missing point have the most points that one has."""
    counts = Counter()
    for top in range(len(measured)):
        for bottom in range(top + 1, len(measured) + 1):
            edges = np.flatnonzero(np.diff(measured[top:bottom].all(axis=0), prepend=False, append=False))
            counts.update((bottom - top) * (edges[1::2] - edges[::2]))
    return counts[max(counts)]


@settings(max_examples=20, deadline=None, phases=[Phase.generate])  # a smaller map would be no clearer
@given(
    st.tuples(st.integers(40, 90), st.integers(40, 90)),
    st.integers(0, 2**32 - 1),
    st.integers(0, 2),
    st.sampled_from(get_args(WindowMethod)),
    st.data(),
)
def test_a_mirrored_or_transposed_map_has_the_same_contact(shape, seed, holes, method, data):
    """To 0.5 % of the area, for odd and even sides, steep waves as long as the map, and holes.

    Holes may leave two largest rectangles, of which any will do.
    """
    values = 0.05 * np.cumsum(np.cumsum(np.random.default_rng(seed).standard_normal(shape), 0), 1)
    for _ in range(holes):
        y, x = (data.draw(st.integers(0, n - 1)) for n in shape)
        values[y : y + shape[0] // 6, x : x + shape[1] // 6] = np.nan
    assume(not holes or count_of_largest_rectangles(np.isfinite(values)) == 1)
    # rows are those of a scanner: their alignment does not know columns
    options = {"line_alignment": "none", "outlier_threshold": None, "fill": "none", "max_missing": 1}
    areas = []
    for variant in (values, values[:, ::-1], values[::-1], values.T):
        window = periodic_window(level(height_map(variant, 1.0), **options), method=method)
        load = 0.05 * (areas[0][1] if areas else window.attrs["rms_gradient_after"])
        solved = solve_contact(
            window, contact_modulus=1.0, mean_pressure=load, tolerance=1e-8, reduce=budget_inputs
        )
        areas.append((solved["relative_contact_area"].item(), load / 0.05))
    area = np.array(areas)[:, 0]
    np.testing.assert_allclose(area, area[0], rtol=5e-3)


@quick
@given(maps(), st.floats(1e-9, 1e9))
def test_units_make_no_difference(height, unit):
    # without the record of the form that was removed, which a periodic map gets back
    levelled = level(height, outlier_threshold=None).assign_attrs(form_removed="{}")
    scaled = height_map(levelled.values * unit, 1.0).assign_coords(y=height["y"] * unit, x=height["x"] * unit)
    a, b = periodic_window(levelled), periodic_window(scaled)
    np.testing.assert_allclose(b.values, a.values * unit, atol=1e-11 * unit)
    assert a.attrs["periodisation"] == b.attrs["periodisation"]
    ratio = parameters.rms_gradient(b) - parameters.rms_gradient(a)
    assert abs(ratio) <= 1e-9 * max(parameters.rms_gradient(a), 1e-12)


@quick
@given(maps(), st.integers(0, 13), st.integers(0, 15))
def test_roughness_does_not_depend_on_the_start(height, dy, dx):
    rolled = height.copy(data=np.roll(height.values, (dy, dx), (0, 1)))
    for name, value in parameters.roughness_parameters(height).items():
        rolled_value = parameters.roughness_parameters(rolled)[name]
        if name in ("rms_height", "rms_gradient", "rms_curvature"):
            assert abs(rolled_value - value) <= 1e-9 * max(value, 1e-12)


@quick
@given(maps())
def test_periodic_plus_smooth_keeps_mean_and_linearity(height):
    values = height.values
    once = periodisation.periodic_plus_smooth(values, (2.0, 1.0))
    assert abs(once.mean() - values.mean()) < 1e-12
    twice = periodisation.periodic_plus_smooth(3 * values + 5, (2.0, 1.0))
    np.testing.assert_allclose(twice, 3 * once + 5, atol=1e-11)
