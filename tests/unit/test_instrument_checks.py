"""Checks of what the instrument made of a surface: they pass, warn just beyond their limits, and say why."""

import json

import instruments
import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine
from scipy import ndimage

import roughcontact as rc
from roughcontact import height_map, self_affine_surface
from roughcontact.statistics import instrument_checks as checks
from roughcontact.surface.roughness import traces
from roughcontact.surface.roughness.summits import _chance

SHARP = {"spectrum_exponent": -3.6, "spectrum_end": 4e-6, "rounded_peaks": 0.1, "sharpest_peak_radius": 2e-6}
SHARP |= {"spectrum_bend": 0.1, "pixel_pitch": 1e-6, "pixel_roughness": 1e-9}
FLAT = {"top_exponent": -1.0, "noise_floor": 2e-9, "noise_gradient_share": 0.15}


def surface(points=160, **options):
    """Return a self-affine surface down to the pixel, cut so that it is not periodic."""
    waves = {"hurst": 0.8, "shortest": 2e-6, "longest": 60e-6, "rms_gradient": 0.2, "seed": 3} | options
    return self_affine_surface((200, 200), 1e-6, **waves).values[:points, :points]


def window_of(values, pitch=1e-6):
    return rc.periodic_window(rc.level(height_map(values, pitch)))


def loads(largest, mean):
    columns = {"max_pressure": largest, "mean_contact_pressure": mean}
    return xr.Dataset({name: ("load", np.array(values, float)) for name, values in columns.items()})


def test_a_rough_surface_passes():
    window = window_of(surface())
    smoothed, noise = checks.smoothed(window.attrs), checks.noise(window.attrs)
    assert smoothed.outcome == noise.outcome == "passed", (smoothed, noise)
    assert smoothed.sentence.startswith("The spectrum reaches down to the pixels: its steepest fall is q^−3.")
    assert window.attrs["spectrum_exponent"] == pytest.approx(-3.6, abs=0.4)
    assert abs(window.attrs["rounded_peaks"]) < 0.2


def test_a_gaussian_filter_is_found():
    window = window_of(ndimage.gaussian_filter(surface(), 2))
    check = checks.smoothed(window.attrs)
    assert check.outcome == "review"
    assert "filter of the instrument's software" in check.sentence
    assert 3e-6 < window.attrs["spectrum_end"] < 12e-6


def test_the_tip_of_a_stylus_is_found():
    values, y = surface(rms_gradient=0.4), np.arange(-5, 6) * 1e-6
    square = y[:, None] ** 2 + y[None, :] ** 2
    tip = np.sqrt(np.maximum(25e-12 - square, 0)) - 5e-6
    traced = ndimage.grey_dilation(values, footprint=square <= 25e-12, structure=tip, mode="reflect")
    window = window_of(traced)
    assert "the tip of a stylus or probe" in checks.smoothed(window.attrs).sentence
    assert window.attrs["sharpest_peak_radius"] == pytest.approx(5e-6, rel=0.4)
    assert checks.smoothed(window.attrs | {"instrument_tip_radius": 5e-6}).outcome == "passed"


def test_a_sphere_has_its_radius_on_steep_slopes_too():
    radius = 5.0  # slopes up to 1.6: its second derivative reaches eight times 1 / radius
    y, x = np.meshgrid(*[np.linspace(-3, 3, 601)] * 2, indexing="ij")
    curvatures, seconds = traces._curvatures(np.sqrt(radius**2 - x**2 - y**2), (0.01, 0.01))
    inside = (np.maximum(abs(x), abs(y)) < 2.99).ravel()  # differences reach round the map at its edges
    assert np.count_nonzero(inside) > 1e5
    for curvature, derivative in zip(curvatures, seconds, strict=True):
        np.testing.assert_allclose(curvature[inside], -1 / radius, rtol=1e-3)
        assert derivative[inside].min() < -2 / radius


def test_a_tip_on_steep_walls_is_found():
    y, x = np.meshgrid(*[np.arange(200)] * 2, indexing="ij")
    texture, radius = surface(200, shortest=6e-6), 10
    walls = 50 * np.tanh(2 * np.sin(x / 9)) * np.tanh(2 * np.sin(y / 11)) + 3 * texture / np.ptp(texture)
    across = np.arange(1 - radius, radius)
    depth = radius**2 - across[:, None] ** 2 - across**2
    traced = ndimage.grey_dilation(
        walls, footprint=depth > 0, structure=np.sqrt(np.maximum(depth, 0)) - radius, mode="reflect"
    )
    sharp, blunt = (window_of(values * 1e-9, 1e-9) for values in (walls, traced))
    assert "the tip of a stylus" not in checks.smoothed(sharp.attrs).sentence
    assert "the tip of a stylus" in checks.smoothed(blunt.attrs).sentence
    # the second derivative, which is large on the walls, would not tell
    seconds = traces._curvatures(blunt.values, (1e-9, 1e-9))[1]
    assert np.mean([traces._roundness(derivative) for derivative in seconds]) < checks.ROUNDED


