"""Parameters of profiles, against closed forms; ISO 21920-2 in other programs is compared in the comments."""

import numpy as np
import pytest

import roughcontact as rc

PITCH = 0.5e-6


def sine(amplitude=1e-6, wavelength=100e-6, points=8000, phase=0.3):
    x = np.arange(points) * PITCH
    return rc.height_map(amplitude * np.sin(2 * np.pi * x / wavelength + phase), PITCH)


def test_a_sine():
    result = rc.profile_parameters(sine())
    expected = {"Pa": 2e-6 / np.pi, "Pq": 1e-6 / np.sqrt(2), "Pz": 2e-6, "Pt": 2e-6, "Pp": 1e-6, "Pv": 1e-6}
    expected |= {"Psk": 0, "Pku": 1.5, "Psm": 100e-6, "Pdq": np.sqrt(2) * np.pi * 1e-6 / 100e-6}
    for name, value in expected.items():
        # differences of neighbours, 0.5 in 100 um, are 4e-4 too flat
        assert result[name] == pytest.approx(value, rel=5e-4, abs=1e-9), name


def test_roughness_parameters_have_the_sections_of_the_l_filter():
    # waves of 25 um are kept, those of 4 mm removed; every section of 250 um has ten of the short ones
    x = np.arange(8000) * PITCH
    short, long = 1e-6 * np.sin(2 * np.pi * x / 25e-6), 20e-6 * np.sin(2 * np.pi * x / 4e-3)
    levelled = rc.level(rc.height_map(short + long, PITCH), l_filter=250e-6, outlier_threshold=None)
    result = rc.profile_parameters(levelled)
    assert not [name for name in result if name.startswith("P")]
    assert result["Rq"] == pytest.approx(1e-6 / np.sqrt(2), rel=0.02)
    assert result["Rz"] == pytest.approx(2e-6, rel=0.02)
    assert result["Rsm"] == pytest.approx(25e-6, rel=1e-3)


def test_hills_within_a_tenth_of_rz_make_no_element():
    x = np.arange(8000) * PITCH
    large, ripple = np.sin(2 * np.pi * x / 100e-6), 0.1 * np.sin(2 * np.pi * x / 3e-6)
    assert rc.profile_parameters(rc.height_map(1e-6 * (large + ripple), PITCH))["Psm"] == pytest.approx(
        100e-6, rel=0.01
    )


def test_several_profiles_have_the_mean_of_each():
    low, high = sine(1e-6), sine(3e-6)
    two_profiles = rc.height_map(np.vstack([low.values, high.values]), PITCH)
    assert rc.profile_parameters(two_profiles)["Pq"] == pytest.approx(2e-6 / np.sqrt(2), rel=1e-6)


def test_the_core_is_that_of_the_material_ratio_curve():
    # a ramp has a straight curve, all core
    result = rc.profile_parameters(rc.height_map(np.linspace(0, 1e-6, 4001)[None], PITCH))
    assert result["Pk"] == pytest.approx(1e-6, rel=1e-6)
    assert result["Ppk"] == pytest.approx(0, abs=1e-12)
    assert np.isnan(result["Psm"])


def test_a_profile_that_is_shorter_than_a_section_is_refused():
    levelled = rc.level(sine(points=400), l_filter=100e-6)
    with pytest.raises(rc.HeightMapError, match="is shorter than one section"):
        rc.profile_parameters(levelled[:, :100])


def test_missing_points_do_not_count_and_keep_their_length():
    # a sine on a step across its gap: with the gap closed its crossings and slopes would be those of the step
    heights = sine(points=7900).values.copy()
    heights[0, 3030:3130] = np.nan
    expected = rc.profile_parameters(sine(points=7900))
    result = rc.profile_parameters(rc.height_map(heights, PITCH))
    assert result["Psm"] == pytest.approx(100e-6, rel=1e-4)
    assert result["Pdq"] == pytest.approx(expected["Pdq"], rel=5e-3)
    filled = rc.level(rc.height_map(heights, PITCH), form="none", outlier_threshold=None)
    assert filled.attrs["filled_points"] == 100
    assert rc.profile_parameters(filled) == pytest.approx(result)


def test_the_sections_of_a_profile_with_a_gap_are_as_long_as_without():
    sections = np.repeat([1.0, 2.0, 3.0, 4.0], 500) * np.tile([1e-6, -1e-6], 1000)
    levelled = rc.level(sine(points=2000), l_filter=250e-6)
    steps = levelled.copy(data=sections[None])
    steps[0, 500:1000] = np.nan
    assert rc.profile_parameters(steps)["Rz"] == pytest.approx(2e-6 * (1 + 3 + 4) / 3)


def test_a_profile_without_points_is_refused():
    with pytest.raises(rc.HeightMapError, match="all 50 points of the map are missing"):
        rc.profile_parameters(rc.height_map(np.full((1, 50), np.nan), PITCH))
    rows = np.vstack([np.linspace(0, 1e-6, 50), np.full(50, np.nan)])
    with pytest.raises(rc.HeightMapError, match="leave its row out"):
        rc.profile_parameters(rc.height_map(rows, PITCH))
