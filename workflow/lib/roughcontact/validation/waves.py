"""Regular waves: Westergaard's ridges, and the product wave of Johnson, Greenwood and Higginson."""

import numpy as np
import xarray as xr

from roughcontact.contact.solve import solve_contact
from roughcontact.elasticity.energy import elastic_energy
from roughcontact.maps import height_map, spacing
from roughcontact.quantities import number
from roughcontact.references import closed_forms
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.validation import drawing
from roughcontact.validation.lines import Evidence, Figure, Line, Part, compare, compare_largest, compare_rms

TITLE = "Regular waves: Westergaard, and Johnson, Greenwood and Higginson"
AMPLITUDE = 0.01  # D/λ; wavelength and E* are 1
PHASE = (0.61, 0.37)  # of the crest between two points, along y and x: nothing falls on a point by chance

_REFERENCE = "tests/unit/test_reference.py"
_WESTERGAARD = "Westergaard (1939); Johnson (1985), sec. 13.2"


def _evidence(formula: str, function: str, test: str, source: str = _WESTERGAARD) -> Evidence:
    """Return the evidence of a closed form."""
    return Evidence(formula, source, f"references.closed_forms.{function}", f"{_REFERENCE}::{test}")


RIDGES = {
    "share": _evidence(
        "A/A₀ = (2/π) asin √r, r = p̄/p*, p* = π E* D/λ",
        "westergaard_contact_share",
        "test_westergaard_pressure_carries_the_load_over_the_contact",
    ),
    "pressure": _evidence(
        "p = (2p̄/r) cos ψ √(r − sin²ψ), ψ = πx/λ",
        "westergaard_pressure",
        "test_westergaard_pressure_carries_the_load_over_the_contact",
    ),
    "gap": _evidence(
        "ū = D (1 − r + r ln r); the mean displacement is ū − D with the crest at rest",
        "westergaard_mean_gap",
        "test_westergaard_gap_closes_at_the_edge_and_has_the_stated_mean",
    ),
    "energy": _evidence(
        "U = D p* r² (1/4 − ln(r)/2), D p*/4 from r = 1 on",
        "westergaard_energy",
        "test_westergaard_surface_under_its_pressure_leaves_its_gap",
    ),
    "closed": _evidence(
        "p = p̄ + p* cos(2πx/λ), r ≥ 1", "westergaard_pressure", "test_westergaard_full_contact"
    ),
}
_JGH = "Johnson, Greenwood and Higginson (1985)"
CRESTS = {
    "table": _evidence(
        "table of an independent code at 512 × 512, p* = √2 π E* D/λ",
        "JGH_CONTACT_SHARE, references.closed_forms.JGH_PEAK_AND_GAP",
        "test_jgh_asymptotes_meet_the_tabulated_shares",
        f"{_JGH}; numbers ± 2e-4 (area), ± 1e-5 (peak, gap)",
    ),
    "low": _evidence(
        "A/A₀ → π [3r/(8π)]^(2/3), r → 0: two Hertz contacts per λ²",
        "jgh_contact_share_low",
        "test_jgh_low_load_is_two_hertz_contacts_per_square",
        f"{_JGH}, small loads",
    ),
    "high": _evidence(
        "1 − A/A₀ → (3/2π)(1 − r), r → 1: pressurised penny-shaped gaps",
        "jgh_contact_share_high",
        "test_jgh_asymptotes_meet_the_tabulated_shares",
        f"{_JGH}, near full contact",
    ),
}


