"""Friction of rubber over the speed: numbers of its contact, Persson's theory, shares of waves, mistakes."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact.arguments.answers import AREA, FRICTION, GAP, PEAK, PRESSURE
from roughcontact.errors import ConvergenceError, SettingsError

PITCH = 1e-6
RUBBER = {"long_time_modulus": "3 MPa", "moduli": ["27 MPa"], "times": [1e-3]}
SEAL = {"viscosity": "1 mPa s", "pressure_difference": "1 bar", "width": "2 mm"}
MODULUS = 3e6 / 0.75  # E* at rest


def rough(points=32, seed=1, **options):
    arguments = {"hurst": 0.8, "rms_gradient": 0.3, "longest": 24e-6, "shortest": 6e-6} | options
    return rc.self_affine_surface((points, points), PITCH, seed=seed, **arguments)


def wave(points=64, waves=4, amplitude=1e-7):
    heights = amplitude * np.cos(2 * np.pi * waves * np.arange(points) / points) + np.zeros((4, 1))
    return rc.height_map(heights, PITCH), 2 * np.pi * waves / (points * PITCH)


def slide(face, speed, **options):
    arguments = {"relaxation": RUBBER, "mean_pressure": "0.5 MPa", "tolerance": 1e-6}
    return rc.sliding_friction(face, speed=speed, **arguments | options)


def test_persson_is_exact_for_a_wave_in_full_contact():
    """μ = q² a² Im E*/(4 p̄); its octave is the one of its wavelength, 16 pixels."""
    face, q = wave()
    speed = 1e3 / q
    sliding = slide(face, speed, mean_pressure="20 MPa").isel(speed=0)
    young = 3e6 + 27e6 * 1j / (1 + 1j)
    exact = (q * 1e-7) ** 2 * young.imag / 0.75 / (4 * 20e6)
    assert float(sliding[FRICTION]) == pytest.approx(exact, rel=1e-5)
    assert float(sliding["persson_friction_coefficient"]) == pytest.approx(exact, rel=1e-5)
    assert float(sliding[AREA]) == 1
    at = int(np.argmax(sliding["friction_share_of_octave"].values))
    assert float(sliding["friction_share_of_octave"][at]) == pytest.approx(1, abs=1e-6)
    assert float(sliding["octave_wavelength"][at]) == pytest.approx(16 * PITCH)


def test_the_last_octave_is_the_shortest_that_was_measured():
    """Up to four pixels, or twice the wavelength at which the spectrum or the band of the map ends."""
    face = rough(64, shortest=3e-6)
    sliding = slide(face, 1e-2).isel(speed=0)
    assert float(sliding["last_octave_wavelength"]) == pytest.approx(4 * PITCH)
    first = sliding["friction_share_of_octave"].values[:2].sum()
    assert 0.02 < float(sliding["friction_share_of_last_octave"]) == pytest.approx(first)
    for attrs in (
        {"spectrum_end": 6e-6, "spectrum_exponent": -20.0},
        {"spectrum_end": 6e-6, "spectrum_exponent": -3.0, "band_shortest": 6e-6},
    ):
        smooth = slide(face.assign_attrs(attrs), 1e-2).isel(speed=0)
        assert float(smooth["last_octave_wavelength"]) == pytest.approx(12 * PITCH)
        to_16 = smooth["friction_share_of_octave"].values[:4].sum()
        assert 2 * first < float(smooth["friction_share_of_last_octave"]) < to_16


def test_the_last_octave_of_a_filtered_map_is_that_of_the_filter():
    filtered = rc.level(rough(64), form="none", s_filter=10e-6)
    sliding = slide(filtered, 1e-2).isel(speed=0)
    assert float(sliding["last_octave_wavelength"]) == pytest.approx(20e-6)
    assert float(sliding["friction_share_of_last_octave"]) > 0.4


def test_slow_rubber_has_the_numbers_of_the_contact_at_rest():
    face = rough()
    sliding = slide(face, "1e-12 m/s", seal=SEAL, shear_strength="1 MPa").isel(speed=0)
    contact = rc.solve_contact(face, contact_modulus=MODULUS, mean_pressure="0.5 MPa", tolerance=1e-7)
    rest = rc.contact_statistics(contact, seal=SEAL).isel(load=0)
    for name in (AREA, GAP, PEAK, PRESSURE, "leak_rate_x", "leak_rate_y"):
        assert float(sliding[name]) == pytest.approx(float(rest[name]), rel=1e-4), name
    adhesive = float(sliding["adhesive_friction_coefficient"])
    assert adhesive == pytest.approx(1e6 * float(sliding[AREA]) / 5e5, rel=1e-12)


def test_friction_has_a_maximum_and_is_near_that_of_persson():
    sliding = slide(rough(64, longest=64e-6), np.geomspace(1e-5, 10, 7).tolist(), tolerance=1e-4)
    friction, theory = sliding[FRICTION].values, sliding["persson_friction_coefficient"].values
    assert 0 < np.argmax(friction) < 6
    assert (friction > 0).all()
    assert (sliding["hysteretic_friction_bound"].values < 1e-3 * friction.max()).all()
    assert 0.4 < friction.max() / theory.max() < 1.6
    assert (np.diff(sliding[AREA].values[:5]) < 0).all()
    np.testing.assert_allclose(sliding["friction_share_of_octave"].sum("octave"), 1)
    assert "pressure" not in slide(rough(), 1e-3, fields=False)


def test_the_way_back_is_that_of_the_mirrored_face():
    face = rough()
    mirrored = rc.height_map(face.values[:, ::-1], PITCH)
    back, there = slide(face, 1e-3, direction="180 deg"), slide(mirrored, 1e-3)
    assert back[FRICTION].item() == pytest.approx(there[FRICTION].item(), rel=1e-6)


@pytest.mark.parametrize(("direction", "angles"), [("both ways", [0, 180]), (["30 deg", 210], [30, 210])])
def test_several_directions_are_each_as_alone(direction, angles):
    face, speeds = rough(), [1e-3, 1e-2]
    both = slide(face, speeds, direction=direction)
    assert both[FRICTION].dims == ("direction", "speed")
    assert both["direction"].values.tolist() == angles
    for angle in angles:
        alone = slide(face, speeds, direction=angle)
        for name in (FRICTION, AREA, "pressure", "persson_friction_coefficient"):
            np.testing.assert_array_equal(both[name].sel(direction=angle), alone[name])
    assert not np.allclose(*both[FRICTION].values, rtol=1e-3)


def test_along_ridges_nothing_is_lost():
    face, _ = wave()
    assert (slide(face, [1e-3, 1.0], direction="90 deg")[FRICTION] == 0).all()
    assert (slide(face, 1e-3, direction=[0, 180])[FRICTION] > 0).all()


@pytest.mark.parametrize("shape", [(7, 5), (1, 33), (60, 48)])
def test_a_flat_face_is_in_full_contact_and_loses_nothing(shape):
    """Of any number of points: rounding of its transforms is no error relative to a wave that it has not."""
    sliding = slide(rc.height_map(np.full(shape, 3e-6), 1e-6), [1.0, 2.0])
    assert (sliding[AREA] == 1).all()
    for name in (FRICTION, "hysteretic_friction_bound", "error_bound", GAP):
        assert (sliding[name] == 0).all()


def test_frequencies_beyond_the_table_are_told():
    face, q = wave()
    frequency = np.geomspace(1, 1e4, 20)
    phase = 2j * np.pi * frequency * 1e-3
    young = 3e6 + 27e6 * phase / (1 + phase)
    table = pd.DataFrame({"f (Hz)": frequency, "E' (Pa)": young.real, "E'' (Pa)": young.imag})
    speeds = (2 * np.pi * np.array([1e3, 2e4]) / q).tolist()  # within the table, and beyond
    sliding = slide(face, speeds, relaxation=table, mean_pressure="20 MPa")
    np.testing.assert_allclose(sliding["friction_share_beyond_table"], [0, 1], atol=1e-6)
    assert sliding.attrs["relaxation_misfit"] < 0.01


def test_the_flash_temperature_is_that_of_the_pressure():
    face = rough()
    sliding = slide(face, 1e-3, thermal_conductivity=[50, 0.25], shear_strength=1e6).isel(speed=0)
    solved = xr.Dataset({name: sliding[name].expand_dims("load") for name in ("pressure", "gap")})
    friction = float(sliding[FRICTION] + sliding["adhesive_friction_coefficient"])
    warm = rc.flash_temperature(
        solved.assign(height=face), friction_coefficient=friction, speed=1e-3, thermal_conductivity=[50, 0.25]
    )
    assert float(sliding["max_flash_temperature"]) == pytest.approx(warm["max_flash_temperature"].item())


def test_mistakes_are_named():
    face = rough()
    with pytest.raises(SettingsError, match="sum of two rough faces"):
        slide(face.assign_attrs(counter_face="other.txt"), 1e-3)
    with pytest.raises(ConvergenceError, match=r"speed 0\.001 m/s: the error bound stopped at"):
        slide(face, 1e-3, tolerance=1e-15)
    with pytest.raises(SettingsError, match="speed = -1"):
        slide(face, -1.0)
    for direction in ("steep", [], [0, 0], np.nan, [0, None]):
        with pytest.raises(SettingsError, match=r"direction = .*: give an angle \(degree\), several"):
            slide(face, 1e-3, direction=direction)
