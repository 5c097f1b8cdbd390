"""Does the ± hold? Intervals of the error budget against surfaces whose true numbers are known."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypedDict

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import refined
from roughcontact.arguments.quantities import number
from roughcontact.contact.solve import solve_contact
from roughcontact.surface import synthetic
from roughcontact.surface.levelling.level import level
from roughcontact.surface.window.periodic_window import periodic_window
from roughcontact.uncertainty.budget import error_budget
from roughcontact.uncertainty.budget_inputs import budget_inputs
from roughcontact.uncertainty.ensemble import solve_member
from roughcontact.uncertainty.scales import ANSWERS, QUANTITIES, from_scale, to_scale
from validation.lines import Section, Table
from validation.masters import FAULTS, KINDS, cut_out, master_surface

# quantity -> half-widths, errors, and errors of the results as solved
Cases = dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]

_PROMISED, _LEAST = 0.95, 0.90  # share of the intervals that hold the true value
_MAPS, _FEW_MAPS = 40, 10  # at full size and at a small one
_LOADS_EACH = 5
_PLACES = 8  # maps whose mean is the truth
_TOLERANCE = 1e-3  # of their pressure
_WORDS = {
    "relative_contact_area": "contact area",
    "mean_gap": "mean gap",
    "max_pressure": "largest pressure",
    "mean_contact_pressure": "pressure in contact",
    "conductance_per_conductivity": "conductance",
    "critical_constriction_x": "narrowest place along x",
    "critical_constriction_y": "narrowest place along y",
}


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add lines and table of 40 maps of either kind, of 10 measured ones where the finest grid is coarse."""
    maps = _MAPS if finest_grid >= 1024 else _FEW_MAPS
    rows = []
    # these take seconds, and the ratio of medians of ten maps would scatter by 0.2
    for name, (half_width, error, as_solved) in pixel_size_cases(_MAPS).items():
        covered, width = _coverage_and_width(half_width, error)
        _add_share(section, "pixel share", _WORDS[name], covered, _MAPS)
        gain = float(np.median(error) / np.median(as_solved))
        section.compare("pixel gain", gain, 0.5, 0.5, quantity=_WORDS[name])
        rows.append(("Pixel size alone", _WORDS[name], error.size, covered, width))
    for name, (half_width, error, _) in measured_cases(maps, master_points=min(320, finest_grid)).items():
        covered, width = _coverage_and_width(half_width, error)
        _add_share(section, "share", _WORDS[name], covered, maps)
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
    section.tables.append(table)


def _coverage_and_width(half_width: np.ndarray, error: np.ndarray) -> tuple[float, float]:
    """Return the share of the intervals that hold, and the median of half-width over error."""
    ratio = half_width / np.maximum(error, np.finfo(float).tiny)
    return float(np.mean(error <= half_width)), float(np.median(ratio))


def _add_share(section: Section, name: str, quantity: str, covered: float, maps: int) -> None:
    """Add the line of a share of intervals that hold: 95 % is promised, more is no fault.

    The least is 90 %. With few maps, twice the standard deviation of a share of so many goes off that.
    """
    tolerance, limit = _PROMISED - _LEAST, "more than 95 % is no fault"
    if maps < _MAPS:
        tolerance += 2 * np.sqrt(_PROMISED * (1 - _PROMISED) / maps)
        limit = f"{maps} maps only"
    line = section.compare(name, covered, _PROMISED, tolerance, quantity=quantity, limit=limit)
    section.lines[-1] = replace(line, deviation=max(0.0, _PROMISED - covered))


