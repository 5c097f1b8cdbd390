"""Points that lie on no even grid: refused, or interpolated where the user asks for it."""

import numpy as np
import pytest
import x3pio
from measured_files import cells, labelled, points, refuses, steps, warnings_of

from roughcontact import HeightMapError, InputFileError, SettingsError, inspect_file, read_height_map

RNG = np.random.default_rng(3)
X, Y = RNG.random((2, 4000)) * [[100.0], [60.0]]  # µm
Z = 0.5 + 0.02 * X - 0.03 * Y  # a plane: linear interpolation is exact


POINTS = cells(np.column_stack([X, Y, Z]), " ", "{:.9f}")


def plane(height):
    """Return the heights (m) of the plane at the points of a map."""
    return 0.5e-6 + 0.02 * height.x - 0.03 * height.y


def test_only_where_asked(refusal, tmp_path):
    refusal(POINTS, "give resample = linear", unit="um")
    refusal(POINTS, "resample = 'cubic': choose linear", error=SettingsError, unit="um", resample="cubic")
    contents = inspect_file(tmp_path / "map.dat", unit="um")
    assert contents["map"] is None
    assert "give resample = linear" in contents["problem"]
    assert inspect_file(tmp_path / "map.dat", unit="um", resample="linear")["map"]["rms_height"] < 1e-15


def test_a_plane_comes_back_exactly(read):
    height = read(POINTS, unit="um", resample="linear")
    pitch = 1e-6 * np.sqrt(np.ptp(X) * np.ptp(Y) / X.size)
    assert steps(height) == pytest.approx([pitch, pitch], rel=1e-9)
    assert height.shape == pytest.approx((60e-6 / pitch, 100e-6 / pitch), abs=2)
    measured = np.isfinite(height.values)
    assert measured.mean() > 0.97  # all but some points outside the outermost triangles
    assert float(abs(height - plane(height)).max()) < 1e-14
    assert "resampled as asked, 4000 points interpolated linearly" in warnings_of(height)


def test_given_steps_and_units(read, refusal):
    columns = np.column_stack([1e-3 * X, 1e-3 * Y, Z])
    text = "x (mm)\ty (mm)\tz (um)\n" + cells(columns, form="{:.9f}")
    height = read(text, dx=2, dy=3, unit="um", resample="linear")
    assert steps(height) == pytest.approx([2e-6, 3e-6], rel=1e-9)
    first_x = 1e-6 * ((X.min() + X.max()) / 2 - (height.sizes["x"] - 1))
    assert float(height.x[0]) == pytest.approx(first_x, rel=1e-6)
    assert float(abs(height - plane(height)).max()) < 1e-13
    refusal(text, "is given without a unit", error=SettingsError, dx=2, dy=3, resample="linear")


@pytest.mark.slow
def test_holes_are_not_bridged(read):
    around = np.column_stack([X, Y, Z])[np.hypot(X - 50, Y - 30) >= 15]
    height = read(cells(around, " "), unit="um", resample="linear")
    away = np.hypot(height.x - 50e-6, height.y - 30e-6)
    assert np.isnan(height.where(away < 11e-6)).all()
    assert float(np.isnan(height.where(away > 17e-6, 0.0)).mean()) < 0.05  # but some at the border


def test_an_uneven_profile(read, refusal):
    x = np.sort(RNG.random(500)) * 200
    text = cells(np.column_stack([x, 0.1 * x]), " ", "{:.9f}")
    refusal(text, r"not evenly spaced.*give resample = linear", unit="um")
    refusal(text, "unit of its positions; give unit", height_unit="um", resample="linear", dx="0.5 m")
    height = read(text, unit="um", resample="linear", dx=0.5)
    assert height.shape == (1, int(np.ptp(x) / 0.5) + 1)
    measured = np.isfinite(height.values[0])
    np.testing.assert_allclose(height.values[0][measured], 0.1 * height.x.values[measured], rtol=1e-6)
    assert measured.mean() > 0.8


def test_netcdf_and_x3p_with_uneven_positions(tmp_path):
    x, y = np.cumsum(0.5 + RNG.random(40)) * 1e-6, np.arange(30) * 1e-6
    even = labelled(np.empty((30, 40)))
    uneven = even.assign_coords(x=("x", x, {"units": "m"}))
    uneven.copy(data=plane(uneven).T).to_netcdf(tmp_path / "map.nc")
    table = points(plane(uneven).T.values)
    table[:, :2] = np.column_stack([np.tile(x, 30), np.repeat(y, 40)])
    x3pio.write_points(tmp_path / "map.x3p", table)
    for name in ("map.nc", "map.x3p"):
        refuses("give resample = linear", tmp_path / name)
        height = read_height_map(tmp_path / name, resample="linear")
        assert float(abs(height - plane(height)).max()) < 1e-13
        assert height.attrs["missing_share"] < 0.02


def test_an_even_grid_is_left_as_it_is(read):
    heights = RNG.random((6, 8))
    text = cells(points(heights), " ", "{:.9f}")
    height = read(text, unit="um", resample="linear")
    np.testing.assert_allclose(height.values, 1e-6 * heights, atol=1e-15)
    assert warnings_of(height) == warnings_of(read(text, unit="um"))


@pytest.mark.parametrize(
    ("words", "columns", "arguments"),
    [
        ("on one line", np.outer((1, 2, 1), np.arange(20.0) ** 2), {"resample": "linear"}),
        ("too few", np.array([X[:3], Y[:3], Z[:3]]), {"resample": "linear"}),
        ("longer than the field", np.array([X, Y, Z]), {"resample": "linear", "dx": 500}),
        ("several points of the list have the same position", np.array([X, Y, Z]).repeat(2, axis=1), {}),
    ],
)
def test_points_that_make_no_map(refusal, words, columns, arguments):
    error = HeightMapError if arguments else InputFileError
    refusal(cells(columns.T, " ", "{:.9f}"), words, error=error, unit="um", **arguments)
