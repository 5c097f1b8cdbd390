"""Sphere and cylinder: exact surfaces come off whole, radius and axis come out right."""

import json

import numpy as np
import pytest
from known_surfaces import self_affine
from scipy.optimize import brentq

from roughcontact import HeightMapError, height_map, level, periodic_window
from roughcontact.surface.levelling.curved import fit_curved_form
from roughcontact.surface.levelling.forms import form_from_record

Y, X = (np.arange(120) + 0.5) * 10e-6, (np.arange(160) + 0.5) * 7.5e-6


def ball(radius, centre, *, sign=1):
    """Heights of a ball (sign 1) or a cup (sign -1)."""
    x, y, z = centre
    return z + sign * np.sqrt(radius**2 - (X[None, :] - x) ** 2 - (Y[:, None] - y) ** 2)


def roll(radius, point, direction):
    """Heights of a cylinder: the upper point at the distance `radius` from the axis, found numerically."""
    direction = np.asarray(direction) / np.linalg.norm(direction)

    def distance(z, x, y):
        from_axis = np.array([x, y, z]) - point
        return np.linalg.norm(from_axis - (from_axis @ direction) * direction) - radius

    heights = [brentq(distance, point[2] + 0.3 * radius, point[2] + 2 * radius, (x, y)) for y in Y for x in X]
    return np.reshape(heights, (Y.size, X.size))


def record_of(values, **options):
    form, record = fit_curved_form(values, (Y, X), **options)
    return form, {name: entry["value"] for name, entry in record.items()}, record


@pytest.mark.parametrize("sign", [1, -1])
def test_ball_and_cup_come_off_whole(sign):
    values = ball(2e-3, (0.9e-3, 0.3e-3, -1.8e-3), sign=sign)
    form, value, record = record_of(values, shape="sphere")
    np.testing.assert_allclose(form, values, atol=1e-15)
    assert value["radius"] == pytest.approx(2e-3, rel=1e-9)
    assert value["curvature"] == pytest.approx(-sign / 2e-3, rel=1e-9)
    centre = [value[f"centre_{axis}"] for axis in "xyz"]
    assert centre == pytest.approx([0.9e-3, 0.3e-3, -1.8e-3], rel=1e-9)
    assert value["mean"] == pytest.approx(values.mean(), rel=1e-9)
    assert {record[name]["units"] for name in ("radius", "centre_x", "mean")} == {"m"}
    np.testing.assert_allclose(form_from_record(record, Y, X), form, atol=1e-17)


def test_cylinder_with_an_inclined_axis():
    direction = np.array([0.5, 0.8, 0.1])
    values = roll(1.7e-3, np.array([0.6e-3, 0.6e-3, -1.5e-3]), direction)
    form, value, record = record_of(values, shape="cylinder")
    np.testing.assert_allclose(form, values, atol=1e-13)
    assert value["radius"] == pytest.approx(1.7e-3, rel=1e-8)
    assert value["axis_azimuth"] == pytest.approx(np.rad2deg(np.arctan2(0.8, 0.5)), abs=1e-6)
    inclination = np.rad2deg(np.arctan2(0.1, np.hypot(0.5, 0.8)))
    assert value["axis_inclination"] == pytest.approx(inclination, abs=1e-6)
    assert record["axis_azimuth"]["units"] == "degree"
    np.testing.assert_allclose(form_from_record(record, Y, X), form, atol=1e-17)


def test_it_is_least_squares():
    """No small change of any of its numbers makes the sum of squares less."""
    generator = np.random.default_rng(0)
    for shape, smooth in (
        ("sphere", ball(3e-3, (0.5e-3, 0.7e-3, 0))),
        ("cylinder", roll(3e-3, np.array([0.5e-3, 0.7e-3, 0]), (1, 0.2, 0))),
    ):
        values = smooth + 2e-6 * generator.standard_normal(smooth.shape)
        form, _, record = record_of(values, shape=shape)
        least_squares = np.sum((values - form) ** 2)
        numbers = ["height_middle", "slope_x", "slope_y", "curvature"]
        numbers += ["axis_azimuth"] if shape == "cylinder" else []
        for name in numbers:
            for sign in (1, -1):
                changed = json.loads(json.dumps(record))
                changed[name]["value"] += sign * 1e-4 * (abs(changed[name]["value"]) + 1e-3)
                assert np.sum((values - form_from_record(changed, Y, X)) ** 2) > least_squares


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_robust_fit_ignores_grooves_and_missing_points(shape):
    exact = (
        ball(2e-3, (0.7e-3, 0.5e-3, 0))
        if shape == "sphere"
        else roll(2e-3, np.array([0.6e-3, 0.6e-3, 0]), (0.2, 1, 0))
    )
    generator = np.random.default_rng(1)
    values = exact + 1e-7 * generator.standard_normal(exact.shape)
    values[20:45] -= 40e-6
    values[generator.random(values.shape) < 0.2] = np.nan
    plain, _, _ = record_of(values, shape=shape)
    form, value, _ = record_of(values, shape=shape, robust=True)
    assert value["radius"] == pytest.approx(2e-3, rel=1e-3)
    assert np.abs(form - exact).max() < 1e-7
    assert np.abs(plain - exact).max() > 1e-6


def test_flat_maps_have_no_radius():
    for values in (np.full((120, 160), 0.3), 0.1 * X[None, :] + 0.02 * Y[:, None]):
        for shape in ("sphere", "cylinder"):
            form, value, _ = record_of(values, shape=shape)
            np.testing.assert_allclose(form, values, atol=1e-15)
            assert value.get("radius", np.inf) > 1e6


def test_profile_is_fitted_by_a_circle():
    for shape in ("sphere", "cylinder"):
        values = np.sqrt(4e-6 - (X[None, :] - 0.5e-3) ** 2)
        form, record = fit_curved_form(values, ([0.0], X), shape=shape)
        np.testing.assert_allclose(form, values, atol=1e-15)
        assert record["radius"]["value"] == pytest.approx(2e-3, rel=1e-8)


def test_points_beyond_the_rim_are_an_error():
    values = np.sqrt(np.maximum(0.55e-3**2 - (X[None, :] - 0.6e-3) ** 2 - (Y[:, None] - 0.6e-3) ** 2, 0))
    height = height_map(values, (10e-6, 7.5e-6))
    height.attrs["source_file"] = "ball.sur"
    with pytest.raises(
        HeightMapError, match=r"ball\.sur: level\.form = 'sphere': \d+ points lie beyond the rim"
    ):
        level(height, form="sphere", robust=True, outlier_threshold=None)


def test_roughness_on_a_ball_is_what_is_left():
    rough = self_affine((120, 160), (10e-6, 7.5e-6), (40e-6, 200e-6), rms_height=1e-7, seed=3)
    height = rough.copy(data=rough.values + ball(5e-3, (0.6e-3, 0.6e-3, 0)))
    levelled = level(height, form="sphere")
    assert levelled.values.std() == pytest.approx(1e-7, rel=2e-2)
    assert np.corrcoef(levelled.values.ravel(), rough.values.ravel())[0, 1] > 0.99
    record = json.loads(levelled.attrs["form_removed"])
    assert record["radius"]["value"] == pytest.approx(5e-3, rel=1e-3)
    window = periodic_window(levelled)
    assert window.attrs["form"] == "sphere"
    assert window.attrs["form_share"] < 0.1
