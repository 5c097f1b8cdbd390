"""Patches of the contact, and the material ratio curve of the heights."""

import numpy as np
from scipy.special import ellipe, ndtri

from roughcontact.connectivity import region_sizes
from roughcontact.contact.solve import solve_contact
from roughcontact.maps import height_map
from roughcontact.references import closed_forms
from roughcontact.roughness.bearing import bearing_parameters
from roughcontact.roughness.heights import height_parameters
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.validation import waves
from roughcontact.validation.lines import Evidence, Line, Part, compare, compare_largest

TITLE = "Patches and material ratio"
_RMS = 1e-6

STRIP = Evidence(
    "one strip for each wave, (2/π) arcsin √r of its length",
    "Westergaard (1939); Johnson (1985), sec. 13.2",
    "references.closed_forms.westergaard_contact_share",
    "tests/unit/test_patches.py::test_ridges_touch_in_one_patch_each",
)
PAIR = Evidence(
    "two patches for each wave along x and y, half of its contact area each",
    "Johnson, Greenwood and Higginson (1985); area as of the product wave",
    "references.closed_forms.JGH_CONTACT_SHARE",
    "tests/unit/test_patches.py::test_the_product_wave_touches_in_two_equal_patches",
)
GAPS = Evidence(
    "share of the length where 0 < g < G, g = 2D [s √(s² − r) − r ln((s + √(s² − r))/√r)], s = |sin(πx/λ)|",
    "Westergaard (1939), its gap",
    "references.closed_forms.westergaard_gap",
    "tests/unit/test_reference.py::test_westergaard_gap_closes_at_the_edge_and_has_the_stated_mean",
)
ARC = Evidence(
    "(2/π) √(1 + m) E(m/(1 + m)) − 1, m = (2πD/λ)², E: complete elliptic integral",
    "length of a sine curve; ISO 25178-2:2021, D.3",
    "roughness.heights.height_parameters",
    "tests/unit/test_patches.py::test_developed_area_of_a_wave",
)
CURVE = Evidence(
    "Sk = 12 σ [erf(t)/(2√π) − 0.4 φ(t)]/0.4³, t = Φ⁻¹(0.7); Spk, Svk, volumes: integrals of Φ",
    "ISO 13565-2:1996 and ISO 25178-2:2021, annex B, for normal heights",
    "references.closed_forms.gaussian_bearing",
    "tests/unit/test_bearing.py::test_closed_form_of_normal_heights_by_quadrature",
)


