"""The band of a map: what its instrument resolves, and what is left where waves are taken out."""

import json

import numpy as np
import pytest
from known_surfaces import self_affine

from roughcontact import HeightMapError, SettingsError, height_map, level, periodic_window
from roughcontact.surface.roughness import parameters
from roughcontact.surface.window.band import limit_band, reliable_wavelength


def three_waves():
    """Waves of 60, 12 and 6 µm with amplitudes of 1, 0.2 and 0.05 µm."""
    x = np.arange(120)[None, :] + np.zeros((60, 1))
    values = sum(a * np.cos(2 * np.pi * x / n) for a, n in ((1.0, 60), (0.2, 12), (0.05, 6)))
    return height_map(1e-6 * values, 1e-6)


def limited(height, *, shortest=None, longest=None, reliable=False):
    return limit_band(
        height, shortest_wavelength=shortest, longest_wavelength=longest, reliable_band=reliable
    )


def test_waves_outside_the_band_go_and_those_inside_stay():
    height = three_waves() + 3e-6
    height.attrs = three_waves().attrs
    band = limited(height, shortest=8e-6, longest=30e-6)
    x = np.arange(120)
    np.testing.assert_allclose(band.values[0], 3e-6 + 0.2e-6 * np.cos(2 * np.pi * x / 12), atol=1e-18)
    gone = np.array([1.0, 0.05]) * 1e-6 / np.sqrt(2)
    assert band.attrs["band_removed_rms_height"] == pytest.approx(np.hypot(*gone), rel=1e-9)
    slopes = gone * 2 * np.pi / np.array([60e-6, 6e-6])
    assert band.attrs["band_removed_rms_gradient"] == pytest.approx(np.hypot(*slopes), rel=1e-9)
    assert band.attrs["band_shortest"] == 8e-6
    assert band.attrs["band_longest"] == 30e-6
    assert band.attrs["band_reason"] == "window.shortest_wavelength"


def test_a_limit_that_is_a_wave_of_the_map_keeps_it():
    band = limited(three_waves(), shortest=12e-6, longest=60e-6)
    assert band.values.var() == pytest.approx((1 + 0.04) / 2 * 1e-12, rel=1e-9)


def test_no_limit_changes_nothing_and_says_what_the_grid_holds():
    height = three_waves()
    band = limited(height)
    np.testing.assert_array_equal(band.values, height.values)
    assert band.attrs["band_removed_rms_height"] == 0
    assert band.attrs["band_shortest"] == pytest.approx(2e-6)
    assert band.attrs["band_longest"] == pytest.approx(120e-6)
    assert band.attrs["band_reason"] == "grid"


def test_variances_add_up():
    height = self_affine((64, 81), (2e-6, 1e-6), (4e-6, 100e-6), hurst=0.5, rms_height=1e-6)
    band = limited(height, shortest=10e-6, longest=50e-6)
    removed = band.attrs["band_removed_rms_height"]
    assert parameters.rms_height(band) ** 2 + removed**2 == pytest.approx(1e-12, rel=1e-9)
    total = parameters.rms_gradient(height) ** 2
    slope = band.attrs["band_removed_rms_gradient"]
    assert parameters.rms_gradient(band) ** 2 + slope**2 == pytest.approx(total, rel=1e-9)
    assert parameters.shortest_wavelength(band) == pytest.approx(10e-6, rel=0.05)


@pytest.mark.cases
def test_the_reliable_wave_is_that_of_the_pixels_or_of_the_lens(instrument, wavelength, reason):
    """At 1.24 L / NA the contrast (2/pi)(acos v - v sqrt(1 - v^2)), v = L / (2 NA wave), is one half."""
    height = height_map(np.zeros((4, 5)), (2e-6, 1e-6))
    height.attrs["instrument"] = json.dumps(instrument)
    wavelength_found, why = reliable_wavelength(height)
    assert wavelength_found == pytest.approx(wavelength, rel=1e-3)
    assert why == reason
    if "lens" in why:
        v = 550e-9 / (2 * float(why.split()[-1][:-1]) * wavelength_found)
        assert 2 / np.pi * (np.arccos(v) - v * np.sqrt(1 - v**2)) == pytest.approx(0.5, abs=1e-9)


def test_the_window_can_be_limited_to_what_the_lens_resolves():
    height = three_waves()
    height.attrs["instrument"] = json.dumps({"numerical_aperture": 0.08})  # 8.5 µm
    levelled = level(height, form="mean", outlier_threshold=None)
    full, band = periodic_window(levelled), periodic_window(levelled, reliable_band=True)
    assert full.attrs["band_removed_rms_height"] == 0
    assert band.attrs["band_reason"] == "window.reliable_band"
    assert band.attrs["band_removed_rms_height"] == pytest.approx(0.05e-6 / np.sqrt(2), rel=1e-6)
    assert band.attrs["rms_gradient_after"] == pytest.approx(parameters.rms_gradient(band), rel=1e-12)
    assert band.attrs["rms_gradient_after"] < full.attrs["rms_gradient_after"]
    # what was given wins where it is longer
    explicit = periodic_window(levelled, reliable_band=True, shortest_wavelength=20e-6)
    assert explicit.attrs["band_shortest"] == 20e-6
    assert explicit.attrs["band_reason"] == "window.shortest_wavelength"


def test_a_cut_window_is_limited_after_it_is_made_periodic():
    rough = self_affine((128, 128), 1e-6, (4e-6, 100e-6), hurst=0.7, rms_height=1e-6, seed=1)
    levelled = level(rough.isel(y=slice(0, 100), x=slice(0, 90)))
    window = periodic_window(levelled, shortest_wavelength=12e-6)
    assert window.attrs["periodisation"] == "smooth-cross-fade"
    assert parameters.shortest_wavelength(window) >= 12e-6 * 0.95
    full = periodic_window(levelled)
    gradient_before, removed = (full.attrs["rms_gradient_after"], window.attrs["band_removed_rms_gradient"])
    assert np.hypot(window.attrs["rms_gradient_after"], removed) == pytest.approx(gradient_before, rel=1e-9)
    assert window.attrs["periodisation_rms_change"] == full.attrs["periodisation_rms_change"]


def test_profiles_and_flat_maps():
    x = np.arange(120)
    profile = height_map([np.cos(2 * np.pi * x / 60) + np.cos(2 * np.pi * x / 6)], 1e-6)
    np.testing.assert_allclose(
        limited(profile, shortest=10e-6).values[0], np.cos(2 * np.pi * x / 60), atol=1e-12
    )
    flat = limited(height_map(np.full((6, 8), 0.3), 1e-6), shortest=1.0)
    assert np.ptp(flat.values) == 0


def test_bands_without_meaning():
    with pytest.raises(SettingsError, match=r"window\.shortest_wavelength = 2e-05 m is not below"):
        limited(three_waves(), shortest=20e-6, longest=10e-6)
    with pytest.raises(HeightMapError, match="no wave of the window lies between 0 m and 1e-06 m: widen"):
        limited(three_waves(), longest=1e-6)
    with pytest.raises(SettingsError, match=r"window\.longest_wavelength = -1"):
        periodic_window(three_waves(), longest_wavelength=-1)
