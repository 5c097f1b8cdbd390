"""Material ratio curve and developed area: curves with known answers, and another library on real files."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ndtri
from shared_data import DATA

from roughcontact import height_map, level, read_height_map
from roughcontact.surface.roughness.bearing import bearing_parameters
from roughcontact.surface.roughness.heights import height_parameters
from validation.closed_forms import gaussian_bearing

TABLE = Path(__file__).with_name("bearing_parameters.csv")
# the other library takes areas from the nearest point of its curve on, not from where the line meets it
AREAS = {"Spk", "Svk", "Sak1", "Sak2", "Vmp", "Vmc", "Vvc", "Vvv"}


def table():
    """Return {file: {parameter: value}} of the numbers that another library found."""
    lines = [line for line in TABLE.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = {row.pop("file"): row for row in csv.DictReader(lines)}
    return {file: {name: float(text) for name, text in row.items()} for file, row in rows.items()}


@pytest.mark.shared_data
@pytest.mark.parametrize("name", table())
def test_another_library_finds_the_same(name):
    levelled = level(read_height_map(DATA / name), outlier_threshold=None, fill="none")
    for parameter, expected in table()[name].items():
        rel = 1e-3 if parameter in AREAS else 1e-8
        assert levelled.attrs[parameter] == pytest.approx(expected, rel=rel), parameter


@pytest.mark.parametrize(("peak", "core", "dale"), [(30.0, 2.0, 8.0), (12.0, 1.0, 50.0)])
def test_three_straight_pieces(peak, core, dale):
    """Slopes by material ratio of peaks (to 10 %), core (to 80 %) and dales: triangles by hand."""
    ratio = np.linspace(0, 1, 100001)
    curve = np.interp(ratio, [0, 0.1, 0.8, 1], [0.1 * peak + 0.7 * core, 0.7 * core, 0.0, -0.2 * dale])
    parameters = bearing_parameters(np.random.default_rng(0).permutation(curve) + 3.0)
    enters, leaves = 0.1 - 0.1 * core / peak, 0.8 + 0.2 * core / dale
    assert parameters["Sk"] == pytest.approx(core, rel=1e-6)
    assert parameters["Smr1"] == pytest.approx(enters, rel=1e-5)
    assert parameters["Smr2"] == pytest.approx(leaves, rel=1e-5)
    assert parameters["Spk"] == pytest.approx(peak * enters, rel=1e-4)
    assert parameters["Svk"] == pytest.approx(dale * (1 - leaves), rel=1e-4)
    assert parameters["Vvv"] == pytest.approx(0.2**2 * dale / 2, rel=1e-4)
    # what the triangles and the core leave of the whole height
    assert parameters["Sak1"] == pytest.approx(peak * enters**2 / 2, rel=1e-4)
    assert parameters["Sak2"] == pytest.approx(dale * (1 - leaves) ** 2 / 2, rel=1e-4)
    assert parameters["Spkx"] == pytest.approx(peak * enters, rel=1e-4)
    assert parameters["Svkx"] == pytest.approx(dale * (1 - leaves), rel=1e-4)
    assert parameters["Sdc"] == pytest.approx(0.075 * peak + 0.4 * core, rel=1e-4)
    assert parameters["Vmp"] == pytest.approx(0.1**2 * peak / 2, rel=1e-4)
    # below 10 %: all of the core's slope, and a rectangle over the first tenth
    assert parameters["Vmc"] == pytest.approx(0.7**2 * core / 2 + 0.1 * 0.7 * core, rel=1e-4)


def test_volumes_of_a_wave():
    """c = a cos π mr: Vm(mr) = a (sin(π mr)/π − mr cos(π mr)), and voids alike from below."""
    a = 3e-7
    wave = a * np.cos(2 * np.pi * (np.arange(200000) + 0.5) / 200000)

    def material(mr):
        return a * (np.sin(np.pi * mr) / np.pi - mr * np.cos(np.pi * mr))

    parameters = bearing_parameters(wave)
    assert parameters["Vmc"] == pytest.approx(material(0.8) - material(0.1), rel=1e-4)
    assert parameters["Vvv"] == pytest.approx(material(0.2), rel=1e-4)
    assert parameters["Vmp"] == pytest.approx(material(0.1), rel=1e-4)
    assert parameters["Vvc"] == pytest.approx(material(0.9) - material(0.2), rel=1e-4)
    assert parameters["Sdc"] == pytest.approx(a * np.cos(0.025 * np.pi), rel=1e-4)


def test_a_symmetric_surface_is_all_core_around_the_middle():
    heights = np.random.default_rng(1).standard_normal(400000)
    parameters = bearing_parameters(heights)
    turned = bearing_parameters(-heights)
    assert parameters["Spk"] == pytest.approx(turned["Svk"], rel=0.02)
    assert parameters["Smr1"] == pytest.approx(1 - turned["Smr2"], abs=0.01)
    # of normal heights, from the quantiles: the secant between 30 % and 70 %, least squares within
    assert parameters["Sk"] == pytest.approx(2.58, abs=0.05)


def test_scale_and_offset():
    heights = np.random.default_rng(2).exponential(size=5000)
    reference, scaled = bearing_parameters(heights), bearing_parameters(1e-9 * heights + 0.5)
    for name, value in reference.items():
        factor = 1.0 if name.startswith("Smr") else 1e-9
        assert scaled[name] == pytest.approx(factor * value, rel=1e-5)


def test_nothing_to_read_off_a_flat_map():
    parameters = bearing_parameters(np.full(10, 0.3))
    assert math.isnan(parameters.pop("Smr1"))
    assert math.isnan(parameters.pop("Smr2"))
    assert set(parameters.values()) == {0.0}
    assert height_parameters(height_map(np.full((5, 6), 0.3), 1e-6))["Sdr"] == 0


@pytest.mark.parametrize("points", [5, 6, 50])
def test_heights_spread_evenly_are_all_core_however_few(points):
    parameters = bearing_parameters(np.linspace(-1e-6, 2e-6, points))
    assert parameters["Sk"] == pytest.approx(3e-6, rel=1e-12)
    assert (parameters["Smr1"], parameters["Smr2"]) == (pytest.approx(0), pytest.approx(1))


def test_two_points():
    parameters = bearing_parameters(np.array([0.0, 1.0]))
    assert parameters["Sk"] >= 0
    assert parameters["Vvv"] == pytest.approx(0.02)


def test_developed_area_of_planes_and_a_tent():
    y, x = np.indices((9, 12))
    tilted = height_map(0.3 * 2e-6 * x - 0.4 * 1e-6 * y, (1e-6, 2e-6))
    assert height_parameters(tilted)["Sdr"] == pytest.approx(math.sqrt(1.25) - 1, rel=1e-12)
    tent = height_map(1e-6 * np.abs(np.arange(11) - 5.0)[None, :] * np.ones((4, 1)), 1e-6)
    assert height_parameters(tent)["Sdr"] == pytest.approx(math.sqrt(2) - 1, rel=1e-12)
    profile = height_map([[0.0, 1.0, 0.0, 1.0]], 0.5)
    assert height_parameters(profile)["Sdr"] == pytest.approx(math.sqrt(5) - 1, rel=1e-12)


def test_developed_area_of_a_small_wave_is_half_the_mean_square_slope():
    x = 2 * np.pi * np.arange(400) / 100
    height = height_map(1e-9 * (np.cos(x)[None, :] + np.cos(x)[:, None]), 1e-6)
    parameters = height_parameters(height)
    assert parameters["Sdr"] == pytest.approx(parameters["Sdq"] ** 2 / 2, rel=1e-3)


def test_cells_with_missing_points_do_not_count():
    values = np.zeros((6, 6))
    values[2, 2] = np.nan
    values[:, 4:] = [1.0, 2.0]
    shortened = np.delete(values, 2, axis=0)
    excess, complete_excess = (
        height_parameters(height_map(part, 1.0))["Sdr"] for part in (values, shortened)
    )
    assert np.isfinite(excess)
    # columns of cells: 0 to 3 flat but for the step to 1, then the slope 1; four cells are missing
    cells = np.array([0, 0, 0, math.sqrt(2) - 1, math.sqrt(2) - 1])
    counts = np.array([5, 3, 3, 5, 5])
    assert excess == pytest.approx((cells @ counts) / counts.sum())
    assert complete_excess == pytest.approx(cells.mean())


def test_closed_form_of_normal_heights_by_quadrature():
    """The line by least squares over a fine curve, areas by the rectangle rule: nothing of the integrals."""
    parameters = gaussian_bearing(2.0)
    ratio = (np.arange(2_000_000) + 0.5) / 2_000_000
    curve = 2.0 * ndtri(1 - ratio)
    middle = (ratio > 0.3) & (ratio < 0.7)
    slope, at_zero = np.polyfit(ratio[middle], curve[middle], 1)
    assert parameters["Sk"] == pytest.approx(-slope, rel=1e-9)
    upper, lower = at_zero, at_zero + slope
    enters, leaves = (curve > upper).mean(), (curve > lower).mean()
    assert parameters["Smr1"] == pytest.approx(enters, abs=1e-6)
    assert parameters["Smr2"] == pytest.approx(leaves, abs=1e-6)
    assert parameters["Spk"] == pytest.approx(2 * np.maximum(curve - upper, 0).mean() / enters, rel=1e-4)
    assert parameters["Svk"] == pytest.approx(
        2 * np.maximum(lower - curve, 0).mean() / (1 - leaves), rel=1e-4
    )
    core, peak = (np.maximum(curve - 2.0 * ndtri(1 - m), 0).mean() for m in (0.8, 0.1))
    assert parameters["Vmc"] == pytest.approx(core - peak, rel=1e-4)
    assert parameters["Vvv"] == pytest.approx(np.maximum(2.0 * ndtri(0.2) - curve, 0).mean(), rel=1e-4)
