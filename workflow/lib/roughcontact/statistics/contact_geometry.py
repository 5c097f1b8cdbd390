"""Area and perimeter of a contact set."""

import numpy as np

from roughcontact.arguments.maps import areal_only

# Share of a pixel by which each switch between contact and non-contact overstates the area: Yastrebov,
# Anciaux and Molinari (2017), Tribol. Int. 114, 161
PERIMETER_CORRECTION = (np.pi - 1 + np.log(2)) / 24


def count_switches(touching: np.ndarray, *, border: int = 0) -> tuple[int, int]:
    """Return the switches between contact and non-contact along all columns and all rows.

    Those at seams are included, but not of a map that ends at a `border` of one line.
    """
    # an axis of a single point has no unlike neighbours: a profile counts along its own axis alone
    unlike_y, unlike_x = (lines != np.roll(lines, 1, 0) for lines in (touching, touching.T))
    # a body that ends has no neighbour beyond its last line
    return int(np.count_nonzero(unlike_y[border:])), int(np.count_nonzero(unlike_x[border:]))


def relative_contact_area(touching: np.ndarray, *, border: int = 0) -> float:
    """Return the relative contact area, 0 to 1, corrected by the perimeter of the contact.

    A/A0 = Na/N - c M/N with c = (π - 1 + ln 2)/24 (Yastrebov, Anciaux and Molinari 2017, Tribol. Int. 114,
    161) and M switches between contact and non-contact along all rows and columns, whatever the pitch,
    but for the `border`, 0 or 1, of a map that ends there: the edge of a body is that of its pixels.
    """
    too_many = PERIMETER_CORRECTION * sum(count_switches(touching, border=border))
    return float((np.count_nonzero(touching) - too_many) / touching.size)


def point_area(shape: tuple[int, ...], steps: tuple[float, float]) -> float:
    """Return the area (m2) of a point; NaN for a profile, which has no width."""
    return steps[0] * steps[1] * areal_only(shape)


def contact_perimeter(touching: np.ndarray, steps: tuple[float, float]) -> float:
    """Return an estimate of the length (m) of the contact line; `steps` are (dy, dx) in m; NaN for a profile.

    The projections Py = M_x dy and Px = M_y dx of the pixel boundary are those of Cauchy and Crofton (Santaló
    1976, Integral Geometry and Geometric Probability, chapter 3), the estimate the perimeter of ellipses with
    them, semi-axes Px/4 and Py/4: exact for ellipses and ridges along the axes, 11 % long for straight lines
    at 45°.
    """
    from scipy.special import ellipe

    along_y, along_x = count_switches(touching)
    # an ellipse that is crossed as often along both axes has this perimeter
    minor, major = sorted((along_y * steps[1] / 4, along_x * steps[0] / 4))
    length = float(4 * major * ellipe(1 - (minor / major) ** 2)) if major > 0 else 0.0
    return length * areal_only(touching.shape)
