"""Laws that filters, line alignment and spectra keep for any map."""

import json

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from roughcontact import height_map, level
from roughcontact.surface.levelling.filters import gaussian_mean_surface
from roughcontact.surface.levelling.scan_lines import find_scars, line_offsets
from roughcontact.surface.roughness.heights import height_parameters
from roughcontact.surface.roughness.parameters import rms_height
from roughcontact.surface.roughness.texture import texture_parameters
from roughcontact.surface.window.band import limit_band

quick = settings(max_examples=60, deadline=None)
heights = arrays(
    float, st.tuples(st.integers(1, 12), st.integers(2, 14)), elements=st.floats(-1, 1, width=32)
)
indices = st.floats(0.2, 60)


def with_holes(values, lost):
    values = np.where(np.resize(lost, values.shape), np.nan, values)
    values.flat[0] = 0.5  # something is measured
    return values


holes = st.lists(st.booleans(), min_size=1, max_size=150)


@quick
@given(heights, holes, indices, st.floats(-3, 3), st.floats(-3, 3), st.floats(-9, 9))
def test_the_filter_is_linear_and_keeps_planes(values, lost, index, slope_y, slope_x, offset):
    values = with_holes(values, lost)
    y, x = np.indices(values.shape)
    plane = offset + slope_y * 2.0 * y + slope_x * x
    mean = gaussian_mean_surface(values, (2.0, 1.0), index)
    tilted = gaussian_mean_surface(values + plane, (2.0, 1.0), index)
    np.testing.assert_allclose(tilted, mean + plane, atol=1e-5)
    np.testing.assert_allclose(gaussian_mean_surface(3 * values, (2.0, 1.0), index), 3 * mean, atol=1e-5)
    np.testing.assert_array_equal(np.isnan(mean), np.isnan(values))


@quick
@given(heights, st.floats(1e-9, 1e6), indices)
def test_the_filter_does_not_depend_on_the_unit_of_length(values, unit, index):
    mean = gaussian_mean_surface(values, (2.0, 1.0), index)
    scaled = gaussian_mean_surface(values, (2.0 * unit, unit), index * unit)
    np.testing.assert_allclose(scaled, mean, atol=1e-6)


@quick
@given(heights, holes, st.sampled_from(["median", "matched-steps"]))
def test_aligned_lines_need_no_further_shift(values, lost, method):
    values = with_holes(values, lost)
    offsets = line_offsets(values, method=method)
    second_offsets = line_offsets(values - offsets[:, None], method=method)
    np.testing.assert_allclose(second_offsets, 0, atol=1e-9)


@quick
@given(heights, holes, st.sampled_from(["sphere", "cylinder"]), st.sampled_from(["median", "matched-steps"]))
def test_what_levelling_took_makes_up_the_map(values, lost, form, method):
    from roughcontact.surface.levelling.forms import form_from_record

    height = height_map(with_holes(values, lost), (2.0, 1.0))
    try:
        levelled = level(
            height, form=form, line_alignment=method, outlier_threshold=None, fill="none", max_missing=1
        )
    except ValueError as error:
        assert "beyond the rim" in str(error)  # noqa: PT017
        return
    record = json.loads(levelled.attrs["form_removed"])
    removed_form = form_from_record(record, height["y"].values, height["x"].values)
    sum_of_parts = levelled.values + removed_form + levelled["line_offset"].values[:, None]
    np.testing.assert_allclose(sum_of_parts, height.values, atol=1e-6 * max(1.0, np.abs(removed_form).max()))


@quick
@given(heights, st.floats(0.5, 9))
def test_scars_are_the_same_upside_down(values, threshold):
    wide = np.tile(values, (2, 3))
    np.testing.assert_array_equal(
        find_scars(wide, threshold=threshold), find_scars(-wide, threshold=threshold)
    )


@quick
@given(heights)
def test_height_parameters_keep_their_order(values):
    parameters = height_parameters(height_map(values, 1.0))
    rounding = 1e-12
    assert parameters["Sa"] <= parameters["Sq"] + rounding
    assert parameters["Sq"] <= max(parameters["Sp"], parameters["Sv"]) + rounding
    assert abs(parameters["Sp"] + parameters["Sv"] - parameters["Sz"]) <= rounding
    if parameters["Sq"] > 1e-9:
        assert parameters["Sku"] >= 1 + parameters["Ssk"] ** 2 - 1e-6  # Pearson's inequality


@quick
@given(heights, st.floats(1, 40), st.floats(1, 40))
def test_band_and_rest_make_up_the_variance(values, a, b):
    height = height_map(values, (2.0, 1.0))
    try:
        band = limit_band(height, shortest_wavelength=min(a, b), longest_wavelength=max(a, b) + 1e-3)
    except ValueError as error:
        assert "no wave" in str(error)  # noqa: PT017
        return
    total = rms_height(height) ** 2
    assert abs(rms_height(band) ** 2 + band.attrs["band_removed_rms_height"] ** 2 - total) <= 1e-9


@quick
@given(heights)
def test_texture_lies_within_its_bounds(values):
    height = height_map(values, (2.0, 1.0))
    texture = texture_parameters(height)
    if np.ptp(values) < 1e-6:
        return
    assert 0 < texture["Sal"] <= max(2.0 * values.shape[0], values.shape[1])
    if min(values.shape) > 1:
        assert np.isnan(texture["Str"]) or 0 < texture["Str"] <= 1  # not known where the map is too narrow
        assert 0 <= texture["Std"] < 180
