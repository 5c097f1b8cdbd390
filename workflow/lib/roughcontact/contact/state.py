"""A feasible pressure, the gap it leaves by a fresh application of the operator, and their energy."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class State:
    """A feasible pressure p, shape (ny, nx), and what one application of the operator tells of it.

    `gap` = G p - H - level, where `level` makes its mean over the contact {p > 0} zero; `norm` = ||p||_G;
    `size` is the root mean square of G p plus that of H, against which rounding is measured.
    """

    pressure: np.ndarray
    gap: np.ndarray
    level: float
    norm: float
    size: float


def evaluate(halfspace, heights: np.ndarray, pressure: np.ndarray) -> State:
    """Return the state of a feasible `pressure`; one operator application in double precision."""
    gap = halfspace.displacement(pressure)
    own = norm(pressure, gap)
    size = norm(gap, gap) + norm(heights, heights)
    gap -= heights
    level = float(gap[pressure > 0].mean())
    gap -= level
    return State(pressure=pressure, gap=gap, level=level, norm=own, size=size)


def energy_change(before: State, after: State) -> float:
    """Return E(after) - E(before) of the energy E(p) = <p, G p>/2 - <p, H>, free of cancellation.

    For a quadratic energy the change along s = p' - p is <s, v + v'>/2; as both pressures have the same mean,
    constants in v = G p - H drop out.
    """
    return 0.5 * mean_product(after.pressure - before.pressure, before.gap + after.gap)


def norm(left: np.ndarray, right: np.ndarray) -> float:
    """Return the root of the mean of left x right, a quadratic form that rounding may turn negative."""
    return float(np.sqrt(max(mean_product(left, right), 0.0)))


def mean_product(left: np.ndarray, right: np.ndarray) -> float:
    """Return the mean over the grid of left x right, summed in double precision."""
    return total_product(left, right) / left.size


def total_product(left: np.ndarray, right: np.ndarray) -> float:
    """Return the sum of left x right, in double precision whatever theirs."""
    if left.dtype == np.float64:
        return float(np.vdot(left, right))
    return float(np.einsum("i,i->", left.ravel(), right.ravel(), dtype=float))


def scale_to_load(pressure: np.ndarray, mean_pressure: float) -> np.ndarray:
    """Return max(pressure, 0), scaled to the prescribed mean."""
    positive = np.maximum(pressure, 0)
    positive *= mean_pressure / positive.mean()
    return positive
