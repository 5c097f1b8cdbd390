"""What the pixel size leaves open: the same map solved once more with pixels half as large.

The map stands for the surface that its Fourier series draws through its points (`refined`). Let q(h) be a
quantity with pixels of size h, and D = q(h) - q(h/2) what halving them changes. An error of the order k is

    q(h) - q(0) = D 2^k / (2^k - 1):   2 D for k = 1, 1.55 D for k = 3/2, 1.33 D for k = 2.

The corrected area has k = 3/2, the mean gap 2, the peak pressure 1 to 2 (docs/explanation/validation.md), so
that 2 |D| is on the safe side. That alone would be too narrow where D is small by chance, so that what is
known of each number is added to it; the parts add as squares:

* The corrected area takes off c M / N for M switches between contact and non-contact among N points. c is
  that of a round patch on a lattice. On solved contacts the corrected area comes out low by 0.010 to 0.018 M
  / N, whatever the load, the grid and the spectrum (M / N falls as h): 0.02 M / N is added, a sixth of the
  correction. Each switch also adds an error of its own, by where the edge happens to cut the pixel: 0.3
  sqrt(M) / N, near the 1/sqrt(12) of an edge at a random place.
* The mean gap changes so little that what the solver leaves open of it on the finer grid counts as well.
* The peak lies between the points. The largest pressure falls short of it by a part of the difference d
  between that point and its neighbours; 0.2 d is added. (A parabola through a point that lies half a pixel
  beside its top is d/4 too low.)

The mean contact pressure is p̄ over the share of the points in contact, which is always too high: its error
is known from the corrected area A, p̄/A - p̄/A_points, to which p̄ u(A) / A² is added, not as squares,
because the former is no matter of chance.

Loads that lie close are not all solved once more (`loads_apart`). At those left out the relative changes of
area and peak are interpolated. Those of the other quantities change their sign with the load and are small by
chance here and there: a load left out takes the largest of two on each side. The conductance and the
narrowest places, which change by single pixels, never count as less than at the loads next to theirs. In a
part of a large window, which has the highest peak and few others, that holds for the peak and the mean gap as
well, and all these changes count half as much again.

The constants are measured on band-limited maps of known fine solution (`roughcontact.validation.coverage`,
benchmarks/pixel_size.py, tests/unit/test_uncertainty_discretisation.py).
"""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.solve import solve_contact
from roughcontact.maps import refined, spacing
from roughcontact.statistics.contact_geometry import count_switches
from roughcontact.uncertainty.answers import answers_in, headline_and_answers
from roughcontact.uncertainty.ensemble import Count
from roughcontact.uncertainty.headline import QUANTITIES, fields_of, headline
from roughcontact.uncertainty.loads_apart import interpolated, largest_beside, loads_apart, ratio
from roughcontact.uncertainty.solver import open_mean_gap
from roughcontact.window.periodisation import periodic_plus_smooth

_FIRST_ORDER = 2.0  # error over change, for an error of the first order
_CORRECTION = 0.02  # pixels for each switch between contact and non-contact, all in the same sense
_EDGE_NOISE = 0.3  # pixels for each switch, at random
_BESIDE_THE_PEAK = 0.2  # of the difference between the highest point and its neighbours
_TOLERANCE = 3e-4  # at most, of the finer solution: at 1e-3 it may move the change by a third
_MOST_POINTS = 1024**2  # of what is refined; of a larger window a part stands for the whole
_IN_A_PART = 1.5  # times what a part shows: of few peaks and valleys
_SMOOTH = ("relative_contact_area", "max_pressure")  # over the load; in a part the first alone


def discretisation_uncertainty(
    window: xr.DataArray, *, contact: Mapping[str, Any], solved: xr.Dataset | None = None
) -> xr.Dataset:
    """Return what the pixel size makes uncertain in each quantity, from a solution with pixels half as large.

    Contact area hypot(2 D, 0.02 M / N, 0.3 sqrt(M) / N), mean gap hypot(2 D, that of the solver), largest
    pressure hypot(2 D, 0.2 d), mean contact pressure p̄/A - p̄/A_points + p̄ u(A) / A²; the head of this
    module explains them. Of a window of more than 1024² points, a part of that size shows the relative
    changes. Not every one of many loads is solved once more.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic.
    contact : dict
        keyword arguments of `solve_contact`.
    solved : Dataset or None
        what `grid_marks` counts in the solution of the window, where it is known already.

    Returns
    -------
    Dataset
        dim load: the half-widths of 95 % intervals of `QUANTITIES`, each in its own unit, and
        `mean_contact_pressure_bias` (Pa), the part of it that is no matter of chance.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> problem = {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> found = discretisation_uncertainty(rough_reference_surface(64), contact=problem)
    >>> f"{found['relative_contact_area'].item():.3f}"
    '0.005'
    """
    if solved is None:
        solved = solve_contact(window, **contact, reduce=grid_marks)
    change = _changes(window, contact, solved)
    load, share = solved["mean_pressure"].values, solved["relative_contact_area"].values
    switches = solved["switches"].values / window.size
    area = _root_of_squares(
        change["relative_contact_area"],
        _CORRECTION * switches,
        _EDGE_NOISE * np.sqrt(switches / window.size),
    )
    overcount = load / share - solved["mean_contact_pressure"].values
    uncertainty = {
        "relative_contact_area": area,
        "mean_gap": np.hypot(change["mean_gap"], change["mean_gap_uncertainty"]),
        "max_pressure": np.hypot(change["max_pressure"], _BESIDE_THE_PEAK * solved["beside_the_peak"].values),
        "mean_contact_pressure": np.abs(overcount) + load * area / share**2,
        "mean_contact_pressure_bias": np.abs(overcount),
        **{name: change[name] for name in answers_in(solved)},
    }
    return xr.Dataset({name: ("load", values) for name, values in uncertainty.items()})


