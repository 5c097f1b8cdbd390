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
pressure is below the reach of the error, and points out of contact whose gap is. The reach is 1.5 eps times
the rms pressure and 1.5 eps times the rms gap. The count is that of all points within one reach, or half of
the points within four where this is more, because the error is not uniform. The factor was 1
for solutions that started from an even pressure on the coarsest grid. From the highest part of the pressure
in full contact, 96 % of 1440 areas (120 made maps) are inside with 1 (94 % at a tolerance of 1e-3), 97 % with
1.5 (96 %), as many as before.

**Pressures.** The peak is a single point; its relative error was mostly below eps, and 2 eps is used. The
mean over the contact is p̄ over the share of points in contact and has the relative uncertainty of that
share.

The constants are calibrated against solutions converged to 1e-10
(tests/unit/test_uncertainty_solver.py).
"""

from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.dataset import influence_of, layers_of
from roughcontact.elasticity.energy import elastic_energy
from roughcontact.maps import spacing
from roughcontact.uncertainty.headline import fields_of

_MEAN_GAP_FACTOR = 0.25  # of the rigorous bound
_PEAK_FACTOR = 2.0  # relative error of the peak over the error bound
_AREA_FACTOR = 1.5  # of the error bound, for the points that may change
_WIDE_REACH, _WIDE_SHARE = 4, 0.5  # within four reaches, half of the points are counted


def solver_uncertainty(contact: xr.Dataset, *, energy: np.ndarray | None = None) -> xr.Dataset:
    """Return the solver uncertainty of each quantity, from the error bound of the pressure.

    Mean gap eps U / p̄, largest pressure 2 eps p_max, contact area n / N with n the number of points that the
    error may move into or out of contact, mean contact pressure p_c n / N_contact; derived in the module
    docstring.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.
    energy : array (load,), J/m2, optional
        `elastic_energy` of the loads where it is known already.

    Returns
    -------
    Dataset
        dim load: the half-widths of 95 % intervals of `QUANTITIES`, each in its own unit.

    Examples
    --------
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> contact = solve_contact(height, contact_modulus=1.0, mean_pressure=0.1, tolerance=1e-3)
    >>> peak, half_width = contact["pressure"].max(), solver_uncertainty(contact)["max_pressure"]
    >>> bool(half_width[0] <= 2e-3 * peak)
    True
    """
    bounds, gaps = contact["error_bound"].values, mean_gap_uncertainty(contact, energy=energy)
    rows = []
    for (pressure, gap), bound, open_gap in zip(fields_of(contact), bounds, gaps, strict=True):
        changing = points_within_reach(pressure, gap, _AREA_FACTOR * bound)
        in_contact = np.count_nonzero(pressure)
        rows.append(
            {
                "relative_contact_area": changing / pressure.size,
                "mean_gap": open_gap,
                "max_pressure": _PEAK_FACTOR * bound * pressure.max(),
                "mean_contact_pressure": pressure.sum() / in_contact * changing / in_contact,
            }
        )
    return xr.Dataset({name: ("load", [row[name] for row in rows]) for name in rows[0]})


def mean_gap_uncertainty(contact: xr.Dataset, *, energy: np.ndarray | None = None) -> np.ndarray:
    """Return the solver uncertainty of the mean gap alone, eps U / p̄, m.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.
    energy : array (load,), J/m2, optional
        `elastic_energy` of the loads where it is known already.

    Returns
    -------
    array (load,)
        the half-width of the 95 % interval.

    Examples
    --------
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> contact = solve_contact(rough_reference_surface(64), contact_modulus=1.0, mean_pressure=0.1)
    >>> bool(mean_gap_uncertainty(contact)[0] == solver_uncertainty(contact)["mean_gap"][0])
    True
    """
    if energy is None:
        steps = spacing(contact["height"])
        elastic: dict[str, Any] = {
            "contact_modulus": float(contact["contact_modulus"]),
            "influence": influence_of(contact),
            "layers": layers_of(contact),
        }
        energy = np.array([elastic_energy(field, steps, **elastic) for field in contact["pressure"].values])
    return _MEAN_GAP_FACTOR * 4 * contact["error_bound"].values * energy / contact["mean_pressure"].values


def points_within_reach(pressure: np.ndarray, gap: np.ndarray, bound: float) -> float:
    """Return the number of points that a relative error `bound` may move into or out of contact.

    Parameters
    ----------
    pressure : array (ny, nx), Pa
    gap : array (ny, nx), m
    bound : float
        relative error of the pressure.

    Returns
    -------
    float
        all points within one reach, or half of the points within four reaches if that is more.

    Examples
    --------
    The reach of the pressure is 0.01 of its rms, 0.05; that of the gap 0.01.

    >>> import numpy as np
    >>> pressure, gap = np.array([[10.0, 0.02, 0.0, 0.0]]), np.array([[0.0, 0.0, 0.001, 2.0]])
    >>> points_within_reach(pressure, gap, 0.01)
    2.0
    """
    touching = pressure > 0
    carried, open_gap = pressure[touching], gap[~touching]
    reaches = (
        (carried, bound * np.sqrt(np.mean(pressure**2, dtype=float))),
        (open_gap, bound * np.sqrt(np.mean(gap**2, dtype=float))),
    )
    near, wide = (
        sum(np.count_nonzero(values < width * reach) for values, reach in reaches)
        for width in (1, _WIDE_REACH)
    )
    return float(max(near, _WIDE_SHARE * wide))
