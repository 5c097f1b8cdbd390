"""Discretisation uncertainty by Richardson extrapolation: the map is solved again with pixels half as large.

The surface is taken to be the Fourier interpolant of the map (`refined`). Let q(h) be a quantity computed
with pixel size h and D = q(h) - q(h/2) its change when h is halved. For an error of order k,

    q(h) - q(0) = D 2^k / (2^k - 1):   2 D for k = 1, 1.55 D for k = 3/2, 1.33 D for k = 2.

The corrected area converges with k = 3/2, the mean gap with 2, the peak pressure with 1 to 2
(docs/explanation/validation.md), so that 2 |D| is conservative. Since D may vanish by chance, further error
terms are added in quadrature:

* Contact area: the correction subtracts c M / N for M switches between contact and non-contact among N
  points, with the c of a circular patch on a lattice. On solved contacts the corrected area is too low by
  0.010 to 0.018 M / N, independent of load, grid and spectrum (M / N is proportional to h): 0.02 M / N is
  added, a sixth of the correction. The random position of the contact edge within its pixel adds 0.3
  sqrt(M) / N, close to the 1/sqrt(12) of a uniform distribution.
* Mean gap: it changes so little that the solver uncertainty on the finer grid matters as well.
* Peak pressure: the true peak lies between grid points. The largest pressure on the grid is too low by a
  fraction of its excess d over the neighbouring points; 0.2 d is added. (For a parabola sampled half a pixel
  from its vertex the fraction is 1/4.)

The mean contact pressure is p̄ over the share of points in contact. That share is always too large, and the
resulting bias follows from the corrected area A, p̄/A - p̄/A_points. The random part p̄ u(A) / A² is added to
it linearly, because the bias is systematic.

Closely spaced loads are not all solved again (`representative_loads`). At skipped loads the relative changes
of area and peak are interpolated. The changes of the other quantities change sign with the load and are
accidentally small at some loads: a skipped load takes the largest of two on each side. Conductance and
critical constrictions, which depend on single pixels, are never given less than at neighbouring loads. In a
subwindow of a large window, which has the highest peak but few others, the same holds for peak and mean gap,
and all these changes are multiplied by 1.5.

The constants are calibrated on band-limited maps with a known fine solution
(`roughcontact.validation.coverage`, benchmarks/pixel_size.py, tests/unit/test_uncertainty_discretisation.py).
"""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.solve import solve_contact
from roughcontact.maps import refined, spacing
from roughcontact.statistics.contact_geometry import count_switches
from roughcontact.uncertainty.answers import answers_present, headline_and_answers, quantities_in
from roughcontact.uncertainty.ensemble import Count
from roughcontact.uncertainty.headline import QUANTITIES, fields_of, headline
from roughcontact.uncertainty.representative_loads import (
    interpolate_over_loads,
    maximum_of_neighbours,
    ratio,
    representative_loads,
)
from roughcontact.uncertainty.solver import mean_gap_uncertainty
from roughcontact.window.periodisation import periodic_plus_smooth

_RICHARDSON_FACTOR = 2.0  # error over change when the pixel size is halved, for first-order convergence
_AREA_CORRECTION_ERROR = 0.02  # pixels per switch between contact and non-contact; systematic
_EDGE_NOISE = 0.3  # pixels per switch; random
_PEAK_SHORTFALL = 0.2  # of the difference between the highest point and its neighbours
_TOLERANCE = 3e-4  # upper limit for the finer solution: 1e-3 may alter the change by a third
_MAX_POINTS = 1024**2  # upper limit for refinement; larger windows are represented by a subwindow
_SUBWINDOW_FACTOR = 1.5  # safety factor for a subwindow, which has few peaks and valleys
_SMOOTH_QUANTITIES = ("relative_contact_area", "max_pressure")  # in the load; in a subwindow only the first


def discretisation_uncertainty(
    window: xr.DataArray, *, contact: Mapping[str, Any], solved: xr.Dataset | None = None
) -> xr.Dataset:
    """Return the discretisation uncertainty of each quantity, from a solution with pixels half as large.

    Contact area hypot(2 D, 0.02 M / N, 0.3 sqrt(M) / N), mean gap hypot(2 D, solver uncertainty), largest
    pressure hypot(2 D, 0.2 d), mean contact pressure p̄/A - p̄/A_points + p̄ u(A) / A²; see the module
    docstring. Relative changes of a window of more than 1024² points are computed on a subwindow of that
    size. Many closely spaced loads are solved again at representative loads only.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic.
    contact : dict
        keyword arguments of `solve_contact`.
    solved : Dataset or None
        what `resolution_indicators` returns for the solution of the window; computed where it is not given.

    Returns
    -------
    Dataset
        dim load: the half-widths of 95 % intervals of `QUANTITIES`, each in its own unit, and
        `mean_contact_pressure_bias` (Pa), the systematic part of that half-width.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> problem = {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> found = discretisation_uncertainty(rough_reference_surface(64), contact=problem)
    >>> f"{found['relative_contact_area'].item():.3f}"
    '0.005'
    """
    if solved is None:
        solved = solve_contact(window, **contact, reduce=resolution_indicators)
    change = _changes(window, contact, solved)
    load, share = solved["mean_pressure"].values, solved["relative_contact_area"].values
    switches = solved["switches"].values / window.size
    area = _root_of_squares(
        change["relative_contact_area"],
        _AREA_CORRECTION_ERROR * switches,
        _EDGE_NOISE * np.sqrt(switches / window.size),
    )
    overcount = load / share - solved["mean_contact_pressure"].values
    uncertainty = {
        "relative_contact_area": area,
        "mean_gap": np.hypot(change["mean_gap"], change["mean_gap_uncertainty"]),
        "max_pressure": np.hypot(change["max_pressure"], _PEAK_SHORTFALL * solved["beside_the_peak"].values),
        "mean_contact_pressure": np.abs(overcount) + load * area / share**2,
        "mean_contact_pressure_bias": np.abs(overcount),
        **{name: change[name] for name in answers_present(solved)},
    }
    return xr.Dataset({name: ("load", values) for name, values in uncertainty.items()})