@pytest.mark.parametrize("hurst", [0.4, 0.8])
def test_a_lens_that_resolves_little_more_than_the_pixels_is_found(hurst):
    rough_map = self_affine((400, 400), 7e-7, (1.4e-6, 7e-5), hurst=hurst, rms_height=1e-7)
    lens = {"numerical_aperture": 0.3, "wavelength": 550e-9}
    part = rough_map.isel(y=slice(220), x=slice(220))
    sharp, blurred = (
        rc.periodic_window(rc.level(measured_map)).attrs
        for measured_map in (part, instruments.through_lens(part, **lens))
    )
    assert sharp["spectrum_bend"] == pytest.approx(0.3, abs=0.4)  # two standard errors above 0
    assert checks.smoothed(sharp).outcome == "passed"
    assert blurred["spectrum_exponent"] > checks.SPECTRUM_ENDS
    assert "A lens that resolves little more than the pixels" in checks.smoothed(blurred).sentence
    # half the wavelength over the aperture, as the settings make of it
    with_resolution = checks.smoothed(blurred | {"instrument_resolution": 9.2e-7})
    assert with_resolution[1:3] == ("passed", "The shortest waves are too low, as stated.")
    # another lens, far sharper than the pixels, does not do this
    assert checks.smoothed(blurred | {"instrument_resolution": 2e-7}).outcome == "review"


@pytest.mark.parametrize("source", ["by nobody", "by the settings", "by the table", "by the file"])
def test_a_lens_that_is_stated_is_no_fault(source):
    rough_map = self_affine_surface((150, 150), 3e-7, hurst=0.8, shortest=6e-7, longest=3e-5, rms_height=1e-7)
    blurred = instruments.through_lens(rough_map[:100, :100], numerical_aperture=0.3, wavelength=550e-9)
    instrument = {"numerical_aperture": 0.3}
    if source == "by the table":
        blurred.attrs["instrument_numerical_aperture"] = 0.3
    elif source == "by the file":
        blurred.attrs["instrument"] = json.dumps(instrument)
    statistics = rc.evaluate(
        blurred,
        contact={"contact_modulus": 1e9, "relative_pressure": 0.1},
        uncertainty={"sources": ["solver"]},
        instrument=instrument if source == "by the settings" else None,
    )
    reasons = [reason["check"] for reason in json.loads(statistics.attrs["reasons"])]
    # the ± counts what is stated, and a file without metadata would have none
    assert ("Smoothed" in reasons) == (source in ("by nobody", "by the file"))


def test_a_spectrum_of_few_strong_waves_does_not_tell_a_lens():
    x = np.arange(200)[None, :]
    lines = sum(np.cos(2 * np.pi * k * x / 10.3) / k**2 for k in (1, 2, 3))  # none in the last octave
    window = window_of(1e-7 * lines + 1e-9 * surface(200) / surface(200).std())
    assert window.attrs["spectrum_bend"] > checks.BENT


def test_a_median_filter_is_found():
    window = window_of(ndimage.median_filter(surface(), 5))
    assert "a median filter does this" in checks.smoothed(window.attrs).sentence


def test_interpolation_is_found():
    finer = ndimage.zoom(surface(100), 2, order=3, mode="reflect", grid_mode=True)
    assert checks.smoothed(window_of(finer, 5e-7).attrs).outcome == "review"


def test_a_smoothed_profile_is_found():
    profile = self_affine_surface((1, 4000), 1e-6, hurst=0.8, shortest=2e-6, longest=1e-4, rms_gradient=0.1)
    sharp = window_of(profile.values[:, :3000])
    blurred = window_of(ndimage.gaussian_filter1d(profile.values[:, :3000], 2))
    assert checks.smoothed(sharp.attrs).outcome == "passed"
    assert checks.smoothed(blurred.attrs).outcome == "review"


@pytest.mark.parametrize(
    ("name", "limit"),
    [
        ("spectrum_exponent", checks.SPECTRUM_ENDS),
        ("spectrum_bend", checks.BENT),
        ("rounded_peaks", checks.ROUNDED),
    ],
)
def test_smoothed_warns_just_beyond_its_limits(name, limit):
    step = 1e-6 if name == "rounded_peaks" else -1e-6
    assert checks.smoothed(SHARP | {name: limit}).outcome == "passed"
    assert checks.smoothed(SHARP | {name: limit + step}).outcome == "review"


def test_repeated_heights_warn_just_beyond_the_limit():
    assert checks.smoothed(SHARP | {"repeated_heights": checks.REPEATED}).outcome == "passed"
    assert checks.smoothed(SHARP | {"repeated_heights": checks.REPEATED + 1e-6}).outcome == "review"