def grid_marks(contact: xr.Dataset) -> xr.Dataset:
    """Return the four quantities of each load and what tells how coarse the grid is for it.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.

    Returns
    -------
    Dataset
        dim load: `QUANTITIES`, `switches` between contact and non-contact along all rows and columns,
        `beside_the_peak` (Pa) the difference between the highest point and its neighbours,
        `place_of_the_peak` the index of the former, counted row by row.

    Examples
    --------
    >>> import xarray as xr
    >>> fields = {"pressure": [[[0.0, 3.0, 1.0, 0.0]]], "gap": [[[0.5, 0.0, 0.0, 0.3]]]}
    >>> found = grid_marks(xr.Dataset({name: (("load", "y", "x"), v) for name, v in fields.items()}))
    >>> found["switches"].item(), found["beside_the_peak"].item()
    (2, 2.5)
    """
    switches, drop, place = [], [], []
    for pressure, _ in fields_of(contact):
        switches.append(sum(count_switches(pressure > 0)))
        place.append(pressure.argmax())
        drop.append(_beside_the_peak(pressure, np.unravel_index(place[-1], pressure.shape)))
    marks = {"switches": switches, "beside_the_peak": drop, "place_of_the_peak": place}
    return headline(contact).assign({name: ("load", values) for name, values in marks.items()})


def _changes(window: xr.DataArray, contact: Mapping[str, Any], solved: xr.Dataset) -> dict[str, np.ndarray]:
    """Return 2 |D| of each quantity at all loads, and the solver's part of the mean gap on the finer grid."""
    load, part = solved["mean_pressure"].values, _part(window, solved["place_of_the_peak"].values)
    wanted = loads_apart(load, solved["relative_contact_area"].values)
    problem = {**contact, "mean_pressure": load[wanted]}
    names = [*QUANTITIES, *answers_in(solved)]
    coarse = solved.isel(load=wanted) if part is window else _solve(part, problem, names)
    fine = _solve(refined(part, 2), problem, names)
    changes = {}
    for name in names:  # no gap that is left, or a narrowest place that is closed, is no base of a ratio
        own, other, value = coarse[name].values, fine[name].values, solved[name].values
        change = _FIRST_ORDER * np.abs(own - other) * ratio(value[wanted], own)
        if name in (_SMOOTH if part is window else _SMOOTH[:1]):
            changes[name] = interpolated(change, wanted, load, value)
        elif part is window:
            changes[name] = largest_beside(change, wanted, load, value, own=name == "mean_gap")
        else:
            changes[name] = _IN_A_PART * largest_beside(change, wanted, load, value)
    of_solver, gap = fine["mean_gap_uncertainty"].values, solved["mean_gap"].values
    return changes | {"mean_gap_uncertainty": largest_beside(of_solver, wanted, load, gap, own=True)}


def _solve(window: xr.DataArray, contact: Mapping[str, Any], names: list[str]) -> xr.Dataset:
    """Return quantities of a map, the solver's part of the mean gap beside them; NaN for a failed load."""
    tolerance = min(_TOLERANCE, contact.get("tolerance", _TOLERANCE))
    arguments = {**contact, "tolerance": tolerance, "on_failure": "flag"}
    count = headline_and_answers if names[len(QUANTITIES) :] else headline
    found = solve_contact(window, **arguments, reduce=partial(_with_open_gap, count))
    return found[[*names, "mean_gap_uncertainty"]].where(found["converged"] == 1)


def _with_open_gap(count: Count, contact: xr.Dataset) -> xr.Dataset:
    """Return what is counted of a load and what the solver leaves open of the mean gap."""
    return count(contact).assign(mean_gap_uncertainty=("load", open_mean_gap(contact)))


def _part(window: xr.DataArray, places: np.ndarray) -> xr.DataArray:
    """Return what surrounds the peak of most loads, made periodic, if a window is too large; else all."""
    sides = list(window.shape)
    while np.prod(sides) > _MOST_POINTS:
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


def _beside_the_peak(pressure: np.ndarray, place: tuple[np.intp, ...]) -> float:
    """Return how much higher the highest point is than the mean of its neighbours along the axes."""
    lines = (pressure[:, place[1]], pressure[place[0]])
    neighbours = [
        line[(at + step) % line.size]
        for line, at in zip(lines, place, strict=True)
        if line.size > 1
        for step in (-1, 1)
    ]
    return float(pressure[place] - np.mean(neighbours))


def _root_of_squares(*parts: np.ndarray) -> np.ndarray:
    """Return the root of the sum of the squares of several arrays."""
    return np.sqrt(sum(part**2 for part in parts))
