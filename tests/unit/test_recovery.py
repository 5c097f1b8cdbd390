"""Measurements with all their faults go through levelling and window, and give back the true contact area."""

import numpy as np
import pytest
from known_surfaces import self_affine

from roughcontact import contact_statistics, error_budget, height_map, level, periodic_window, solve_contact
from roughcontact.surface.roughness.parameters import rms_gradient

PITCH, MODULUS, POINTS = 1e-6, 1e9, 256
LEVEL = {"form": "polynomial", "order": 2, "line_alignment": "matched-steps", "s_filter": 2e-6}


def contact_area(window, mean_pressure):
    contact = solve_contact(
        window,
        contact_modulus=MODULUS,
        mean_pressure=mean_pressure,
        tolerance=1e-3,
        reduce=contact_statistics,
    )
    return float(contact["relative_contact_area"][0])


def measure(surface, corner, seed):
    """Return a part of a surface as an instrument may deliver it."""
    generator = np.random.default_rng(seed)
    heights = surface.values[tuple(slice(start, start + POINTS) for start in corner)].copy()
    rms = heights.std()
    y, x = np.indices(heights.shape) * PITCH
    heights += 0.3e-6 + 0.02 * x - 0.01 * y  # offset and tilt
    heights += (x - 100e-6) ** 2 / (2 * 10e-3)  # form
    heights += 0.01 * rms * generator.standard_normal(heights.shape)  # noise
    heights += 0.3 * rms * generator.standard_normal((POINTS, 1))  # scan lines
    spikes = generator.integers(0, POINTS, (2, 40))
    heights[spikes[0], spikes[1]] += generator.choice([-8, 8], 40) * rms
    for row, column in generator.integers(5, POINTS - 20, (12, 2)):  # dropouts
        heights[row : row + generator.integers(1, 8), column : column + generator.integers(1, 12)] = np.nan
    return height_map(heights, PITCH)


@pytest.mark.nightly
@pytest.mark.parametrize("placement", ["largest", "whole-periods"])
def test_contact_area_of_faulty_measurements(placement):
    """Eight windows of two surfaces: the true area lies within their ±, and within what their spread says."""
    ratios, half_widths = [], []
    for seed in range(2):
        surface = self_affine((2 * POINTS, 2 * POINTS), PITCH, (8e-6, 128e-6), rms_gradient=0.1, seed=seed)
        load = 0.1 * MODULUS * rms_gradient(surface)
        truth = contact_area(surface, load)
        for quadrant in range(4):
            corner = [POINTS * n for n in divmod(quadrant, 2)]
            levelled = level(measure(surface, corner, seed=10 * seed + quadrant), **LEVEL)
            assert 35 <= levelled.attrs["outliers_rejected"] <= 45
            assert levelled.attrs["filled_share"] > 0.003
            window = periodic_window(levelled, placement=placement)
            ratios.append(contact_area(window, load) / truth)
            contact = {"contact_modulus": MODULUS, "mean_pressure": [load]}
            settings = {"level": LEVEL, "window": {"placement": placement}, "contact": contact}
            budget = error_budget(levelled, window, settings)["relative_contact_area_uncertainty"]
            half_widths.append(float(budget.sel(source="combined")[0]) / truth)
    ratios, half_widths = np.array(ratios), np.array(half_widths)
    assert (np.abs(ratios - 1) <= half_widths).mean() >= 7 / 8
    assert np.median(half_widths) < 0.15
    spread = ratios.std(ddof=1)
    assert spread < 0.1
    assert abs(ratios.mean() - 1) < 2 * spread / np.sqrt(ratios.size)
    assert (np.abs(ratios - 1) < 3 * spread).all()


def test_without_levelling_the_area_is_far_off():
    """The faults matter: what the test above takes off would ruin the result."""
    surface = self_affine((512, 512), PITCH, (8e-6, 128e-6), rms_gradient=0.1, seed=0)
    load = 0.1 * MODULUS * rms_gradient(surface)
    plain = level(measure(surface, (0, 0), seed=0), form="mean", outlier_threshold=None)
    assert contact_area(periodic_window(plain), load) < 0.6 * contact_area(surface, load)