def part(*, finest_grid: int) -> Part:
    """Return the lines of this part.

    Parameters
    ----------
    finest_grid : int
        points along the finest grid.

    Returns
    -------
    Part
    """
    lines = []
    full = closed_forms.westergaard_full_contact_pressure(waves.AMPLITUDE, 1.0, 1.0)
    _, ridge = waves.ridge(finest_grid)
    for ratio in (0.1, 0.5, 0.9):
        contact = solve_contact(ridge, contact_modulus=1.0, mean_pressure=ratio * full, tolerance=1e-8)
        touching = np.tile(contact["pressure"].values[0] > 0, (1, 3))
        lines.append(
            compare(
                f"Three ridges, r = {ratio:g}: largest patch / λ",
                region_sizes(touching).max() / finest_grid,
                closed_forms.westergaard_contact_share(ratio),
                tolerance=2 / finest_grid,
                reason=f"2/n, n = {finest_grid}: either end is known to one point",
                evidence=STRIP,
                measure="absolute",
            )
        )
    lines += [*_two_patches(finest_grid // 8), *_gaps(finest_grid), _developed(finest_grid)]
    points = finest_grid**2
    heights = _RMS * ndtri((np.arange(points) + 0.5) / points)
    found, known = bearing_parameters(heights), closed_forms.gaussian_bearing(_RMS)
    for name, reference in known.items():
        lines.append(
            compare(
                f"Normal heights: {name}" + ("" if name.startswith("Smr") else " / Sq"),
                found[name] / (1 if name.startswith("Smr") else _RMS),
                reference / (1 if name.startswith("Smr") else _RMS),
                tolerance=4 / finest_grid,
                reason=f"4/n of n² = {points} heights: where the flattest 40 % begin",
                evidence=CURVE,
            )
        )
    text = (
        "Each of Westergaard's ridges touches in one strip, the product wave in two patches, and the heights "
        "of the gap beside a ridge are known. Heights that are normally distributed have a material ratio "
        "curve whose parameters are known in closed form, and so has a wave its developed area."
    )
    return Part("patches", TITLE, text, lines)


def _two_patches(points: int) -> list[Line]:
    """Return the lines of the patches of the product wave, three waves each way."""
    waves_each, ratio = 3, 0.1
    side = waves_each * points // 2
    y, x = ((np.arange(side) + phase) * waves_each / side for phase in waves.PHASE)
    wave = np.cos(2 * np.pi * y)[:, None] * np.cos(2 * np.pi * x)[None, :]
    full = closed_forms.jgh_full_contact_pressure(waves.AMPLITUDE, 1.0, 1.0)
    contact = solve_contact(
        height_map(waves.AMPLITUDE * wave, waves_each / side),
        contact_modulus=1.0,
        mean_pressure=ratio * full,
        tolerance=1e-5,
    )
    statistics = contact_statistics(contact, flow="never").isel(load=0)
    area = closed_forms.JGH_CONTACT_SHARE[ratio] / 2
    bounds = statistics["patch_bin_bounds"].values
    shares = statistics["patch_area_density"].values * np.diff(bounds, axis=1)[:, 0]
    near = (bounds[:, 1] > 0.9 * area) & (bounds[:, 0] < 1.1 * area)
    return [
        compare(
            f"Product wave, {waves_each} × {waves_each} waves, r = {ratio:g}: patches",
            statistics["contact_clusters"],
            2 * waves_each**2,
            tolerance=0,
            reason="a count",
            evidence=PAIR,
        ),
        compare(
            f"Product wave, r = {ratio:g}: largest patch / λ²",
            statistics["largest_patch_area"],
            area,
            tolerance=6 * waves_each / side,
            reason=f"6/n, n = {side // waves_each} points a wave: pixels at its rim",
            evidence=PAIR,
        ),
        compare(
            f"Product wave, r = {ratio:g}: share of the patches within a tenth of that area",
            shares[near].sum(),
            1.0,
            tolerance=1e-12,
            reason="rounding: of the bins that reach into it",
            evidence=PAIR,
        ),
    ]


def _gaps(points: int) -> list[Line]:
    """Return the lines of how the heights of the gap are distributed beside ridges in contact."""
    full = closed_forms.westergaard_full_contact_pressure(waves.AMPLITUDE, 1.0, 1.0)
    _, ridge = waves.ridge(points)
    lines = []
    for ratio in (0.1, 0.5):
        contact = solve_contact(ridge, contact_modulus=1.0, mean_pressure=ratio * full, tolerance=1e-8)
        statistics = contact_statistics(contact, flow="never").isel(load=0)
        bounds = statistics["gap_bin_bounds"].values
        found = np.cumsum(statistics["gap_density"].values * np.diff(bounds, axis=1)[:, 0])
        edge = closed_forms.westergaard_contact_share(ratio) / 2
        x = np.linspace(edge, 0.5, 20001)
        heights = closed_forms.westergaard_gap(x, 1.0, waves.AMPLITUDE, ratio)
        known = (np.interp(bounds[:, 1], heights, x) - edge) / (0.5 - edge)
        lines.append(
            compare_largest(
                f"Ridges, r = {ratio:g}: share of the gap below each height",
                found,
                known,
                tolerance=4 / ((1 - 2 * edge) * points),
                reason=f"four points of n = {points}: at both edges, and at both ends of a bin",
                evidence=GAPS,
            )
        )
    return lines


def _developed(points: int) -> Line:
    """Return the line of the developed area of a wave."""
    amplitude = 0.1
    x = np.arange(points) / points
    wave = np.tile(amplitude * np.cos(2 * np.pi * x), (4, 1))
    square = (2 * np.pi * amplitude) ** 2
    return compare(
        f"A wave of amplitude {amplitude:g} λ: Sdr",
        height_parameters(height_map(wave, 1 / points))["Sdr"],
        2 / np.pi * np.sqrt(1 + square) * ellipe(square / (1 + square)) - 1,
        tolerance=1.1 / points,
        reason=f"1/n, n = {points}: the map ends one interval before the wave, where it is flat",
        evidence=ARC,
    )
