"""Instrument, material and unresolved waves in the error budget, against known lenses, tips, finer maps."""

import json
import math

import numpy as np
import pytest
import xarray as xr
from known_surfaces import noisy, self_affine
from scipy.ndimage import grey_dilation

import roughcontact as rc
from roughcontact import SettingsError, height_map, self_affine_surface, solve_contact
from roughcontact.arguments.maps import refined, spacing
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.synthetic import rough_reference_surface
from roughcontact.surface.window.instrument import check_instrument, stated_instrument
from roughcontact.surface.window.transfer import (
    eroded,
    reliability_length,
    restored,
    shortest_transmitted,
    transfer,
    undone,
    unrounded,
)
from roughcontact.uncertainty import unresolved
from roughcontact.uncertainty.budget_inputs import budget_inputs
from roughcontact.uncertainty.calibration import entry, table
from roughcontact.uncertainty.combination import sum_of_causes
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.inputs import instrument_components
from roughcontact.uncertainty.scales import (
    ANSWERS,
    AREA,
    CONDUCTANCE,
    GAP,
    PEAK,
    PRESSURE,
    QUANTITIES,
    to_scale,
)

MODULUS = 1e9
LENS = {"numerical_aperture": 0.3, "wavelength": 0.55e-6}


@pytest.fixture(scope="module")
def surface() -> xr.DataArray:
    """Return a periodic self-affine surface with waves from 1.6 to 32 um, rough to its pixels of 0.4 um."""
    return self_affine((160, 160), 0.4e-6, (1.6e-6, 32e-6), rms_gradient=0.1, seed=3)


def loads(window: xr.DataArray, *relative: float) -> list[float]:
    return [share * MODULUS * rms_gradient(window) for share in relative]


def results(window: xr.DataArray, pressures: list[float]) -> xr.Dataset:
    return solve_contact(
        window, contact_modulus=MODULUS, mean_pressure=pressures, tolerance=1e-6, reduce=budget_inputs
    )


def result_of(window, pressures, solved, names=(*QUANTITIES, *ANSWERS), modulus=MODULUS):
    """Return what the sources of uncertainty start from: the quantities of a solution."""
    contact = {"contact_modulus": modulus, "mean_pressure": pressures}
    return Result(window, contact, {name: solved[name].values for name in names if name != PRESSURE})


def shifts(window, pressures, seen, instrument):
    """Return the components of what is stated of the instrument, on the scales."""
    causes, _ = instrument_components(
        result_of(window, pressures, seen, (AREA, GAP, PEAK)), instrument, None, undone(window, instrument)
    )
    return sum_of_causes(causes)


def reaches(components, seen, truth, names=(AREA, GAP, PEAK)):
    """Hold that the truth lies between the shifted ends."""
    for name in names:
        deviation = to_scale(name, truth[name].values) - to_scale(name, seen[name].values)
        down, up, shift_down, shift_up = components[name]
        assert (deviation >= -shift_down - down - 1e-3).all(), name
        assert (deviation <= shift_up + up + 1e-3).all(), name


def test_a_lens_transmits_what_goodman_says():
    cutoff = 2 * LENS["numerical_aperture"] / LENS["wavelength"]
    # (2/pi) (acos v - v sqrt(1 - v^2)) at v = 1/2 is 2/3 - sqrt(3)/(2 pi)
    assert transfer(np.array([cutoff / 2]), LENS)[0] == pytest.approx(2 / 3 - math.sqrt(3) / (2 * math.pi))


def test_the_interval_of_a_blurred_map_reaches_the_sharp_one(surface):
    frequency = np.hypot(np.fft.fftfreq(160, 0.4e-6)[:, None], np.fft.rfftfreq(160, 0.4e-6)[None, :])
    v = np.clip(frequency * LENS["wavelength"] / (2 * LENS["numerical_aperture"]), 0, 1)
    share = 2 / np.pi * (np.arccos(v) - v * np.sqrt(1 - v**2))
    blurred = surface.copy(data=np.fft.irfft2(np.fft.rfft2(surface.values) * share, s=surface.shape))
    pressures = loads(surface, 0.02, 0.1)
    truth, seen = results(surface, pressures), results(blurred, pressures)
    components = shifts(blurred, pressures, seen, LENS)
    assert (truth["relative_contact_area"] < 0.95 * seen["relative_contact_area"]).all()
    reaches(components, seen, truth)
    assert (components[AREA][3] == 0).all()


