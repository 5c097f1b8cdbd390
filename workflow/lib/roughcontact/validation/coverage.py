"""Does the ± hold? Intervals of the error budget against surfaces whose true numbers are known."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypedDict

import numpy as np
import xarray as xr
from scipy.ndimage import maximum_filter

from roughcontact.contact.solve import solve_contact
from roughcontact.levelling.level import level
from roughcontact.maps import refined
from roughcontact.quantities import number
from roughcontact.references import synthetic
from roughcontact.uncertainty.answers import headline_and_answers, quantities_in
from roughcontact.uncertainty.budget import error_budget
from roughcontact.uncertainty.discretisation import discretisation_uncertainty, resolution_indicators
from roughcontact.uncertainty.ensemble import Count
from roughcontact.uncertainty.headline import QUANTITIES, headline
from roughcontact.validation.lines import Part, Table
from roughcontact.validation.masters import FAULTS, KINDS, cut_out, master_surface
from roughcontact.window.periodic_window import periodic_window

Cases = dict[str, tuple[np.ndarray, np.ndarray]]  # quantity -> half-widths and errors

_PROMISED, _LEAST = 0.95, 0.90  # share of the intervals that hold the true value
_WIDTH = 3.0  # median of half-width over error that is not to be exceeded
_MAPS, _FEW_MAPS = 40, 10  # at full size and at a small one
_LOADS_EACH = 5
_WORDS = {
    "relative_contact_area": "contact area",
    "mean_gap": "mean gap",
    "max_pressure": "largest pressure",
    "mean_contact_pressure": "pressure in contact",
    "conductance_per_conductivity": "conductance",
    "critical_constriction_x": "narrowest place along x",
    "critical_constriction_y": "narrowest place along y",
}


def add_lines(part: Part, *, finest_grid: int) -> None:
    """Add lines and table of 40 maps of either kind, of 10 where the finest grid is coarse."""
    maps = _MAPS if finest_grid >= 1024 else _FEW_MAPS
    rows = []
    for name, (half_width, error) in pixel_size_cases(maps).items():
        covered, width = _coverage_and_width(half_width, error)
        _add_share(part, "pixel share", _WORDS[name], covered, maps)
        part.compare("pixel width", width, (1 + _WIDTH) / 2, (_WIDTH - 1) / 2, quantity=_WORDS[name])
        rows.append(("Pixel size alone", _WORDS[name], error.size, covered, width))
    for name, (half_width, error) in measured_cases(maps, master_points=min(320, finest_grid)).items():
        covered, width = _coverage_and_width(half_width, error)
        _add_share(part, "share", _WORDS[name], covered, maps)
        rows.append(("All sources together", _WORDS[name], error.size, covered, width))
    table = Table(
        "Coverage and width of the intervals",
        ["source", "quantity", "cases", "share that hold", "half-width over error, median"],
        [
            [source, quantity, str(cases), number(covered), number(width, digits=2)]
            for source, quantity, cases, covered, width in rows
        ],
        "An interval of 95 % of a normal distribution is 2.9 times as wide as the median error.",
    )
    part.tables.append(table)


def _coverage_and_width(half_width: np.ndarray, error: np.ndarray) -> tuple[float, float]:
    """Return the share of the intervals that hold, and the median of half-width over error."""
    ratio = half_width / np.maximum(error, np.finfo(float).tiny)
    return float(np.mean(error <= half_width)), float(np.median(ratio))


def _add_share(part: Part, name: str, quantity: str, covered: float, maps: int) -> None:
    """Add the line of a share of intervals that hold: 95 % is promised, more is no fault.

    The least is 90 %. With few maps, twice the standard deviation of a share of so many goes off that.
    """
    tolerance, limit = _PROMISED - _LEAST, "more than 95 % is no fault"
    if maps < _MAPS:
        tolerance += 2 * np.sqrt(_PROMISED * (1 - _PROMISED) / maps)
        limit = f"{maps} maps only"
    line = part.compare(name, covered, _PROMISED, tolerance, quantity=quantity, limit=limit)
    part.lines[-1] = replace(line, deviation=max(0.0, _PROMISED - covered))


def pixel_size_cases(maps: int, *, seed: int = 2024) -> Cases:
    """Return half-widths and errors of the pixel size on maps of known fine solution.

    Each map has 64 x 64 points and is solved at five loads, p' from 0.007 to 0.9; its shortest wave has 2.2
    to 16 points, its longest is a quarter to the whole of the side, 0.2 <= H <= 1. The truth is its Fourier
    series on eight times as many points along each axis. `seed` is that of the random maps and loads.

    Returns
    -------
    dict
        quantity -> (half-widths, errors), arrays over all maps and loads, in the unit of the quantity.
    """
    generator = np.random.default_rng(seed)
    found = []
    for _ in range(maps):
        longest = generator.uniform(0.25, 1)
        shortest = min(np.exp(generator.uniform(np.log(2.2), np.log(16))) / 64, 0.8 * longest)
        window = synthetic.self_affine_surface(
            (64, 64),
            1 / 64,
            hurst=generator.uniform(0.2, 1),
            shortest=shortest,
            longest=longest,
            rms_gradient=1.0,
            seed=int(generator.integers(2**31)),
        )
        loads = np.sort(np.exp(generator.uniform(np.log(0.007), np.log(0.9), _LOADS_EACH)))
        contact = _problem(loads)
        solved = solve_contact(window, **contact, reduce=resolution_indicators)
        half_widths = discretisation_uncertainty(window, contact=contact, solved=solved)
        truth = _truth(refined(window, 8), loads, count=headline)
        found.append(_cases(half_widths[list(QUANTITIES)], solved, truth))
    return _joined(found)


def measured_cases(maps: int, *, master_points: int, seed: int = 7) -> Cases:
    """Return half-widths and errors of the combined intervals of maps cut from known surfaces.

    The surfaces take turns among the kinds of `masters`; each is periodic, of `master_points` squared, its
    longest wave a quarter of the map at most. The map is cut out of it at random, 3/8 to 5/8 of its side,
    tilted, 1 % of its points are missing, in spots, and it takes turns among the faults. Levelling, window
    and budget are those of the default settings; the loads are given in Pa, so that the truth is the surface
    at the same mean pressure, with pixels half as large. That of the largest pressure is the median over all
    squares as large as the window. `seed` is that of the random surfaces, maps and loads.

    Returns
    -------
    dict
        quantity -> (half-widths, errors), arrays over all maps and loads, in the unit of the quantity, the
        answers that have an interval among them; the half-widths are those to the side on which the truth
        lies, infinite where an interval has no end there.
    """
    generator = np.random.default_rng(seed)
    found = []
    for index in range(maps):
        side = int(generator.uniform(3 / 8, 5 / 8) * master_points)
        master = master_surface(
            KINDS[index % len(KINDS)],
            master_points,
            hurst=generator.uniform(0.4, 1),
            longest=generator.uniform(0.1, 0.25) * side / master_points,
            seed=int(generator.integers(2**31)),
        )
        loads = np.sort(0.1 * np.exp(generator.uniform(np.log(0.01), np.log(0.7), _LOADS_EACH)))
        levelled = level(cut_out(master, side, generator, fault=FAULTS[index % len(FAULTS)]))
        window = periodic_window(levelled)
        contact = _problem(loads)
        budget = error_budget(levelled, window, {"level": {}, "window": {}, "contact": contact})
        result = solve_contact(window, **contact, reduce=headline_and_answers)
        truth = _truth(refined(master, 2), loads, count=headline_and_answers, box=2 * window.shape[0])
        half_widths = {}
        for name in quantities_in(result):
            lower, upper = (budget[f"{name}_{end}"] for end in ("lower", "upper"))
            upper = upper.where(np.isfinite(upper) | np.isnan(lower), np.inf)
            half_widths[name] = xr.where(
                truth[name] > result[name], upper - result[name], result[name] - lower
            )
        found.append(_cases(half_widths, result, truth))
    return _joined(found)


def _cases(half_widths: xr.Dataset | dict[str, xr.DataArray], result: xr.Dataset, truth: xr.Dataset) -> Cases:
    """Return half-widths and errors at the loads of one map; an infinite conductance is left out."""
    cases = {}
    for name, values in half_widths.items():
        error = np.abs(result[name].values - truth[name].values)
        known = np.isfinite(error)
        cases[str(name)] = values.values[known], error[known]
    return cases


def _joined(maps: Sequence[Cases]) -> Cases:
    """Return all half-widths and all errors of each quantity, map after map."""
    joined = {}
    for name in dict.fromkeys(name for cases in maps for name in cases):
        half_widths, errors = zip(*(cases[name] for cases in maps if name in cases), strict=True)
        joined[name] = np.concatenate(half_widths), np.concatenate(errors)
    return joined


class _Problem(TypedDict):
    """Keyword arguments of `solve_contact`, E* = 1."""

    contact_modulus: float
    mean_pressure: list[float]
    tolerance: float


def _problem(loads: Sequence[float] | np.ndarray) -> _Problem:
    """Return the problem that every map of this part is solved for."""
    return {"contact_modulus": 1.0, "mean_pressure": list(loads), "tolerance": 1e-4}


def _truth(surface: xr.DataArray, loads: np.ndarray, *, count: Count, box: int = 0) -> xr.Dataset:
    """Return what is counted of a surface; the pressure in contact is the load over the corrected area.

    The largest pressure is the median over all squares with sides of `box` points, where one is given.
    """

    def counted(contact: xr.Dataset) -> xr.Dataset:
        found = count(contact)
        if box:
            largest = maximum_filter(contact["pressure"].values[0], box, mode="wrap")
            found["max_pressure"] = ("load", [np.median(largest)])
        return found

    solved = solve_contact(surface, **_problem(loads), reduce=counted)
    pressure = solved["mean_pressure"].values / solved["relative_contact_area"].values
    return solved.assign(mean_contact_pressure=("load", pressure))
