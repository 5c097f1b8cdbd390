"""Levelling: what was put in comes out, roughness stays."""

import json

import numpy as np
import pytest
from known_surfaces import self_affine

from roughcontact import HeightMapError, SettingsError, height_map, level
from roughcontact.surface.levelling.forms import form_from_record
from roughcontact.surface.levelling.polynomial import fit_polynomial


def rough(shape=(96, 128), spacing=(2e-6, 1e-6), seed=0, rms=1e-7):
    return self_affine(shape, spacing, (8e-6, 60e-6), rms_height=rms, seed=seed)


def removed(levelled):
    return {name: entry["value"] for name, entry in json.loads(levelled.attrs["form_removed"]).items()}


def with_form(height, form):
    y, x = height["y"].values[:, None], height["x"].values[None, :]
    return height.copy(data=height.values + form(y - y.mean(), x - x.mean()))


def test_tilt_is_found_and_taken_off():
    tilted = with_form(rough(), lambda y, x: 5e-6 + 0.03 * x - 0.02 * y)
    levelled = level(tilted, outlier_threshold=None)
    assert removed(levelled)["mean"] == pytest.approx(5e-6, abs=1e-9)
    assert removed(levelled)["slope_x"] == pytest.approx(0.03, abs=1e-3)
    assert removed(levelled)["slope_y"] == pytest.approx(-0.02, abs=1e-3)
    # the same as the normal equations solved by another route
    y, x = np.meshgrid(tilted["y"], tilted["x"], indexing="ij")
    design = np.stack(
        [np.ones(x.size), (x.ravel() - x.mean()) / np.ptp(x), (y.ravel() - y.mean()) / np.ptp(y)]
    )
    solution = np.linalg.lstsq(design.T, tilted.values.ravel(), rcond=None)[0]
    expected = tilted.values - (design.T @ solution).reshape(x.shape)
    np.testing.assert_allclose(levelled.values, expected, atol=1e-15)
    assert levelled.attrs["form"] == "plane"
    units = json.loads(levelled.attrs["form_removed"])
    assert (units["mean"]["units"], units["slope_x"]["units"]) == ("m", "1")


@pytest.mark.parametrize("order", [2, 3, 5, 8])
def test_polynomial_of_any_order_comes_off_whole(order):
    generator = np.random.default_rng(order)
    coefficients = generator.standard_normal((order + 1, order + 1))
    shape = (90, 110)
    y, x = np.linspace(-1, 1, 90)[:, None], np.linspace(-1, 1, 110)[None, :]
    form = sum(
        coefficients[i, j] * x**i * y**j for i in range(order + 1) for j in range(order + 1) if i + j <= order
    )
    height = height_map(1e-5 * form, (2e-6, 1e-6))
    levelled = level(height, form="polynomial", order=order, outlier_threshold=None)
    assert np.abs(levelled.values).max() < 1e-13 * np.abs(height.values).max() * shape[0]
    assert (
        len([name for name in removed(levelled) if name.startswith("c_")]) == (order + 1) * (order + 2) // 2
    )


def test_curvature_is_that_of_the_sphere():
    radius = 20e-3
    height = with_form(rough(rms=1e-9), lambda y, x: -(x**2 + y**2) / (2 * radius))
    values = removed(level(height, form="polynomial", outlier_threshold=None))
    assert values["curvature_x"] == pytest.approx(-1 / radius, rel=2e-2)
    assert values["curvature_y"] == pytest.approx(-1 / radius, rel=2e-2)


@pytest.mark.parametrize("order", [0, 1, 2, 4])
def test_record_alone_rebuilds_the_form(order):
    height = rough()
    coordinates = height["y"].values, height["x"].values
    form, record = fit_polynomial(height.values + 3e-6, coordinates, order=order)
    np.testing.assert_allclose(form_from_record(record, *coordinates), form, atol=1e-19, rtol=1e-12)


def test_mean_and_none():
    height = with_form(rough(), lambda y, x: 2e-6 + 0.01 * x)
    np.testing.assert_allclose(
        level(height, form="mean").values, height.values - height.values.mean(), atol=1e-20
    )
    untouched = level(height, form="none")
    np.testing.assert_array_equal(untouched.values, height.values)
    assert json.loads(untouched.attrs["form_removed"]) == {}


def test_missing_points_do_not_pull_the_form():
    tilted = with_form(rough(), lambda y, x: 0.05 * x + 0.01 * y)
    gone = np.random.default_rng(3).random(tilted.shape) < 0.3
    gone[:, :20] = True
    levelled = level(tilted.copy(data=np.where(gone, np.nan, tilted.values)), max_missing=0.5)
    assert removed(levelled)["slope_x"] == pytest.approx(0.05, abs=2e-3)


