"""Points that lie on no even grid: refused, or interpolated where the user asks for it."""

import json

import numpy as np
import pytest
import x3pio
import xarray as xr
from measured_files import refuses, steps

from roughcontact.errors import HeightMapError, InputFileError, SettingsError
from roughcontact.io.inspection import inspect_file
from roughcontact.io.read import read_height_map

RNG = np.random.default_rng(3)
X, Y = RNG.random((2, 4000)) * [[100.0], [60.0]]  # µm
Z = 0.5 + 0.02 * X - 0.03 * Y  # a plane: linear interpolation is exact


def points_file(path, x=X, y=Y, z=Z):
    np.savetxt(path, np.column_stack([x, y, z]), fmt="%.9f")
    return path


def test_only_where_asked(tmp_path):
    path = points_file(tmp_path / "points.txt")
    refuses("give resample = linear", path, unit="um")
    refuses("resample = 'cubic': choose linear", path, error=SettingsError, unit="um", resample="cubic")
    found = inspect_file(path, unit="um")
    assert found["map"] is None
    assert "give resample = linear" in found["problem"]
    assert inspect_file(path, unit="um", resample="linear")["map"]["rms_height"] < 1e-15


def test_a_plane_comes_back_exactly(tmp_path):
    height = read_height_map(points_file(tmp_path / "points.txt"), unit="um", resample="linear")
    pitch = 1e-6 * np.sqrt(np.ptp(X) * np.ptp(Y) / X.size)
    assert steps(height) == pytest.approx([pitch, pitch], rel=1e-9)
    assert height.shape == pytest.approx((60e-6 / pitch, 100e-6 / pitch), abs=2)
    exact = 0.5e-6 + 0.02 * height.x - 0.03 * height.y
    measured = np.isfinite(height.values)
    assert measured.mean() > 0.97  # all but some points outside the outermost triangles
    assert float(abs(height - exact).max()) < 1e-14
    notes = json.loads(height.attrs["ingest_warnings"])
    assert any("resampled as asked, 4000 points interpolated linearly" in note for note in notes)


def test_given_steps_and_units(tmp_path):
    text = "x (mm)\ty (mm)\tz (um)\n" + "".join(
        f"{1e-3 * x:.9f}\t{1e-3 * y:.9f}\t{z:.9f}\n" for x, y, z in zip(X, Y, Z, strict=True)
    )
    (tmp_path / "points.txt").write_text(text)
    height = read_height_map(tmp_path / "points.txt", dx=2, dy=3, unit="um", resample="linear")
    assert steps(height) == pytest.approx([2e-6, 3e-6], rel=1e-9)
    assert float(height.x[0]) == pytest.approx(
        1e-6 * ((X.min() + X.max()) / 2 - (height.sizes["x"] - 1)), rel=1e-6
    )
    assert float(abs(height - (0.5e-6 + 0.02 * height.x - 0.03 * height.y)).max()) < 1e-13
    refuses(
        "is given without a unit", tmp_path / "points.txt", error=SettingsError, dx=2, dy=3, resample="linear"
    )


@pytest.mark.slow
def test_holes_are_not_bridged(tmp_path):
    hole = np.hypot(X - 50, Y - 30) < 15
    path = points_file(tmp_path / "points.txt", X[~hole], Y[~hole], Z[~hole])
    height = read_height_map(path, unit="um", resample="linear")
    away = np.hypot(height.x - 50e-6, height.y - 30e-6)
    assert np.isnan(height.where(away < 11e-6)).all()
    assert float(np.isnan(height.where(away > 17e-6, 0.0)).mean()) < 0.05  # but some at the border


def test_an_uneven_profile(tmp_path):
    x = np.sort(RNG.random(500)) * 200
    np.savetxt(tmp_path / "trace.txt", np.column_stack([x, 0.1 * x]), fmt="%.9f")
    refuses(r"not evenly spaced.*give resample = linear", tmp_path / "trace.txt", unit="um")
    height = read_height_map(tmp_path / "trace.txt", unit="um", resample="linear", dx=0.5)
    assert height.shape == (1, int(np.ptp(x) / 0.5) + 1)
    measured = np.isfinite(height.values[0])
    np.testing.assert_allclose(height.values[0][measured], 0.1 * height.x.values[measured], rtol=1e-6)
    assert measured.mean() > 0.8


def test_netcdf_and_x3p_with_uneven_positions(tmp_path):
    x, y = np.cumsum(0.5 + RNG.random(40)) * 1e-6, np.arange(30) * 1e-6
    z = 0.5e-6 + 0.02 * x + 0.03 * y[:, None]
    axes = {"x": ("x", x, {"units": "m"}), "y": ("y", y, {"units": "m"})}
    xr.DataArray(z, coords=axes, dims=("y", "x"), name="height", attrs={"units": "m"}).to_netcdf(
        tmp_path / "map.nc"
    )
    px, py = (part.ravel() for part in np.meshgrid(x, y))
    x3pio.write_points(tmp_path / "map.x3p", np.column_stack([px, py, z.ravel()]))
    for name in ("map.nc", "map.x3p"):
        refuses("give resample = linear", tmp_path / name)
        height = read_height_map(tmp_path / name, resample="linear")
        assert float(abs(height - (0.5e-6 + 0.02 * height.x + 0.03 * height.y)).max()) < 1e-13
        assert height.attrs["missing_share"] < 0.02


def test_an_even_grid_is_left_as_it_is(tmp_path):
    column, row = np.meshgrid(np.arange(8.0), np.arange(6.0))
    z = RNG.random(48)
    path = points_file(tmp_path / "points.txt", column.ravel(), row.ravel(), z)
    height = read_height_map(path, unit="um", resample="linear")
    np.testing.assert_allclose(height.values.ravel(), 1e-6 * z, atol=1e-15)
    assert height.attrs["ingest_warnings"] == read_height_map(path, unit="um").attrs["ingest_warnings"]


@pytest.mark.parametrize(
    ("words", "columns", "arguments"),
    [
        ("on one line", np.outer((1, 2, 1), np.arange(20.0) ** 2), {"resample": "linear"}),
        ("too few", np.array([X[:3], Y[:3], Z[:3]]), {"resample": "linear"}),
        ("longer than the field", np.array([X, Y, Z]), {"resample": "linear", "dx": 500}),
        ("several points of the list have the same position", np.array([X, Y, Z]).repeat(2, axis=1), {}),
    ],
)
def test_points_that_make_no_map(tmp_path, words, columns, arguments):
    error = HeightMapError if arguments else InputFileError
    refuses(words, points_file(tmp_path / "a.txt", *columns), error=error, unit="um", **arguments)
