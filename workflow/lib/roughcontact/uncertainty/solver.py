"""Solver uncertainty of each quantity, derived from the error bound of the pressure.

The certificate (`roughcontact.contact.certificate`) bounds the error e = p - p* of the pressure in the norm
of the elastic energy, ||e||_G <= eps ||p||_G. From this bound on the whole field, bounds and estimates for
single quantities are derived as follows.

**Mean gap.** Let v = G p - h, c the offset it has in the contact, r the residual of the certificate,
||r||_{G^-1} <= eps ||p||_G, and v*, c* those of the solution, whose gap g* = v* - c* fulfils g* >= 0 and <p*,
g*> = 0; then the mean gap is -c less the mean height. The mean of p (v - c) - p (v* - c*) over the window is
<p, r> - <p, g*> = <p, G e> - (c - c*) p̄. Likewise with p*, where v - c >= r: <p*, r> <= <p*, G e> - (c - c*)
p̄. With g* >= 0,

    <p, G e> - <p, r> <= (c - c*) p̄ <= <p*, G e> - <p*, r>,

and by Cauchy and Schwarz, with U = ||p||_G^2 / 2 the elastic energy per area, and ||p*||_G = ||p||_G to
first order,

    |mean gap - its true value| <= 2 eps ||p||_G^2 / p̄ = 4 eps U / p̄.

This is a rigorous bound, for the offset at which r has zero mean. Equality holds where e is proportional to
p. Solver errors consist of short waves, p of long ones, and the actual error is much smaller: at most 0.21 of
the bound on 180 maps and loads (profiles, noise, any size), whatever the tolerance. A quarter of the bound is
used.

**Contact area.** Only points that the error may move into or out of contact count: points in contact whose
pressure is below the reach of the error, and points out of contact whose gap is. The reach is 3 eps times
the rms pressure and 3 eps times the rms gap: 96 % of 288 areas (24 made maps) are inside.

**Pressures.** The peak is a single point; its relative error was mostly below eps, and 3 eps is used. The
mean over the contact is the load over the area.

The constants are calibrated against solutions converged to 1e-9 (tests/unit/test_uncertainty_solver.py).
"""

import numpy as np
import xarray as xr

from roughcontact.uncertainty.headline import fields_of
from roughcontact.uncertainty.scales import AREA, GAP, PEAK

_POINT_ERROR = 3.0  # relative error of the pressure at a point over that of the field


def solver_uncertainty(contact: xr.Dataset, *, energy: np.ndarray) -> dict[str, np.ndarray]:
    """Return the half-widths (load) of 95 % intervals of area, gap and largest pressure, in their units.

    Contact area n/N with n the number of points that the error may move into or out of contact, mean gap
    eps U/p̄ with U the elastic energy (load; J/m2), largest pressure 3 eps p_max; derived in the module
    docstring.
    """
    bounds = contact["error_bound"].values
    areas, peaks = [], []
    for (pressure, gap), bound in zip(fields_of(contact), bounds, strict=True):
        areas.append(points_within_reach(pressure, gap, _POINT_ERROR * bound) / pressure.size)
        peaks.append(_POINT_ERROR * bound * pressure.max())
    gaps = bounds * energy / contact["mean_pressure"].values
    return {AREA: np.array(areas), GAP: gaps, PEAK: np.array(peaks)}


def points_within_reach(pressure: np.ndarray, gap: np.ndarray, bound: float) -> int:
    """Return the number of points of pressure and gap that a relative error may move across the edge.

    Examples
    --------
    The reach of the pressure is 0.01 of its rms, 0.05; that of the gap 0.01.

    >>> pressure, gap = np.array([[10.0, 0.02, 0.0, 0.0]]), np.array([[0.0, 0.0, 0.001, 2.0]])
    >>> points_within_reach(pressure, gap, 0.01)
    2
    """
    touching = pressure > 0
    return sum(
        int(np.count_nonzero(values < bound * np.sqrt(np.mean(field**2, dtype=float))))
        for values, field in ((pressure[touching], pressure), (gap[~touching], gap))
    )
