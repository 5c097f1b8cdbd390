"""The contacts of Hertz: a sphere and an ellipsoid on a half-space of contact modulus E*.

A sphere of radius R carries the force F on a contact of radius a with the largest pressure p0. Johnson, K. L.
(1985), Contact Mechanics.
"""

from collections.abc import Sequence

import numpy as np


def hertz(force: float, radius: float, contact_modulus: float) -> dict[str, float]:
    """Return contact radius a (m), pressure p0 (Pa), approach δ (m) and energy U (J) of a sphere (N, m, Pa).

    a³ = 3FR/(4E*), p0 = 2E*a/(πR), δ = a²/R, U = (8/15) E* √R δ^(5/2); Johnson (1985), eqs. (4.22)-(4.24).
    """
    a = (3 * force * radius / (4 * contact_modulus)) ** (1 / 3)
    approach = a**2 / radius
    return {
        "contact_radius": a,
        "max_pressure": 2 * contact_modulus * a / (np.pi * radius),
        "approach": approach,
        "energy": 8 / 15 * contact_modulus * np.sqrt(radius) * approach**2.5,
    }


def hertz_ellipse(force: float, radii: Sequence[float], contact_modulus: float) -> dict[str, float]:
    """Return semi-axes (m), largest pressure (Pa) and approach (m) of a body of radii along x and y (N, m).

    Johnson (1985), eqs. (4.25) to (4.28), solved for the ratio of the axes; the major axis is that of the
    larger radius. One radius is that of a ball.
    """
    from scipy.optimize import brentq  # these imports take longer than a small contact
    from scipy.special import ellipe, ellipkm1

    larger, smaller = max(radii), min(radii)
    if larger / smaller - 1 < 1e-6:  # the elliptic integrals differ by rounding
        ball = hertz(force, larger, contact_modulus)
        return ball | dict.fromkeys(("major", "minor", "axis_x", "axis_y"), ball["contact_radius"])

    def excess(logarithm: float) -> float:
        """Return ln of the ratio of the curvatures for ln (minor/major)^2, less that of the body."""
        argument = np.exp(logarithm)
        k, e = ellipkm1(argument), ellipe(1 - argument)
        return float(np.log((e / argument - k) / (k - e)) - np.log(larger / smaller))

    # from the slimmest ellipse that a double holds to nearly a circle
    square = np.exp(brentq(excess, -690, -1e-9, xtol=1e-15))
    m, k, e = 1 - square, float(ellipkm1(square)), float(ellipe(1 - square))
    # 1/(2 R) of the larger radius is p0 b (K - E)/(E* m a²), with p0 = 3 F/(2 pi a b)
    major = (3 * force * larger * (k - e) / (np.pi * contact_modulus * m)) ** (1 / 3)
    minor = major * square**0.5
    pressure = 3 * force / (2 * np.pi * major * minor)
    approach = pressure * minor * k / contact_modulus
    x, y = (major, minor) if radii[0] == larger else (minor, major)
    axes = {"major": major, "minor": minor, "axis_x": x, "axis_y": y}
    return axes | {"max_pressure": pressure, "approach": approach}