def test_the_interval_of_rounded_heights_reaches_the_true_ones(surface):
    step = 0.1 * float(surface.std())
    rounded = surface.copy(data=np.rint(surface.values / step) * step)
    rounded.attrs |= {"quantisation_step": step, "Sq": float(surface.std())}
    smooth = unrounded(rounded, step)
    assert float(abs(smooth - rounded).max()) <= step / 2 * (1 + 1e-9)
    assert rms_gradient(smooth) < rms_gradient(surface) < rms_gradient(rounded)
    pressures = loads(surface, 0.02, 0.1)
    truth, seen = results(surface, pressures), results(rounded, pressures)
    components = shifts(rounded, pressures, seen, {})
    assert (truth["relative_contact_area"] > 1.02 * seen["relative_contact_area"]).all()
    reaches(components, seen, truth)
    assert (components[AREA][2] == 0).all()
    fine = rounded.assign_attrs(quantisation_step=0.2 * step)  # 2 % of the rms height: nothing is done
    assert shifts(fine, pressures, seen, {}) == {}


def test_restoring_stops_at_the_noise(surface):
    noise = 0.05 * float(surface.std())
    measured = noisy(surface, noise)
    careful = restored(measured, {"resolution": 1e-6}, noise=noise)
    careless = restored(measured, {"resolution": 1e-6})
    assert rms_gradient(careful) < 0.7 * rms_gradient(careless)


def test_the_interval_of_a_noisy_map_reaches_the_true_one(surface):
    noise = 0.01 * float(surface.std())
    measured = noisy(surface, noise, 1)
    pressures = loads(surface, 0.02, 0.1)
    truth, seen = results(surface, pressures), results(measured, pressures)
    components = shifts(measured, pressures, seen, {"noise": noise})
    assert (truth[AREA] > 1.005 * seen[AREA]).all()
    reaches(components, seen, truth)
    deviation = to_scale(AREA, truth[AREA].values) - to_scale(AREA, seen[AREA].values)
    assert (components[AREA][3] < 4 * deviation).all()


def test_chance_of_noise_is_part_of_the_interval():
    """The largest pressure is that of one point, and its noise lowers it nearly as often as it raises it."""
    inside, raised = [], []
    for seed in range(20):
        waves = {"hurst": 0.8, "shortest": 1.6e-6, "longest": 16e-6, "rms_gradient": 0.1}
        true = self_affine_surface((80, 80), 0.4e-6, **waves, seed=seed)
        noise, pressures = 0.01 * float(true.std()), loads(true, 0.02, 0.1)
        measured = noisy(true, noise, 100 + seed)
        truth, seen = results(true, pressures), results(measured, pressures)
        deviation = to_scale(PEAK, truth[PEAK].values) - to_scale(PEAK, seen[PEAK].values)
        down, up, shift_down, shift_up = shifts(measured, pressures, seen, {"noise": noise})[PEAK]
        inside += [*((deviation >= -shift_down - down) & (deviation <= shift_up + up))]
        raised += [*(deviation > 0)]
    assert 0.2 < np.mean(raised) < 0.8
    assert np.mean(inside) >= 0.9


def test_noise_that_is_all_of_the_gradient_leaves_no_upper_end(surface):
    smooth = unresolved.remove_shortest_waves(surface, 6.4e-6)
    noise = 0.5 * float(smooth.std())
    measured = noisy(smooth, noise)
    pressures = loads(measured, 0.05)
    solved = results(measured, pressures)
    components = shifts(measured, pressures, solved, {"noise": 2 * noise})
    assert np.isinf(components[AREA][3]).all()


def test_a_conductance_that_stays_infinite_does_not_change():
    infinite = {CONDUCTANCE: np.array([np.inf, 2.0])}
    result = Result(rough_reference_surface(64), {"mean_pressure": [1.0, 2.0]}, infinite)
    assert (result.changes(infinite)[CONDUCTANCE] == 0).all()


def _tip(radius: float, step: float) -> np.ndarray:
    reach = np.arange(-12, 13) * step
    return np.sqrt(radius**2 - reach[:, None] ** 2 - reach[None, :] ** 2) - radius


