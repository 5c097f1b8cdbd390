"""A feasible pressure and the results of one application of the operator to it.

All fields are dimensionless and have the shape (ny, nx).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from roughcontact.kernels.array_api import mean
from roughcontact.kernels.arrays import Array, as_precision, empty, get_precision, n_elements, namespace
from roughcontact.kernels.choose import kernels_for


@dataclass(frozen=True)
class State:
    """A dimensionless pressure 0 <= p <= cap of the prescribed mean and its separation G p - H (ny, nx)."""

    pressure: Array
    separation: Array
    offset: float  # mean separation over the free contact {0 < p < cap}
    norm: float  # ||p||_G
    size: float  # scale of rounding: the root mean square of G p plus that of H
    free_share: float = 1.0  # share of points that make up for the rounding of the cap

    @property
    def gap(self) -> Array:
        """The separation less the offset."""
        return self.separation - self.offset

    @cached_property
    def pressure_size(self) -> float:
        """The root mean square of the pressure."""
        return norm(self.pressure, self.pressure)


def contact_mean(pressure: Array, separation: Array, *, cap: float) -> float:
    """Return the mean separation over the free contact {0 < p < cap}."""
    xp = namespace(pressure)
    free = (pressure > 0) & (pressure < cap)
    if xp.any(free):
        return mean(separation[free])
    full = pressure >= cap
    if xp.all(full):
        return float(xp.max(separation))  # at the cap the gap is nowhere positive
    # all points in contact are at the cap: any offset between theirs and the others is valid
    return 0.5 * (float(xp.max(separation[full])) + float(xp.min(separation[~full])))


def scale_to_load(
    pressure: Array,
    mean_pressure: float,
    *,
    cap: float = np.inf,
    precision: str | None = None,
    copy: bool = True,
) -> Array:
    """Return max(pressure, 0) x factor, at most `cap`, with the factor that gives the prescribed mean.

    Points that the factor takes beyond the cap are held in turn, which ends after finitely many passes; a
    change of `precision` rounds the cap, and points at it. Without `copy` the pressure may be overwritten.
    """
    xp, total = namespace(pressure), mean_pressure * n_elements(pressure)
    if cap == np.inf:
        result_precision, rescaled = precision or get_precision(pressure), pressure
        if copy or get_precision(pressure) != result_precision:
            rescaled = empty(pressure, result_precision)
            rescaled[...] = pressure
        kernels = kernels_for(rescaled)
        kernels.rescale(rescaled, total / kernels.rescale(rescaled, 1.0, np.inf), np.inf)
        return rescaled
    positive = xp.clip(as_precision(pressure, precision or get_precision(pressure), copy=False), 0, None)
    if mean_pressure >= cap:
        raise ValueError(f"a mean pressure of {mean_pressure:g} cannot be carried below the cap {cap:g}")
    at_cap = pressure >= cap
    rounding = 4 * float(xp.finfo(positive.dtype).eps) * total  # of the sum of the pressures
    if total < cap * int(xp.count_nonzero(at_cap)) - rounding:
        at_cap = pressure > np.inf  # nowhere: they carry more than the load, so all are scaled down
    while True:
        missing = total - cap * int(xp.count_nonzero(at_cap))
        free_load = float(xp.sum(positive[~at_cap], dtype=xp.float64))
        if abs(missing) <= rounding:  # the points at the cap carry the whole load
            rescaled = xp.zeros_like(positive)
        elif free_load > 0:
            rescaled = positive * (missing / free_load)
        else:  # all points with a pressure are at the cap: the others share the missing load
            rescaled = xp.full_like(positive, missing / int(xp.count_nonzero(~at_cap)))
        above_cap = (rescaled > cap) & ~at_cap
        if free_load == 0 or not xp.any(above_cap):
            return xp.where(at_cap, xp.full_like(positive, cap), rescaled)
        at_cap |= above_cap  # grows in every pass, so that the loop ends


def scale_below_cap(pressure: Array, mean_pressure: float, cap: float) -> float:
    """Return the factor for the pressure below the cap that gives the prescribed mean; all are in [0, `cap`].

    Negative where the points at the cap carry more than the load, infinite where no other carries any.
    """
    xp = namespace(pressure)
    below = pressure < cap
    count = n_elements(pressure)
    missing = mean_pressure * count - cap * (count - int(xp.count_nonzero(below)))
    free_load = float(xp.sum(xp.where(below, pressure, xp.zeros_like(pressure)), dtype=xp.float64))
    return missing / free_load if free_load > 0 else np.inf


def project_to_load(pressure: Array, mean_pressure: float, *, cap: float) -> Array:
    """Return the nearest field to `pressure` between 0 and `cap` that has the prescribed mean.

    It is max(min(p - shift, cap), 0). The mean falls with the shift, linearly between the shifts at which a
    point comes to a bound: steps of Newton and of bisection, in turns, find it to the last digit.
    """
    xp = namespace(pressure)
    # between these shifts the mean of the projection passes the prescribed one
    low, high = float(xp.min(pressure)) - mean_pressure, float(xp.max(pressure))
    low -= cap if cap < np.inf else 0.0
    rounding_floor = float(xp.finfo(pressure.dtype).eps) * mean_pressure
    shift, by_newton = 0.5 * (low + high), False
    while True:
        projection = xp.clip(pressure - shift, 0, cap)
        excess = mean(projection) - mean_pressure
        low, high = (shift, high) if excess > 0 else (low, shift)
        middle = 0.5 * (low + high)
        if abs(excess) <= rounding_floor or not low < middle < high:
            return projection
        free_points = int(xp.count_nonzero((projection > 0) & (projection < cap)))
        # Newton's step is exact once the free points are right; bisection in turns keeps it from circling
        newton = shift + excess * n_elements(pressure) / max(free_points, 1)
        by_newton = not by_newton
        shift = newton if by_newton and low < newton < high else middle


def norm(u: Array, v: Array) -> float:
    """Return the root of the mean of u x v, a quadratic form that rounding may turn negative."""
    return float(np.sqrt(max(mean_product(u, v), 0.0)))


def mean_product(u: Array, v: Array) -> float:
    """Return the mean over the grid of u x v, summed in double precision."""
    return kernels_for(u).product(u, v) / n_elements(u)
