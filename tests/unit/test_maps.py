"""Labelled height maps: their coordinates and attributes, their pitches, and the same map on a finer grid."""

import json

import numpy as np
import pytest
import xarray as xr

from roughcontact.arguments.checking import check_map
from roughcontact.arguments.maps import height_map, pitches, refined, spacing
from roughcontact.errors import HeightMapError


def test_a_map_says_where_its_cells_are_and_what_is_missing():
    height = height_map([[1, np.nan, 3], [4, 5, 6]], (3.0, 2.0), channel="raw", instrument={"lens": "50x"})
    assert height.name == "height"
    assert height["y"].values.tolist() == [1.5, 4.5]
    assert height["x"].values.tolist() == [1.0, 3.0, 5.0]
    assert height["x"].attrs["units"] == height["y"].attrs["units"] == height.attrs["units"] == "m"
    assert (height.attrs["missing_points"], height.attrs["missing_share"]) == (1, 1 / 6)
    assert json.loads(height.attrs["channels"]) == ["raw"]
    assert json.loads(height.attrs["instrument"]) == {"lens": "50x"}


def test_pitches_of_maps_and_profiles():
    assert pitches(2) == (2.0, 2.0)
    assert pitches((3, 1)) == (3.0, 1.0)
    with pytest.raises(ValueError, match="give the pitch of the points"):
        pitches((1, 2, 3))
    for shape, expected in (
        ((4, 5), (3.0, 2.0)),
        ((1, 5), (2.0, 2.0)),
        ((4, 1), (3.0, 3.0)),
        ((1, 1), (1, 1)),
    ):
        assert spacing(height_map(np.zeros(shape), (3.0, 2.0))) == pytest.approx(expected)


@pytest.mark.parametrize("shape", [(6, 8), (5, 9), (1, 8), (7, 1)])
@pytest.mark.parametrize("factor", [1, 2, 3])
def test_a_finer_grid_goes_through_the_points_and_holds_no_other_waves(shape, factor):
    values = np.random.default_rng(0).standard_normal(shape)
    height = height_map(values, (3.0, 2.0))
    fine = refined(height, factor)
    assert fine.shape == tuple(n * factor if n > 1 else 1 for n in shape)
    every = tuple(slice(None, None, factor if n > 1 else 1) for n in shape)
    np.testing.assert_allclose(fine.values[every], values, atol=1e-13)
    for own_step, step, points in zip(spacing(height), spacing(fine), shape, strict=True):
        assert step == pytest.approx(own_step / factor if points > 1 or min(shape) == 1 else own_step)
    # waves shorter than the map's own Nyquist limit are none
    power = np.abs(np.fft.fft2(fine.values)) ** 2
    for axis, points in enumerate(shape):
        waves = np.abs(np.fft.fftfreq(fine.shape[axis], 1 / fine.shape[axis]))
        assert np.compress(waves > points / 2, power, axis=axis).sum() <= 1e-24 * power.sum()


def test_what_is_no_map():
    with pytest.raises(HeightMapError, match=r"has the dimensions \('x', 'y'\): transpose it"):
        check_map(height_map(np.zeros((2, 3)), 1.0).transpose("x", "y"))
    with pytest.raises(HeightMapError, match=r"all 6 points of part\.sur are missing"):
        check_map(height_map(np.full((2, 3), np.inf), 1.0).assign_attrs(source_file="part.sur"))
    checked = check_map(height_map([[1.0, -np.inf]], 1.0))
    np.testing.assert_array_equal(checked, [[1.0, np.nan]])


def test_a_labelled_array_keeps_its_unit_and_its_axes():
    heights = np.arange(6.0).reshape(2, 3)
    labelled = xr.DataArray(heights, dims=("y", "x"), attrs={"units": "um"})
    for values in (labelled, labelled.T):
        np.testing.assert_allclose(height_map(values, 1e-6), 1e-6 * heights, rtol=1e-15)
    np.testing.assert_allclose(height_map(labelled, 1e-6, height_unit="nm"), 1e-9 * heights, rtol=1e-15)
    np.testing.assert_array_equal(height_map(labelled.drop_attrs(), 1e-6), heights)
