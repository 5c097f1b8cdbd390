"""Convergence orders: how fast each quantity approaches its limit as the grid is refined.

Errors are root mean squares over several loads and over positions of the crest between the points: where an
edge falls within a pixel is chance, and a single position would measure luck. The order k is the slope of a
straight line through log error against log points, least squares.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from roughcontact.contact.solve import solve_contact
from roughcontact.elasticity.energy import elastic_energy
from roughcontact.references import closed_forms
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.validation import drawing
from roughcontact.validation.lines import Evidence, Figure, Line, Part, compare
from roughcontact.validation.waves import AMPLITUDE, product_wave, ridge

TITLE = "Orders of convergence"
# Loads whose edges fall at unrelated places within a pixel, and positions of the crest between the points
_RIDGE_LOADS = np.linspace(0.1, 0.85, 24)
_RIDGE_PHASES = (np.arange(4) + 0.5) / 4
_CREST_LOADS = np.linspace(0.1, 0.85, 6)
_POSITIONS = 8
_TEST = "tests/unit/test_validation.py::test_fitted_order_of_a_power_law"

FIRST = Evidence(
    "error ~ 1/n: the edge of the contact is known to a pixel, the pressure starts there like a square root",
    "Yastrebov, Anciaux and Molinari (2017) for the area; closed forms of Westergaard (1939)",
    "validation.convergence.fitted_order",
    _TEST,
)
SECOND = Evidence(
    "error ~ 1/n²: energy is stationary, so an edge that is off by ε changes it, and the mean gap, by ε²",
    "Johnson (1985), sec. 5.9 (minimum of energy); closed forms of Westergaard (1939)",
    "validation.convergence.fitted_order",
    _TEST,
)
CORRECTED = Evidence(
    "A/A₀ = Na/N − c M/N, c = (π − 1 + ln 2)/24: takes the first order out; what is left is scatter along "
    "the contact line, ~ 1/n^1.5",
    "Yastrebov, Anciaux and Molinari (2017)",
    "statistics.contact_geometry.relative_contact_area",
    "tests/unit/test_statistics.py::test_corrected_area_of_the_product_wave_is_nearer_than_the_pixels",
)


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
    ridges, ridge_figures = _ridges(_doubled(64, finest_grid))
    crests, crest_figures = _crests(_doubled(32, max(finest_grid // 4, 256)))
    text = (
        "The order k says how an error falls with the number of points n, as n⁻ᵏ. The errors are rms over "
        "many loads and positions of the wave between the points. Area and pressure field are of first "
        "order; energy, gap, approach and peak of second."
    )
    return Part("convergence", TITLE, text, [*ridges, *crests], [*ridge_figures, *crest_figures])


def fitted_order(sizes: ArrayLike, errors: ArrayLike) -> float:
    """Return k of error ~ n^-k, a straight line through the logarithms by least squares.

    Parameters
    ----------
    sizes : array (n)
        numbers of points.
    errors : array (n)

    Returns
    -------
    float

    Examples
    --------
    >>> round(fitted_order([32, 64, 128], [0.4, 0.1, 0.025]), 6)
    2.0
    """
    return float(-np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def slope_scatter(sizes: ArrayLike, cases: int) -> float:
    """Return the standard deviation of a fitted order where every error is the rms of so many cases.

    The rms of N independent normal numbers scatters by 1/√(2 N) of itself, so that the slope of the straight
    line scatters by 1/√(2 N) over the root of the sum of squares of ln n about its mean.

    Parameters
    ----------
    sizes : array (n)
        numbers of points.
    cases : int
        behind each error.

    Returns
    -------
    float

    Examples
    --------
    >>> round(slope_scatter([32, 64, 128, 256, 512], 48), 3)
    0.047
    """
    points = np.log(np.asarray(sizes, float))
    return float(1 / np.sqrt(2 * cases * np.sum((points - points.mean()) ** 2)))


def _doubled(first: int, last: int) -> list[int]:
    """Return first, 2 first, 4 first, ... up to last."""
    sizes = [first]
    while sizes[-1] * 2 <= last:
        sizes.append(sizes[-1] * 2)
    return sizes


def _ridges(sizes: Sequence[int]) -> tuple[list[Line], list[Figure]]:
    """Return lines and figure for Westergaard's wave, whose limits are known exactly."""
    errors = np.array([_rms(_ridge_errors(n, phase) for phase in _RIDGE_PHASES) for n in sizes])
    names = ("pressure", "raw area", "largest pressure", "mean gap", "energy", "approach")
    expected = (1, 1, 2, 2, 2, 2)
    lines, drawn = [], []
    for name, order, values in zip(names, expected, errors.T, strict=True):
        fitted = fitted_order(sizes, values)
        drawn.append((name, values, fitted))
        lines.append(
            compare(
                f"Ridges, {sizes[0]} to {sizes[-1]} points: order of the {name}",
                fitted,
                order,
                measure="absolute",
                tolerance=0.15 * order,
                reason="15 % of the order: scatter of the edges within a pixel",
                evidence=FIRST if order == 1 else SECOND,
            )
        )
    image = drawing.error_chart(drawn, sizes, x="points per wave", y="relative error", title="fitted orders")
    caption = "Westergaard's ridges: errors against the closed forms, rms over 24 loads and four positions."
    return lines, [Figure("Ridges", image, caption)]


