"""Sealing: flow through channels, what two phases conduct, and the contact area at which a gap closes."""

from collections.abc import Callable

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from roughcontact.connectivity import runs_around
from roughcontact.contact.solve import solve_contact
from roughcontact.maps import spacing
from roughcontact.quantities import number, percent
from roughcontact.references import closed_forms
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.roughness.parameters import rms_gradient
from roughcontact.sealing.flow import flow_columns
from roughcontact.sealing.percolation import percolation_columns
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.validation.lines import Evidence, Line, Part, Table, compare

TITLE = "Sealing"
_ROW = 256  # points across a channel along an axis, where the answer is exact
_SEEDS = 8
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
        "How much flows through channels of one wave, along, across and at 45°, and through two phases in a "
        "checkerboard; the narrowest place between the valleys of crossed waves; and the contact area at "
        "which the gap of isotropic rough surfaces closes. Bruggeman's effective medium, which knows the "
        "heights of the gap and not where they lie, stands beside the flow factors of one of these."
    )
    points = finest_grid // 8
    return Part("sealing", TITLE, text, [*_channels(points), _closing()], tables=[_effective_medium()])


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
                number(_bruggeman(open_gap)),
            )
        )
    return Table(
        "Flow factors beside Bruggeman's effective medium",
        ("contact area", "Φxx", "Φyy", "effective medium"),
        rows,
        "The effective medium of Dapp, Lücke, Persson and Müser (2012), Phys. Rev. Lett. 108, 244301, in two "
        "dimensions: Σ (g³ − s)/(g³ + s) = 0, closed from half contact on. One isotropic surface.",
    )


def _bruggeman(gap: np.ndarray) -> float:
    """Return the flow factor of an effective medium with the heights of a gap: 0 from half contact on."""
    cubed = (gap / gap.mean()) ** 3

    def excess(logarithm: float) -> float:
        medium = np.exp(logarithm)
        return float(((cubed - medium) / (cubed + medium)).sum())

    low, high = np.log(1e-12), np.log(cubed.max())
    return float(np.exp(brentq(excess, low, high))) if excess(low) > 0 else 0.0
