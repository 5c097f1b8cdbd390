"""Statistical theories of rough contact, to draw beside the deterministic result.

Each returns the relative contact area for a load p' = p̄/(E* g), g the root mean square gradient.
"""

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

# columns of the statistics: contact areas of endless half-spaces
AREAS = ("area_persson", "area_xu", "area_bush_gibson_thomas", "area_greenwood_williamson")
_BISECTIONS = 60  # halves a bracket of relative width 0.6 to rounding
SEPARATIONS = np.linspace(-8.0, 12.0, 2001)  # plane above the mean summit, in standard deviations


def persson_area(relative_pressure: ArrayLike) -> np.ndarray:
    """Return the relative contact area after Persson, A = erf(√2 p').

    The pressure variance is that of full contact, (E* g/2)²; the slope at low load is √(8/π) [1]_.

    Parameters
    ----------
    relative_pressure : array-like
        p' = p̄/(E* g).

    Returns
    -------
    array, of the shape of `relative_pressure`

    References
    ----------
    .. [1] Persson (2001), J. Chem. Phys. 115, 3840.

    Examples
    --------
    >>> persson_area([0.05, 0.2, 1.0]).round(3)
    array([0.08 , 0.311, 0.954])
    """
    from scipy.special import erf

    return erf(np.sqrt(2) * np.asarray(relative_pressure, float))


def xu_area(relative_pressure: ArrayLike) -> np.ndarray:
    """Return the relative contact area after Xu et al., A = erf(√2 p'/√(0.42 + 0.58 A)).

    Persson's result with the pressure variance V = (E* g/2)² of full contact reduced to (0.42 + 0.58 A) V
    [1]_. The right side falls with A, so there is one root, between erf(√2 p') and erf(√2 p'/√0.42): found by
    bisection.

    Parameters
    ----------
    relative_pressure : array-like
        p' = p̄/(E* g).

    Returns
    -------
    array, of the shape of `relative_pressure`

    References
    ----------
    .. [1] Xu, Li, Chen and Zhou (2024), Int. J. Solids Struct., 112684.

    Examples
    --------
    >>> xu_area([0.05, 0.2, 1.0]).round(3)
    array([0.114, 0.382, 0.957])
    """
    from scipy.special import erf

    load = np.sqrt(2) * np.asarray(relative_pressure, float)
    low, high = erf(load), erf(load / np.sqrt(0.42))
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        # the area is on both sides: bisected between its bounds with A = 1 and A = 0
        above = erf(load / np.sqrt(0.42 + 0.58 * middle)) > middle
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return (low + high) / 2


def bush_gibson_thomas_area(relative_pressure: ArrayLike) -> np.ndarray:
    """Return the relative contact area after Bush, Gibson and Thomas at low load, A = √(2π) p'.

    This is the asymptote of isotropic surfaces for large separation [1]_.

    Parameters
    ----------
    relative_pressure : array-like
        p' = p̄/(E* g).

    Returns
    -------
    array, of the shape of `relative_pressure`
        NaN where the asymptote exceeds 1 and means nothing.

    References
    ----------
    .. [1] Bush, Gibson and Thomas (1975), Wear 35, 87.

    Examples
    --------
    >>> bush_gibson_thomas_area([0.05, 0.2, 1.0]).round(3)
    array([0.125, 0.501,   nan])
    """
    area = np.sqrt(2 * np.pi) * np.asarray(relative_pressure, float)
    return np.where(area <= 1, area, np.nan)  # beyond full contact the theory means nothing


def greenwood_williamson_area(
    mean_pressure: ArrayLike, summits: dict[str, float], *, contact_modulus: float
) -> np.ndarray:
    """Return the relative contact area of independent equal spheres with Gaussian heights [1]_.

    With t the separation over the spread s of the summit heights, η their density, R the tip radius and
    F_n(t) = ∫_0^∞ uⁿ φ(t + u) du:  A = π η R s F_1(t),  p̄ = (4/3) E* η √R s^(3/2) F_{3/2}(t).

    Parameters
    ----------
    mean_pressure : array-like, Pa
    summits : dict
        `density` (m-2), `mean_radius` (m), `height_std` (m), as `roughness.summits.summit_statistics`
        returns it.
    contact_modulus : float, Pa

    Returns
    -------
    array, of the shape of `mean_pressure`
        NaN where the map has no spread of summit heights (no summit, one, or all equally high), and where the
        area would exceed 1, which the theory does not know to avoid.

    References
    ----------
    .. [1] Greenwood and Williamson (1966), Proc. R. Soc. A 295, 300.

    Examples
    --------
    >>> summits = {"density": 2e9, "mean_radius": 4e-5, "height_std": 3e-7}
    >>> greenwood_williamson_area([1e6, 1e7, 1e9], summits, contact_modulus=1e11).round(5)
    array([0.00036, 0.00316, 0.16895])
    """
    mean_pressure = np.asarray(mean_pressure, float)
    density, radius, spread = (summits[name] for name in ("density", "mean_radius", "height_std"))
    if not (spread > 0 and radius > 0):
        return np.full(mean_pressure.shape, np.nan)
    area = np.pi * density * radius * spread * _gaussian_moments(1.0)
    pressure = 4 / 3 * contact_modulus * density * np.sqrt(radius) * spread**1.5 * _gaussian_moments(1.5)
    with np.errstate(divide="ignore"):
        load = np.log(mean_pressure)
    # in logarithms both curves are nearly straight; no extrapolation
    area_at_load = np.exp(np.interp(load, np.log(pressure), np.log(area), left=np.nan, right=np.nan))
    return np.where(area_at_load <= 1, area_at_load, np.nan)


def summit_moment(order: float, t: np.ndarray) -> np.ndarray:
    """Return F_n(t) = ∫_0^∞ uⁿ φ(t + u) du, the mean of (z − t)ⁿ over Gaussian summits z above t.

    It is interpolated in a table, below which two terms of its asymptotic series hold.

    Parameters
    ----------
    order : float
        n, at least 0.
    t : ndarray
        Separation over the standard deviation of the summits.

    Returns
    -------
    ndarray
        F_n(t) of Greenwood and Tripp (1971), of the shape of `t`.
    """
    table = np.log(_gaussian_moments(order)[::-1])
    # far below the summits the moment is that of their mean and variance
    deep = np.minimum(t, SEPARATIONS[0])
    below = (-deep) ** order * (1 + order * (order - 1) / (2 * deep**2))
    return np.where(t < SEPARATIONS[0], below, np.exp(np.interp(t, SEPARATIONS, table)))


@cache
def _gaussian_moments(order: float) -> np.ndarray:
    """Return F_n(t) = ∫_0^∞ uⁿ φ(t + u) du for all separations, the largest first, once for all surfaces.

    By Gauss-Legendre over the part that matters. With u = v² the integrand is smooth at 0 for half-integer n
    as well.
    """
    nodes, weights = np.polynomial.legendre.leggauss(200)
    # for t >= 0 the integrand falls like exp(-t u - u²/2); beyond `reach` it is below exp(-72) of its value
    # at 0
    t = SEPARATIONS[::-1, None]
    reach = np.sqrt(-t + np.sqrt(t**2 + 144.0))
    v = reach / 2 * (nodes + 1)
    integrand = 2 * v ** (2 * order + 1) * np.exp(-((t + v**2) ** 2) / 2) / np.sqrt(2 * np.pi)
    moments = (reach[:, 0] / 2) * (integrand @ weights)
    moments.setflags(write=False)  # shared by all callers
    return moments
