"""The contacts of Hertz: a sphere and an ellipsoid on a half-space of contact modulus E*.

A sphere of radius R carries the force F on a contact of radius a with the largest pressure p0. Johnson, K. L.
(1985), Contact Mechanics.
"""

import numpy as np


def hertz(force: float, radius: float, contact_modulus: float) -> dict[str, float]:
    """Return contact radius, largest pressure, approach and energy of a sphere under a force.

    a³ = 3FR/(4E*), p0 = 2E*a/(πR), δ = a²/R, U = (8/15) E* √R δ^(5/2); Johnson (1985), eqs. (4.22)-(4.24).

    `force` in N; `radius` in m; `contact_modulus` in Pa. Returns `contact_radius` (a, m), `max_pressure` (p0,
    Pa), `approach` (δ, m), `energy` (U, J).

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

    `force` in N; `radii` in m; `contact_modulus` in Pa. Returns `major` (a, m), `minor` (b, m),
    `max_pressure` (p0, Pa), `approach` (δ, m).

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