def test_erosion_undoes_the_tip_where_it_touched(surface):
    radius = 20e-6
    traced = surface.copy(data=grey_dilation(surface.values, structure=_tip(radius, 0.4e-6), mode="wrap"))
    back = eroded(traced, radius)
    assert (back.values >= surface.values - 1e-15).all()
    assert float(np.mean(np.isclose(back, surface, rtol=0, atol=1e-12))) > 0.1


def test_erosion_takes_the_full_tip_however_many_pixels_it_has():
    """A tip of 125 pixels, on a map that is rough enough to touch it far from its apex; by brute force."""
    shape, step, radius = (60, 130), 0.4e-9, 50e-9
    rng = np.random.default_rng(5)
    waves = np.exp(-((np.hypot(*np.meshgrid(*map(np.fft.fftfreq, shape), indexing="ij")) / 0.02) ** 2))
    values = np.fft.ifft2(np.fft.fft2(rng.standard_normal(shape)) * waves).real
    values *= 12e-9 / values.std()
    away = [np.minimum(np.arange(n), n - np.arange(n)) * step for n in shape]  # from the nearest copy
    square = away[0][:, None] ** 2 + away[1] ** 2
    tip = np.where(square < radius**2, radius - np.sqrt(np.maximum(radius**2 - square, 0.0)), np.inf)
    positions = list(np.ndindex(shape))
    traced = np.max([values[at] - np.roll(tip, at, (0, 1)) for at in positions], axis=0)
    reference = np.min([traced[at] + np.roll(tip, at, (0, 1)) for at in positions], axis=0)
    back = eroded(height_map(traced, step), radius).values
    assert np.allclose(back, reference, rtol=0, atol=1e-20)
    assert (back >= values - 1e-20).all()
    profile = eroded(height_map(traced[:1], step), radius).values[0]
    profile_reference = np.min([traced[0, k] + np.roll(tip[0], k) for k in range(shape[1])], axis=0)
    assert np.allclose(profile, profile_reference, rtol=0, atol=1e-20)


def test_the_reliability_length_is_that_of_the_tips_cusps(surface):
    traced = surface.copy(data=grey_dilation(surface.values, structure=_tip(20e-6, 0.4e-6), mode="wrap"))
    assert reliability_length(traced, 20e-6) >= 1.6e-6
    assert reliability_length(traced, 20e-9) == 0.0


def shortest_wave(height: xr.DataArray) -> float:
    """Return the shortest wavelength of a map that is more than rounding."""
    frequencies = [np.fft.fftfreq(n, step) for n, step in zip(height.shape, spacing(height), strict=True)]
    amplitude = np.abs(np.fft.fft2(height.values))
    return 1 / np.hypot.outer(*frequencies)[amplitude > 1e-9 * amplitude.max()].max()


def test_coarser_maps_keep_the_longer_waves(surface):
    coarse = unresolved.remove_shortest_waves(surface, 3.2e-6)
    assert coarse.shape == (60, 60)  # three points to a wave
    q = np.abs(np.fft.fft2(surface.values))[:15, :15] / surface.size
    assert np.allclose(np.abs(np.fft.fft2(coarse.values))[:15, :15] / coarse.size, q, rtol=0, atol=1e-15)
    assert shortest_wave(coarse) == pytest.approx(3.2e-6, rel=0.02)  # in all directions
    profile = unresolved.remove_shortest_waves(surface[:1], 1.6e-6)
    assert profile.shape == (1, 120)
    assert spacing(profile) == pytest.approx((160 / 120 * 0.4e-6,) * 2)


