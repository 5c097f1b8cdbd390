"""Closed forms of smooth contacts: Westergaard's wave h = D cos(2πx/λ), and the sphere of Hertz.

The surface is rigid, its heights are positive outwards; the half-space has the contact modulus E*. A wave has
the amplitude D and the wavelength λ; r is the mean pressure over the pressure p* that just closes it. A
sphere of radius R carries the force F on a contact of radius a with the largest pressure p0.

References
----------
- Johnson, K. L. (1985), Contact Mechanics.
- Westergaard, H. M. (1939), J. Appl. Mech. 6, A49.
"""

import numpy as np
import numpy.typing as npt


def westergaard_full_contact_pressure(amplitude: float, wavelength: float, contact_modulus: float) -> float:
    """Return the mean pressure that just closes the wave D cos(2πx/λ): p* = π E* D/λ.

    Westergaard (1939); Johnson (1985), section 13.2.

    Parameters
    ----------
    amplitude, wavelength : float, m
    contact_modulus : float, Pa

    Returns
    -------
    float, Pa

    Examples
    --------
    >>> print(f"{westergaard_full_contact_pressure(1e-6, 1e-4, 1e9):.4g} Pa")
    3.142e+07 Pa
    """
    return np.pi * contact_modulus * amplitude / wavelength


def westergaard_contact_share(load_ratio: npt.ArrayLike) -> np.ndarray:
    """Return the share of the wave in contact, (2/π) asin √r.

    Westergaard (1939); Johnson (1985), section 13.2.

    Parameters
    ----------
    load_ratio : float or array
        r = p̄/p*; from 1 on the share is 1.

    Returns
    -------
    float or array of the shape of `load_ratio`, 0 to 1

    Examples
    --------
    >>> print(np.round(westergaard_contact_share([0.0, 0.5, 1.0, 2.0]), 6))
    [0.  0.5 1.  1. ]
    """
    return 2 / np.pi * np.arcsin(np.sqrt(np.clip(load_ratio, 0, 1)))


def westergaard_pressure(
    x: npt.ArrayLike, wavelength: float, mean_pressure: float, load_ratio: float
) -> np.ndarray:
    """Return the pressure under the wave D cos(2πx/λ), crest at x = 0.

    p = (2p̄/r) cos ψ √(r - sin²ψ), ψ = πx/λ, where sin²ψ < r; from r = 1 on the wave is closed and
    p = p̄ + p* cos(2πx/λ). Westergaard (1939); Johnson (1985), section 13.2.

    Parameters
    ----------
    x : array, m
    wavelength : float, m
    mean_pressure : float, Pa
        p̄.
    load_ratio : float
        r = p̄/p*, greater than 0.

    Returns
    -------
    array of the shape of `x`, Pa

    Examples
    --------
    >>> print(np.round(westergaard_pressure([0.0, 0.25, 0.5], 1.0, 1.0, 1.0), 6))
    [2. 1. 0.]
    """
    phase = np.pi * np.asarray(x, float) / wavelength
    if load_ratio >= 1:
        return mean_pressure * (1 + np.cos(2 * phase) / load_ratio)
    inside = np.clip(load_ratio - np.sin(phase) ** 2, 0, None)
    return 2 * mean_pressure / load_ratio * np.abs(np.cos(phase)) * np.sqrt(inside)


def westergaard_gap(x: npt.ArrayLike, wavelength: float, amplitude: float, load_ratio: float) -> np.ndarray:
    """Return the gap over the wave D cos(2πx/λ), crest at x = 0.

    gap = 2D [s √(s² - r) - r ln((s + √(s² - r))/√r)], s = |sin(πx/λ)|, where s² > r, 0 elsewhere: the
    integral of the conjugate function of the stress function of Westergaard (1939) from the edge of the
    contact. Its mean is `westergaard_mean_gap`; at r = 0 it is D - h.

    Parameters
    ----------
    x : array, m
    wavelength, amplitude : float, m
    load_ratio : float
        r = p̄/p*.

    Returns
    -------
    array of the shape of `x`, m

    Examples
    --------
    >>> print(np.round(westergaard_gap([0.0, 0.25, 0.5], 1.0, 1.0, 0.0), 6))
    [0. 1. 2.]
    """
    s = np.abs(np.sin(np.pi * np.asarray(x, float) / wavelength))
    root = np.sqrt(np.clip(s**2 - load_ratio, 0, None))
    if load_ratio == 0:
        return 2 * amplitude * s**2
    outside = s**2 > load_ratio
    logarithm = np.log(np.where(outside, (s + root) / np.sqrt(load_ratio), 1.0))
    return 2 * amplitude * (s * root - load_ratio * logarithm)


