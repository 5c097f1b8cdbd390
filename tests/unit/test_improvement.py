"""The line of what would halve the interval: its number of maps is held against groups of made maps."""

import json
from pathlib import Path

import calibrate
import numpy as np
import pandas as pd
import pytest
import scipy
import xarray as xr

import roughcontact as rc
from roughcontact.configuration.tiles import cut, tiles_of
from roughcontact.maps import height_map
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.uncertainty import calibration
from roughcontact.uncertainty.budget import error_budget
from roughcontact.uncertainty.combination import SOURCES
from roughcontact.uncertainty.groups import group_statistics
from roughcontact.uncertainty.improvement import (
    half_width_of_mean,
    halving_line,
    maps_to_halve,
)

SIDE = 96
SCATTER = np.array([0.1])
RESULTS = Path(__file__).parents[2] / "benchmarks/results/bank"
MASTERS = ((0.8, 64e-6), (0.5, 48e-6), (0.8, 128e-6), (0.3, 32e-6))  # Hurst exponent, longest wave


def promised_over_found(hurst, longest, seed):
    """Return the half-width that single maps promise of the mean of nine over that of these nine."""
    shape = (3 * SIDE, 3 * SIDE)
    waves = {"hurst": hurst, "shortest": 4e-6, "longest": longest, "rms_gradient": 0.1}
    master = height_map(self_affine_surface(shape, 1e-6, **waves, seed=seed).values, 1e-6)
    contact = {"contact_modulus": 1e9, "mean_pressure": [1e7]}
    maps, scatters = [], []
    for part in tiles_of("3x3"):
        height = cut(master, part)
        maps.append(rc.evaluate(height, contact=contact, uncertainty={"sources": ["window"]}))
        levelled = rc.level(height)
        budget = error_budget(
            levelled, rc.periodic_window(levelled), {"window": {}, "contact": contact}, sources=["window"]
        )
        scatters.append(float(np.ravel(budget.attrs["map_scatter"])[0]))
    mean = group_statistics(maps)
    area, lower, upper = (float(mean[f"relative_contact_area{end}"][0]) for end in ("", "_lower", "_upper"))
    return half_width_of_mean(float(np.median(scatters)), len(maps), 0.0) / ((upper - lower) / (2 * area))


def test_the_mean_of_more_maps_is_known_as_well_as_the_line_promises():
    ratios = [promised_over_found(*master, seed) for seed, master in enumerate(MASTERS)]
    assert 0.7 < 1 / scipy.stats.gmean(ratios) < 1.3
    # the scatter of nine maps itself is known within a factor of 0.68 to 1.92 (chi-square, 95 %)
    assert all(0.5 < ratio < 2.0 for ratio in ratios)


def test_the_number_of_places_holds_on_the_bank():
    """Width of the mean of n parts over what one part promises, the map left out of the fit."""
    table = pd.read_csv(RESULTS / "halving.csv")
    assert set(table["maps"]) == {"measured", "synthetic"}
    assert set(table["n"]) == {3, 5, 9}
    assert table["width over promise"].between(0.7, 1.3).all()


def test_the_words_of_precision_hold_on_the_bank():
    """Answers of the bank that are as their words say, the map left out of the calibration."""
    table = pd.read_csv(RESULTS / "claims.csv")
    assert len(table) == 4
    for kind in ("measured", "synthetic"):
        assert (table[f"{kind}: hold (%)"] >= 93).all()
        assert (table[f"{kind}: answers"] > 300).all()


def test_the_calibrated_scatter_is_the_fit_to_the_bank():
    rows = calibrate.scatter_of_maps(calibrate.read_bank())
    assert calibrate.rounded(calibrate.fitted_scatter(rows).to_dict()) == calibration.table()["map_scatter"]


def statistics(widths, reasons=(), **attrs):
    """Return statistics of one load with these relative half-widths by source."""
    half = np.array(
        [widths.get(source, np.nan) for source in SOURCES] + [np.hypot.reduce([*widths.values()])]
    )
    components = np.zeros((1, len(SOURCES) + 1, 4))
    components[0, :, :2] = np.nan_to_num(0.1 * half)[:, None]
    total = 0.1 * half[-1]
    return xr.Dataset(
        {
            "relative_contact_area": ("load", [0.1]),
            "relative_contact_area_lower": ("load", [0.1 - total]),
            "relative_contact_area_upper": ("load", [0.1 + total]),
            "relative_contact_area_uncertainty": (("load", "source"), 0.1 * half[None]),
            "relative_contact_area_components": (("load", "source", "component"), components),
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
        ({"instrument": 0.3, "window": 0.02}, (), "export the heights in finer steps"),
    ],
)
def test_the_largest_source_decides_what_halves_the_interval(widths, reasons, words):
    line = halving_line(statistics(widths, reasons), SCATTER)
    assert words in line
    assert ";" not in line


def test_an_isolated_summit_is_to_be_cleaned_first():
    line = halving_line(statistics({"window": 0.3}, ["Isolated peak"], summit_x=2e-6, summit_y=3e-6), SCATTER)
    assert line.startswith("clean the summit at (2.00 µm, 3.00 µm); measure ")


def test_a_stated_instrument_is_to_be_stated_more_narrowly():
    line = halving_line(statistics({"instrument": 0.3, "window": 0.02}, instrument_noise=1e-9), SCATTER)
    assert line == "repeat the measurement and average, or state the instrument more narrowly"


def test_nothing_is_proposed_without_an_interval():
    assert halving_line(xr.Dataset({"relative_contact_area": ("load", [0.1])}), None) == ""


def test_the_number_of_maps_is_the_smallest_that_halves():
    for scatter, half_width in ((0.05, 0.3), (0.1, 0.3), (0.2, 0.3)):
        maps = maps_to_halve(scatter, half_width, 0.0)
        factors = [
            scipy.stats.t.ppf(0.975, n - 1)
            * scatter
            / np.sqrt(n)
            * scipy.stats.chi(n - 1).median()
            / np.sqrt(n - 1)
            for n in (max(maps - 1, 2), maps)
        ]
        assert factors[1] <= half_width / 2
        assert maps == 2 or factors[0] > half_width / 2