@pytest.mark.parametrize(
    "statement",
    [
        {"instrument_resolution": 4e-6},
        {"filters_removed": json.dumps({"s_filter": {"nesting_index": {"value": 4e-6, "units": "m"}}})},
        {"band_shortest": 4e-6, "band_reason": "window.shortest_wavelength"},
    ],
)
def test_what_the_settings_say_is_no_fault(statement):
    attrs = SHARP | {"spectrum_exponent": -12.0}
    assert checks.smoothed(attrs).outcome == "review"
    assert checks.smoothed(attrs | statement).sentence == "Waves below 4.0 µm are missing, as stated."


def test_the_sentence_of_a_smoothed_map():
    sentence = checks.smoothed(SHARP | {"spectrum_exponent": -12.0}).sentence
    assert sentence.startswith("No waves were measured below 4.0 µm (4.0 pixels): the spectrum ends")
    assert "Contact areas are then too large, pressures and gaps too small" in sentence
    assert "instrument.resolution" in sentence
    assert "level.s_filter" in sentence


def test_periodic_and_tiny_maps_are_not_judged():
    rough_map = self_affine_surface((64, 64), 1e-6, hurst=0.8, shortest=8e-6, longest=6e-5, rms_height=1e-7)
    periodic, tiny = window_of(rough_map), window_of(surface(8))
    assert periodic.attrs["periodisation"] == "none"
    assert checks.smoothed(periodic.attrs).outcome == checks.smoothed(tiny.attrs).outcome == "not made"
    assert checks.noise(tiny.attrs).outcome == "not made"
    assert traces.instrument_traces(height_map(np.zeros((64, 64)), 1e-6)) == {}
    # a measured plateau with pits may meet at its edges by chance: noise shows there as elsewhere
    assert checks.noise(periodic.attrs).outcome == "passed"
    noisy = rough_map + 3e-8 * np.random.default_rng(1).standard_normal(rough_map.shape)
    noisy = window_of(noisy.values)
    assert noisy.attrs["periodisation"] == "none"
    assert checks.noise(noisy.attrs).outcome == "review"
    assert checks.suspected_noise(noisy.attrs) == pytest.approx(3e-8, rel=0.1)


def test_no_noise_shows_in_maps_of_few_short_waves_or_of_none():
    """19 x 4 points have seven waves near the Nyquist frequency; equal rows have no waves across them."""
    noise = np.random.default_rng(1).standard_normal((64, 64))
    for values in (noise[:19, :4], np.tile(noise[0], (64, 1))):
        found = traces.instrument_traces(height_map(values, 1e-6))
        assert (found["noise_floor"], found["top_exponent"]) == (0.0, -np.inf)


def test_quantised_heights_are_not_repeated_ones():
    values = surface() + 1e-7 * np.arange(160)
    for levels in (20, 100, 1000):
        quantised = np.round(values / np.ptp(values) * levels)
        assert traces.repeated_heights(quantised) < checks.REPEATED
    missing = values.copy()
    missing[50:60] = np.nan
    assert traces.repeated_heights(missing) == 0
    assert traces.repeated_heights(np.zeros((64, 64))) == 0


def test_noise_is_found():
    noisy = surface() + 2e-7 * np.random.default_rng(1).standard_normal((160, 160))
    window = window_of(noisy)
    assert window.attrs["noise_floor"] == pytest.approx(2e-7, rel=0.2)
    check = checks.noise(window.attrs)
    assert check.outcome == "review"
    assert "one map cannot tell" in check.sentence


def test_noise_warns_just_beyond_its_limits():
    limit = checks.NOISE_SHARE
    assert checks.noise(FLAT | {"noise_gradient_share": limit}).outcome == "passed"
    noisy = FLAT | {"noise_gradient_share": limit + 1e-6}
    assert checks.noise(noisy).outcome == "review"
    assert "too small by up to 10.6 %" in checks.noise(noisy).sentence
    assert checks.noise(noisy | {"top_exponent": checks.WHITE}).outcome == "passed"
    assert "by an unknown factor" in checks.noise(FLAT | {"noise_gradient_share": 1.2}).sentence


def test_stated_noise_counts_whatever_the_spectrum():
    steep = FLAT | {"top_exponent": -4.0, "instrument_noise": 2e-9}
    check = checks.noise(steep)
    assert check.outcome == "passed"
    assert check.sentence == "The stated noise of 2.00 nm makes up 15.0 % of the mean square gradient."
    assert checks.noise(steep | {"instrument_noise": 4e-9}).outcome == "review"


def with_dust():
    rows, columns = np.ogrid[:160, :160]
    return surface() + 10 * surface().std() * np.exp(-((rows - 70) ** 2 + (columns - 90) ** 2) / 2)


