"""Problems that several sections solve, with E* = 1 and a unit period: ridges, the product wave, a sphere."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import height_map, spacing
from roughcontact.contact.elasticity.energy import elastic_energy
from roughcontact.contact.elasticity.influence import HALF_SPACE
from roughcontact.contact.response import linear_response
from roughcontact.contact.solve import solve_contact
from roughcontact.statistics.contact_geometry import relative_contact_area
from validation import closed_forms

AMPLITUDE = 0.01  # of both waves, over their length
PHASE = (0.61, 0.37)  # of the crest between two points, along y and x: nothing falls on a point by chance
RIDGES_CLOSED = closed_forms.westergaard_full_contact_pressure(AMPLITUDE, 1.0, 1.0)  # p* of the ridges
WAVE_CLOSED = closed_forms.jgh_full_contact_pressure(AMPLITUDE, 1.0, 1.0)  # p* of the product wave
RADIUS, FORCE = 10.0, 1e-5  # of the sphere, over the period and E* times its area: a_H = 0.0422 periods


@dataclass(frozen=True)
class Solution:
    """A contact at one load: pressure and gap (y, x), mean displacement of the surfaces, pixel (y, x)."""

    pressure: np.ndarray
    gap: np.ndarray
    approach: float
    pixel: tuple[float, float]

    @property
    def touching(self) -> np.ndarray:
        """The points in contact."""
        return self.pressure > 0

    @property
    def area(self) -> float:
        """Relative contact area, corrected by the perimeter."""
        return relative_contact_area(self.touching)

    @property
    def mean_gap(self) -> float:
        """Mean gap over the whole map."""
        return self.gap[self.pressure == 0].sum() / self.gap.size

    @property
    def energy(self) -> float:
        """Elastic energy of one period."""
        return elastic_energy(self.pressure, self.pixel, HALF_SPACE)

    def compliance(self, tolerance: float) -> float:
        """Return -d(mean gap)/d(mean pressure) of this contact set."""
        return linear_response(self.touching, self.pixel, HALF_SPACE, tolerance)[0]


def solve(height: xr.DataArray, loads: Sequence[float], tolerance: float) -> list[Solution]:
    """Return the contact of a map at each mean pressure."""
    contact = solve_contact(height, contact_modulus=1.0, mean_pressure=loads, tolerance=tolerance)
    fields = (contact[name].values for name in ("pressure", "gap", "approach"))
    return [Solution(p, g, float(a), spacing(height)) for p, g, a in zip(*fields, strict=True)]


def ridge(points: int, phase: float = PHASE[1]) -> tuple[np.ndarray, xr.DataArray]:
    """Return one row of Westergaard's wave, with its crest `phase` points before the first one.

    Returns
    -------
    x : array (points)
        distance from the crest.
    height : DataArray (y, x)

    Examples
    --------
    >>> x, height = ridge(4, 0.0)
    >>> height.values.round(3)
    array([[ 0.01,  0.  , -0.01, -0.  ]])
    """
    x = (np.arange(points) + phase) / points
    return x, height_map(AMPLITUDE * np.cos(2 * np.pi * x)[None, :], 1 / points)


def solved_ridges(points: int, ratios: Sequence[float], tolerance: float = 1e-8) -> dict[float, Solution]:
    """Return the contact of a row of ridges by load over that of full contact, each solved by itself."""
    _, height = ridge(points)
    return {ratio: solve(height, [ratio * RIDGES_CLOSED], tolerance)[0] for ratio in ratios}


def product_wave(points: int, phase: tuple[float, float] = PHASE, *, waves: int = 1) -> xr.DataArray:
    """Return `waves` periods of the product wave each way, with its crest `phase` points before the first.

    Examples
    --------
    >>> product_wave(4, (0.0, 0.0)).values[:, 0].round(3)
    array([ 0.01,  0.  , -0.01, -0.  ])
    """
    y, x = ((np.arange(points) + shift) * waves / points for shift in phase)
    heights = AMPLITUDE * np.cos(2 * np.pi * y)[:, None] * np.cos(2 * np.pi * x)[None, :]
    return height_map(heights, waves / points)


def sphere(points: int) -> xr.DataArray:
    """Return the sphere in its period, as a paraboloid with a summit that lies on no point."""
    x = (np.arange(points) + 0.27) / points - 0.5
    return height_map(-(x[None, :] ** 2 + x[:, None] ** 2) / (2 * RADIUS), 1 / points)