@pytest.mark.parametrize(("shape", "pitch"), [((96, 96), (1e-6, 1e-6)), ((90, 128), (1.4e-6, 1e-6))])
def test_the_cut_off_is_the_shortest_wave_that_is_kept(shape, pitch):
    window = height_map(1e-7 * np.random.default_rng(2).standard_normal(shape), pitch)
    pressures = loads(window, 0.2)
    curve = unresolved.magnification_curve(result_of(window, pressures, results(window, pressures)))
    cutoffs, gradients = curve["cutoff_wavelength"][1], curve["gradient_at_cutoff"][1]
    assert cutoffs[0] == pytest.approx(shortest_wave(window))  # along the diagonal
    assert cutoffs.size == 3
    for octave, (cutoff, gradient) in enumerate(zip(cutoffs, gradients, strict=True)):
        if octave:
            area = math.pi / (math.sqrt(math.pi * math.prod(pitch)) * 2**octave) ** 2
            assert area == pytest.approx(1 / math.prod(pitch) / 4**octave)  # as many waves as of such pixels
            filtered = unresolved.remove_shortest_waves(window, cutoff)
            assert shortest_wave(filtered) == pytest.approx(cutoff, rel=1e-9)
            assert rms_gradient(filtered) == pytest.approx(gradient, rel=1e-12)
            assert cutoff == pytest.approx(math.sqrt(math.pi * math.prod(pitch)) * 2**octave, rel=0.02)


def test_a_band_that_the_settings_cut_off_begins_the_magnification_curve():
    window = rc.periodic_window(rough_reference_surface(96), shortest_wavelength=5 / 96)
    problem = {"contact_modulus": 1.0, "mean_pressure": loads(window, 0.1)}
    problem["mean_pressure"] = [pressure / MODULUS for pressure in problem["mean_pressure"]]
    solved = solve_contact(window, **problem, reduce=budget_inputs)
    curve = unresolved.magnification_curve(result_of(window, problem["mean_pressure"], solved, modulus=1.0))
    assert curve["cutoff_wavelength"][1][:2] == pytest.approx(5 / 96, rel=0.02)
    assert curve["cutoff_wavelength"][1][2] > 6 / 96


def test_the_magnification_curve_begins_with_the_result_and_ends_smoother(surface):
    pressures = loads(surface, 0.05)
    solved = results(surface, pressures)
    curve = unresolved.magnification_curve(result_of(surface, pressures, solved))
    area = curve["relative_contact_area_at_cutoff"][1][0]
    assert area[0] == solved["relative_contact_area"][0]
    assert (np.diff(area[1:]) > 0).all()


@pytest.mark.parametrize("hurst", [0.5, 0.9])
def test_results_by_wave_are_those_of_the_same_waves_on_a_fine_grid(hurst):
    window = self_affine((160, 160), 1e-6, (2e-6, 50e-6), hurst=hurst, rms_gradient=0.1, seed=1)
    pressures = loads(window, 0.05, 0.2)
    curve = unresolved.magnification_curve(result_of(window, pressures, results(window, pressures)))
    q = np.hypot(np.fft.fftfreq(160, 1e-6)[:, None], np.fft.rfftfreq(160, 1e-6))
    for number, cutoff in enumerate(curve["cutoff_wavelength"][1][1:], start=1):
        spectrum = np.fft.rfft2(window.values) * (q <= 1.0001 / cutoff)
        fine = refined(window.copy(data=np.fft.irfft2(spectrum, s=window.shape)), 2)
        expected = results(fine, pressures)
        values_at_cutoff = {name: curve[f"{name}_at_cutoff"][1][:, number] for name in QUANTITIES}
        pressure = expected["mean_pressure"] / expected["relative_contact_area"]
        for name, value, tolerance in (
            ("relative_contact_area", expected["relative_contact_area"], 0.05),
            ("mean_contact_pressure", pressure, 0.05),
            ("mean_gap", expected["mean_gap"], 0.03),
            ("max_pressure", expected["max_pressure"], 0.1),
        ):
            assert values_at_cutoff[name] == pytest.approx(value.values, rel=tolerance), (name, entry)


def test_a_part_shows_what_short_waves_change_of_a_large_window(monkeypatch):
    window = self_affine((320, 320), 1e-6, (4e-6, 32e-6), hurst=0.8, rms_gradient=0.1, seed=2)
    pressures = loads(window, 0.05, 0.3)
    solved = solve_contact(window, contact_modulus=MODULUS, mean_pressure=pressures, reduce=budget_inputs)
    result = result_of(window, pressures, solved, (AREA, GAP, PEAK))
    whole = unresolved.magnification_curve(result)
    monkeypatch.setattr(unresolved, "_LARGEST_GRID", 200**2)  # between the first entry and the second
    monkeypatch.setattr(unresolved, "LARGEST_PART", 160**2)
    by_part = unresolved.magnification_curve(result)
    for name, tolerance in ((AREA, 0.02), (GAP, 0.005), (PEAK, 0.1), ("mean_contact_pressure", 0.02)):
        of_part, of_whole = (curve[f"{name}_at_cutoff"][1] for curve in (by_part, whole))
        assert of_part[:, 1] == pytest.approx(of_whole[:, 1], rel=tolerance), name
        assert (of_part[:, 1] != of_whole[:, 1]).all()
        assert (np.delete(of_part, 1, axis=1) == np.delete(of_whole, 1, axis=1)).all()
    for name in ("cutoff_wavelength", "gradient_at_cutoff"):
        assert by_part[name][1] == pytest.approx(whole[name][1], rel=0.01)


