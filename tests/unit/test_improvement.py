"""The line of what would halve the interval: its number of maps is held against groups of made maps."""

import json

import numpy as np
import pytest
import scipy
import xarray as xr

import roughcontact as rc
from roughcontact.maps import height_map
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.uncertainty.combination import SOURCES
from roughcontact.uncertainty.groups import group_statistics
from roughcontact.uncertainty.improvement import (
    half_width_of_mean,
    halving_line,
    map_scatter_ratio,
    maps_to_halve,
    scatter_of_maps,
)

SIDE = 96
MASTERS = ((0.8, 64e-6), (0.5, 48e-6), (0.8, 128e-6), (0.3, 32e-6))  # Hurst exponent, longest wave


def promised_over_found(hurst, longest, seed):
    """Return the half-width that single maps promise of the mean of nine over that of these nine."""
    shape = (3 * SIDE, 3 * SIDE)
    waves = {"hurst": hurst, "shortest": 4e-6, "longest": longest, "rms_gradient": 0.1}
    master = self_affine_surface(shape, 1e-6, **waves, seed=seed).values
    maps, scatters = [], []
    for row, column in np.ndindex(3, 3):
        corner = master[SIDE * row : SIDE * (row + 1), SIDE * column : SIDE * (column + 1)]
        height = height_map(corner.copy(), 1e-6)
        contact = {"contact_modulus": 1e9, "mean_pressure": 1e7}
        maps.append(rc.evaluate(height, contact=contact, uncertainty={"sources": ["window"]}))
        ratio = map_scatter_ratio(rc.level(height), maps[-1].sizes["member"])
        scatters.append(scatter_of_maps(maps[-1], 0, ratio))
    mean = group_statistics(maps)
    area, lower, upper = (float(mean[f"relative_contact_area{end}"][0]) for end in ("", "_lower", "_upper"))
    return half_width_of_mean(float(np.median(scatters)), len(maps), 0.0) / ((upper - lower) / (2 * area))


def test_the_mean_of_more_maps_is_known_as_well_as_the_line_promises():
    ratios = [promised_over_found(*master, seed) for seed, master in enumerate(MASTERS)]
    assert 0.7 < scipy.stats.gmean(ratios) < 1.3
    # the scatter of nine maps itself is known within a factor of 0.68 to 1.92 (chi-square, 95 %)
    assert all(0.5 < ratio < 2.0 for ratio in ratios)


def test_places_that_are_independent_scatter_by_the_root_of_their_area():
    noise = [np.random.default_rng(seed).normal(size=(240, 240)) * 1e-8 for seed in range(15)]
    ratios = [map_scatter_ratio(height_map(heights, 1e-6), 9) for heights in noise]
    assert np.median(ratios) == pytest.approx(1 / 3, abs=0.07)
    tilt = np.linspace(0.1, 10, 240)[:, None] * np.random.default_rng(1).normal(size=(240, 240)) * 1e-8
    assert map_scatter_ratio(height_map(tilt, 1e-6), 9) > 0.6  # the gradient drifts along the map


def statistics(widths, reasons=(), **attrs):
    """Return statistics of one load with these relative half-widths by source."""
    half = np.array(
        [widths.get(source, np.nan) for source in SOURCES] + [np.hypot.reduce([*widths.values()])]
    )
    components = np.zeros((1, len(SOURCES) + 1, 4))
    components[0, :, :2] = np.nan_to_num(0.1 * half)[:, None]
    total = 0.1 * half[-1]
    parts = 0.1 * np.exp(np.random.default_rng(2).normal(0, widths.get("window", 0.0) / 0.7, 9))
    return xr.Dataset(
        {
            "relative_contact_area": ("load", [0.1]),
            "relative_contact_area_lower": ("load", [0.1 - total]),
            "relative_contact_area_upper": ("load", [0.1 + total]),
            "relative_contact_area_uncertainty": (("load", "source"), 0.1 * half[None]),
            "relative_contact_area_components": (("load", "source", "component"), components),
            "relative_contact_area_parts": (("member", "load"), parts[:, None]),
        },
        {"source": [*SOURCES, "combined"]},
        {"reasons": json.dumps([{"check": name} for name in reasons]), **attrs},
    )


@pytest.mark.parametrize(
    ("widths", "reasons", "words"),
    [
        ({"window": 0.3, "solver": 0.01}, (), "more place"),
        ({"discretisation": 0.3, "window": 0.02}, (), "pixels half as large"),
        ({"unresolved": 0.3, "window": 0.02}, (), "finer_spectrum"),
        ({"unresolved": 0.3, "window": 0.02}, ("Smoothed",), "state the lens"),
        ({"material": 0.3, "window": 0.02}, (), "contact modulus"),
    ],
)
def test_the_largest_source_decides_what_halves_the_interval(widths, reasons, words):
    line = halving_line(statistics(widths, reasons), 1 / 3)
    assert words in line
    assert ";" not in line


def test_an_isolated_summit_is_to_be_cleaned_first():
    line = halving_line(statistics({"window": 0.3}, ["Isolated peak"], summit_x=2e-6, summit_y=3e-6), 1 / 3)
    assert line.startswith("clean the summit at (2.00 µm, 3.00 µm); measure ")


def test_nothing_is_proposed_without_an_interval():
    assert halving_line(xr.Dataset({"relative_contact_area": ("load", [0.1])}), None) == ""


def test_the_number_of_maps_is_the_smallest_that_halves():
    for scatter, half_width in ((0.05, 0.3), (0.1, 0.3), (0.2, 0.3)):
        maps = maps_to_halve(scatter, half_width, 0.0)
        factors = [scipy.stats.t.ppf(0.975, n - 1) * scatter / np.sqrt(n) for n in (maps - 1, maps)]
        assert factors[1] <= half_width / 2
        assert maps == 2 or factors[0] > half_width / 2
