"""Maps that are corrected for their instrument: nearer to the truth, in the interval, and named."""

import json
from collections.abc import Sequence

import numpy as np
import pytest
import xarray as xr
from known_surfaces import noisy

import roughcontact as rc
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.arguments.settings.stages import stage_settings
from roughcontact.errors import SettingsError
from roughcontact.report.facts import waves_in_words
from roughcontact.results.collect import collect_statistics, summary_table
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.window.instrument import window_arguments
from roughcontact.surface.window.transfer import corrected, transfer
from validation.masters import master_surface

MODULUS = 1e9
SOURCES = ("solver", "discretisation", "instrument", "unresolved")
SHOWN = ("relative_contact_area", "mean_gap", "mean_contact_pressure", "max_pressure")


def true_surface(kind: str, seed: int = 1) -> xr.DataArray:
    """Return a periodic surface with pixels of 0.4 um."""
    return height_map(1e-6 * master_surface(kind, 96, longest=0.4, seed=seed).values, 0.4e-6)


def through(height: xr.DataArray, **lens: float) -> xr.DataArray:
    """Return a periodic map as an instrument transmits it."""
    frequency = [np.fft.fftfreq(n, d) for n, d in zip(height.shape, spacing(height), strict=True)]
    share = transfer(np.hypot(frequency[0][:, None], frequency[1][None, :]), lens)
    return height.copy(data=np.fft.ifft2(np.fft.fft2(height.values) * share).real)


def evaluated(
    height: xr.DataArray, loads: list[float], *, sources: Sequence[str] = SOURCES, **instrument: float | bool
) -> xr.Dataset:
    return rc.evaluate(
        height,
        contact={"contact_modulus": MODULUS, "mean_pressure": loads},
        uncertainty={"sources": list(sources)},
        instrument=instrument,
    )


@pytest.mark.parametrize("kind", ["random", "worn", "honed", "grainy"])
@pytest.mark.parametrize(
    ("numerical_aperture", "share_of_noise"), [(0.3, 0.0), (0.55, 0.01), (0.8, 0.01), (None, 0.1)]
)
def test_a_corrected_map_is_nearer_to_the_truth_which_is_in_its_interval(
    kind, numerical_aperture, share_of_noise
):
    height = true_surface(kind)
    loads = [share * MODULUS * rms_gradient(height) for share in (0.02, 0.2)]
    truth = rc.contact_statistics(rc.solve_contact(height, contact_modulus=MODULUS, mean_pressure=loads))
    optics = {}
    measured = height
    if numerical_aperture:
        optics["numerical_aperture"] = numerical_aperture
        measured = through(measured, **optics)
    if share_of_noise:
        optics["noise"] = share_of_noise * float(height.std())
        measured = noisy(measured, optics["noise"])
    result = evaluated(measured, loads, correct=True, **optics)
    area = "relative_contact_area"
    for name in SHOWN[:3]:
        true = (np.array(loads) / truth[area] if "contact_p" in name else truth[name]).values
        assert (true >= result[f"{name}_lower"]).all(), name
        assert (np.nan_to_num(result[f"{name}_upper"], nan=np.inf) >= true).all(), name
    error_corrected, error_measured = (
        np.abs(np.log(result[name] / truth[area])).max() for name in (area, f"{area}_as_measured")
    )
    assert error_corrected < error_measured / 2
    plain = evaluated(measured, loads, **optics)
    for name in SHOWN:
        solved = (
            np.array(loads) / plain[f"{area}_as_solved"]
            if "contact_p" in name
            else plain[f"{name}_as_solved"]
        )
        assert result[f"{name}_as_measured"].values == pytest.approx(solved.values, rel=3e-3)
    instrument = result[f"{area}_components"].sel(source="instrument")
    assert (instrument.sel(component=["down", "up"]) > 0).all()  # to both sides
    assert (instrument.sel(component=["shift_down", "shift_up"]) == 0).all()


def test_a_correction_brings_its_uncertainty_whatever_the_sources():
    """JCGM 100:2008, 3.2.4; and what is not asked for is not corrected: the area then stays as solved."""
    height = true_surface("random")
    loads = [0.1 * MODULUS * rms_gradient(height)]
    noise = 0.05 * float(height.std())
    measured = noisy(height, noise)
    unstated, add_noise = (
        evaluated(measured, loads, sources=sources, noise=noise, correct=True)
        for sources in (["solver"], ["solver", "instrument"])
    )
    xr.testing.assert_equal(unstated.drop_attrs(), add_noise.drop_attrs())
    area = "relative_contact_area"
    true = rc.contact_statistics(rc.solve_contact(height, contact_modulus=MODULUS, mean_pressure=loads))[area]
    assert (unstated[f"{area}_lower"] <= true).all()
    assert (true <= unstated[f"{area}_upper"]).all()
    assert unstated[area].values == pytest.approx(unstated[f"{area}_as_solved"].values, rel=1e-12)
    none = evaluated(measured, loads, sources=[], noise=noise, correct=True)
    assert f"{area}_lower" not in none
    assert "corrected_for" in none.attrs


