"""The benchmark of measured maps spoils what it says it spoils, and counts right."""

import measurement
import numpy as np
import pandas as pd
import pytest

import roughcontact as rc
from roughcontact.arguments.maps import height_map, spacing


@pytest.fixture(scope="module")
def truth():
    return measurement.synthetic("random")


def rows(**columns):
    """Return rows of one quantity and truth, one for each entry of the columns."""
    common = {
        "truth": "a",
        "spoiler": "none",
        "group": "synthetic",
        "quantity": "area",
        "flags": "",
        "of_cause": 0.1,
    }
    frame = pd.DataFrame({"value": 1.0, "lower": 0.9, "upper": 1.1, "true": 1.0, **columns})
    bounds = {which + bound: frame[bound] for which in measurement.INTERVALS for bound in ("lower", "upper")}
    return frame.assign(**(bounds | common))


@pytest.mark.parametrize("side", measurement.SIDES)
def test_the_window_stays_in_its_place_with_pixels_twice_as_large(side):
    heights = np.random.default_rng(side).standard_normal((side, side)).cumsum(0).cumsum(1)
    fine = rc.periodic_window(height_map(heights, 1e-6))
    coarse = rc.periodic_window(height_map(heights[::2, ::2], 2e-6))
    assert coarse.shape == tuple(n // 2 for n in fine.shape)
    for axis in "xy":
        assert coarse.attrs[f"window_offset_{axis}"] == pytest.approx(fine.attrs[f"window_offset_{axis}"])


@pytest.mark.parametrize("spoiler", measurement.SPOILERS)
def test_an_error_is_of_the_size_that_is_stated(spoiler, truth):
    case = measurement.spoilt(spoiler, "random", truth)
    assert measurement.spoilt(spoiler, "random", truth).height.identical(case.height)
    instrument = case.instrument or {}
    change = (case.height - truth).values if case.height.shape == truth.shape else None
    if "noise" in instrument:
        assert change.std() == pytest.approx(instrument["noise"], rel=0.03)
    elif "tip_radius" in instrument:
        assert (change >= 0).all()
    elif "numerical_aperture" in instrument:
        assert 0.5 < case.height.std() / truth.std() < 1
    elif "amplification_z" in instrument:
        assert np.ptp((case.height / truth).values) < 1e-12
        assert abs(float(case.height[0, 0] / truth[0, 0]) - 1) <= instrument["amplification_z"]
    elif case.modulus_uncertainty:
        assert 0 < abs(case.modulus / measurement.MODULUS - 1) <= case.modulus_uncertainty
    elif spoiler.startswith("steps"):
        levels = np.unique(case.height) / (float(spoiler.split()[2].rstrip("%")) / 100 * float(truth.std()))
        assert np.allclose(levels, np.rint(levels), atol=1e-9)
        assert 0 < abs(change).max() <= np.diff(np.unique(case.height)).min() / 2 * 1.0001
    elif spoiler.startswith("one period"):
        window = rc.periodic_window(rc.level(truth))
        assert case.height.shape == window.shape
        assert float(case.height.isnull().mean()) == pytest.approx(0.01, rel=0.3)
        # without the plane, second differences are those of the window, from another first point
        curvature = [np.diff(surface.values, 2, axis=1) for surface in (case.height, window)]
        assert np.nanstd(curvature[0]) == pytest.approx(np.std(curvature[1]), rel=0.02)
    elif spoiler == "none":
        assert case.height.identical(truth)
    else:
        assert spacing(case.height) == pytest.approx([2 * d for d in spacing(truth)])


def test_a_part_of_a_measured_map_is_the_middle_of_what_was_measured(tmp_path):
    y, x = np.mgrid[:240, :300]
    heights = 1e-9 * np.sin(x / 3.0) * np.cos(y / 5.0) + 1e-8 * x
    heights[:, :60] = np.nan
    height_map(heights, 1e-6).to_netcdf(tmp_path / "map.nc")
    part = measurement.measured(tmp_path / "map.nc")
    assert part.shape == (220, 220)
    plain = rc.level(height_map(heights, 1e-6)).values
    assert np.allclose(part, plain[10:230, 70:290], atol=1e-15)


def test_truths_outside_are_counted_and_open_ends_hold():
    judgement = measurement.judged(rows(true=[1.0, 1.2, 0.8, 1.2], upper=[1.1, 1.1, 1.1, np.nan]))
    assert judgement["inside"].tolist() == [True, False, False, True]
    assert judgement["silent"].tolist() == [False, True, True, False]
    assert judgement["error"].tolist() == pytest.approx([0, 0.2, 0.2, 0.2])
    warned = measurement.judged(rows(true=[1.2]).assign(flags="Plasticity; Noise"))
    assert not warned["silent"].any()
    of_map = measurement.judged(rows(true=[1.2]).assign(map_upper=1.3))
    assert of_map["map_inside"].all()
    assert not of_map["inside"].any()


def test_a_width_is_held_against_the_largest_errors():
    row = measurement.counted(measurement.judged(rows(true=[0.95, 1.05, 1.2])))
    assert row["cases"] == 1
    assert row["area inside (%)"] == pytest.approx(100 * 2 / 3)
    assert row["area width"] == pytest.approx(0.1 / 0.185)
    assert np.isnan(measurement.counted(measurement.judged(rows(true=[1.0])))["area width"])


def test_tables_have_every_error_and_cause():
    coarser = rows(true=[1.2]).assign(spoiler="pixels × 2", octave_upper=1.3)
    tables = measurement.tables(
        pd.concat([rows(true=[1.0]), rows(true=[1.2]).assign(spoiler="tip 10 nm"), coarser])
    )
    assert tables["errors"]["error"].tolist() == [*["none", "tip 10 nm"] * 2, "pixels × 2"]
    causes = tables["causes"].set_index(["interval", "cause", "group"])["area inside (%)"]
    assert causes["map", "none", "all"] == "100"
    assert causes["surface", "tip", "synthetic"] == "0"
    assert causes["octave", "pixels", "all"] == "100"
