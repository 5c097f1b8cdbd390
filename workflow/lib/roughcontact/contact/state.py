"""A feasible pressure, what one application of the operator tells of it, and the way between two of them."""

from dataclasses import dataclass, replace

import numpy as np

from roughcontact.kernels.array_api import mean


@dataclass(frozen=True)
class State:
    """A pressure 0 <= p <= cap of the prescribed mean, shape (ny, nx), and its separation G p - H.

    The gap is the separation less `level`, which makes the mean gap over the free contact {0 < p < cap} zero.
    `norm` = ||p||_G; `size`, the scale of rounding, is the root mean square of G p plus that of H.
    """

    pressure: np.ndarray
    separation: np.ndarray
    level: float
    norm: float
    size: float

    @property
    def gap(self):
        return self.separation - self.level


@dataclass(frozen=True)
class Way:
    """The elastic energy along the straight way from one state to another of equal load.

    E(p) = <p, G p>/2 - <p, H> is quadratic along s = p' - p: it changes by t <s, v> + t^2 <s, v' - v>/2, with
    the separations v = G p - H. `slope` = <s, v> and `slope_after` = <s, v'> are means over the grid.
    """

    slope: float
    slope_after: float

    @property
    def least(self) -> float:
        """The share t of the way at which the energy is least; it may lie beyond the end."""
        curvature = self.slope_after - self.slope
        return -self.slope / curvature if curvature > 0 else np.inf

    @property
    def falls(self) -> bool:
        return self.slope + self.slope_after < 0


def between(before: State, after: State, way: Way, *, cap: float) -> State | None:
    """Return the state of least energy on the way; None where the energy rises from the start.

    Both states are linear in the share, so that no application of the operator is needed.
    """
    if way.slope >= 0:
        return None
    share = way.least
    pressure = before.pressure + share * (after.pressure - before.pressure)
    separation = before.separation + share * (after.separation - before.separation)
    square = (1 - share) * before.norm**2 + share * after.norm**2
    square -= share * (1 - share) * (way.slope_after - way.slope)
    return replace(
        after,
        pressure=pressure,
        separation=separation,
        level=contact_mean(pressure, separation, cap=cap),
        norm=float(np.sqrt(max(square, 0))),
    )


def contact_mean(pressure, separation, *, cap: float) -> float:
    """Return the mean separation over the free contact {0 < p < cap}.

    Where every point in contact has reached the cap, any level between the separations of the points at the
    cap and of those without pressure will do: the middle.
    """
    xp = pressure.__array_namespace__()
    free = (pressure > 0) & (pressure < cap)
    if xp.any(free):
        return mean(separation[free])
    full = pressure >= cap
    if xp.all(full):
        return float(xp.max(separation))
    return 0.5 * (float(xp.max(separation[full])) + float(xp.min(separation[~full])))


def scale_to_load(pressure, mean_pressure: float, *, cap: float = np.inf):
    """Return max(pressure, 0) x factor, at most `cap`, with the factor that gives the prescribed mean.

    Without a cap that is one multiplication. With one, points at the cap stay there, the others are scaled,
    and those that the factor takes beyond the cap are held in turn, which ends after finitely many passes.
    """
    xp = pressure.__array_namespace__()
    positive = xp.clip(pressure, 0, None)
    total = mean_pressure * pressure.size
    load = float(xp.sum(positive, dtype=xp.float64))
    if cap == np.inf:
        positive *= total / load
        return positive
    if mean_pressure >= cap:
        raise ValueError(f"a mean pressure of {mean_pressure:g} cannot be carried below the cap {cap:g}")
    held = pressure >= cap
    if mean_pressure * pressure.size < cap * int(xp.count_nonzero(held)):
        held = pressure > np.inf  # nowhere: there is more than the load, all must give way
    while True:
        missing = total - cap * int(xp.count_nonzero(held))
        rest = float(xp.sum(positive[~held], dtype=xp.float64))
        if rest > 0:
            scaled = positive * (missing / rest)
        else:  # all that carried something is at the cap: the others share what is missing
            scaled = xp.full_like(positive, missing / int(xp.count_nonzero(~held)))
        beyond = (scaled > cap) & ~held
        if rest == 0 or not xp.any(beyond):
            return xp.where(held, xp.full_like(positive, cap), scaled)
        held |= beyond


def norm(left, right) -> float:
    """Return the root of the mean of left x right, a quadratic form that rounding may turn negative."""
    return float(np.sqrt(max(mean_product(left, right), 0.0)))


def mean_product(left, right) -> float:
    """Return the mean over the grid of left x right, summed in double precision."""
    return mean(left * right)
