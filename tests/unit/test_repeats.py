"""What two measurements of a place differ by: noise, a shift, or what was done in between."""

import re
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact import HeightMapError, self_affine_surface
from roughcontact.surface.levelling.repeats import noise_of_repeats


@pytest.fixture(scope="module")
def twice():
    """A function that measures a map, and another one of the same place, with 2 nm of white noise each."""
    generator = np.random.default_rng(7)

    def measured(height, second_height=None):
        pair = height, height if second_height is None else second_height
        return [height_of_pair + 2e-9 * generator.standard_normal(height.shape) for height_of_pair in pair]

    return measured


@pytest.fixture(scope="module")
def rough():
    """A map with Sq of 300 nm."""
    waves = {"hurst": 0.8, "shortest": 4e-6, "longest": 64e-6, "rms_height": 300e-9}
    return self_affine_surface((128, 128), 1e-6, **waves, seed=3)


def test_two_maps_with_white_noise_have_that_noise(rough, twice):
    height, repeat = twice(rough)
    noise, remark = noise_of_repeats(height, repeat + 1e-3 * repeat["x"])  # tilted
    assert noise == pytest.approx(2e-9, rel=0.1)
    assert remark == ""


def test_profiles_have_noise_as_well(twice):
    waves = {"hurst": 0.8, "shortest": 4e-6, "longest": 64e-6, "rms_height": 300e-9}
    profile = self_affine_surface((1, 1024), 1e-6, **waves, seed=3)
    assert noise_of_repeats(*twice(profile))[0] == pytest.approx(2e-9, rel=0.1)
    worn = profile.clip(max=float(profile.quantile(0.8)))
    noise, remark = noise_of_repeats(*twice(profile, worn))
    assert np.isnan(noise)
    assert "not as by noise" in remark


def changed(rough, kind):
    """Return the map after something was done to it, of an rms not far above the noise."""
    y, x = np.meshgrid(*map(np.arange, rough.shape), indexing="ij")
    return {
        "flattened": rough.clip(max=float(rough.quantile(0.9))),
        "step": rough + 20e-9 * (x > 64),
        "scratch": rough - 100e-9 * (np.abs(y - 70) < 2),
        "oblique scratch": rough - 60e-9 * (x == y),
        "bow": rough + 5e-12 * (x - 64.0) ** 2,
        "ripple": rough + 3e-9 * np.sin(np.pi / 2 * (x + y)),  # neighbours are not correlated
        "dust": rough + 1e-6 * ((x == 30) & (y == 30)),
        "another scale": 1.02 * rough,
    }[kind]


@pytest.mark.parametrize(
    "kind", ["flattened", "step", "scratch", "oblique scratch", "bow", "ripple", "dust", "another scale"]
)
def test_what_was_done_to_a_surface_is_no_noise(rough, twice, kind):
    noise, remark = noise_of_repeats(*twice(rough, changed(rough, kind)))
    assert np.isnan(noise)
    assert " (rms), not as by noise: " in remark
    assert " of its mean square lies " in remark
    assert "name the earlier one in the column before, not in repeat_of" in remark


def shifted(rough, pixels):
    """Return a periodic map that lies some pixels further along x."""
    wave = np.exp(-2j * np.pi * pixels * np.fft.fftfreq(rough.shape[1]))
    return rough.copy(data=np.fft.ifft(np.fft.fft(rough.values, axis=1) * wave, axis=1).real)


def test_a_small_shift_is_left_out_of_the_noise_and_said(rough, twice):
    height, repeat = twice(rough, shifted(rough, 0.1))
    assert float((repeat - height).std()) > 1.5 * np.sqrt(2) * 2e-9
    noise, remark = noise_of_repeats(height, repeat)
    assert noise == pytest.approx(2e-9, rel=0.1)
    match = re.fullmatch(
        r"as by a shift of (-?0\.\d\d) along y, (0\.\d\d) along x \(pixels\), .* leaves out", remark
    )
    assert [float(by) for by in match.groups()] == pytest.approx([0.0, 0.1], abs=0.02)


def test_a_shift_too_large_to_be_left_out_is_no_noise_and_said(rough, twice):
    noise, remark = noise_of_repeats(*twice(rough, shifted(rough, 1.0)))
    assert np.isnan(noise)
    assert re.search(
        r"as by a shift of -?0\.0\d along y, 1\.[01]\d along x \(pixels\), not as by noise", remark
    )


def test_noise_is_found_beside_holes_and_on_rounded_heights(rough, twice):
    height, repeat = twice(rough)
    hole = height.where((height["x"] > 20e-6) | (height["y"] > 30e-6))
    assert noise_of_repeats(hole, repeat)[0] == pytest.approx(2e-9, rel=0.1)
    step = 6e-9  # rounding adds its own noise, step / sqrt(12)
    noise, remark = noise_of_repeats(
        *(step * (measured_map / step).round() for measured_map in (height, repeat))
    )
    assert noise == pytest.approx(np.hypot(2e-9, step / np.sqrt(12)), rel=0.05)
    assert remark == ""


def test_a_copy_is_no_repeat(rough):
    with pytest.raises(HeightMapError, match="have equal heights: a copy is no second measurement"):
        noise_of_repeats(rough, rough.where(rough["x"] > rough["x"][4]))  # a part of it masked


def test_repeats_of_another_size_or_place_are_refused(rough):
    with pytest.raises(HeightMapError, match="differ in size or pitch"):
        noise_of_repeats(rough, rough[:100])
    with pytest.raises(HeightMapError, match="do not show the same place"):
        noise_of_repeats(rough, rough.roll(x=40, roll_coords=False))


def test_repeats_with_unlike_missing_points_have_one_window(rough, twice, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "workflow/scripts"))
    from _other_maps import with_repeats

    lacking = {"a": np.s_[:, :9], "b": np.s_[100:, :], "c": np.s_[40:44, 60:70]}
    for name, points in lacking.items():
        height = twice(rough)[0].assign_attrs(rough.attrs)  # an older xarray drops them
        height[points] = np.nan
        height.rename("height").to_netcdf(tmp_path / f"{name}.nc")
    windows = []
    for name in lacking:
        others = [{"name": key, "path": str(tmp_path / f"{key}.nc")} for key in lacking if key != name]
        part = with_repeats(rc.read_height_map(tmp_path / f"{name}.nc"), name, others)
        assert part.attrs["instrument_noise"] == pytest.approx(2e-9, rel=0.1)
        assert part.attrs["missing_points"] == int(part.isnull().sum())
        windows.append(rc.periodic_window(rc.level(part)))
    for window in windows[1:]:
        assert all((window[axis] == windows[0][axis]).all() for axis in "yx")