def test_dust_is_found():
    window = window_of(with_dust())
    problem = {"contact_modulus": 1e9, "mean_pressure": 0.02e9 * window.attrs["rms_gradient_after"]}
    solved = rc.contact_statistics(rc.solve_contact(window, **problem, tolerance=1e-2), flow="never")
    check = checks.isolated_peak(solved, window.attrs)
    assert check.outcome == "review"
    assert "at x = 90.5 µm and y = 70.5 µm; the largest pressure is" in check.sentence


def test_a_mirrored_map_has_its_summit_once():
    window = rc.periodic_window(rc.level(height_map(with_dust(), 1e-6)), method="mirror")
    assert window.attrs["summit_chance"] < checks.CHANCE
    assert window.attrs["summit_over_next"] > 1.5


def test_the_chance_of_a_summit_is_that_of_an_exponential_tail():
    generator = np.random.default_rng(5)
    tails = np.sort(generator.exponential(size=(4000, 300)))[:, :-41:-1]
    chances = np.array([_chance(list(tail)) for tail in tails])
    for level in (0.01, 0.1, 0.5):
        assert np.mean(chances < level) == pytest.approx(level, abs=4 * np.sqrt(level / 4000))
    assert _chance([3.0, 0.0]) == 0
    assert _chance([3.0, 2.0, 0.0]) == _chance([2.0, 2.0, 2.0]) == 1


def test_an_isolated_peak_warns_just_beyond_its_limits():
    mean, margin = checks.PEAK_OVER_MEAN, 1 + 1e-6
    usual = {"summit_over_next": 1.1, "summit_chance": checks.CHANCE, "summit_x": 1e-5, "summit_y": 2e-5}
    dust = usual | {"summit_chance": checks.CHANCE / margin}
    assert checks.isolated_peak(loads([mean * margin], [1]), dust).outcome == "review"
    assert checks.isolated_peak(loads([mean], [1]), dust).outcome == "passed"
    assert checks.isolated_peak(loads([mean * margin], [1]), usual).outcome == "passed"
    assert checks.isolated_peak(loads([2, 20], [1, 1]), dust).outcome == "review"
    assert checks.isolated_peak(loads([20], [1]), {}).outcome == "not made"


def test_the_sentence_of_an_isolated_peak():
    dust = {"summit_over_next": 2.0, "summit_chance": 1e-4, "summit_x": 1e-5, "summit_y": 2e-5}
    assert checks.isolated_peak(loads([20], [1]), dust).sentence.startswith(
        "One summit stands out, 2.0 times as high above its surroundings as any other, at x = 10.0 µm and "
        "y = 20.0 µm; the largest pressure is 20 times the mean in contact."
    )
    single_summit = checks.isolated_peak(loads([20], [1]), dust | {"summit_over_next": np.inf})
    assert single_summit.sentence.startswith("One summit stands out, and no other summit does, at")


def test_heights_below_all_noise_warn():
    limit = checks.QUIETEST
    assert checks.height_unit({}, SHARP | {"pixel_roughness": limit}).outcome == "passed"
    check = checks.height_unit({}, SHARP | {"pixel_roughness": limit * (1 - 1e-6)})
    assert check.outcome == "review"
    assert check.sentence.endswith("(50 pm). Check the unit of the heights: were µm read as nm?")
    probe = {"instrument": '{"kind": "scanning probe microscope"}'}
    assert checks.height_unit(probe, SHARP | {"pixel_roughness": limit / 2}).outcome == "passed"
    assert (
        checks.height_unit({}, SHARP | {"pixel_roughness": limit / 2, "pixel_pitch": 2e-9}).outcome
        == "passed"
    )
    assert (
        checks.height_unit({}, SHARP | {"pixel_roughness": 0.0, "spectrum_exponent": -9.0}).outcome
        == "not made"
    )


def test_pixels_of_another_instrument_warn():
    optical = {"instrument": '{"kind": "optical profiler", "lens": "50 X"}'}
    assert checks.pixel_size({}, SHARP).outcome == "not made"
    assert checks.pixel_size(optical, SHARP | {"pixel_pitch": 2e-7}).outcome == "passed"
    assert checks.pixel_size(optical, SHARP | {"pixel_pitch": 2e-6}).sentence == (
        "Pixels of 2.0 µm are not those of an optical profiler with a lens of 50×: they would be 100 µm on "
        "its camera. Check the lateral unit, and whether the map was resampled."
    )
    assert checks.pixel_size(optical, SHARP | {"pixel_pitch": 2e-3}).outcome == "review"
    unnamed = {"instrument": '{"kind": "optical profiler", "magnification": 5.14}'}
    assert checks.pixel_size(unnamed, SHARP | {"pixel_pitch": 1.6e-6}).outcome == "passed"
