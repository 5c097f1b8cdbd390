"""Statistical theories of rough contact, to draw beside the deterministic result.

Each returns the relative contact area for a load p' = p̄/(E* g), g the root mean square gradient.
"""

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from roughcontact.contact.elasticity.closed_forms import hertz

# columns of the statistics: contact areas of endless half-spaces
AREAS = ("area_persson", "area_xu", "area_bush_gibson_thomas", "area_greenwood_williamson")
_BISECTIONS = 60  # halves a bracket of relative width 0.6 to rounding
_SEPARATIONS = np.linspace(-8.0, 12.0, 2001)  # plane above the mean summit, in standard deviations
_RINGS, _CONVERGED = 150, 1e-10  # of a rough ball after Greenwood and Tripp


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
    return np.where(area <= 1, area, np.nan)


def greenwood_williamson_curve(
    summits: dict[str, float], *, contact_modulus: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return mean pressure and contact area of independent equal spheres with Gaussian heights.

    With t the separation over the spread s of the summit heights, η their density, R the tip radius and
    F_n(t) = ∫_0^∞ uⁿ φ(t + u) du:  A = π η R s F_1(t),  p̄ = (4/3) E* η √R s^(3/2) F_{3/2}(t) [1]_.

    Parameters
    ----------
    summits : dict
        `density` (m-2), `mean_radius` (m), `height_std` (m), as `roughness.summits.summit_statistics`
        returns it.
    contact_modulus : float, Pa

    Returns
    -------
    mean_pressure : array (n), Pa
        rising.
    area : array (n)
        relative contact area, not limited to 1.

    References
    ----------
    .. [1] Greenwood and Williamson (1966), Proc. R. Soc. A 295, 300.

    Examples
    --------
    From 1 kPa to 2 MPa the mean pressure over the contact rises by a quarter.

    >>> summits = {"density": 2e9, "mean_radius": 4e-5, "height_std": 3e-7}
    >>> pressure, area = greenwood_williamson_curve(summits, contact_modulus=1e11)
    >>> [f"{pressure[i] / area[i]:.2g} Pa at {pressure[i]:.1g} Pa" for i in (800, 1000)]
    ['2.3e+09 Pa at 1e+03 Pa', '2.9e+09 Pa at 2e+06 Pa']
    """
    density, radius, spread = (summits[name] for name in ("density", "mean_radius", "height_std"))
    area = np.pi * density * radius * spread * _gaussian_moments(1.0)
    pressure = 4 / 3 * contact_modulus * density * np.sqrt(radius) * spread**1.5
    return pressure * _gaussian_moments(1.5), area


def greenwood_williamson_area(
    mean_pressure: ArrayLike, summits: dict[str, float], *, contact_modulus: float
) -> np.ndarray:
    """Return the relative contact area after Greenwood and Williamson [1]_ at the given mean pressures.

    Parameters
    ----------
    mean_pressure : array-like, Pa
    summits : dict
        as `roughness.summits.summit_statistics` returns it.
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
    if not (summits["height_std"] > 0 and summits["mean_radius"] > 0):
        return np.full(mean_pressure.shape, np.nan)
    pressure, area = greenwood_williamson_curve(summits, contact_modulus=contact_modulus)
    with np.errstate(divide="ignore"):
        load = np.log(mean_pressure)
    area_at_load = np.exp(np.interp(load, np.log(pressure), np.log(area), left=np.nan, right=np.nan))
    return np.where(area_at_load <= 1, area_at_load, np.nan)


def greenwood_tripp(
    force: float, radius: float, summits: dict[str, float], *, contact_modulus: float
) -> dict[str, float]:
    """Return the contact of a rough ball after Greenwood and Tripp [1]_: independent summits on a soft ball.

    The nominal pressure p(r) = (4/3) E* η √β s^(3/2) F_{3/2}(t) presses the summits, of density η, mean
    radius β and spread s, by the separation s t(r) = r²/(2R) - δ + w(r), w the displacement of the
    half-space under p. Rings of constant p, Powell's hybrid method.

    Parameters
    ----------
    force : float, N
    radius : float, m
        of the ball.
    summits : dict
        of the roughness without the ball, as `roughness.summits.summit_statistics` returns it.
    contact_modulus : float, Pa

    Returns
    -------
    dict
        `contact_area` (m2) of all summits, NaN beyond that of the loaded circle; `max_pressure` (Pa),
        nominal, in the middle; `loaded_radius` (m), (3/8) F/∫ p dr, which is that of the contact where p is
        Hertz's. NaN for a map without summits, or none above rounding.

    References
    ----------
    .. [1] Greenwood and Tripp (1967), J. Appl. Mech. 34, 153; Johnson (1985), Contact Mechanics, 13.5.

    Examples
    --------
    A spread of 5 % of Hertz's approach lowers the largest pressure by about 7 % (Johnson, μ = 4):

    >>> density = 4 / (8 / 3 * 0.05 * np.sqrt(2 * 1e-3))
    >>> summits = {"density": density, "mean_radius": 1e-3, "height_std": 0.05}
    >>> rough = greenwood_tripp(4 / 3, 1.0, summits, contact_modulus=1.0)
    >>> print(f"{rough['max_pressure'] / (2 / np.pi):.2f}")
    0.93
    """
    from scipy.optimize import root
    from scipy.special import ellipe, ellipk

    density, tip, spread = (summits[name] for name in ("density", "mean_radius", "height_std"))
    if not (spread > 0 and tip > 0):
        return dict.fromkeys(("contact_area", "max_pressure", "loaded_radius"), np.nan)
    smooth = hertz(force, radius, contact_modulus)
    reach = np.sqrt(1.5 * smooth["contact_radius"] ** 2 + 12 * radius * spread)
    edges = reach * np.linspace(0, 1, _RINGS + 1)
    r, areas = (edges[1:] + edges[:-1]) / 2, np.pi * np.diff(edges**2)
    larger = np.maximum(r[:, None], edges)
    m = (np.minimum(r[:, None], edges) / larger) ** 2
    discs = larger * (ellipe(m) - np.where(edges > r[:, None], 0.0, (1 - m) * ellipk(m)))
    influence = np.diff(4 / (np.pi * contact_modulus * spread) * discs, axis=1)
    scale = 4 / 3 * contact_modulus * density * np.sqrt(tip) * spread**1.5
    share = np.sqrt(np.maximum(1 - (r / smooth["contact_radius"]) ** 2, 1e-6))
    guess = smooth["max_pressure"] * (smooth["contact_radius"] / edges[-1]) ** 2 * share / scale
    separations = np.concatenate([-np.geomspace(1e6, 8, 400)[:-1], _SEPARATIONS])
    t = np.interp(-np.log(guess), -np.log(_moment(1.5, separations)), separations)
    bulk = r**2 / (2 * radius * spread)
    approach = bulk[0] + influence[0] @ (scale * _moment(1.5, t)) - t[0]

    def excess(solution: np.ndarray) -> np.ndarray:
        pressure = scale * _moment(1.5, solution[:-1])
        balance = solution[:-1] - bulk + solution[-1] - influence @ pressure
        return np.append(balance, areas @ pressure / force - 1)

    def jacobian(solution: np.ndarray) -> np.ndarray:
        slope = 1.5 * scale * _moment(0.5, solution[:-1])
        rings = np.hstack([np.eye(_RINGS) + influence * slope, np.ones((_RINGS, 1))])
        return np.vstack([rings, np.append(-areas * slope / force, 0.0)])

    solution = root(excess, np.append(t, approach), jac=jacobian, tol=_CONVERGED)
    # it does not converge where rounding hides the summits
    t = np.where(solution.success, solution.x[:-1], np.nan)
    pressure = scale * _moment(1.5, t)
    loaded_radius = float(3 * force / (8 * (pressure @ np.diff(edges))))
    area = float(np.pi * density * tip * spread * (areas @ _moment(1.0, t)))
    return {
        "contact_area": area if area <= np.pi * loaded_radius**2 else np.nan,
        "max_pressure": float(pressure[0]),
        "loaded_radius": loaded_radius,
    }


def _moment(order: float, t: np.ndarray) -> np.ndarray:
    """Return F_n(t) by the table of `_gaussian_moments`, below it by two terms of its asymptotic series."""
    table = np.log(_gaussian_moments(order)[::-1])
    deep = np.minimum(t, _SEPARATIONS[0])
    below = (-deep) ** order * (1 + order * (order - 1) / (2 * deep**2))
    return np.where(t < _SEPARATIONS[0], below, np.exp(np.interp(t, _SEPARATIONS, table)))


@cache
def _gaussian_moments(order: float) -> np.ndarray:
    """Return F_n(t) = ∫_0^∞ uⁿ φ(t + u) du for all separations, the largest first, once for all surfaces.

    By Gauss-Legendre over the part that matters. With u = v² the integrand is smooth at 0 for half-integer n
    as well.
    """
    nodes, weights = np.polynomial.legendre.leggauss(200)
    # for t >= 0 the integrand falls like exp(-t u - u²/2); beyond `reach` it is below exp(-72) of its value
    # at 0
    t = _SEPARATIONS[::-1, None]
    reach = np.sqrt(-t + np.sqrt(t**2 + 144.0))
    v = reach / 2 * (nodes + 1)
    integrand = 2 * v ** (2 * order + 1) * np.exp(-((t + v**2) ** 2) / 2) / np.sqrt(2 * np.pi)
    moments = (reach[:, 0] / 2) * (integrand @ weights)
    moments.setflags(write=False)
    return moments