def _ridge_errors(points: int, phase: float) -> np.ndarray:
    """Return the relative errors of one row of Westergaard's wave, array (load, quantity)."""
    full = closed_forms.westergaard_full_contact_pressure(AMPLITUDE, 1.0, 1.0)
    x, height = ridge(points, phase)
    contact = solve_contact(
        height, contact_modulus=1.0, mean_pressure=list(_RIDGE_LOADS * full), tolerance=1e-9
    )
    rows = []
    for index, ratio in enumerate(_RIDGE_LOADS):
        pressure, gap = (contact[name].values[index] for name in ("pressure", "gap"))
        exact = closed_forms.westergaard_pressure(x, 1.0, ratio * full, ratio)
        mean_gap = closed_forms.westergaard_mean_gap(AMPLITUDE, ratio)
        energy = elastic_energy(pressure, (1 / points, 1 / points), contact_modulus=1.0)
        rows.append(
            [
                np.sqrt(np.mean((pressure[0] - exact) ** 2) / np.mean(exact**2)),
                np.count_nonzero(pressure) / points / closed_forms.westergaard_contact_share(ratio) - 1,
                pressure.max() / (2 * full * np.sqrt(ratio)) - 1,
                gap[pressure == 0].sum() / points / mean_gap - 1,
                energy / closed_forms.westergaard_energy(AMPLITUDE, 1.0, 1.0, ratio) - 1,
                float(contact["approach"][index]) / mean_gap - 1,
            ]
        )
    return np.array(rows)


def _crests(sizes: Sequence[int]) -> tuple[list[Line], list[Figure]]:
    """Return lines and figure for the areas of the product wave, their limit from a grid twice as fine."""
    limit = np.mean([_areas(2 * sizes[-1], phase)[:, 1] for phase in _phases(2)], axis=0)
    errors = np.array(
        [_rms(_areas(n, phase) - limit[:, None] for phase in _phases(_POSITIONS)) for n in sizes]
    )
    raw, corrected = errors.T
    cases = len(_phases(_POSITIONS)) * len(_CREST_LOADS)
    drawn = [
        (name, values, fitted_order(sizes, values))
        for name, values in (("raw area", raw), ("corrected area", corrected))
    ]
    about = f"Product wave, {sizes[0]} to {sizes[-1]} points"
    lines = [
        compare(
            f"{about}: order of the raw area",
            drawn[0][2],
            1.0,
            measure="absolute",
            tolerance=0.15,
            reason="15 % of the order: scatter of the edges within a pixel",
            evidence=FIRST,
        ),
        compare(
            f"{about}: order of the corrected area",
            drawn[1][2],
            1.5,
            measure="absolute",
            tolerance=3 * slope_scatter(sizes, cases),
            reason=f"three standard deviations of a slope through rms errors of {cases} cases each",
            evidence=CORRECTED,
        ),
        compare(
            f"{about}: error left by the correction, of the raw one at {sizes[-1]} points",
            corrected[-1] / raw[-1],
            0.0,
            measure="absolute",
            tolerance=3 / np.sqrt(sizes[-1]),
            reason=f"it falls faster by half an order: 3/√n, n = {sizes[-1]}",
            evidence=CORRECTED,
        ),
    ]
    image = drawing.error_chart(drawn, sizes, x="points per wave", y="error of A/A₀", title="fitted orders")
    caption = (
        "Product wave: counted and corrected area, rms over six loads and eight positions; the limit is the "
        f"corrected area at {2 * sizes[-1]} points."
    )
    return lines, [Figure("Product wave", image, caption)]


def _phases(number: int) -> list[tuple[float, float]]:
    """Return so many positions (along y, along x) of the crest between the points, well spread."""
    steps = np.arange(number)
    return list(zip((steps * 5 % number + 0.25) / number, (steps + 0.5) / number, strict=True))


def _areas(points: int, phase: tuple[float, float]) -> np.ndarray:
    """Return the counted and the corrected area of the product wave, array (load, 2)."""
    full = closed_forms.jgh_full_contact_pressure(AMPLITUDE, 1.0, 1.0)
    contact = solve_contact(
        product_wave(points, phase),
        contact_modulus=1.0,
        mean_pressure=list(_CREST_LOADS * full),
        tolerance=1e-5,
    )
    touching = contact["contact"].values > 0
    return np.array([[share.mean(), relative_contact_area(share)] for share in touching])


def _rms(errors: Iterable[np.ndarray]) -> np.ndarray:
    """Return the root mean square over positions and loads, array (quantity)."""
    return np.sqrt(np.mean(np.square(list(errors)), axis=(0, 1)))
