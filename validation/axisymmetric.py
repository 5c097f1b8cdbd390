"""Contact of a body of revolution whose pressure ends at the hardness, by rings of uniform pressure.

Neither a grid nor a Fourier transform is shared with the solver: the displacement of a ring is that of two
discs, in elliptic integrals, and the load is found by its approach.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from validation.closed_forms import LATTICE_CUBES


class Rings(NamedTuple):
    """Rings between radii (n + 1,): mid radii (n,), displacement per pressure (n, n), E* = 1, areas (n,)."""

    radius: np.ndarray
    displacement: np.ndarray
    area: np.ndarray


class RingContact(NamedTuple):
    """Approach, and pressure and depth of plastic flow (n,) of each ring."""

    approach: float
    pressure: np.ndarray
    depth: np.ndarray


def rings(edges: np.ndarray) -> Rings:
    """Return rings between the radii `edges`, from 0 on.

    Examples
    --------
    >>> fine = rings(np.linspace(0, 1, 101))
    >>> print(f"{(fine.displacement @ np.ones(100))[0]:.3f}")  # the middle of a disc: 2 p b/E*
    2.000
    """
    radius = (edges[1:] + edges[:-1]) / 2
    discs = np.transpose([_disc(radius, edge) for edge in edges[1:]])
    return Rings(radius, np.diff(discs, axis=1, prepend=0), np.pi * np.diff(edges**2))


def _disc(r: np.ndarray, edge: float) -> np.ndarray:
    """Return the displacement at r of a unit pressure within `edge`: Johnson (1985), eq. (3.29), E* = 1."""
    k = (np.minimum(r, edge) / np.maximum(r, edge)) ** 2
    outside = r * (ellipe(k) - (1 - k) * ellipk(k))
    return np.where(r < edge, edge * ellipe(k), outside) * 4 / np.pi


def ring_contact(
    body: Rings, height: np.ndarray, force: float, *, hardness: float = np.inf, period: float = np.inf
) -> RingContact:
    """Return the contact of `height` (n,) with a rigid flat at E* = 1, no pressure above the hardness.

    With a `period` the contact is repeated on a square lattice, whose other contacts act as in
    `periodic_hertz`: c (r^2 + the mean square radius of the pressure), c = 9.0336 F/(4 pi E* L^3),
    and a shift that is left out.
    """
    neighbours = LATTICE_CUBES * force / (4 * np.pi * period**3)
    height = height - neighbours * body.radius**2
    lowest = -float(height.max())

    def excess(approach: float) -> float:
        return float(body.area @ _pressure(body, height + approach, hardness)) - force

    highest = lowest + 1e-6
    while excess(highest) < 0:
        highest = lowest + 2 * (highest - lowest)
    approach = float(brentq(excess, lowest, highest, xtol=1e-15, rtol=1e-14))
    pressure = _pressure(body, height + approach, hardness)
    overlap = height + approach - body.displacement @ pressure
    spread = float(body.area * pressure @ body.radius**2) / force
    return RingContact(
        approach + neighbours * spread, pressure, np.where(pressure >= hardness, np.maximum(overlap, 0), 0)
    )


def _pressure(body: Rings, indentation: np.ndarray, hardness: float) -> np.ndarray:
    """Return the pressures that give the indentation where they lie between 0 and the hardness."""
    elastic, flowing = indentation > 0, np.zeros(len(indentation), dtype=bool)
    for _ in range(1000):
        pressure = np.where(flowing, hardness, 0.0) if flowing.any() else np.zeros(len(indentation))
        rest = (indentation - body.displacement @ pressure)[elastic]
        pressure[elastic] = np.linalg.solve(body.displacement[np.ix_(elastic, elastic)], rest)
        gap = body.displacement @ pressure - indentation
        rounding = 1e-12 * np.abs(indentation).max()
        now_flowing = np.where(flowing, gap <= rounding, elastic & (pressure > hardness))
        touching = np.where(elastic, pressure >= 0, gap < -rounding) | flowing
        if np.array_equal(now_flowing, flowing) and np.array_equal(touching & ~now_flowing, elastic):
            return pressure
        elastic, flowing = touching & ~now_flowing, now_flowing
    raise ArithmeticError("the pressures of the rings do not settle")
