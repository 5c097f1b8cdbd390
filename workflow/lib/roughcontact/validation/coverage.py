"""Does the ± hold? Intervals of the error budget against surfaces whose true numbers are known."""

from collections.abc import Sequence
from typing import TypedDict

import numpy as np
import xarray as xr
from scipy.ndimage import maximum_filter

from roughcontact.contact.solve import solve_contact
from roughcontact.levelling.level import level
from roughcontact.maps import refined
from roughcontact.quantities import number
from roughcontact.references import synthetic
from roughcontact.uncertainty.answers import answers_present, headline_and_answers
from roughcontact.uncertainty.budget import error_budget
from roughcontact.uncertainty.discretisation import discretisation_uncertainty, resolution_indicators
from roughcontact.uncertainty.ensemble import Count
from roughcontact.uncertainty.headline import QUANTITIES, headline
from roughcontact.validation.lines import Evidence, Line, Part, Table, compare
from roughcontact.validation.masters import FAULTS, KINDS, cut_out, master_surface
from roughcontact.window.periodic_window import periodic_window

Cases = dict[str, tuple[np.ndarray, np.ndarray]]  # quantity -> half-widths and errors

TITLE = "The error budget: how often the ± holds"
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

FINE = Evidence(
    "maps of 64 × 64 points; truth: their Fourier series on 512 × 512 points",
    "docs/explanation/uncertainty.md",
    "uncertainty.discretisation.discretisation_uncertainty",
    "tests/unit/test_uncertainty_discretisation.py::test_the_interval_of_the_pixel_size_covers_a_finer_solution",
)
MASTER = Evidence(
    "parts of large periodic surfaces of eight kinds, tilted, with points left out, a bow or spikes, "
    "processed by default; truth: the whole surface at the same mean pressure",
    "docs/explanation/uncertainty.md",
    "uncertainty.budget.error_budget",
    "tests/unit/test_uncertainty_budget.py::test_the_combined_interval_covers_the_surface_that_was_measured",
)


def part(*, finest_grid: int) -> Part:
    """Return the lines of this part.

    Parameters
    ----------
    finest_grid : int
        points along the finest grid.

    Returns
    -------
    Part
    """
    maps = _MAPS if finest_grid >= 1024 else _FEW_MAPS
    alone = pixel_size_cases(maps)
    combined = measured_cases(maps, master_points=min(320, finest_grid))
    lines, rows = [], []
    for what, cases, evidence in (
        ("Pixel size alone", alone, FINE),
        ("All sources together", combined, MASTER),
    ):
        for name, (half_width, error) in cases.items():
            covered = float(np.mean(error <= half_width))
            width = float(np.median(half_width / np.maximum(error, np.finfo(float).tiny)))
            counted = f"{what}: {_WORDS[name]}, share of the intervals that hold"
            lines.append(_coverage(counted, covered, maps, evidence))
            if evidence is FINE:
                lines.append(
                    _width(f"{what}: {_WORDS[name]}, half-width over error, median", width, evidence)
                )
            rows.append([what, _WORDS[name], str(error.size), number(covered), number(width, digits=2)])
    table = Table(
        "Coverage and width of the intervals",
        ["source", "quantity", "cases", "share that hold", "half-width over error, median"],
        rows,
        "An interval of 95 % of a normal distribution is 2.9 times as wide as the median error.",
    )
    text = (
        "The main numbers and the answers in the report have a ±. Here it is held against surfaces whose "
        "numbers are known: first the part for the pixel size alone, on maps of known fine solution; then "
        "all parts, on maps cut from large surfaces (random, worn, eroded, honed, dimpled, ground, turned, "
        "grainy), tilted, with missing points, a bow or spikes, and processed like measured ones. An "
        "interval without an upper end, where grooves leave the map, holds what is not below it."
    )
    return Part("coverage", TITLE, text, lines, (), [table])


class _Problem(TypedDict):
    """Keyword arguments of `solve_contact`, E* = 1."""

    contact_modulus: float
    mean_pressure: list[float]
    tolerance: float


