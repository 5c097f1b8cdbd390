"""Statistical theories of rough contact, to draw beside the deterministic result.

Each returns the relative contact area for a load p' = p̄/(E* g): mean pressure over contact modulus times
root mean square gradient. They are estimates from a few numbers of the surface; the solver needs none of
them.
"""

import numpy as np

_BISECTIONS = 60  # halves a bracket of relative width 0.6 to rounding
_SEPARATIONS = np.linspace(-8.0, 12.0, 2001)  # plane above the mean summit, in standard deviations


def persson_area(relative_pressure):
    """Return the relative contact area A = erf(√2 p'); slope √(8/π) at low load.

    Parameters
    ----------
    relative_pressure : array-like
        p' = p̄/(E* g).

    Source: Persson (2001), J. Chem. Phys. 115, 3840, with the pressure variance (E* g/2)² of full contact.
    """
    from scipy.special import erf

    return erf(np.sqrt(2) * np.asarray(relative_pressure, float))


def xu_area(relative_pressure):
    """Return the relative contact area from A = erf(√2 p'/√(0.42 + 0.58 A)).

    Persson's result with the pressure variance V = (E* g/2)² of full contact reduced to (0.42 + 0.58 A) V.
    The right side falls with A, so there is one root, between erf(√2 p') and erf(√2 p'/√0.42): found by
    bisection.

    Parameters
    ----------
    relative_pressure : array-like
        p' = p̄/(E* g).

    Source: Xu, Li, Chen and Zhou (2024), Int. J. Solids Struct., 112684.
    """
    from scipy.special import erf

    load = np.sqrt(2) * np.asarray(relative_pressure, float)
    low, high = erf(load), erf(load / np.sqrt(0.42))
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        above = erf(load / np.sqrt(0.42 + 0.58 * middle)) > middle
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return (low + high) / 2


def bush_gibson_thomas_area(relative_pressure):
    """Return the low-load asymptote A = √(2π) p', NaN where it exceeds 1 and means nothing.

    Parameters
    ----------
    relative_pressure : array-like
        p' = p̄/(E* g).

    Source: Bush, Gibson and Thomas (1975), Wear 35, 87: asymptote for large separation, isotropic surfaces.
    """
    area = np.sqrt(2 * np.pi) * np.asarray(relative_pressure, float)
    return np.where(area <= 1, area, np.nan)


def greenwood_williamson_curve(summits: dict, *, contact_modulus):
    """Return (mean pressure in Pa, relative contact area) of independent equal spheres with Gaussian heights.

    With t the separation over the spread s of the summit heights, η their density, R the tip radius and
    F_n(t) = ∫_0^∞ uⁿ φ(t + u) du:  A = π η R s F_1(t),  p̄ = (4/3) E* η √R s^(3/2) F_{3/2}(t).

    Parameters
    ----------
    summits : dict
        `density` (m-2), `mean_radius` (m), `height_std` (m), as `roughness.summit_statistics` returns it.
    contact_modulus : float, Pa

    Returns
    -------
    two arrays, the mean pressure rising; the area is not limited to 1

    Source: Greenwood and Williamson (1966), Proc. R. Soc. A 295, 300.
    """
    density, radius, spread = (summits[name] for name in ("density", "mean_radius", "height_std"))
    separation = _SEPARATIONS[::-1]
    area = np.pi * density * radius * spread * _gaussian_moment(1.0, separation)
    pressure = 4 / 3 * contact_modulus * density * np.sqrt(radius) * spread**1.5
    return pressure * _gaussian_moment(1.5, separation), area


def greenwood_williamson_area(mean_pressure, summits: dict, *, contact_modulus):
    """Return the relative contact area of `greenwood_williamson_curve` at the given mean pressures.

    NaN where the map has no spread of summit heights (no summit, one, or all equally high), and where the
    area would exceed 1, which the theory does not know to avoid.

    Parameters
    ----------
    mean_pressure : array-like, Pa
    summits : dict
        As `roughness.summit_statistics` returns it.
    contact_modulus : float, Pa

    Source: Greenwood and Williamson (1966), Proc. R. Soc. A 295, 300.
    """
    mean_pressure = np.asarray(mean_pressure, float)
    if not (summits["height_std"] > 0 and summits["mean_radius"] > 0):
        return np.full(mean_pressure.shape, np.nan)
    pressure, area = greenwood_williamson_curve(summits, contact_modulus=contact_modulus)
    with np.errstate(divide="ignore"):
        load = np.log(mean_pressure)
    found = np.exp(np.interp(load, np.log(pressure), np.log(area), left=np.nan, right=np.nan))
    return np.where(found <= 1, found, np.nan)


def _gaussian_moment(order, separation):
    """Return F_n(t) = ∫_0^∞ uⁿ φ(t + u) du for an array of t, by Gauss-Legendre over the part that matters.

    With u = v² the integrand is smooth at 0 for half-integer n as well.
    """
    nodes, weights = np.polynomial.legendre.leggauss(200)
    # for t >= 0 the integrand falls like exp(-t u - u²/2); beyond `reach` it is below exp(-72) of its value
    # at 0
    t = np.asarray(separation, float)[:, None]
    reach = np.sqrt(-t + np.sqrt(t**2 + 144.0))
    v = reach / 2 * (nodes + 1)
    integrand = 2 * v ** (2 * order + 1) * np.exp(-((t + v**2) ** 2) / 2) / np.sqrt(2 * np.pi)
    return (reach[:, 0] / 2) * (integrand @ weights)
