"""Solver uncertainty of each quantity, from the bound ||e||_G <= eps ||p||_G of the error e = p - p*.

**Mean gap.** Let v = G p - h, c its offset in the contact, r the residual of the certificate, ||r||_{G^-1} <=
eps ||p||_G, and v*, c*, g* = v* - c* those of the solution, g* >= 0 and <p*, g*> = 0; the mean gap is -c less
the mean height. Then

    <p, G e> - <p, r> <= (c - c*) p̄ <= <p*, G e> - <p*, r>,

and by Cauchy and Schwarz, with the elastic energy per area U = ||p||_G^2 / 2, to first order

    |mean gap - its true value| <= 2 eps ||p||_G^2 / p̄ = 4 eps U / p̄.

The error consists of short waves, p of long ones: it was at most 0.21 of the bound on 180 maps and loads, and
a quarter is used. **Contact area.** Points count that lie within 3 eps times rms pressure or rms gap of the
edge: 96 % of 288 areas (24 made maps) are inside. **Pressures.** 3 eps for the peak, mostly below eps; the
mean is the load over the area. Constants are calibrated against solutions converged to 1e-9
(tests/unit/test_uncertainty_solver.py).
"""

import numpy as np
import xarray as xr

from roughcontact.uncertainty.combination import Components, component_from_units, symmetric
from roughcontact.uncertainty.headline import iterate_fields
from roughcontact.uncertainty.scales import APPROACH, AREA, GAP, PEAK

_POINT_ERROR = 3.0  # relative error of the pressure at a point over that of the field


def solver_uncertainty(contact: xr.Dataset, *, energy: np.ndarray) -> dict[str, np.ndarray]:
    """Return the half-widths (load) of 95 % intervals of area, gap and largest pressure, in their units.

    They are n/N of the points within reach, eps U/p̄ (U in J/m2) and 3 eps p_max: see the top of the module.
    """
    bounds = contact["error_bound"].values
    areas, peaks = [], []
    for (pressure, gap), bound in zip(iterate_fields(contact), bounds, strict=True):
        areas.append(points_within_reach(pressure, gap, _POINT_ERROR * bound) / pressure.size)
        peaks.append(_POINT_ERROR * bound * pressure.max())
    gaps = bounds * energy / contact["mean_pressure"].values
    return {AREA: np.array(areas), GAP: gaps, PEAK: np.array(peaks)}


def solver_components(solution: xr.Dataset) -> Components:
    """Return the components of the solver from `budget_inputs`, on the scales."""
    names = [name for name in (AREA, GAP, PEAK, APPROACH) if name in solution]
    widths = {name: symmetric(solution[f"{name}_uncertainty"].values) for name in names}
    return {name: component_from_units(name, solution[name].values, width) for name, width in widths.items()}


def points_within_reach(pressure: np.ndarray, gap: np.ndarray, bound: float) -> int:
    """Return the number of points of pressure and gap that a relative error may move across the edge."""
    touching = pressure > 0
    return sum(
        int(np.count_nonzero(values < bound * np.sqrt(np.mean(field**2, dtype=float))))
        for values, field in ((pressure[touching], pressure), (gap[~touching], gap))
    )
