"""Height parameters of ISO 25178-2: closed forms, and other software on real files."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from shared_data import DATA

import roughcontact as rc
from roughcontact import height_map, level, periodic_window, read_height_map
from roughcontact.arguments.si import labelled_in_si
from roughcontact.statistics.contact_statistics import surface_statistics
from roughcontact.surface.roughness.heights import HEIGHT_PARAMETERS, height_parameters
from validation.surfaces import ground_surface

TABLE = Path(__file__).with_name("height_parameters.csv")


def table():
    """Return {file: {parameter: value}} of the numbers that other software found."""
    lines = [line for line in TABLE.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = {row.pop("file"): row for row in csv.DictReader(lines)}
    return {file: {name: float(text) for name, text in row.items() if text} for file, row in rows.items()}


@pytest.mark.shared_data
@pytest.mark.parametrize("name", table())
def test_other_software_finds_the_same(name):
    height = read_height_map(DATA / name)
    levelled = level(height, outlier_threshold=None, fill="none")
    expected = table()[name]
    parameters = {parameter: levelled.attrs[parameter] for parameter in expected}
    assert parameters == pytest.approx(expected, rel=1e-6)


def test_a_wave_in_closed_form():
    """z = a cos: Sa = 2a/pi, Sq = a/sqrt 2, Ssk = 0, Sku = 3/2; the differences of a cosine are known too."""
    n, a, pitch = 360, 2e-7, 1e-6
    x = np.arange(n)
    height = height_map(5e-6 + a * np.cos(2 * np.pi * 3 * x / n) + np.zeros((8, 1)), pitch)
    parameters = height_parameters(height)
    assert parameters["Sa"] == pytest.approx(2 * a / np.pi, rel=1e-3)
    assert parameters["Sq"] == pytest.approx(a / math.sqrt(2), rel=1e-12)
    assert parameters["Ssk"] == pytest.approx(0, abs=1e-12)
    assert parameters["Sku"] == pytest.approx(1.5, rel=1e-12)
    assert parameters["Sz"] == pytest.approx(2 * a, rel=1e-12)
    assert parameters["Sp"] + parameters["Sv"] == pytest.approx(parameters["Sz"], rel=1e-15)
    steps = 2 * a * np.sin(np.pi * 3 / n) * np.sin(2 * np.pi * 3 * (x[:-1] + 0.5) / n)
    assert parameters["Sdq"] == pytest.approx(np.sqrt(np.mean(steps**2)) / pitch, rel=1e-12)


def test_a_tilted_plate_and_pixels_that_are_not_square():
    y, x = np.indices((20, 30))
    parameters = height_parameters(height_map(0.3 * 2e-6 * x - 0.4 * 1e-6 * y, (1e-6, 2e-6)))
    assert parameters["Sdq"] == pytest.approx(0.5, rel=1e-12)
    assert parameters["Ssk"] == pytest.approx(0, abs=1e-12)


def test_points_that_were_not_measured_do_not_count():
    generator = np.random.default_rng(0)
    values = generator.standard_normal((30, 40))
    values[generator.random(values.shape) < 0.3] = np.nan
    parameters = height_parameters(height_map(values, (2.0, 1.0)))
    finite = values[~np.isnan(values)]
    assert parameters["Sq"] == pytest.approx(finite.std(), rel=1e-12)
    assert parameters["Sz"] == pytest.approx(np.ptp(finite), rel=1e-12)
    squares = [(values[j, i + 1] - values[j, i]) ** 2 for j in range(30) for i in range(39)]
    across = [(values[j + 1, i] - values[j, i]) ** 2 / 4 for j in range(29) for i in range(40)]
    assert parameters["Sdq"] == pytest.approx(np.sqrt(np.nanmean(squares) + np.nanmean(across)), rel=1e-12)


def test_skewness_and_kurtosis_of_known_distributions():
    generator = np.random.default_rng(1)
    parameters = height_parameters(height_map(generator.exponential(size=(1000, 1000)), 1.0))
    assert parameters["Ssk"] == pytest.approx(2, rel=2e-2)
    assert parameters["Sku"] == pytest.approx(9, rel=4e-2)


def test_flat_map_and_profile():
    flat = height_parameters(height_map(np.full((5, 6), 0.3), 1e-6))
    assert all(flat[name] == 0 for name in ("Sa", "Sq", "Sp", "Sv", "Sz", "Sdq"))
    assert math.isnan(flat["Ssk"])
    assert math.isnan(flat["Sku"])
    profile = height_parameters(height_map([[0.0, 1.0, 0.0, 1.0]], 0.5))
    assert profile["Sdq"] == pytest.approx(2.0)


def test_they_are_those_of_the_measured_points_and_reach_the_statistics():
    generator = np.random.default_rng(2)
    values = generator.standard_normal((64, 64)) * 1e-7
    values[20:30, 20:30] = np.nan
    levelled = level(height_map(values, 1e-6))
    assert int(levelled["filled"].sum()) == 100
    rough = levelled.values[levelled["filled"].values == 0]
    assert levelled.attrs["Sq"] == pytest.approx(rough.std(), rel=1e-12)
    window = periodic_window(levelled)
    statistics = surface_statistics(window)
    assert {name: statistics[name] for name in HEIGHT_PARAMETERS} == {
        name: levelled.attrs[name] for name in HEIGHT_PARAMETERS
    }
    restated = window.copy(data=window.values * 1e6).assign_attrs(units="um")
    assert surface_statistics(labelled_in_si(restated))["Sq"] == levelled.attrs["Sq"]


@pytest.mark.parametrize(
    "changed",
    [
        lambda height: 2 * height,
        lambda height: -height,
        lambda height: height.isel(y=slice(40)),
        lambda height: height - height.rolling(x=9, center=True, min_periods=1).mean(),
        lambda height: height.copy(data=np.maximum(height.values, -1e-8)),
    ],
)
@pytest.mark.parametrize("stage", ["levelled", "window"])
def test_heights_that_were_changed_have_parameters_of_their_own(changed, stage):
    """Attributes are kept by arithmetic, filters and selections."""
    surface = ground_surface((64, 64), 1e-6, hurst=0.8, shortest=4e-6, longest=6e-5, rms_height=1e-7)
    levelled = level(surface.copy(data=np.maximum(surface.values, -1.5e-7)), form="none")
    with xr.set_options(keep_attrs=True):
        height = changed(levelled if stage == "levelled" else periodic_window(levelled))
    assert height.attrs["Sq"] == levelled.attrs["Sq"]
    own_parameters = height_parameters(height)
    assert own_parameters["Spk"] != pytest.approx(levelled.attrs["Spk"], rel=1e-2)
    statistics = surface_statistics(height if stage == "window" else periodic_window(height, method="raw"))
    assert {name: statistics[name] for name in HEIGHT_PARAMETERS} == pytest.approx(own_parameters, rel=1e-12)
    assert "row_jitter" not in statistics


@pytest.mark.parametrize("crop", [slice(None), slice(0, 50)])
def test_the_areal_parameters_are_those_of_levelling_and_of_the_statistics(crop):
    surface = ground_surface((64, 64), 1e-6, hurst=0.8, shortest=4e-6, longest=6e-5, rms_height=1e-7)
    values = surface[crop].values
    values[3, 5] = np.nan
    levelled = level(height_map(values, 1e-6))
    parameters = rc.parameters(levelled)
    assert {name: parameters[name].item() for name in HEIGHT_PARAMETERS} == {
        name: levelled.attrs[name] for name in HEIGHT_PARAMETERS
    }
    solved = rc.solve_contact(periodic_window(levelled), contact_modulus=1e9, mean_pressure=1e6)
    statistics = rc.contact_statistics(solved, flow="never")
    assert parameters.drop_attrs(deep=False).identical(statistics[[*parameters]].drop_attrs(deep=False))
    assert (parameters["Sal"].attrs["units"], parameters["Std"].attrs["units"]) == ("m", "degree")


def test_the_areal_parameters_of_a_wave_in_micrometres():
    """Sal of a wave is that of its autocorrelation, a cosine: its length times acos(0.2) / (2 pi)."""
    x = np.arange(64)
    wave = height_map(3 * np.cos(2 * np.pi * x / 16) + np.zeros((64, 1)), 2, unit="um")
    parameters = rc.parameters(wave)
    assert parameters["Sq"].item() == pytest.approx(3e-6 / math.sqrt(2), rel=1e-12)
    assert parameters["Sal"].item() == pytest.approx(32e-6 * math.acos(0.2) / (2 * np.pi), rel=1e-3)
    assert parameters["Ssw"].item() == pytest.approx(32e-6, rel=1e-12)
    scaled = rc.parameters(2 * wave)
    assert scaled["Sq"].item() == pytest.approx(2 * parameters["Sq"].item(), rel=1e-12)


def test_infinite_heights_are_left_out_of_the_parameters(recwarn):
    rough = np.random.default_rng(3).standard_normal((30, 40))
    infinite, missing = (height_map(rough, 1.0, unit="m").copy() for _ in range(2))
    infinite[4:6, 7:9], missing[4:6, 7:9] = np.inf, np.nan
    assert rc.parameters(infinite).identical(rc.parameters(missing))
    assert not [warning for warning in recwarn if issubclass(warning.category, RuntimeWarning)]
