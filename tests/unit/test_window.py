"""The window: the best rectangle, good sides, and a true record of what was done."""

import json
from typing import get_args

import numpy as np
import pytest
from known_surfaces import self_affine
from shared_data import DATA

from roughcontact import HeightMapError, SettingsError, height_map, level, periodic_window, read_height_map
from roughcontact.arguments.choices import PERIODIC_BY, Placement, WindowMethod
from roughcontact.arguments.maps import spacing
from roughcontact.statistics.map_checks import FORM
from roughcontact.surface import synthetic
from roughcontact.surface.roughness.parameters import rms_gradient, rms_height
from roughcontact.surface.window.rectangle import largest_rectangle
from roughcontact.surface.window.sides import friendly_sides

METHODS = get_args(WindowMethod)


def cut_out(shape=(100, 130), pitch=(2e-6, 1e-6), seed=0):
    large = self_affine(
        (2 * shape[0] if shape[0] > 1 else 1, 2 * shape[1]), pitch, (8e-6, 100e-6), rms_height=1e-7, seed=seed
    )
    return large.isel(y=slice(shape[0]), x=slice(shape[1]))


def largest_by_trying(good, sides):
    best = 0
    for top in range(good.shape[0]):
        for bottom in range(top + 1, good.shape[0] + 1):
            run = 0
            for column in good[top:bottom].all(axis=0):
                run = run + 1 if column else 0
                best = max(best, sides[bottom - top] * sides[run])
    return best


def test_largest_rectangle_against_trying_all():
    generator = np.random.default_rng(0)
    for number in range(150):
        good = generator.random(generator.integers(1, 26, 2)) < (generator.random() if number % 5 else 1)
        for sides in (np.arange(41), friendly_sides(40, fade=0.2)):
            y0, x0, height, width = largest_rectangle(good, sides)
            assert good[y0 : y0 + height, x0 : x0 + width].all()
            assert sides[height] * sides[width] == largest_by_trying(good, sides)


@pytest.mark.parametrize("turned", [np.s_[::-1], np.s_[:, ::-1], np.s_[::-1, ::-1]])
def test_the_rectangle_of_a_map_turned_over_is_the_same_turned_over(turned):
    y, x = np.indices((43, 42))
    pupil = np.hypot(y - 21.5, x - 19.0) < 20  # many rectangles in it hold equal windows
    for good in (pupil, np.ones((43, 42), dtype=bool)):
        y0, x0, height, width = largest_rectangle(good, friendly_sides(43))
        chosen = np.zeros(good.shape, dtype=bool)
        chosen[y0 : y0 + height, x0 : x0 + width] = True
        y0, x0, height, width = largest_rectangle(good[turned], friendly_sides(43))
        assert chosen[turned][y0 : y0 + height, x0 : x0 + width].all()
        assert height * width == chosen.sum()


def test_largest_rectangle_of_a_large_map_in_seconds():
    good = np.random.default_rng(0).random((4096, 4096)) < 0.9999
    y0, x0, height, width = largest_rectangle(good, friendly_sides(4096))
    assert good[y0 : y0 + height, x0 : x0 + width].all()
    assert height * width > 50_000


@pytest.mark.cases
def test_friendly_sides(points, side):
    assert friendly_sides(points)[points] == side


def test_friendly_sides_fit_have_small_factors_and_lose_little():
    sides = friendly_sides(3000)
    for points in range(33, 3001):
        side = int(sides[points])
        assert 0.88 * points <= side <= points
        for factor in (2, 3, 5):
            while side % factor == 0:
                side //= factor
        assert side == 1
    assert (np.diff(sides) >= 0).all()
    with_band = friendly_sides(500, fade=0.125)
    assert all(side + round(0.125 * side) <= n for n, side in enumerate(with_band) if n)


