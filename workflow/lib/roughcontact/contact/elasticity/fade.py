"""How a response in free space is cut off beyond the contact, and the quadratures of its waves."""

import numpy as np

FADE = 1.15  # distance where a response vanishes over the distance up to which it is exact
_NODES = 16  # of Gauss and Legendre, on panels of at most so many radians


def smooth_fade(distance: np.ndarray, outer_radius: float) -> np.ndarray:
    """Return the polynomial that is 1 up to the distance 1 and 0 beyond the end, smooth between them."""
    fraction = np.clip((distance - 1) / (outer_radius - 1), 0, 1)
    # two derivatives vanish at both ends, so that its transform falls fast
    return np.asarray(1 - fraction**3 * (10 - 15 * fraction + 6 * fraction**2))


def graded_panels(upper: float, widest: float, finest: float) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of a quadrature (Gauss and Legendre) on panels that are halved towards 0."""
    points, weights = np.polynomial.legendre.leggauss(_NODES)
    halvings = upper * 0.5 ** np.arange(max(1.0, np.ceil(np.log2(upper / finest))))
    edges = np.union1d(np.linspace(0, upper, int(np.ceil(upper / widest)) + 1), halvings)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + points)).ravel(), (half * weights).ravel()
