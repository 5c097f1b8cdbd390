"""Area, perimeter and clusters of a contact set."""

import numpy as np

# Share of a pixel by which each contact/non-contact switch overstates the area: Yastrebov, Anciaux and
# Molinari (2017), Tribol. Int. 114, 161
PERIMETER_CORRECTION = (np.pi - 1 + np.log(2)) / 24


def count_switches(touching: np.ndarray) -> tuple[int, int]:
    """Return (along y, along x) how often neighbours differ, the periodic wrap included.

    An axis of a single point has no neighbours along it, so a profile counts along its own axis alone.
    """
    return tuple(int(np.count_nonzero(touching != np.roll(touching, 1, axis))) for axis in (0, 1))


def relative_contact_area(touching: np.ndarray) -> float:
    """Return A/A0 = Na/N - c M/N, c = (π - 1 + ln 2)/24, the contact area corrected by its perimeter.

    The pixels of a solved contact overstate its area, in proportion to the length of its boundary. M counts
    the switches between contact and non-contact along all rows and columns. A switch along x is a piece of
    boundary as long as dy and overstates the area by c dx of it, so that it weighs c dx dy, as does one
    along y: the share needs no pitch. It is not allowed below zero.

    Parameters
    ----------
    touching : bool array (ny, nx)

    Source: Yastrebov, Anciaux and Molinari (2017), Tribol. Int. 114, 161.
    """
    corrected = np.count_nonzero(touching) - PERIMETER_CORRECTION * sum(count_switches(touching))
    return float(max(corrected, 0.0) / touching.size)


def contact_perimeter(touching: np.ndarray, steps: tuple[float, float]) -> float:
    """Return an estimate of the length of the contact line (m).

    The pixel boundary projects onto the axes with lengths Py = M_x dy and Px = M_y dx (Cauchy and Crofton),
    which do not suffer from its steps. The estimate is the perimeter of the ellipses with these
    projections, semi-axes Px/4 and Py/4: (π/4)(Px + Py) where the contact line has no preferred direction
    (Px = Py), Py alone for straight lines along y (ridges, profiles), and exact for ellipses along the
    axes. Straight lines at 45° come out 11 % long. The length of the steps themselves, the city-block
    length Px + Py, is 4/π too long for round contacts.

    Parameters
    ----------
    touching : bool array (ny, nx)
    steps : (dy, dx), m

    Source: Cauchy-Crofton formula (Santaló 1976, Integral Geometry and Geometric Probability, ch. 3).
    """
    from scipy.special import ellipe

    along_y, along_x = count_switches(touching)
    minor, major = sorted((along_y * steps[1] / 4, along_x * steps[0] / 4))
    return float(4 * major * ellipe(1 - (minor / major) ** 2)) if major > 0 else 0.0


def count_clusters(touching: np.ndarray) -> int:
    """Return the number of contact patches; pixels join over shared edges (not corners) and over the period.

    Parameters
    ----------
    touching : bool array (ny, nx)
    """
    from scipy.ndimage import label
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    labels, patches = label(touching)
    if patches < 2:
        return patches
    ends = np.concatenate([[labels[0], labels[-1]], [labels[:, 0], labels[:, -1]]], axis=1)
    first, last = ends[:, (ends > 0).all(axis=0)] - 1
    seams = coo_array((np.ones(first.size, bool), (first, last)), shape=(patches, patches))
    return int(connected_components(seams, directed=False)[0])
