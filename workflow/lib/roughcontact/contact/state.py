"""A feasible pressure, the gap it leaves by a fresh application of the operator, and their energy."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class State:
    """A feasible pressure p, shape (ny, nx), and what one application of the operator tells of it.

    `gap` = G p - H - level, where `level` makes its mean over the contact {p > 0} zero; `norm` = ||p||_G;
    `size` is the root mean square of G p plus that of H, against which rounding is measured. The gap is in
    the precision of the application, the pressure in double.
    """

    pressure: np.ndarray
    gap: np.ndarray
    level: float
    norm: float
    size: float


def evaluate(halfspace, heights: np.ndarray, pressure: np.ndarray, *, dtype=np.float64) -> State:
    """Return the state of a feasible `pressure`; one operator application in the precision `dtype`."""
    displaced = halfspace.displacement(pressure, dtype=dtype)
    own = norm(pressure, displaced)
    size = norm(displaced, displaced) + norm(heights, heights)
    gap = np.empty(heights.shape, dtype=dtype)
    np.subtract(displaced, heights, out=gap, casting="same_kind")
    level = contact_mean(pressure, gap)
    gap -= level
    return State(pressure=pressure, gap=gap, level=level, norm=own, size=size)


def contact_mean(pressure: np.ndarray, field: np.ndarray) -> float:
    """Return the mean of `field` over the points of positive pressure."""
    return float(field[pressure > 0].mean(dtype=float))


def descend(before: State, after: State) -> State | None:
    """Return the state of least energy between two states of equal load; None where none is below `before`.

    E(p) = <p, G p>/2 - <p, H> is quadratic along s = p' - p: its change is t <s, v> + t^2 <s, v' - v>/2, with
    v = G p - H up to a constant, which drops out. Both states are linear in t, so that no application is
    needed, and no digits cancel.
    """
    step = after.pressure - before.pressure
    slope, slope_after = mean_product(step, before.gap), mean_product(step, after.gap)
    if slope + slope_after < 0:
        return after
    if slope >= 0:
        return None
    curvature = slope_after - slope
    share = -slope / curvature
    pressure = before.pressure + share * step
    gap = before.gap + share * (after.gap - before.gap)
    shift = contact_mean(pressure, gap)
    gap -= shift
    level = before.level + share * (after.level - before.level) + shift
    square = (1 - share) * before.norm**2 + share * after.norm**2 - share * (1 - share) * curvature
    return State(
        pressure=pressure, gap=gap, level=level, norm=float(np.sqrt(max(square, 0))), size=after.size
    )


def norm(left: np.ndarray, right: np.ndarray) -> float:
    """Return the root of the mean of left x right, a quadratic form that rounding may turn negative."""
    return float(np.sqrt(max(mean_product(left, right), 0.0)))


def mean_product(left: np.ndarray, right: np.ndarray) -> float:
    """Return the mean over the grid of left x right, summed in double precision."""
    return total_product(left, right) / left.size


def total_product(left: np.ndarray, right: np.ndarray) -> float:
    """Return the sum of left x right, in double precision whatever theirs."""
    if left.dtype == right.dtype == np.float64:
        return float(np.vdot(left, right))
    return float(np.einsum("i,i->", left.ravel(), right.ravel(), dtype=float))


def scale_to_load(pressure: np.ndarray, mean_pressure: float) -> np.ndarray:
    """Return max(pressure, 0), scaled to the prescribed mean."""
    positive = np.maximum(pressure, 0)
    positive *= mean_pressure / positive.mean()
    return positive
