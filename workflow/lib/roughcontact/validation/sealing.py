"""Sealing: flow through channels, what two phases conduct, and the contact area at which a gap closes."""

from collections.abc import Callable

import numpy as np
import xarray as xr
from scipy.integrate import quad
from scipy.optimize import brentq

from roughcontact.connectivity import runs_around
from roughcontact.contact.solve import solve_contact
from roughcontact.maps import spacing
from roughcontact.quantities import number, percent
from roughcontact.references import closed_forms
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.sealing.flow import flow_columns, leak_columns
from roughcontact.sealing.percolation import percolation_columns
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.validation import waves
from roughcontact.validation.lines import Evidence, Line, Part, Table, compare

TITLE = "Sealing"
_ROW = 256  # points across a channel along an axis, where the answer is exact
_SEEDS = 8
_SEAL = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 1e-2}  # water, 1 bar, 10 mm
_LOADS = (0.02, 0.05, 0.1, 0.15, 0.2)

_TESTS = "tests/unit/test_sealing.py"
CHANNEL = Evidence(
    "along <g³>/ū³ = 1 + 3ε²/2, across 1/(ū³<g⁻³>) = (1 − ε²)^(5/2)/(1 + ε²/2)",
    "Reynolds' equation in one dimension; Patir and Cheng (1978), ASME J. Lubr. Technol. 100, 12",
    "references.closed_forms.channel_flow_factors",
    f"{_TESTS}::test_closed_form_of_the_channels_by_quadrature",
)
DIAGONAL = Evidence(
    "Φxx = (along + across)/2, Φxy = (across − along)/2",
    "the same, turned by 45°",
    "references.closed_forms.channel_flow_factors",
    f"{_TESTS}::test_channels_at_an_angle_lead_the_flow_aside",
)
BOARD = Evidence(
    "√(k₁k₂)",
    "Dykhne (1970), Sov. Phys. JETP 32, 63; Keller (1964), J. Math. Phys. 5, 548",
    "sealing.flow.flow_columns",
    f"{_TESTS}::test_checkerboard_conducts_the_geometric_mean",
)
LOW = Evidence(
    "(Φxx + Φyy)/2 = 1 − (3/2) (σ/ū)²",
    "Tripp (1983), ASME J. Lubr. Technol. 105, 458, for roughness without a direction",
    "references.closed_forms.isotropic_flow_factor",
    f"{_TESTS}::test_tripps_factor_is_what_channels_along_and_across_let_through",
)
MEDIUM = Evidence(
    "Σ (g³ − s)/(g³ + s) = 0, to second order 1 − (3/2) (σ/ū)²",
    "Dapp, Lücke, Persson and Müser (2012), Phys. Rev. Lett. 108, 244301; Tripp (1983)",
    "references.closed_forms.effective_medium_flow_factor",
    f"{_TESTS}::test_effective_medium_of_two_phases",
)
SLIT = Evidence(
    "h³ Δp/(12 η w)",
    "Reynolds (1886), Phil. Trans. R. Soc. 177, 157, between parallel plates",
    "sealing.flow.leak_columns",
    f"{_TESTS}::test_leak_rate_of_a_seal",
)
RIDGES = Evidence(
    "<g³> Δp/(12 η w), g = 2D [s √(s² − r) − r ln((s + √(s² − r))/√r)], s = |sin(πx/λ)|",
    "Westergaard (1939), its gap; the flow between parallel plates in each strip of it",
    "references.closed_forms.westergaard_gap",
    "tests/unit/test_reference.py::test_westergaard_gap_closes_at_the_edge_and_has_the_stated_mean",
)
SITES = Evidence(
    "points of a square lattice percolate from a share of 0.592746 on",
    "Jacobsen (2015), J. Phys. A 48, 454003",
    "sealing.percolation.percolation_columns",
    f"{_TESTS}::test_random_points_percolate_at_the_published_threshold",
)
SADDLE = Evidence(
    "ḡ, between two valleys of ḡ (1 + (cos x + cos y)/2)",
    "the saddle, by inspection",
    "sealing.percolation.percolation_columns",
    f"{_TESTS}::test_constriction_of_crossed_waves_is_their_saddle",
)
CLOSING = Evidence(
    "A/A₀ ≈ 0.42 where the gap ceases to be open, isotropic",
    "Dapp and Müser (2015), arXiv 1512.00186; Wang and Müser (2020), arXiv 2010.13470",
    "connectivity.runs_around",
    f"{_TESTS}::test_regions_around_the_period_are_those_of_a_walker",
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
    text = (
        "How much flows through channels of one wave, along, across and at 45°, through two phases in a "
        "checkerboard, and through low roughness; what leaks between plates and along ridges in contact; the "
        "narrowest place between the valleys of crossed waves, and where random heights let something "
        "through; and the contact area at which the gap of isotropic rough surfaces closes. Bruggeman's "
        "effective medium, which knows the heights of the gap and not where they lie, stands beside the flow "
        "factors of one of these."
    )
    points = finest_grid // 8
    lines = [
        *_channels(points),
        *_low_roughness(points),
        *_leaks(points),
        _random_heights(2 * points),
        _closing(),
    ]
    return Part("sealing", TITLE, text, lines, tables=[_effective_medium()])


def _channels(points: int) -> list[Line]:
    """Return the lines of closed forms."""
    x, row = (2 * np.pi * np.arange(n) / n for n in (points, _ROW))
    steps = (1 / points, 1 / points)
    lines = []
    for depth in (0.5, 0.9):
        along, across = closed_forms.channel_flow_factors(depth)
        found = flow_columns((1 + depth * np.cos(row)) * np.ones((8, 1)), steps, tolerance=1e-9)
        lines += [
            compare(
                f"Channel of depth {depth:g} ū: flow factor {word}",
                found[f"flow_factor_{axes}"],
                known,
                tolerance=1e-8,
                reason="exact but for the iteration",
                evidence=CHANNEL,
            )
            for word, axes, known in (("along", "yy", along), ("across", "xx", across))
        ]
    along, across = closed_forms.channel_flow_factors(0.5)
    found = flow_columns(1 + 0.5 * np.cos(x[:, None] + x[None, :]), steps, tolerance=1e-9)
    lines += [
        compare(
            f"Channel at 45°, depth 0.5 ū: flow factor {axes}",
            found[f"flow_factor_{axes}"],
            known,
            tolerance=100 / points**2,
            reason=f"second order: 100/n², n = {points}",
            evidence=DIAGONAL,
        )
        for axes, known in (("xx", (along + across) / 2), ("xy", (across - along) / 2))
    ]
    board = np.where((np.indices((points, points)) // (points // 2)).sum(axis=0) % 2, 1.0, 3.0) ** (1 / 3)
    lines.append(
        compare(
            "Checkerboard of conductivities 1 and 3: conductivity",
            flow_columns(board, steps, tolerance=1e-9)["flow_factor_xx"] * board.mean() ** 3,
            np.sqrt(3),
            tolerance=0.5 * points**-1.2,
            reason=f"0.5/n^1.2, n = {points}: the flux is singular at the corners",
            evidence=BOARD,
        )
    )
    crossed = 1 + (np.cos(x)[:, None] + np.cos(x)[None, :]) / 2
    lines.append(
        compare(
            "Crossed waves: critical constriction / ū",
            percolation_columns(crossed)["critical_constriction_x"],
            1.0,
            tolerance=1e-12,
            reason="exact: the saddle is a point of the map",
            evidence=SADDLE,
        )
    )
    return lines


def _low_roughness(points: int) -> list[Line]:
    """Return the lines of a gap with roughness of a twentieth of it."""
    relative = 0.05
    height = self_affine_surface(
        (points, points), 1.0, hurst=0.8, shortest=8.0, longest=points / 4, rms_height=relative
    )
    gap = 1 + height.values
    factors = flow_columns(gap, (1.0, 1.0), tolerance=1e-9)
    found = {
        "mean of the flow factors": ((factors["flow_factor_xx"] + factors["flow_factor_yy"]) / 2, LOW),
        "effective medium": (closed_forms.effective_medium_flow_factor(gap), MEDIUM),
    }
    return [
        compare(
            f"Roughness of 0.05 ū: {word}, less 1",
            value - 1,
            closed_forms.isotropic_flow_factor(relative) - 1,
            tolerance=relative,
            reason="the next term is of third order: σ/ū of this one",
            evidence=evidence,
        )
        for word, (value, evidence) in found.items()
    ]


def _leaks(points: int) -> list[Line]:
    """Return the lines of leak rates: between plates, and along the gap of ridges that touch."""
    plates = np.full((4, 4), 1e-6)
    known = 1e-18 * _SEAL["pressure_difference"] / (12 * _SEAL["viscosity"] * _SEAL["width"])
    lines = [
        compare(
            "Water between plates 1 µm apart, 1 bar over 10 mm: leak rate, m²/s",
            leak_columns(1e-6, flow_columns(plates, (1e-6, 1e-6)), **_SEAL)["leak_rate_x"],
            known,
            tolerance=1e-12,
            reason="exact",
            evidence=SLIT,
        )
    ]
    full = closed_forms.westergaard_full_contact_pressure(waves.AMPLITUDE, 1.0, 1.0)
    _, ridge = waves.ridge(points)
    for ratio in (0.1, 0.5):
        contact = solve_contact(ridge, contact_modulus=1.0, mean_pressure=ratio * full, tolerance=1e-8)
        gap = np.where(contact["pressure"].values[0] > 0, 0.0, contact["gap"].values[0])
        found = leak_columns(gap.mean(), flow_columns(gap, spacing(ridge)), **_SEAL)
        cubed, _ = quad(
            lambda x, ratio=ratio: closed_forms.westergaard_gap(x, 1.0, waves.AMPLITUDE, ratio) ** 3, 0.0, 0.5
        )
        lines.append(
            compare(
                f"Ridges, r = {ratio:g}: leak rate along them / that between plates D apart",
                found["leak_rate_y"] / (known * (waves.AMPLITUDE / 1e-6) ** 3),
                2 * cubed / waves.AMPLITUDE**3,
                tolerance=20 / points**2,
                reason=f"second order: 20/n², n = {points}",
                evidence=RIDGES,
            )
        )
    return lines


def _random_heights(points: int) -> Line:
    """Return the line of the threshold at which random heights percolate: mean over maps and axes."""
    levels = [
        list(percolation_columns(np.random.default_rng(seed).random((points, points))).values())[2:]
        for seed in range(_SEEDS)
    ]
    scatter = 0.7 * points**-0.75 / np.sqrt(2 * _SEEDS)
    return compare(
        f"Random heights: share of the points from which on they percolate, mean of {_SEEDS} maps",
        1 - np.mean(levels),
        0.592746,
        measure="absolute",
        tolerance=3 * scatter,
        reason=f"three times the scatter of the mean, 0.7 n^(−3/4)/√{2 * _SEEDS}, n = {points}",
        evidence=SITES,
    )


def _closing() -> Line:
    """Return the line of the contact area at which gaps close: mean of some small surfaces."""
    areas = []
    for seed in range(_SEEDS):
        height = self_affine_surface(
            (256, 256), 1.0, hurst=0.8, shortest=8.0, longest=32.0, rms_height=1e-3, seed=seed
        )
        gradient = rms_gradient(height)

        def contact(relative: float, height: xr.DataArray = height, gradient: float = gradient) -> np.ndarray:
            solved = solve_contact(
                height, contact_modulus=1.0, mean_pressure=relative * gradient, tolerance=1e-3
            )
            return solved["pressure"].values[0] > 0

        def is_open(relative: float, contact: Callable[[float], np.ndarray] = contact) -> float:
            return 1.0 if any(runs_around(~contact(relative))) else -1.0

        closed = brentq(is_open, 0.1, 0.4, xtol=1e-3)
        areas.append(relative_contact_area(contact(closed)))
    scatter = float(np.std(areas, ddof=1))
    return compare(
        f"Contact area at which the gap closes, mean of {_SEEDS} surfaces",
        np.mean(areas),
        0.42,
        measure="absolute",
        tolerance=0.03,
        reason=f"0.415 to 0.42 published, for wide bands of waves; these, two octaves wide, scatter by "
        f"{number(scatter, digits=2)}",
        evidence=CLOSING,
    )


def _effective_medium() -> Table:
    """Return the table of flow factors beside those of Bruggeman's effective medium."""
    height = self_affine_surface((256, 256), 1.0, hurst=0.8, shortest=8.0, longest=32.0, rms_height=1e-3)
    loads = [relative * rms_gradient(height) for relative in _LOADS]
    contact = solve_contact(height, contact_modulus=1.0, mean_pressure=loads)
    rows = []
    for pressure, gap in zip(contact["pressure"].values, contact["gap"].values, strict=True):
        open_gap = np.where(pressure > 0, 0.0, gap)
        factors = flow_columns(open_gap, spacing(height))
        rows.append(
            (
                percent(relative_contact_area(pressure > 0)),
                number(factors["flow_factor_xx"]),
                number(factors["flow_factor_yy"]),
                number(closed_forms.effective_medium_flow_factor(open_gap)),
            )
        )
    return Table(
        "Flow factors beside Bruggeman's effective medium",
        ("contact area", "Φxx", "Φyy", "effective medium"),
        rows,
        "The effective medium of Dapp, Lücke, Persson and Müser (2012), Phys. Rev. Lett. 108, 244301, in two "
        "dimensions: Σ (g³ − s)/(g³ + s) = 0, closed from half contact on. One isotropic surface.",
    )
