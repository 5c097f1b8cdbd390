"""Height parameters of ISO 25178-2: closed forms, and other software on real files."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from shared_data import DATA

from roughcontact.io.read import read_height_map
from roughcontact.levelling.level import level
from roughcontact.maps import height_map
from roughcontact.roughness.heights import height_parameters
from roughcontact.statistics.contact_statistics import HEIGHT_PARAMETERS, surface_statistics
from roughcontact.window.periodic_window import periodic_window

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
    found = {parameter: levelled.attrs[parameter] for parameter in expected}
    assert found == pytest.approx(expected, rel=1e-6)


def test_a_wave_in_closed_form():
    """z = a cos: Sa = 2a/pi, Sq = a/sqrt 2, Ssk = 0, Sku = 3/2; the differences of a cosine are known too."""
    n, a, pitch = 360, 2e-7, 1e-6
    x = np.arange(n)
    height = height_map(5e-6 + a * np.cos(2 * np.pi * 3 * x / n) + np.zeros((8, 1)), pitch)
    found = height_parameters(height)
    assert found["Sa"] == pytest.approx(2 * a / np.pi, rel=1e-3)
    assert found["Sq"] == pytest.approx(a / math.sqrt(2), rel=1e-12)
    assert found["Ssk"] == pytest.approx(0, abs=1e-12)
    assert found["Sku"] == pytest.approx(1.5, rel=1e-12)
    assert found["Sz"] == pytest.approx(2 * a, rel=1e-12)
    assert found["Sp"] + found["Sv"] == pytest.approx(found["Sz"], rel=1e-15)
    steps = 2 * a * np.sin(np.pi * 3 / n) * np.sin(2 * np.pi * 3 * (x[:-1] + 0.5) / n)
    assert found["Sdq"] == pytest.approx(np.sqrt(np.mean(steps**2)) / pitch, rel=1e-12)


def test_a_tilted_plate_and_pixels_that_are_not_square():
    y, x = np.indices((20, 30))
    found = height_parameters(height_map(0.3 * 2e-6 * x - 0.4 * 1e-6 * y, (1e-6, 2e-6)))
    assert found["Sdq"] == pytest.approx(0.5, rel=1e-12)
    assert found["Ssk"] == pytest.approx(0, abs=1e-12)


def test_points_that_were_not_measured_do_not_count():
    generator = np.random.default_rng(0)
    values = generator.standard_normal((30, 40))
    values[generator.random(values.shape) < 0.3] = np.nan
    found = height_parameters(height_map(values, (2.0, 1.0)))
    known = values[~np.isnan(values)]
    assert found["Sq"] == pytest.approx(known.std(), rel=1e-12)
    assert found["Sz"] == pytest.approx(np.ptp(known), rel=1e-12)
    squares = [(values[j, i + 1] - values[j, i]) ** 2 for j in range(30) for i in range(39)]
    across = [(values[j + 1, i] - values[j, i]) ** 2 / 4 for j in range(29) for i in range(40)]
    assert found["Sdq"] == pytest.approx(np.sqrt(np.nanmean(squares) + np.nanmean(across)), rel=1e-12)


def test_skewness_and_kurtosis_of_known_distributions():
    generator = np.random.default_rng(1)
    found = height_parameters(height_map(generator.exponential(size=(1000, 1000)), 1.0))
    assert found["Ssk"] == pytest.approx(2, rel=2e-2)
    assert found["Sku"] == pytest.approx(9, rel=4e-2)


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
    # a window that nobody levelled has none
    assert "Sa" not in surface_statistics(height_map(window.values, 1e-6))
