"""What the error budget takes from a solution, so that its fields need not be kept: numbers, solver bounds.

Solver uncertainty of each quantity comes from the bound ||e||_G <= eps ||p||_G of the error e = p - p*.

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

from collections.abc import Collection, Iterator

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import APPROACH, AREA, CONDUCTANCE, GAP, PEAK, PRESSURE
from roughcontact.arguments.maps import dimensions
from roughcontact.contact.elasticity.influence import HALF_SPACE, Elasticity
from roughcontact.contact.response import linear_response
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.statistics.sealing.percolation import half_way_levels, percolation_columns
from roughcontact.uncertainty.combination import Components, component_from_units, symmetric
from roughcontact.uncertainty.scales import CONSTRICTIONS, headline_names

_POINT_ERROR = 3.0  # relative error of the pressure at a point over that of the field
_GROOVE_AREA_LIMIT = 0.2  # of the window: random valleys, of waves up to a third of the map, take up more


def headline_values(
    pressure: np.ndarray,
    gap: np.ndarray,
    names: Collection[str],
    elasticity: Elasticity = HALF_SPACE,
    *,
    steps: tuple[float, float],
    border: int = 0,
    approach: float = np.nan,
) -> dict[str, float]:
    """Return quantities of one load from pressure (Pa) and gap (m), as `contact_statistics` defines them.

    `steps` are (dy, dx; m), `border` is that of `relative_contact_area`, `approach` (m) that since the first
    touch. The conductance is NaN in full contact, where it is infinite, and of layered bodies.

    Examples
    --------
    >>> pressure, gap = np.array([[0.0, 3.0, 1.0, 0.0]]), np.array([[0.5, 0.0, 0.0, 0.3]])
    >>> headline_values(pressure, gap, ("mean_gap", "max_pressure"), steps=(1.0, 1.0))
    {'mean_gap': 0.2, 'max_pressure': 3.0}
    """
    touching = pressure > 0
    values = {
        AREA: relative_contact_area(touching, border=border),
        GAP: float(gap[~touching].sum(dtype=float)) / gap.size,
        PEAK: float(pressure.max()),
        APPROACH: approach,
    }
    if PRESSURE in names:
        values[PRESSURE] = float(pressure[touching].mean(dtype=float))
    if CONDUCTANCE in names:
        of_unit = Elasticity(influence=elasticity.influence)
        is_conducting = elasticity.medium.is_homogeneous  # as it displaces
        compliance = linear_response(touching, steps, of_unit)[0] if is_conducting else 0.0
        values[CONDUCTANCE] = 1 / compliance if compliance > 0 else np.nan
    if CONSTRICTIONS[0] in names:
        values |= percolation_columns(np.where(touching, 0.0, gap))
    return {name: values[name] for name in names}


def iterate_fields(contact: xr.Dataset) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield pressure (Pa) and gap (m), arrays (ny, nx), of each load of a solution."""
    yield from zip(contact["pressure"].values, contact["gap"].values, strict=True)


def budget_inputs(
    contact: xr.Dataset, statistics: xr.Dataset | None = None, grooves: Collection[str] | None = None
) -> xr.Dataset:
    """Return what the error budget takes from a solution with its fields, along `load`.

    Headline quantities and answers, `{name}_uncertainty` of the solver, the texture aspect ratio `Str` of the
    map, and `{name}_half_way`, the constrictions (m) of gap paths half as long as the map, of the
    `constrictions_in_grooves`, here `grooves`.
    """
    if statistics is None:
        statistics = contact_statistics(contact, flow="never", stress="never")
    plain = {name: statistics[name].values for name in headline_names(statistics)}
    # of full contact it is infinite
    plain[CONDUCTANCE] = np.where(np.isfinite(plain[CONDUCTANCE]), plain[CONDUCTANCE], np.nan)
    widths = solver_uncertainty(contact, energy=statistics["elastic_energy"].values)
    widths |= {APPROACH: widths[GAP]} if APPROACH in plain else {}  # one offset moves both
    plain |= {f"{name}_uncertainty": width for name, width in widths.items()}
    if grooves is None:
        grooves = constrictions_in_grooves(contact["height"])
    if grooves:
        open_gaps = (np.where(pressure > 0, 0.0, gap) for pressure, gap in iterate_fields(contact))
        levels = [half_way_levels(gap) for gap in open_gaps]
        plain |= {f"{name}_half_way": np.array([level[name] for level in levels]) for name in grooves}
    inputs = contact[["contact_modulus", "mean_pressure"]]
    inputs = inputs.assign({name: ("load", values) for name, values in plain.items()})
    return inputs.assign(Str=((), float(statistics["Str"])))


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


def constrictions_in_grooves(window: xr.DataArray) -> list[str]:
    """Return the critical constrictions that lie in grooves, or valleys, leading out of a periodic map.

    Random heights percolate when about half of the area is open (Dapp, Lücke, Persson and Müser 2012, Phys.
    Rev. Lett. 108, 244301), grooves with much less, here by paths half as long as the map.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface, westergaard_surface
    >>> constrictions_in_grooves(westergaard_surface((64, 64), 1e-6, amplitude=1e-6, wavelength=32e-6))
    ['critical_constriction_y']
    >>> constrictions_in_grooves(rough_reference_surface(64))
    []
    """
    if dimensions(window.shape) == 1:
        return []
    depth = window.values.max() - window.values
    levels = half_way_levels(depth)
    return [name for name in CONSTRICTIONS if np.mean(depth >= levels[name]) < _GROOVE_AREA_LIMIT]