@pytest.mark.parametrize("order", [1, 2])
def test_robust_fit_ignores_valleys_and_particles(order):
    """A plateau with a third of its area in deep grooves, tilted: the plane is that of the plateau."""
    height = rough(rms=1e-8)
    y, x = np.indices(height.shape)
    groove = (x + y // 3) % 40 < 13
    groove[y > 60] = False  # on one side only, so that they would tilt a least squares plane
    values = np.where(groove, height.values - 3e-6, height.values)
    values[5:9, 100:110] += 20e-6
    grooved = with_form(height.copy(data=values), lambda y, x: 0.01 * x - 0.004 * y)
    form = "plane" if order == 1 else "polynomial"
    plain = removed(level(grooved, form=form, order=order, outlier_threshold=None))
    robust = removed(level(grooved, form=form, order=order, robust=True, outlier_threshold=None))
    assert robust["slope_x"] == pytest.approx(0.01, abs=2e-4)
    assert robust["slope_y"] == pytest.approx(-0.004, abs=2e-4)
    assert abs(plain["slope_y"] + 0.004) > 10 * abs(robust["slope_y"] + 0.004)


def test_robust_fit_of_a_plain_surface_is_nearly_least_squares():
    height = with_form(rough(), lambda y, x: 0.02 * x)
    plain, robust = (removed(level(height, robust=flag, outlier_threshold=None)) for flag in (False, True))
    assert robust["slope_x"] == pytest.approx(plain["slope_x"], abs=5e-4)
    assert robust["mean"] == pytest.approx(plain["mean"], abs=3e-8)


@pytest.mark.parametrize("form", ["plane", "polynomial"])
def test_tilted_plate_becomes_exactly_flat(form):
    y, x = np.indices((64, 48)) * 1e-6
    levelled = level(height_map(1e-3 + 0.1 * x + 0.03 * y, 1e-6), form=form, outlier_threshold=None)
    assert not levelled.values.any()


@pytest.mark.parametrize("robust", [False, True])
@pytest.mark.parametrize("form", ["none", "mean", "plane", "polynomial"])
def test_constant_map_stays_flat(form, robust):
    flat = height_map(np.full((20, 30), 0.3), 1e-6)
    levelled = level(flat, form=form, order=4, robust=robust)
    assert np.ptp(levelled.values) == 0
    assert levelled.attrs["outliers_rejected"] == 0


@pytest.mark.parametrize("shape", [(1, 200), (200, 1), (2, 50), (3, 3), (1, 2)])
def test_profiles_and_thin_maps(shape):
    generator = np.random.default_rng(0)
    height = height_map(generator.standard_normal(shape), 1e-6)
    for form in ("plane", "polynomial") if max(shape) > 3 else ("plane",):
        levelled = level(height, form=form, order=3)
        assert levelled.shape == shape
        assert np.isfinite(levelled.values).all()
        assert abs(levelled.values.mean()) < 1e-12


def test_a_polynomial_that_takes_all_heights_away_is_refused():
    heights = np.random.default_rng(0).standard_normal((18, 20))
    level(height_map(heights, 1e-6), form="polynomial", order=11)  # 78 terms
    with pytest.raises(SettingsError, match=r"level\.order = 12: .* 91 terms .* of 360 measured points"):
        level(height_map(heights, 1e-6), form="polynomial", order=12)
    heights[0] = np.nan
    with pytest.raises(SettingsError, match=r"level\.order = 12: .* of 340 measured points"):
        level(height_map(heights, 1e-6), form="polynomial", order=12, outlier_threshold=None)
    with pytest.raises(SettingsError, match=r"level\.order = 60: give a whole number from 1 to 12"):
        level(height_map(np.random.default_rng(1).random((40, 37)), 1e-6), form="polynomial", order=60)


def test_profile_is_levelled_by_a_straight_line():
    x = np.arange(50) * 1e-6
    height = height_map((2e-6 + 0.3 * x)[None, :], 1e-6)
    levelled = level(height)
    assert np.abs(levelled.values).max() < 1e-18
    assert removed(levelled)["slope_x"] == pytest.approx(0.3)


def test_holes_are_filled_flagged_and_counted():
    height = with_form(rough(), lambda y, x: 0.02 * x)
    values = height.values.copy()
    values[10:14, 20:30] = np.nan  # inside
    values[40, 50] = np.nan
    values[0:3, 60] = np.nan  # open to the border
    levelled = level(height.copy(data=values))
    assert levelled.attrs["filled_points"] == 41
    assert levelled.attrs["filled_share"] == pytest.approx(41 / height.size)
    assert levelled.attrs["largest_hole"] == 40
    assert levelled.attrs["fill_method"] == "harmonic"
    assert levelled["filled"].dtype == np.int8
    assert levelled["filled"].values[10:14, 20:30].all()
    assert int(levelled["filled"].sum()) == 41
    assert int(np.isnan(levelled).sum()) == 3
    unfilled = level(height.copy(data=values), fill="none")
    assert int(np.isnan(unfilled).sum()) == 44
    assert unfilled.attrs["filled_points"] == 0
    assert unfilled.attrs["largest_hole"] == 40


def test_infinite_heights_count_as_missing():
    values = rough().values.copy()
    values[5, 5], values[6, 8] = np.inf, -np.inf
    levelled = level(height_map(values, 1e-6))
    assert np.isfinite(levelled.values).all()
    assert levelled.attrs["filled_points"] == 2


def test_attributes_of_the_measurement_are_kept():
    height = rough()
    height.attrs |= {"source_file": "a.x3p", "source_sha256": "12"}
    levelled = level(height)
    assert levelled.attrs["source_file"] == "a.x3p"
    assert levelled.attrs["source_sha256"] == "12"
    assert levelled.name == "height"
    np.testing.assert_array_equal(levelled["x"], height["x"])
    assert all(isinstance(value, (str, int, float)) for value in levelled.attrs.values())


def test_maps_that_cannot_be_levelled():
    lost = height_map(np.full((3, 4), np.nan), 1.0)
    lost.attrs["source_file"] = "b.sur"
    with pytest.raises(HeightMapError, match=r"all 12 points of b\.sur are missing"):
        level(lost)
    with pytest.raises(HeightMapError, match="a single point"):
        level(height_map([[1.0]], 1.0))
    with pytest.raises(HeightMapError, match="transpose"):
        level(rough().transpose("x", "y"))
    values = rough().values.copy()
    values[:, :64] = np.nan
    with pytest.raises(HeightMapError, match=r"50\.0 % of the points are missing.*max_missing = 0\.4.*cut"):
        level(height_map(values, 1e-6))
    assert level(height_map(values, 1e-6), max_missing=0.5).attrs["filled_points"] == 0


@pytest.mark.cases
def test_options_without_meaning(options, message):
    with pytest.raises(SettingsError, match=message):
        level(rough(), **options)


def test_robust_fit_of_a_large_map_does_not_depend_on_its_start(monkeypatch):
    """A large map starts from a thinned one; the result is that of starting from all points."""
    from roughcontact.surface.levelling import polynomial

    generator = np.random.default_rng(0)
    values = generator.standard_normal((700, 900)) + 0.01 * np.arange(900)
    values[generator.random(values.shape) < 0.2] -= 30
    coordinates = np.arange(700.0), np.arange(900.0)
    thinned, record = fit_polynomial(values, coordinates, order=2, robust=True)
    monkeypatch.setattr(polynomial, "_START_POINTS", values.size)
    full_fit, _ = fit_polynomial(values, coordinates, order=2, robust=True)
    np.testing.assert_allclose(thinned, full_fit, atol=1e-5)
    assert record["slope_x"]["value"] == pytest.approx(0.01, abs=1e-4)


def test_infinite_heights_are_missing_without_a_warning(recwarn):
    values = np.random.default_rng(0).normal(0, 1e-7, (64, 64))
    values[:, :3] = -np.inf
    infinite = level(height_map(values, 1e-6))
    missing = level(height_map(np.where(np.isfinite(values), values, np.nan), 1e-6))
    np.testing.assert_array_equal(infinite, missing)
    assert infinite.attrs["quantisation_step"] == missing.attrs["quantisation_step"] == 0
    assert not recwarn


@pytest.mark.parametrize("kind", ["u1", "i1", "f2"])
def test_numbers_of_a_narrow_type_are_told_apart_as_those_of_doubles(kind):
    """Differences of small integers wrap around, and sums of half precision overflow."""
    heights = (np.random.default_rng(0).standard_normal((60, 70)).clip(-2, 2) * 60).round().astype(int)
    heights = heights + 127 if kind == "u1" else heights
    narrow, double = (
        level(height_map(np.zeros(heights.shape), 1e-6, unit="m").copy(data=heights.astype(dtype)))
        for dtype in (kind, float)
    )
    for name in ("repeated_heights", "quantisation_step"):
        assert narrow.attrs[name] == double.attrs[name]
