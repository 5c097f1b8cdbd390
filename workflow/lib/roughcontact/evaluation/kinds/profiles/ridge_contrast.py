"""Profiles of a surface and of the surfaces drawn behind them, all pressed as ridges: a control variate.

What spectrum, heights and slopes do not hold of a surface changes the contact of its profiles as well, which
is known of the measured ones (Hammersley and Handscomb 1964, Monte Carlo Methods, section 5.5).
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import height_map, spacing
from roughcontact.surface.levelling.level import level
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.window.periodic_window import subwindow
from roughcontact.uncertainty.ensemble import solve_member
from roughcontact.uncertainty.scales import AREA, GAP, to_scale

COMPARED = (AREA, GAP)
LOADS = np.array([0.02, 0.1, 0.4])  # of the result, mean pressure over E* and the rms gradient
# at which ridges are solved: chance averages out between them, and heavier loads nearly close ridges
_RIDGE_LOADS = np.geomspace(0.02, 0.2, 4)
_ROWS = 6  # of each surface
_TOLERANCE = 1e-2  # of their pressure, far below their scatter


def ridge_contrast(
    profiles: np.ndarray,
    surfaces: Sequence[xr.DataArray],
    arguments: Mapping[str, Any] = MappingProxyType({}),
) -> dict[str, np.ndarray]:
    """Return how far results of profiles (number, points; m) lie above those of rows of surfaces, as ridges.

    Each is on the scale of its quantity, at `LOADS`, on the straight line over ln p that is nearest to all
    loads; 0 but for area and gap. The surfaces have the pitch of the profiles. All are made periodic by the
    `arguments` of `periodic_window`: in a band both are cut as profiles, whose long waves are also oblique
    short ones.
    """
    surface = surfaces[0]
    side, rows = surface.shape[1], np.arange(_ROWS) * surface.shape[0] // _ROWS
    pieces = profiles[:, : profiles.shape[1] // side * side].reshape(-1, side)
    lines_of_surfaces = np.vstack([surface.values[rows] for surface in surfaces])
    of_profiles, of_surfaces = (_ridges(lines, surface, arguments) for lines in (pieces, lines_of_surfaces))
    slope = np.sqrt(np.mean([rms_gradient(ridges) ** 2 for ridges in of_surfaces]))
    pressure = _RIDGE_LOADS * np.sqrt(2) * slope  # of all directions alike
    higher, lower = (_mean_results(ridges, pressure) for ridges in (of_profiles, of_surfaces))
    contrast: dict[str, np.ndarray] = defaultdict(lambda: np.zeros_like(LOADS))
    for name in COMPARED:
        difference = to_scale(name, higher[name]) - to_scale(name, lower[name])
        finite = np.isfinite(difference)  # nothing has a logarithm in full contact
        line = np.polyfit(np.log(_RIDGE_LOADS[finite]), difference[finite], 1) if finite.sum() > 1 else [0.0]
        contrast[name] = np.polyval(line, np.log(LOADS))
    return contrast


def _ridges(lines: np.ndarray, like: xr.DataArray, arguments: Mapping[str, Any]) -> list[xr.DataArray]:
    """Return lines (number, points; m) of the pitch and file of a map, levelled and made periodic."""
    profiles = [height_map(line, spacing(like)[1], unit="m").assign_attrs(like.attrs) for line in lines]
    return [subwindow(level(profile, outlier_threshold=None), **arguments) for profile in profiles]


def _mean_results(windows: Sequence[xr.DataArray], pressure: np.ndarray) -> dict[str, np.ndarray]:
    """Return the means over windows of the results (load) at pressures over E*."""
    contact = {"contact_modulus": 1.0, "mean_pressure": pressure, "on_failure": "flag"}
    results = [solve_member(window, contact, names=COMPARED, tolerance=_TOLERANCE) for window in windows]
    return {name: np.mean([result[name] for result in results], axis=0) for name in COMPARED}
