"""A feasible pressure and what one application of the operator tells of it."""

from dataclasses import dataclass

import numpy as np

from roughcontact.kernels.array_api import mean
from roughcontact.kernels.arrays import Array, in_precision, precision_of


@dataclass(frozen=True)
class State:
    """A pressure 0 <= p <= cap of the prescribed mean and its separation G p - H.

    Attributes
    ----------
    pressure, separation : array (ny, nx)
        dimensionless.
    offset : float
        mean separation over the free contact {0 < p < cap}: the gap is the separation less that.
    norm : float
        ||p||_G.
    size : float
        scale of rounding: the root mean square of G p plus that of H.
    """

    pressure: Array
    separation: Array
    offset: float
    norm: float
    size: float

    @property
    def gap(self) -> Array:
        """The separation less the offset."""
        return self.separation - self.offset


def contact_mean(pressure: Array, separation: Array, *, cap: float) -> float:
    """Return the mean separation over the free contact {0 < p < cap}.

    Where every point in contact has reached the cap, any offset between the separations of the points at the
    cap and of those without pressure will do: the middle.

    Parameters
    ----------
    pressure, separation : array (ny, nx)
        dimensionless.
    cap : float
        largest pressure allowed.

    Returns
    -------
    float
    """
    xp = pressure.__array_namespace__()
    free = (pressure > 0) & (pressure < cap)
    if xp.any(free):
        return mean(separation[free])
    full = pressure >= cap
    if xp.all(full):
        return float(xp.max(separation))
    return 0.5 * (float(xp.max(separation[full])) + float(xp.min(separation[~full])))


def scale_to_load(
    pressure: Array, mean_pressure: float, *, cap: float = np.inf, precision: str | None = None
) -> Array:
    """Return max(pressure, 0) x factor, at most `cap`, with the factor that gives the prescribed mean.

    Without a cap that is one multiplication. With one, points at the cap stay there, the others are scaled,
    and those that the factor takes beyond the cap are held in turn, which ends after finitely many passes.
    A change of precision rounds the cap: what was at the cap before it is at the cap after it.

    Parameters
    ----------
    pressure : array (ny, nx)
        dimensionless.
    mean_pressure : float
        to be reached.
    cap : float
        largest pressure allowed.
    precision : str, optional
        of the result, where it is another one.

    Returns
    -------
    array (ny, nx)

    Raises
    ------
    ValueError
        for a mean pressure that is not below the cap.
    """
    xp = pressure.__array_namespace__()
    positive = xp.clip(in_precision(pressure, precision or precision_of(pressure), copy=False), 0, None)
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


def norm(left: Array, right: Array) -> float:
    """Return the root of the mean of left x right, a quadratic form that rounding may turn negative.

    Parameters
    ----------
    left, right : array (ny, nx)
        a field and what the operator makes of it.

    Returns
    -------
    float
    """
    return float(np.sqrt(max(mean_product(left, right), 0.0)))


def mean_product(left: Array, right: Array) -> float:
    """Return the mean over the grid of left x right, summed in double precision.

    Parameters
    ----------
    left, right : array (ny, nx)
        of one array library.

    Returns
    -------
    float
    """
    return mean(left * right)