class _Cases:
    """Half-widths and errors of each quantity, map after map."""

    def __init__(self) -> None:
        self._pairs: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}

    def add(self, half_widths: xr.Dataset, result: xr.Dataset, truth: xr.Dataset) -> None:
        """Take in the loads of one map; what conducts without end is no number."""
        for name in map(str, half_widths.data_vars):
            error = np.abs(result[name].values - truth[name].values)
            known = np.isfinite(error)
            self._pairs.setdefault(name, []).append((half_widths[name].values[known], error[known]))

    def joined(self) -> Cases:
        """Return all half-widths and all errors of each quantity."""
        joined = {}
        for name, pairs in self._pairs.items():
            half_widths, errors = (np.concatenate(values) for values in zip(*pairs, strict=True))
            joined[name] = (half_widths, errors)
        return joined


def pixel_size_cases(maps: int, *, seed: int = 2024) -> Cases:
    """Return half-widths and errors of the pixel size on maps of known fine solution.

    Each map has 64 x 64 points and is solved at five loads, p' from 0.007 to 0.9; its shortest wave has 2.2
    to 16 points, its longest is a quarter to the whole of the side, 0.2 <= H <= 1. The truth is its Fourier
    series on eight times as many points along each axis.

    Parameters
    ----------
    maps : int
        how many.
    seed : int
        of the random maps and loads.

    Returns
    -------
    dict
        quantity -> (half-widths, errors), arrays over all maps and loads, in the unit of the quantity.
    """
    generator = np.random.default_rng(seed)
    found = _Cases()
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
        found.add(half_widths[list(QUANTITIES)], solved, truth)
    return found.joined()


def measured_cases(maps: int, *, master_points: int, seed: int = 7) -> Cases:
    """Return half-widths and errors of the combined intervals of maps cut from known surfaces.

    The surfaces take turns among the kinds of `masters`; each is periodic, of `master_points` squared, its
    longest wave a quarter of the map at most. The map is cut out of it at random, 3/8 to 5/8 of its side,
    tilted, 1 % of its points are missing, in spots, and it takes turns among the faults. Levelling, window
    and budget are those of the default settings; the loads are given in Pa, so that the truth is the surface
    at the same mean pressure, with pixels half as large. That of the largest pressure is the median over all
    squares as large as the window.

    Parameters
    ----------
    maps : int
        how many.
    master_points : int
        along the side of each surface.
    seed : int
        of the random surfaces, maps and loads.

    Returns
    -------
    dict
        quantity -> (half-widths, errors), arrays over all maps and loads, in the unit of the quantity, the
        answers that have an interval among them; the half-widths are those to the side on which the truth
        lies, infinite where an interval has no end there.
    """
    generator = np.random.default_rng(seed)
    found = _Cases()
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
        for name in (*QUANTITIES, *answers_present(result)):
            lower, upper = (budget[f"{name}_{end}"] for end in ("lower", "upper"))
            upper = upper.where(np.isfinite(upper) | np.isnan(lower), np.inf)
            half_widths[name] = xr.where(
                truth[name] > result[name], upper - result[name], result[name] - lower
            )
        found.add(xr.Dataset(half_widths), result, truth)
    return found.joined()


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


def _coverage(what: str, covered: float, maps: int, evidence: Evidence) -> Line:
    """Return the line of a share of intervals that hold: 95 % is promised, more is no fault.

    The least is 90 %. With few maps, twice the standard deviation of a share of so many goes off that.
    """
    deviation = max(0.0, _PROMISED - covered)
    tolerance, reason = _PROMISED - _LEAST, "below 90 % the ± does not hold; more than 95 % is no fault"
    if maps < _MAPS:
        tolerance += 2 * np.sqrt(_PROMISED * (1 - _PROMISED) / maps)
        reason = f"below 90 % the ± does not hold; {maps} maps only"
    return Line(what, _PROMISED, covered, deviation, "absolute", float(tolerance), reason, evidence)


def _width(what: str, width: float, evidence: Evidence) -> Line:
    """Return the line of the median of half-width over error: from 1 to 3."""
    return compare(
        what,
        width,
        (1 + _WIDTH) / 2,
        measure="absolute",
        tolerance=(_WIDTH - 1) / 2,
        reason="neither narrower than the error nor three times as wide",
        evidence=evidence,
    )