@pytest.mark.parametrize("method", METHODS)
def test_record_of_each_method(method):
    levelled = level(cut_out((100, 130)))
    window = periodic_window(levelled, placement="largest", method=method, width=0.1)
    attrs = window.attrs
    assert attrs["periodisation"] == method
    assert np.isfinite(window.values).all()
    assert window.dims == ("y", "x")
    assert spacing(window) == pytest.approx(spacing(levelled))
    assert window["filled"].shape == window.shape
    assert attrs["rms_gradient_after"] == pytest.approx(rms_gradient(window), rel=1e-12)
    change = attrs["periodisation_rms_change"]
    assert attrs["periodisation_relative_change"] == pytest.approx(change / rms_height(window), rel=1e-9)
    assert (change == 0) == (method in ("raw", "mirror"))
    assert all(isinstance(value, (str, int, float)) for value in attrs.values())
    fades = ("cross-fade", "smooth-cross-fade")
    shapes = {"mirror": (200, 256)} | dict.fromkeys(fades, (90, 108))
    assert window.shape == shapes.get(method, (100, 128))
    used_points = 100 * 120 if method in fades else 100 * 128
    assert attrs["window_share"] == pytest.approx(used_points / 13000)
    assert f"made periodic by {PERIODIC_BY.get(method)}" in attrs["window_reason"] or method == "raw"
    if method != "mirror":
        offset = {d: float(window[d][0] - levelled[d][0]) for d in "yx"}
        assert attrs["window_offset_x"] == pytest.approx(offset["x"], abs=1e-15)
        assert attrs["window_offset_y"] == pytest.approx(offset["y"], abs=1e-15)


def test_raw_window_is_a_plain_cut():
    levelled = level(cut_out((100, 130)))
    window = periodic_window(levelled, placement="largest", method="raw")
    same = levelled.sel(y=window["y"], x=window["x"], method="nearest", tolerance=1e-12)
    np.testing.assert_array_equal(window.values, same.values)
    # the solver sees the steps at the seams, the measured part has none
    assert window.attrs["rms_gradient_after"] > 1.2 * window.attrs["rms_gradient_before"]


@pytest.mark.parametrize("method", METHODS)
def test_gradient_before_is_that_of_the_inside(method):
    window = periodic_window(level(cut_out((256, 300))), method=method)
    gradient_before, gradient_after = (window.attrs[f"rms_gradient_{when}"] for when in ("before", "after"))
    if method == "mirror":
        assert gradient_before == pytest.approx(gradient_after, rel=1e-12)
    elif method == "raw":
        assert gradient_after > 1.2 * gradient_before
    else:
        assert gradient_before == pytest.approx(gradient_after, rel=0.03 if "smooth" in method else 0.1)


@pytest.mark.parametrize("shape", [(96, 128), (1, 200)])
def test_share_of_the_form_is_known(shape):
    height = height_map(np.random.default_rng(0).standard_normal(shape), (2e-6, 1e-6))
    x = np.linspace(-1, 1, shape[1])
    bow = np.sqrt(45 / 4) * (x**2 - 1 / 3)  # of rms height 1
    for share in (0.0, 0.5, 0.9):
        values = np.sqrt(1 - share) * height.values + np.sqrt(share) * bow
        window = periodic_window(height.copy(data=values), method="raw")
        assert window.attrs["form_share"] == pytest.approx(share, abs=0.05)
    flat = periodic_window(height.copy(data=np.full(shape, 0.1)))
    assert flat.attrs["form_share"] == 0


def test_missing_border_is_cut_and_flags_are_kept():
    values = cut_out((96, 160)).values
    values[:, :30] = np.nan
    values[90:, 100] = np.nan
    values[40:44, 60:63] = np.nan
    levelled = level(height_map(values, (2e-6, 1e-6)))
    options = {"placement": "largest"}
    window = periodic_window(levelled, method="periodic-plus-smooth", **options)
    assert window.shape == (90, 128)
    assert np.isfinite(window.values).all()
    assert window.attrs["window_offset_x"] == pytest.approx(31e-6)
    assert window.attrs["window_offset_y"] == 0
    assert int(window["filled"].sum()) == 12
    assert window["filled"].values[40:44, 29:32].all()
    assert "largest rectangle without missing points" in window.attrs["window_reason"]
    fading = periodic_window(levelled, method="cross-fade", **options)
    assert 0 < int(fading["filled"].sum()) <= 24
    assert int(periodic_window(levelled, method="mirror", **options)["filled"].sum()) == 48


def test_periodic_map_is_left_alone():
    height = synthetic.rough_reference_surface(101)
    for method in METHODS:
        window = periodic_window(level(height, form="mean"), method=method)
        assert window.attrs["periodisation"] == "none"
        assert window.attrs["window_share"] == 1
        assert "left alone" in window.attrs["window_reason"]
        np.testing.assert_allclose(window.values, height.values, atol=1e-16)