@pytest.mark.cases
def test_a_statement_that_cannot_be_true_is_refused(surface, statement, words):
    with pytest.raises(SettingsError, match=words):
        check_instrument(surface, statement)


def test_the_table_prevails_over_the_settings_and_both_over_the_file(surface):
    file = surface.assign_attrs(instrument=json.dumps({"numerical_aperture": 0.4}))
    assert stated_instrument(file, {}) == {}  # the ± of a file without metadata is no narrower
    assert stated_instrument(file, {"correct": True}) == {"numerical_aperture": 0.4}
    assert stated_instrument(file, {"correct": True, "tip_radius": 2e-6}) == {"tip_radius": 2e-6}
    row = file.assign_attrs(instrument_noise=1e-9)
    assert stated_instrument(row, {"noise": 3e-9})["noise"] == 1e-9


@pytest.fixture(scope="module")
def evaluated() -> xr.Dataset:
    """Return the statistics of a map of which all is stated."""
    return rc.evaluate(
        rough_reference_surface(64),
        contact={
            "contact_modulus": MODULUS,
            "relative_pressure": [0.05, 0.2],
            "contact_modulus_uncertainty": 0.05,
            "mean_pressure_uncertainty": 0.02,
        },
        instrument={"noise": "1 mm", "amplification_z": 0.01, "tip_radius": "1 cm", "resolution": "5 cm"},
    )


def test_every_source_has_its_part(evaluated):
    parts = evaluated["relative_contact_area_uncertainty"]
    assert np.isfinite(parts.drop_sel(source=["hardness", "unresolved", "combined"])).all()
    for side in ("lower", "upper"):
        wide, narrow = (evaluated[f"mean_contact_pressure_{kind}{side}"] for kind in ("", "map_"))
        assert ((wide <= narrow) if side == "lower" else (wide >= narrow)).all()


def curve_of(gradients):
    """Return a magnification curve of five octaves whose results change by 0.1 in an octave, on the scale."""
    areas = {
        f"{name}_at_cutoff": (("load", "cutoff"), np.exp([[0.4, 0.3, 0.2, 0.1, 0.0]])) for name in (GAP, PEAK)
    }
    waves = {"cutoff_wavelength": ("cutoff", np.array([2.0, 4.0, 8.0, 16.0, 32.0]))}
    return areas | waves | {"gradient_at_cutoff": ("cutoff", np.exp(gradients))}


@pytest.mark.parametrize(("shortest", "octaves"), [(2.0, 0), (4.0, 1), (8.0, 2), (16.0, np.inf)])
def test_hidden_waves_continue_the_trend_over_two_octaves_at_most(shortest, octaves):
    window = height_map(np.random.default_rng(0).standard_normal((64, 64)), 1.0)
    instrument = {"resolution": shortest / shortest_transmitted({"resolution": 1.0})}
    components = unresolved.hidden_waves(window, curve_of([0.4, 0.3, 0.2, 0.1, 0.0]), instrument, {})
    if not octaves:
        assert components == {}
        return
    assert components[PEAK][3].item() == pytest.approx(0.1 * octaves)
    assert components[PEAK][2].item() == 0


def test_the_next_octave_bounds_every_quantity_to_both_sides():
    """Full contacts of the bank, which have no gap and no last change to scale by, leave no end open."""
    octave = unresolved.next_octave(curve_of([0.4, 0.3, 0.2, 0.1, 0.0]))
    for name in (AREA, GAP, PEAK, *ANSWERS):
        assert np.isfinite([*table()["octave"][entry(name)].values()]).all(), name
    for name, component in octave.items():
        assert np.isfinite(component).all(), name
        assert (component[1] > 0).all(), name