def pixel_size_cases(maps: int, *, seed: int = 2024) -> Cases:
    """Return half-widths and errors of the correction for the pixel size on maps of known fine solution.

    Each map has 64 x 64 points and is solved at five loads, p' from 0.007 to 0.9; its shortest wave has 2.2
    to 16 points, its longest is a quarter to the whole of the side, 0.2 <= H <= 1. The truth is its Fourier
    series on eight times as many points along each axis. `seed` is that of the random maps and loads.

    Returns
    -------
    dict
        quantity -> (half-widths, errors) of the corrected results, and errors of those as solved, arrays over
        all maps and loads, in the unit of the quantity.
    """
    generator = np.random.default_rng(seed)
    computed = []
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
        solved = solve_contact(window, **contact, reduce=budget_inputs)
        settings = {"level": {}, "window": {}, "contact": contact}
        budget = error_budget(window, window, settings, sources=["discretisation"], solved=solved)
        fine = solve_contact(refined(window, 8), **contact, reduce=budget_inputs)
        computed.append(_cases(budget, {name: fine[name].values for name in QUANTITIES}, loads))
    return _joined(computed)


def measured_cases(maps: int, *, master_points: int, seed: int = 7) -> Cases:
    """Return half-widths and errors of the intervals of maps cut from known surfaces.

    The surfaces take turns among the kinds of `masters`; each is periodic, of `master_points` squared, its
    longest wave a quarter of the map at most. The map is cut out of it at random, 3/8 to 5/8 of its side,
    tilted, 1 % of its points are missing, in spots, and it takes turns among the faults. Levelling, window
    and budget are those of the default settings. The truth is the mean, on the scale of each quantity, of
    what eight such maps without a fault show at the same loads (Pa). `seed` is that of the random surfaces,
    maps and loads.

    Returns
    -------
    dict
        quantity -> as of `pixel_size_cases`, the answers that have an interval among them; the half-widths
        are those to the side on which the truth lies, infinite where an interval has no end there.
    """
    generator = np.random.default_rng(seed)
    computed = []
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
        contact = _problem(loads)
        settings = {"level": {}, "window": {}, "contact": contact}
        budget = error_budget(levelled, periodic_window(levelled), settings)
        names = [name for name in (*QUANTITIES, *ANSWERS) if f"{name}_lower" in budget]
        others = [
            solve_member(
                periodic_window(level(cut_out(master, side, generator, fault="none"))),
                contact,
                tolerance=_TOLERANCE,
                names=names,
            )
            for _ in range(_PLACES)
        ]
        truth = {
            name: from_scale(name, np.mean([to_scale(name, other[name]) for other in others], axis=0))
            for name in names
        }
        computed.append(_cases(budget, truth, loads))
    return _joined(computed)


def _cases(budget: xr.Dataset, truth: Mapping[str, np.ndarray], loads: np.ndarray) -> Cases:
    """Return half-widths towards the truth and errors at the loads of one map.

    The true pressure in contact is the load over the area; an infinite conductance is left out.
    """
    truth = {**truth, "mean_contact_pressure": loads / truth["relative_contact_area"]}
    cases = {}
    for name, true in truth.items():
        value, lower, upper = (budget[f"{name}_{key}"].values for key in ("estimate", "lower", "upper"))
        as_solved = budget.get(f"{name}_as_solved", budget[f"{name}_estimate"]).values
        upper = np.where(np.isnan(upper) & ~np.isnan(lower), np.inf, upper)
        half_width, error = np.where(true > value, upper - value, value - lower), np.abs(true - value)
        expected = np.isfinite(error)
        cases[name] = half_width[expected], error[expected], np.abs(true - as_solved)[expected]
    return cases


def _joined(maps: Sequence[Cases]) -> Cases:
    """Return all half-widths and all errors of each quantity, map after map."""
    joined = {}
    for name in dict.fromkeys(name for cases in maps for name in cases):
        columns = zip(*(cases[name] for cases in maps if name in cases), strict=True)
        half_width, error, as_solved = map(np.concatenate, columns)
        joined[name] = half_width, error, as_solved
    return joined


class _Problem(TypedDict):
    """Keyword arguments of `solve_contact`, E* = 1."""

    contact_modulus: float
    mean_pressure: list[float]
    tolerance: float


def _problem(loads: Sequence[float] | np.ndarray) -> _Problem:
    """Return the problem that every map of this section is solved for."""
    return {"contact_modulus": 1.0, "mean_pressure": list(loads), "tolerance": 1e-4}