@pytest.mark.parametrize(("form", "order"), [("plane", 1), ("polynomial", 3)])
def test_form_that_broke_a_periodic_map_is_put_back(form, order):
    height = synthetic.rough_reference_surface(101)
    levelled = level(height, form=form, order=order)
    assert np.abs(levelled.values - height.values).max() > 0.05 * rms_height(height)
    window = periodic_window(levelled)
    assert window.attrs["periodisation"] == "none"
    np.testing.assert_allclose(window.values, height.values - height.values.mean(), atol=1e-15)
    assert list(json.loads(window.attrs["form_removed"])) == ["mean"]
    assert window.attrs["form"] == "mean"


def test_tilted_measurement_does_not_get_its_tilt_back():
    height = cut_out((96, 128))
    tilted = height.copy(data=height.values + 0.02 * height["x"].values)
    window = periodic_window(level(tilted))
    assert window.attrs["periodisation"] == "smooth-cross-fade"
    assert abs(np.polyfit(np.arange(window.shape[1]), window.values.mean(axis=0), 1)[0]) < 1e-3 * 1e-6


@pytest.mark.parametrize("shape", [(1, 301), (2, 300), (7, 4), (101, 99), (3, 3), (1, 2)])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("placement", get_args(Placement))
def test_profiles_thin_small_and_odd_maps(shape, method, placement):
    height = height_map(np.random.default_rng(0).standard_normal(shape), (3e-6, 1e-6))
    window = periodic_window(level(height, outlier_threshold=None), method=method, placement=placement)
    assert np.isfinite(window.values).all()
    assert (window.shape[0] == 1) == (shape[0] == 1)
    assert window.size >= 2


def test_flat_map_is_periodic():
    window = periodic_window(level(height_map(np.full((20, 30), 2.0), 1e-6)))
    assert window.attrs["periodisation"] == "none"
    assert window.attrs["periodisation_relative_change"] == 0
    assert window.attrs["rms_gradient_after"] == 0


def test_maps_without_a_window():
    with pytest.raises(HeightMapError, match="a single point"):
        periodic_window(height_map([[1.0]], 1.0))
    with pytest.raises(HeightMapError, match="missing"):
        periodic_window(height_map(np.full((5, 5), np.nan), 1.0))
    scattered = np.where(np.indices((40, 40)).sum(axis=0) % 2, 1.0, np.nan)
    with pytest.raises(HeightMapError, match="no two neighbouring points"):
        periodic_window(height_map(scattered, 1.0))
    holes = cut_out((120, 120)).values
    holes[::8, ::8] = np.nan
    with pytest.raises(HeightMapError, match=r"window.min_share = 0.1: fill the holes"):
        periodic_window(height_map(holes, 1.0), min_share=0.1)
    assert periodic_window(height_map(holes, 1.0), min_share=0.0, method="raw").shape == (7, 120)


def test_limits_of_the_options_are_allowed():
    levelled = level(cut_out((40, 50)))
    assert periodic_window(levelled, width=0.0, min_share=0.0).shape == (40, 50)
    half = periodic_window(levelled, width=0.5)  # 26 + 13 of 40, 32 + 16 of 50 points
    assert half.shape == (26, 32)
    for options in ({"width": 0.5001}, {"width": -0.0001}, {"min_share": 1.0001}, {"min_share": -0.0001}):
        with pytest.raises(SettingsError, match="give a share"):
            periodic_window(levelled, **options)


@pytest.mark.parametrize("placement", ["largest", "whole-periods"])
def test_a_window_may_be_just_as_small_as_the_least_share(placement):
    """27 x 50 of 30 x 100 points: the left half is missing, and three rows."""
    values = cut_out((30, 100)).values
    values[:, :50] = values[27:] = np.nan
    height = height_map(values, 1e-6)
    options = {"placement": placement, "method": "raw"}
    assert periodic_window(height, min_share=0.45, **options).attrs["window_share"] == 0.45
    with pytest.raises(HeightMapError, match=r"has 50 x 27 points, 45\.0 % of the map"):
        periodic_window(height, min_share=0.4501, **options)