def resolution_indicators(contact: xr.Dataset) -> xr.Dataset:
    """Return the headline quantities of each load and indicators of the grid resolution.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.

    Returns
    -------
    Dataset
        dim load: `QUANTITIES`, `switches` between contact and non-contact along all rows and columns,
        `beside_the_peak` (Pa) the largest pressure less the mean of its neighbours,
        `place_of_the_peak` the index of the largest pressure, counted row by row.

    Examples
    --------
    >>> import xarray as xr
    >>> fields = {"pressure": [[[0.0, 3.0, 1.0, 0.0]]], "gap": [[[0.5, 0.0, 0.0, 0.3]]]}
    >>> contact = xr.Dataset({name: (("load", "y", "x"), values) for name, values in fields.items()})
    >>> found = resolution_indicators(contact)
    >>> found["switches"].item(), found["beside_the_peak"].item()
    (2, 2.5)
    """
    switches, drop, place = [], [], []
    for pressure, _ in fields_of(contact):
        switches.append(sum(count_switches(pressure > 0)))
        place.append(pressure.argmax())
        drop.append(_peak_drop(pressure, np.unravel_index(place[-1], pressure.shape)))
    marks = {"switches": switches, "beside_the_peak": drop, "place_of_the_peak": place}
    return headline(contact).assign({name: ("load", values) for name, values in marks.items()})


def _changes(window: xr.DataArray, contact: Mapping[str, Any], solved: xr.Dataset) -> dict[str, np.ndarray]:
    """Return 2 |D| of each quantity at all loads, and the solver uncertainty of the finer mean gap."""
    load, part = solved["mean_pressure"].values, _subwindow(window, solved["place_of_the_peak"].values)
    wanted = representative_loads(load, solved["relative_contact_area"].values)
    problem = {**contact, "mean_pressure": load[wanted]}
    names = list(quantities_in(solved))
    coarse = solved.isel(load=wanted) if part is window else _solve(part, problem, names)
    fine = _solve(refined(part, 2), problem, names)
    changes = {}
    for name in names:  # where a gap or a constriction is closed, `ratio` is 1
        own, other, value = coarse[name].values, fine[name].values, solved[name].values
        change = _RICHARDSON_FACTOR * np.abs(own - other) * ratio(value[wanted], own)
        if name in (_SMOOTH_QUANTITIES if part is window else _SMOOTH_QUANTITIES[:1]):
            changes[name] = interpolate_over_loads(change, wanted, load, value)
        elif part is window:
            changes[name] = maximum_of_neighbours(change, wanted, load, value, own=name == "mean_gap")
        else:
            changes[name] = _SUBWINDOW_FACTOR * maximum_of_neighbours(change, wanted, load, value)
    of_solver, gap = fine["mean_gap_uncertainty"].values, solved["mean_gap"].values
    return changes | {"mean_gap_uncertainty": maximum_of_neighbours(of_solver, wanted, load, gap, own=True)}


def _solve(window: xr.DataArray, contact: Mapping[str, Any], names: list[str]) -> xr.Dataset:
    """Return quantities of a map and the solver uncertainty of its mean gap; NaN for a failed load."""
    tolerance = min(_TOLERANCE, contact.get("tolerance", _TOLERANCE))
    arguments = {**contact, "tolerance": tolerance, "on_failure": "flag"}
    count = headline_and_answers if names[len(QUANTITIES) :] else headline
    found = solve_contact(window, **arguments, reduce=partial(_with_mean_gap_uncertainty, count))
    return found[[*names, "mean_gap_uncertainty"]].where(found["converged"] == 1)


def _with_mean_gap_uncertainty(count: Count, contact: xr.Dataset) -> xr.Dataset:
    """Return the quantities of each load and the solver uncertainty of the mean gap."""
    return count(contact).assign(mean_gap_uncertainty=("load", mean_gap_uncertainty(contact)))


def _subwindow(window: xr.DataArray, places: np.ndarray) -> xr.DataArray:
    """Return a periodic subwindow around the most frequent peak, or the window itself if small enough."""
    sides = list(window.shape)
    while np.prod(sides) > _MAX_POINTS:
        longest = int(np.argmax(sides))
        sides[longest] = -(-sides[longest] // 2)
    if sides == list(window.shape):
        return window
    found, times = np.unique(places, return_counts=True)
    middle = np.unravel_index(found[times.argmax()], window.shape)
    rows, columns = (
        np.arange(at - side // 2, at - side // 2 + side) % n
        for at, side, n in zip(middle, sides, window.shape, strict=True)
    )
    heights = window.values[rows[:, None], columns]
    return window[: sides[0], : sides[1]].copy(data=periodic_plus_smooth(heights, spacing(window)))


def _peak_drop(pressure: np.ndarray, place: tuple[np.intp, ...]) -> float:
    """Return the pressure at a point less the mean of its neighbours along the axes."""
    lines = (pressure[:, place[1]], pressure[place[0]])
    neighbours = [
        line[(at + step) % line.size]
        for line, at in zip(lines, place, strict=True)
        if line.size > 1
        for step in (-1, 1)
    ]
    return float(pressure[place] - np.mean(neighbours))


def _root_of_squares(*parts: np.ndarray) -> np.ndarray:
    """Return the root of the sum of squares of several arrays."""
    return np.sqrt(sum(part**2 for part in parts))