def test_a_correction_restores_the_gradient_that_noise_hides():
    height = true_surface("random", seed=2)
    noise = 0.1 * float(height.std())
    measured = noisy(height, noise)
    restored = corrected(measured, {"noise": noise})
    assert rms_gradient(measured) > 1.2 * rms_gradient(height)
    assert rms_gradient(restored) == pytest.approx(rms_gradient(height), rel=0.02)
    assert float(restored.mean()) == pytest.approx(float(measured.mean()), abs=1e-12)


@pytest.mark.parametrize("shape", [(30, 33), (33, 30), (32, 48), (31, 29)])
@pytest.mark.parametrize(
    "instrument",
    [{"noise": 0.05}, {"noise": 0.05, "resolution": 4e-6}, {"numerical_aperture": 0.1, "wavelength": 6e-7}],
)
def test_a_correction_counts_every_wave_once_whatever_the_axis(shape, instrument):
    """By the transform of all waves, where `restored` has that of a half of them; and of the map turned."""
    x = np.indices(shape)[1]
    heights = np.random.default_rng(0).standard_normal(shape)
    heights = height_map(np.sin(2 * np.pi * x / shape[1]) + 0.2 * heights, (1.5e-6, 1e-6))
    actual = corrected(heights, instrument)
    turned = corrected(height_map(heights.values.T, spacing(heights)[::-1]), instrument)
    np.testing.assert_allclose(turned.values.T, actual, atol=1e-12)

    frequency = [np.fft.fftfreq(n, d) for n, d in zip(shape, spacing(heights), strict=True)]
    frequency = np.hypot(frequency[0][:, None], frequency[1][None, :])
    share, spectrum = transfer(frequency, instrument), np.fft.fft2(heights)
    power, of_noise = np.abs(spectrum) ** 2, heights.size * instrument.get("noise", 0.0) ** 2
    hidden = share < 0.01
    floor = max(of_noise, np.median(power[hidden])) if hidden.any() else of_noise
    rings = np.rint(frequency / frequency.max() * max(shape))
    mean = np.zeros(shape)
    for ring in np.unique(rings):
        mean[rings == ring] = power[rings == ring].mean()
    gain = np.where((mean >= 2 * floor) & ~hidden, 1 / np.maximum(share, 0.2), 1.0)
    gain *= np.sqrt(np.maximum(1 - of_noise / mean, 0))
    gain[0, 0] = 1.0
    np.testing.assert_allclose(actual, np.fft.ifft2(spectrum * gain).real, atol=1e-12)


def test_noise_that_is_all_of_the_gradient_leaves_no_upper_end():
    height = true_surface("random")
    smooth = through(height, resolution=8e-6)
    noise = 0.5 * float(smooth.std())
    measured = noisy(smooth, noise)
    result = evaluated(measured, [0.1 * MODULUS * rms_gradient(smooth)], noise=noise, correct=True)
    assert float(result["relative_contact_area_upper"][0]) == 1.0


def test_a_correction_is_named_wherever_its_numbers_stand(tmp_path):
    height = true_surface("random")
    loads = [0.1 * MODULUS * rms_gradient(height)]
    words = "noise of 2.00 nm, numerical aperture of 0.55"
    result = evaluated(height, loads, noise=2e-9, numerical_aperture=0.55, correct=True)
    assert result.attrs["corrected_for"] == words
    assert json.loads(result.attrs["settings"])["instrument"]["correct"] is True
    result.to_netcdf(tmp_path / "statistics.nc")
    entry = {"surface": "one", "case": None, "statistics": tmp_path / "statistics.nc"}
    assert summary_table(collect_statistics([entry]))["corrected_for"].tolist() == [words]
    window = rc.periodic_window(height, correct_for={"noise": 2e-9, "numerical_aperture": 0.55})
    assert waves_in_words(window).endswith(f", corrected for {words}")


def test_the_window_follows_the_instrument_only_where_it_is_corrected():
    contact = {"contact": {"contact_modulus": MODULUS}}
    plain, with_correction = (
        resolve(contact | {"instrument": {"noise": "2 nm", "correct": correct}})[""]
        for correct in (False, True)
    )
    assert list(stage_settings(plain, "window")) == ["level", "window"]
    assert list(stage_settings(with_correction, "window")) == ["level", "window", "instrument"]
    assert list(stage_settings(with_correction, "levelled")) == ["level"]
    height = true_surface("random")
    assert window_arguments(height, plain) == plain["window"]
    assert window_arguments(height, with_correction)["correct_for"]["noise"] == pytest.approx(2e-9)


@pytest.mark.cases
def test_a_correction_that_cannot_be_made_is_refused(instrument, attrs, words):
    height = true_surface("random").assign_attrs(source_file="a.sur", **attrs)
    settings = {"window": {}, "instrument": instrument | {"correct": True}}
    with pytest.raises(SettingsError, match=words):
        window_arguments(height, settings)