def test_the_window_lies_in_the_middle_of_the_rectangle():
    """Of 107 columns it has 100 and leaves 3 or 4 in front: the end columns that differ less decide."""
    levelled = level(cut_out((101, 107)))
    window = periodic_window(levelled, method="raw")
    assert window.shape == (100, 100)
    heights = levelled.values
    step = [np.sum((heights[:, start + 99] - heights[:, start]) ** 2) for start in (3, 4)]
    assert window.attrs["window_offset_x"] == pytest.approx((3 + np.argmin(step)) * 1e-6)
    mirrored = periodic_window(level(levelled.copy(data=heights[:, ::-1])), method="raw")
    np.testing.assert_allclose(mirrored.values, window.values[:, ::-1], atol=1e-15)


def test_a_blended_point_counts_as_filled_where_a_filled_one_has_a_weight():
    values = cut_out((64, 110)).values
    values[20, 2] = np.nan  # in the band along x: it is blended with the point one side on
    levelled = level(height_map(values, 1e-6))
    window = periodic_window(levelled, method="cross-fade", width=0.1)
    assert window.shape == (54, 100)
    assert np.argwhere(window["filled"].values == 1).tolist() == [[15, 97]]  # row 2 is its first: 60 of 64
    values = cut_out((64, 110)).values
    values[20, 102] = np.nan  # the other one of the two
    window = periodic_window(level(height_map(values, 1e-6)), method="cross-fade", width=0.1)
    assert np.argwhere(window["filled"].values == 1).tolist() == [[15, 97]]


@pytest.mark.cases
def test_options_without_meaning(options, message):
    with pytest.raises(SettingsError, match=message):
        periodic_window(cut_out(), **options)


@pytest.mark.shared_data
@pytest.mark.parametrize(
    ("file", "kinds", "least_share"),
    [
        ("frt-1.frt", {"spike"}, 0.55),  # a third missing at the border, one line not scanned
        ("valid_zygo_dat_file.dat", set(), 0.4),  # a round pupil
        ("KautschukInfiniteFocus.x3p", set(), 0.85),
        ("plu-1.plu", {"spike"}, 0.95),
        ("opdx-3.opdx", set(), 0.95),  # a profile
    ],
)
def test_real_files_get_a_window(file, kinds, least_share):
    levelled = level(read_height_map(DATA / file))
    assert kinds <= set(json.loads(levelled.attrs["outlier_kinds"]))
    assert levelled.attrs["outliers_rejected"] < 0.005 * levelled.size
    # without a band for blending, which costs friendly sides
    full_window = periodic_window(levelled, method="periodic-plus-smooth")
    assert full_window.attrs["window_share"] > least_share
    shortened = periodic_window(levelled, placement="whole-periods")
    for window, part in ((full_window, 0.7), (periodic_window(levelled), 0.7), (shortened, 0.7**2)):
        assert np.isfinite(window.values).all()
        assert window.attrs["window_share"] > part * least_share
        gradients = [window.attrs[f"rms_gradient_{when}"] for when in ("before", "after")]
        # the band closes the ends of a bow, which makes it steeper; map_checks.FORM says so to the user
        form = window.attrs["form_share"] > FORM
        assert gradients[1] == pytest.approx(gradients[0], rel=0.05 if form else 0.03)


@pytest.mark.shared_data
def test_real_file_that_is_mostly_missing_is_refused():
    with pytest.raises(HeightMapError, match=r"sur-3\.sur: 88\.9 % of the points are missing"):
        level(read_height_map(DATA / "sur-3.sur"))


def test_a_periodic_map_begins_where_it_begins_and_is_not_changed():
    window = periodic_window(level(synthetic.rough_reference_surface(101), form="mean"))
    assert window.attrs["periodisation_rms_change"] == window.attrs["periodisation_relative_change"] == 0.0
    assert (window.attrs["window_offset_x"], window.attrs["window_offset_y"]) == (0.0, 0.0)


@pytest.mark.cases
def test_the_reason_names_the_points_that_are_left_where_that_is_another_number(method, ending):
    window = periodic_window(level(cut_out((100, 130))), method=method)
    assert window.attrs["window_reason"].endswith(f"; {ending}")


def test_where_nothing_is_measured_the_largest_rectangle_has_no_points():
    assert largest_rectangle(np.zeros((3, 4), dtype=bool), np.arange(5))[2:] == (0, 0)