def part(*, finest_grid: int) -> Part:
    """Return the lines and figures of this part.

    Parameters
    ----------
    finest_grid : int
        points along the finest grid.

    Returns
    -------
    Part
    """
    ridges, ridge_figures = _ridges(finest_grid)
    crests, crest_figures = _crests(finest_grid // 2)
    text = (
        "A wave is pressed flat by p*; r = p̄/p* is the load. Westergaard's ridges D cos(2πx/λ) have a "
        "closed form for everything. The product wave D cos(2πx/λ) cos(2πy/λ) has closed forms at both ends "
        "of the load range, and between them numbers of an independent code."
    )
    return Part("waves", TITLE, text, [*ridges, *crests], [*ridge_figures, *crest_figures])


def ridge(points: int, phase: float = PHASE[1]) -> tuple[np.ndarray, xr.DataArray]:
    """Return one row of Westergaard's wave, of unit length and amplitude `AMPLITUDE`.

    Parameters
    ----------
    points : int
    phase : float
        how many points the crest lies before the first point.

    Returns
    -------
    x : array (points)
        distance from the crest.
    height : DataArray (y, x)

    Examples
    --------
    >>> x, height = ridge(4, 0.0)
    >>> height.values.round(3)
    array([[ 0.01,  0.  , -0.01, -0.  ]])
    """
    x = (np.arange(points) + phase) / points
    return x, height_map(AMPLITUDE * np.cos(2 * np.pi * x)[None, :], 1 / points)


def product_wave(points: int, phase: tuple[float, float] = PHASE) -> xr.DataArray:
    """Return one period of the product wave, of unit length and amplitude `AMPLITUDE`.

    Parameters
    ----------
    points : int
        along each side.
    phase : (float, float)
        how many points the crest lies before the first point, along y and x.

    Returns
    -------
    DataArray (y, x)

    Examples
    --------
    >>> product_wave(4, (0.0, 0.0)).values[:, 0].round(3)
    array([ 0.01,  0.  , -0.01, -0.  ])
    """
    y, x = ((np.arange(points) + shift) / points for shift in phase)
    heights = AMPLITUDE * np.cos(2 * np.pi * y)[:, None] * np.cos(2 * np.pi * x)[None, :]
    return height_map(heights, 1 / points)


def _ridges(points: int) -> tuple[list[Line], list[Figure]]:
    """Return lines and figure of Westergaard's wave, one row of `points` points."""
    full = closed_forms.westergaard_full_contact_pressure(AMPLITUDE, 1.0, 1.0)
    x, height = ridge(points)
    ratios = (0.05, 0.3, 0.5, 0.9, 1.0, 2.0)
    contact = solve_contact(
        height, contact_modulus=1.0, mean_pressure=[r * full for r in ratios], tolerance=1e-9
    )
    lines, curves = [], []
    for index, ratio in enumerate(ratios):
        pressure, gap = (contact[name].values[index, 0] for name in ("pressure", "gap"))
        exact = closed_forms.westergaard_pressure(x, 1.0, ratio * full, ratio)
        energy = elastic_energy(pressure[None, :], spacing(height), contact_modulus=1.0)
        known_energy = closed_forms.westergaard_energy(AMPLITUDE, 1.0, 1.0, ratio)
        wave = f"Ridges, r = {ratio:g}"
        if ratio >= 1:
            lines += [
                compare_largest(
                    f"{wave}: pressure, every point",
                    pressure / full,
                    exact / full,
                    tolerance=1e-12,
                    reason="rounding: the discrete answer is exact",
                    evidence=RIDGES["closed"],
                ),
                compare(
                    f"{wave}: energy / (D p*)",
                    energy / (AMPLITUDE * full),
                    known_energy / (AMPLITUDE * full),
                    tolerance=1e-12,
                    reason="rounding: the discrete answer is exact",
                    evidence=RIDGES["energy"],
                ),
            ]
            continue
        share = closed_forms.westergaard_contact_share(ratio)
        across = share * points
        lines += [
            compare(
                f"{wave}: points in contact",
                np.count_nonzero(pressure) / points,
                share,
                measure="absolute",
                tolerance=1 / points,
                reason=f"one point of {points}",
                evidence=RIDGES["share"],
            ),
            compare_rms(
                f"{wave}: pressure / p*, every point",
                pressure / full,
                exact / full,
                tolerance=0.5 / across,
                reason=f"first order: 0.5/n, n = {across:.0f} points across the contact",
                evidence=RIDGES["pressure"],
            ),
            compare(
                f"{wave}: largest pressure / p*",
                pressure.max() / full,
                2 * np.sqrt(ratio),
                tolerance=2 * across**-2,
                reason=f"second order: 2/n², n = {across:.0f} points across the contact",
                evidence=RIDGES["pressure"],
            ),
            compare(
                f"{wave}: mean gap / D",
                gap[pressure == 0].sum() / points / AMPLITUDE,
                closed_forms.westergaard_mean_gap(AMPLITUDE, ratio) / AMPLITUDE,
                measure="absolute",
                tolerance=2 / points**2,
                reason=f"second order: 2/n², n = {points}",
                evidence=RIDGES["gap"],
            ),
            compare(
                f"{wave}: mean displacement / D",
                # gap = u - h + approach, the mean of h being zero: counted from the crest at rest
                float(contact["approach"][index]) / AMPLITUDE - 1,
                closed_forms.westergaard_mean_gap(AMPLITUDE, ratio) / AMPLITUDE - 1,
                measure="absolute",
                tolerance=2 / points**2,
                reason=f"second order: 2/n², n = {points}",
                evidence=RIDGES["gap"],
            ),
            compare(
                f"{wave}: energy / (D p*)",
                energy / (AMPLITUDE * full),
                known_energy / (AMPLITUDE * full),
                tolerance=2 * across**-2,
                reason=f"second order: 2/n², n = {across:.0f} points across the contact",
                evidence=RIDGES["energy"],
            ),
        ]
        curves.append((ratio, pressure / full))
    centred = (x + 0.5) % 1 - 0.5
    order = np.argsort(centred)
    thin = order[:: max(1, points // 128)]
    fine = np.linspace(-0.5, 0.5, 801)
    image = drawing.chart(
        [("closed form", fine, closed_forms.westergaard_pressure(fine, 1.0, r, r)) for r, _ in curves[:1]],
        [(f"computed, r = {ratio:g}", centred[thin], values[thin]) for ratio, values in curves],
        x="x / λ",
        y="p / p*",
        more=[(fine, closed_forms.westergaard_pressure(fine, 1.0, r, r)) for r, _ in curves[1:]],
    )
    caption = "Pressure under Westergaard's ridges at four loads."
    return lines, [Figure("Westergaard: pressure", image, caption)]


def _crests(points: int) -> tuple[list[Line], list[Figure]]:
    """Return lines and figure of the product wave, `points` x `points`."""
    full = closed_forms.jgh_full_contact_pressure(AMPLITUDE, 1.0, 1.0)
    height = product_wave(points)
    table = closed_forms.JGH_CONTACT_SHARE
    ratios = sorted({0.002, 0.005, 0.01, 0.02, 0.7, 0.98, *table})
    contact = solve_contact(
        height, contact_modulus=1.0, mean_pressure=[r * full for r in ratios], tolerance=1e-7
    )
    areas = {r: relative_contact_area(p > 0) for r, p in zip(ratios, contact["pressure"].values, strict=True)}
    lines = []
    for ratio, share in table.items():
        lines.append(
            compare(
                f"Product wave, r = {ratio:g}: contact area",
                areas[ratio],
                share,
                measure="absolute",
                tolerance=2e-4 + 0.2 / points,
                reason=f"2e-4 of the reference, and 0.2/n, n = {points}",
                evidence=CRESTS["table"],
            )
        )
        if ratio not in closed_forms.JGH_PEAK_AND_GAP:
            continue
        peak, gap = closed_forms.JGH_PEAK_AND_GAP[ratio]
        piece = contact.isel(load=ratios.index(ratio))
        pressure = piece["pressure"].values
        found_gap = piece["gap"].values[pressure == 0].sum() / pressure.size
        for what, value, known in (
            ("largest pressure / mean pressure", pressure.max() / (ratio * full), peak),
            ("mean gap / D", found_gap / AMPLITUDE, gap),
        ):
            rounded = 0.5e-5 / known  # the table has five decimals
            lines.append(
                compare(
                    f"Product wave, r = {ratio:g}: {what}",
                    value,
                    known,
                    tolerance=1e-5 + rounded + 8 / points**2,
                    reason=f"1e-5 and the fifth decimal of the reference, and 8/n², n = {points}",
                    evidence=CRESTS["table"],
                )
            )
    low, high = 0.002, 0.98
    lines += [
        compare(
            f"Product wave, r = {low:g}: contact area, low asymptote",
            areas[low],
            closed_forms.jgh_contact_share_low(low),
            tolerance=low ** (2 / 3) + 1 / points,
            reason=f"next term of the expansion, r^(2/3), and 1/n, n = {points}",
            evidence=CRESTS["low"],
        ),
        compare(
            f"Product wave, r = {high:g}: area out of contact, high asymptote",
            1 - areas[high],
            1 - closed_forms.jgh_contact_share_high(high),
            tolerance=(1 - high) + 1 / points,
            reason=f"next term of the expansion, 1 − r, and 1/n, n = {points}",
            evidence=CRESTS["high"],
        ),
    ]
    line = np.geomspace(1e-3, 1, 200)
    near = line > 0.6
    largest = max(one.deviation for one in lines[: len(table)])
    image = drawing.chart(
        [
            ("low asymptote", line[line < 0.4], closed_forms.jgh_contact_share_low(line[line < 0.4])),
            ("high asymptote", line[near], closed_forms.jgh_contact_share_high(line[near])),
        ],
        [("computed", ratios, [areas[r] for r in ratios])],
        published=[("independent code", list(table), list(table.values()))],
        x="r = p̄ / p*",
        y="relative contact area A/A₀",
        scales=("log", "log"),
        note=f"largest deviation of the area {number(largest, digits=2)}",
    )
    caption = "Contact area of the product wave over the whole load range, with both asymptotes."
    return lines, [Figure("Product wave: area against load", image, caption)]
