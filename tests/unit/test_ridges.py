"""Contrast between measured profiles and those of drawn surfaces, pressed as ridges."""

from pathlib import Path

import numpy as np
import pytest
from known_surfaces import self_affine

import roughcontact as rc
from data_samples.make_samples import blasted_surface
from roughcontact.arguments.maps import height_map
from roughcontact.evaluation.kinds.profiles.ridge_contrast import ridge_contrast
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.uncertainty.scales import AREA, GAP

SAMPLES = Path(__file__).parents[2] / "data_samples"
PITCH, ROWS = 1e-6, (0, 42, 85, 128, 170, 213)


@pytest.fixture(scope="module")
def surface():
    return self_affine((256, 256), PITCH, (8e-6, 6e-5), rms_height=3e-7, seed=4)


def test_profiles_of_the_drawn_surface_itself_have_no_contrast(surface):
    contrast = ridge_contrast(surface.values[list(ROWS)], [surface])
    for name in (AREA, GAP):
        np.testing.assert_allclose(contrast[name], 0.0, atol=1e-3, err_msg=name)


def test_profiles_twice_as_high_have_that_of_half_the_load(surface):
    """By Persson's law the scale of the area is ln(p/g), -ln 2; far from full contact the gap grows alike."""
    contrast = ridge_contrast(2 * surface.values[list(ROWS)], [surface])
    assert ((contrast[AREA] > -0.75) & (contrast[AREA] < -0.5)).all()
    assert np.log(2) < contrast[GAP][0] < 1.3 * np.log(2)  # half the load presses less together


def test_the_members_have_the_band_of_the_window():
    """The result is the mean of the members: without short waves it is that of the surface without them."""
    surface = rc.periodic_window(rc.level(blasted_surface()), shortest_wavelength=40e-6)
    solution = rc.solve_contact(surface, contact_modulus=1e9, mean_pressure=5e6)
    true = float((solution["pressure"] > 0).mean())
    file = SAMPLES / "blasted-profiles.csv"
    result = rc.evaluate(
        [rc.read_height_map(file, channel=f"z{number}") for number in (1, 2, 3)],
        lay="none",
        window={"shortest_wavelength": "40 um"},
        contact={"contact_modulus": "1 GPa", "mean_pressure": "5 MPa"},
        uncertainty={"sources": ["solver", "window"]},
    )
    low, value, high = (float(result[f"{AREA}{suffix}"][0]) for suffix in ("_lower", "", "_upper"))
    assert value == pytest.approx(true, rel=0.2)
    assert 0.4 * value < low < true < high < 2.2 * value


def test_grains_have_the_area_that_their_profiles_show():
    """Round tops of grains: spectrum, heights and slopes do not hold them, ridges of profiles do."""
    grains = rc.level(_grains(256, seed=0))
    pressure = 0.02 * 1e9 * rms_gradient(grains)
    solution = rc.solve_contact(grains, contact_modulus=1e9, mean_pressure=pressure)
    true = float((solution["pressure"] > 0).mean())
    result = rc.evaluate(
        [grains[[row]] for row in (10, 60, 110, 160, 210)],
        lay="none",
        contact={"contact_modulus": "1 GPa", "mean_pressure": f"{pressure} Pa"},
        uncertainty={"sources": ["solver", "window"]},
    )
    assert float(result[f"{AREA}_as_solved"][0]) < 0.8 * true
    assert float(result[AREA][0]) == pytest.approx(true, rel=0.12)
    assert float(result[f"{AREA}_lower"][0]) < true < float(result[f"{AREA}_upper"][0])


def _grains(points, seed):
    """Return paraboloids on a flat, alike in all directions (y, x; m), periodic."""
    rng = np.random.default_rng(seed)
    heights, axis = np.full((points, points), -5.0), np.arange(points)
    for x, y, radius in np.column_stack([rng.uniform(0, points, (120, 2)), rng.uniform(8, 25, 120)]):
        dx, dy = (np.minimum(abs(axis - middle), points - abs(axis - middle)) for middle in (x, y))
        heights = np.maximum(heights, radius - (dx**2 + dy[:, None] ** 2) / (2 * radius))
    return height_map(2e-8 * heights, PITCH)
