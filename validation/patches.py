"""Patches of the contact, and the material ratio curve of the heights."""

import numpy as np
from scipy.special import ellipe, ndtri

from roughcontact.arguments.maps import height_map
from roughcontact.contact.solve import solve_contact
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.statistics.sealing.connectivity import region_sizes
from roughcontact.surface.roughness.bearing import bearing_parameters
from roughcontact.surface.roughness.heights import height_parameters
from validation import closed_forms
from validation.lines import Section
from validation.problems import (
    AMPLITUDE,
    RIDGES_CLOSED,
    WAVE_CLOSED,
    product_wave,
    ridge,
    solved_ridges,
)

_RMS = 1e-6


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the lines of ridges, of the product wave on a grid an eighth as fine, and of normal heights."""
    for ratio, contact in solved_ridges(finest_grid, (0.1, 0.5, 0.9)).items():
        largest = region_sizes(np.tile(contact.touching, (1, 3))).max() / finest_grid
        expected = closed_forms.westergaard_contact_share(ratio)
        section.compare("strip", largest, expected, 2 / finest_grid, r=ratio, n=finest_grid)
    _two_patches(section, finest_grid // 8)
    _gaps(section, finest_grid)
    _developed(section, finest_grid)
    points = finest_grid**2
    heights = _RMS * ndtri((np.arange(points) + 0.5) / points)
    computed = bearing_parameters(heights)
    for name, reference in closed_forms.gaussian_bearing(_RMS).items():
        unit, over = (1.0, "") if name.startswith("Smr") else (_RMS, " / Sq")
        fields = {"quantity": name + over, "points": points}
        section.compare("curve", computed[name] / unit, reference / unit, 4 / finest_grid, **fields)


def _two_patches(section: Section, points: int) -> None:
    """Add the lines of the patches of the product wave, three waves each way."""
    waves, ratio = 3, 0.1
    side = waves * points // 2
    height = product_wave(side, waves=waves)
    contact = solve_contact(height, contact_modulus=1.0, mean_pressure=ratio * WAVE_CLOSED, tolerance=1e-5)
    statistics = contact_statistics(contact, flow="never").isel(load=0)
    area = closed_forms.JGH_CONTACT_SHARE[ratio] / 2
    bounds = statistics["patch_bin_bounds"].values
    shares = statistics["patch_area_density"].values * np.diff(bounds, axis=1)[:, 0]
    near = (bounds[:, 1] > 0.9 * area) & (bounds[:, 0] < 1.1 * area)
    section.compare("number", statistics["contact_clusters"], 2 * waves**2, 0, r=ratio, waves=waves)
    largest = statistics["largest_patch_area"]
    section.compare("largest", largest, area, 6 * waves / side, r=ratio, n=side // waves)
    section.compare("share", shares[near].sum(), 1.0, 1e-12, r=ratio)


def _gaps(section: Section, points: int) -> None:
    """Add the lines of how the heights of the gap are distributed beside ridges in contact."""
    _, height = ridge(points)
    for ratio in (0.1, 0.5):
        load = ratio * RIDGES_CLOSED
        contact = solve_contact(height, contact_modulus=1.0, mean_pressure=load, tolerance=1e-8)
        statistics = contact_statistics(contact, flow="never").isel(load=0)
        bounds = statistics["gap_bin_bounds"].values
        computed = np.cumsum(statistics["gap_density"].values * np.diff(bounds, axis=1)[:, 0])
        edge = closed_forms.westergaard_contact_share(ratio) / 2
        x = np.linspace(edge, 0.5, 20001)
        heights = closed_forms.westergaard_gap(x, 1.0, AMPLITUDE, ratio)
        expected = (np.interp(bounds[:, 1], heights, x) - edge) / (0.5 - edge)
        section.compare("gaps", computed, expected, 4 / ((1 - 2 * edge) * points), r=ratio, n=points)


def _developed(section: Section, points: int) -> None:
    """Add the line of the developed area of a wave."""
    amplitude = 0.1
    x = np.arange(points) / points
    wave = np.tile(amplitude * np.cos(2 * np.pi * x), (4, 1))
    square = (2 * np.pi * amplitude) ** 2
    computed = height_parameters(height_map(wave, 1 / points))["Sdr"]
    expected = 2 / np.pi * np.sqrt(1 + square) * ellipe(square / (1 + square)) - 1
    section.compare("developed", computed, expected, 1.1 / points, n=points)