def westergaard_mean_gap(amplitude: float, load_ratio: npt.ArrayLike) -> np.ndarray:
    """Return the mean gap over the wave: ū = D (1 - r + r ln r).

    It follows from `westergaard_energy` by dU/dū = -p̄; Johnson (1985), section 13.2.

    Parameters
    ----------
    amplitude : float, m
    load_ratio : float or array
        r = p̄/p*; from 1 on the gap is 0.

    Returns
    -------
    float or array of the shape of `load_ratio`, m

    Examples
    --------
    >>> print(np.round(westergaard_mean_gap(1.0, [0.0, 0.1, 1.0]), 4))
    [1.     0.6697 0.    ]
    """
    r = np.clip(np.asarray(load_ratio, float), 0, 1)
    logarithm = np.log(np.where(r > 0, r, 1.0))
    return amplitude * (1 - r + r * logarithm)


def hertz(force: float, radius: float, contact_modulus: float) -> dict[str, float]:
    """Return contact radius, largest pressure, approach and energy of a sphere under a force.

    a³ = 3FR/(4E*), p0 = 2E*a/(πR), δ = a²/R, U = (8/15) E* √R δ^(5/2); Johnson (1985), eqs. (4.22)-(4.24).

    Parameters
    ----------
    force : float, N
    radius : float, m
    contact_modulus : float, Pa

    Returns
    -------
    dict of float
        `contact_radius` (a, m), `max_pressure` (p0, Pa), `approach` (δ, m), `energy` (U, J).

    Examples
    --------
    >>> {name: round(float(value), 4) for name, value in hertz(4 / 3, 1.0, 1.0).items()}
    {'contact_radius': 1.0, 'max_pressure': 0.6366, 'approach': 1.0, 'energy': 0.5333}
    """
    a = (3 * force * radius / (4 * contact_modulus)) ** (1 / 3)
    approach = a**2 / radius
    return {
        "contact_radius": a,
        "max_pressure": 2 * contact_modulus * a / (np.pi * radius),
        "approach": approach,
        "energy": 8 / 15 * contact_modulus * np.sqrt(radius) * approach**2.5,
    }


def hertz_ellipse(force: float, radii: tuple[float, float], contact_modulus: float) -> dict[str, float]:
    """Return semi-axes, largest pressure and approach of a body with two radii of curvature under a force.

    Johnson (1985), eqs. (4.25) to (4.28), solved for the ratio of the axes: elliptic integrals K, E of
    m = 1 - (b/a)². The major axis lies along the direction of the larger radius.

    Parameters
    ----------
    force : float, N
    radii : (float, float), m
    contact_modulus : float, Pa

    Returns
    -------
    dict of float
        `major` (a, m), `minor` (b, m), `max_pressure` (p0, Pa), `approach` (δ, m).

    Examples
    --------
    >>> ball, ellipse = hertz(1.0, 1e-2, 1e9), hertz_ellipse(1.0, (1e-2, 1.0000001e-2), 1e9)
    >>> [f"{ellipse[name] / ball[name]:.4f}" for name in ("max_pressure", "approach")]
    ['1.0000', '1.0000']
    """
    from scipy.optimize import brentq  # these imports take longer than a small contact
    from scipy.special import ellipe, ellipk

    larger, smaller = max(radii), min(radii)
    if larger / smaller - 1 < 1e-6:  # the elliptic integrals differ by rounding
        ball = hertz(force, larger, contact_modulus)
        return ball | {"major": ball["contact_radius"], "minor": ball["contact_radius"]}

    def curvature_ratio(m: float) -> float:
        """Return the ratio of the curvatures whose ellipse of contact has the parameter m."""
        k, e = ellipk(m), ellipe(m)
        return float((e / (1 - m) - k) / (k - e))

    m = brentq(lambda m: curvature_ratio(m) - larger / smaller, 1e-9, 1 - 1e-12, xtol=1e-15)
    k, e = float(ellipk(m)), float(ellipe(m))
    # 1/(2 R) of the larger radius is p0 b (K - E)/(E* m a²), with p0 = 3 F/(2 pi a b)
    major = (3 * force * larger * (k - e) / (np.pi * contact_modulus * m)) ** (1 / 3)
    minor = major * (1 - m) ** 0.5
    pressure = 3 * force / (2 * np.pi * major * minor)
    approach = pressure * minor * k / contact_modulus
    return {"major": major, "minor": minor, "max_pressure": pressure, "approach": approach}
