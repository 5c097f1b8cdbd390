"""Convergence orders: how fast each quantity approaches its limit as the grid is refined.

Errors are root mean squares over several loads and over positions of the crest between the points: where an
edge falls within a pixel is chance, and a single position would measure luck. The order k is the slope of a
straight line through log error against log points, least squares.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from validation import closed_forms, drawing
from validation.lines import Figure, Section
from validation.problems import (
    AMPLITUDE,
    RIDGES_CLOSED,
    WAVE_CLOSED,
    product_wave,
    ridge,
    solve,
)

# Loads whose edges fall at unrelated places within a pixel, and positions of the crest between the points
_RIDGE_LOADS = np.linspace(0.1, 0.85, 24)
_RIDGE_PHASES = (np.arange(4) + 0.5) / 4
_CREST_LOADS = np.linspace(0.1, 0.85, 6)
_POSITIONS = 8
_ORDERS = {
    "pressure": 1,
    "raw area": 1,
    "largest pressure": 2,
    "mean gap": 2,
    "energy": 2,
    "approach": 2,
}


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add lines and figures: ridges up to the finest grid, the product wave up to a quarter of it."""
    _ridges(section, _doubled(64, finest_grid))
    _crests(section, _doubled(32, max(finest_grid // 4, 256)))


def fitted_order(sizes: ArrayLike, errors: ArrayLike) -> float:
    """Return k of error ~ n^-k, a straight line through the logarithms by least squares.

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

    Examples
    --------
    >>> round(slope_scatter([32, 64, 128, 256, 512], 48), 3)
    0.047
    """
    points = np.log(np.asarray(sizes, float))
    return float(1 / np.sqrt(2 * cases * np.sum((points - points.mean()) ** 2)))


def _doubled(first: int, last: int) -> list[int]:
    """Return first, 2 first, 4 first, ... up to last."""
    return [first << power for power in range((last // first).bit_length())]


def _ridges(section: Section, sizes: Sequence[int]) -> None:
    """Add lines and figure of Westergaard's wave, whose limits are known exactly."""
    errors = np.array([_rms(_ridge_errors(n, phase) for phase in _RIDGE_PHASES) for n in sizes])
    drawn = []
    for (quantity, order), values in zip(_ORDERS.items(), errors.T, strict=True):
        fitted = fitted_order(sizes, values)
        drawn.append((quantity, values, fitted))
        fields = {"first": sizes[0], "last": sizes[-1], "quantity": quantity}
        section.compare("first" if order == 1 else "second", fitted, order, 0.15 * order, **fields)
    image = drawing.error_chart(drawn, sizes, y="relative error")
    caption = "Westergaard's ridges: errors against the closed forms, rms over 24 loads and four positions."
    section.figures.append(Figure("Ridges", image, caption))


def _ridge_errors(points: int, phase: float) -> np.ndarray:
    """Return the relative errors of one row of Westergaard's wave, array (load, quantity)."""
    x, height = ridge(points, phase)
    contacts = solve(height, list(_RIDGE_LOADS * RIDGES_CLOSED), 1e-9)
    rows = []
    for ratio, contact in zip(_RIDGE_LOADS, contacts, strict=True):
        exact = closed_forms.westergaard_pressure(x, 1.0, ratio * RIDGES_CLOSED, ratio)
        mean_gap = closed_forms.westergaard_mean_gap(AMPLITUDE, ratio)
        rows.append(
            [
                np.sqrt(np.mean((contact.pressure[0] - exact) ** 2) / np.mean(exact**2)),
                contact.touching.mean() / closed_forms.westergaard_contact_share(ratio) - 1,
                contact.pressure.max() / (2 * RIDGES_CLOSED * np.sqrt(ratio)) - 1,
                contact.mean_gap / mean_gap - 1,
                contact.energy / closed_forms.westergaard_energy(AMPLITUDE, 1.0, 1.0, ratio) - 1,
                contact.approach / mean_gap - 1,
            ]
        )
    return np.array(rows)


def _crests(section: Section, sizes: Sequence[int]) -> None:
    """Add lines and figure of the areas of the product wave, their limit from a grid twice as fine."""
    first, last = sizes[0], sizes[-1]
    limit = np.mean([_areas(2 * last, phase)[:, 1] for phase in _phases(2)], axis=0)
    errors = np.array(
        [_rms(_areas(n, phase) - limit[:, None] for phase in _phases(_POSITIONS)) for n in sizes]
    )
    raw, corrected = errors.T
    orders = [fitted_order(sizes, values) for values in (raw, corrected)]
    cases = _POSITIONS * len(_CREST_LOADS)
    for name, value, expected, tolerance in (
        ("raw area", orders[0], 1.0, 0.15),
        ("corrected area", orders[1], 1.5, 3 * slope_scatter(sizes, cases)),
        ("rest", corrected[-1] / raw[-1], 0.0, 3 / np.sqrt(last)),
    ):
        section.compare(name, value, expected, tolerance, first=first, last=last, cases=cases)
    drawn = [("raw area", raw, orders[0]), ("corrected area", corrected, orders[1])]
    image = drawing.error_chart(drawn, sizes, y="error of A/A₀")
    caption = (
        "Product wave: counted and corrected area, rms over six loads and eight positions; the limit is the "
        f"corrected area at {2 * last} points."
    )
    section.figures.append(Figure("Product wave", image, caption))


def _phases(number: int) -> list[tuple[float, float]]:
    """Return so many positions (along y, along x) of the crest between the points, well spread."""
    steps = np.arange(number)
    return list(zip((steps * 5 % number + 0.25) / number, (steps + 0.5) / number, strict=True))


def _areas(points: int, phase: tuple[float, float]) -> np.ndarray:
    """Return the counted and the corrected area of the product wave, array (load, 2)."""
    contacts = solve(product_wave(points, phase), list(_CREST_LOADS * WAVE_CLOSED), 1e-5)
    return np.array([[contact.touching.mean(), contact.area] for contact in contacts])


def _rms(errors: Iterable[np.ndarray]) -> np.ndarray:
    """Return the root mean square over positions and loads, array (quantity)."""
    return np.sqrt(np.mean(np.square(list(errors)), axis=(0, 1)))
