"""Rough maps: the rough reference case, a map that other codes solved, an ensemble beside the theories."""

import numpy as np
import xarray as xr

from roughcontact.arguments.quantities import number, percent
from roughcontact.contact.loads import DEFAULT_PLAN
from roughcontact.statistics import theory
from roughcontact.surface import synthetic
from roughcontact.surface.roughness import parameters
from roughcontact.surface.roughness.summits import summit_statistics
from validation import closed_forms, drawing
from validation.lines import Figure, Section, Table
from validation.problems import solve

_MAPS = 6


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the reference case on a grid half as fine, and the maps of the ensemble on a quarter."""
    _reference_case(section, finest_grid // 2)
    _outside_codes(section)
    _ensemble(section, finest_grid // 4)


def ensemble_map(points: int, seed: int) -> xr.DataArray:
    """Return a self-affine map of unit side and gradient, H = 0.8, waves of 8 points to a quarter side.

    Examples
    --------
    >>> from roughcontact.surface.roughness.parameters import rms_gradient
    >>> round(rms_gradient(ensemble_map(64, seed=0)), 6)
    1.0
    """
    return synthetic.self_affine_surface(
        (points, points),
        1 / points,
        hurst=0.8,
        shortest=8 / points,
        longest=1 / 4,
        rms_gradient=1.0,
        seed=seed,
    )


def _reference_case(section: Section, points: int) -> None:
    """Add the lines of the rough reference case."""
    height = synthetic.rough_reference_surface(points)
    gradient, rms = parameters.rms_gradient(height), parameters.rms_height(height)
    section.compare("rms height", rms, 0.023699516, 3e-8)
    section.compare("rms gradient", gradient, 0.55501825, 1e-8)
    expected = closed_forms.ROUGH_AREA_AND_GAP
    contacts = solve(height, [load * gradient for load in expected], 1e-6)
    # the other code has solved it on 1024 x 1024 points
    coarse = 0.0 if points == 1024 else 1 / points
    grid = f", and the coarser grid, n = {points}" if coarse else ""
    for contact, (load, (area, gap)) in zip(contacts, expected.items(), strict=True):
        for name, value, reference, tolerance in (
            ("area", contact.area, area, 2e-5 + 0.25 * coarse),
            ("gap", contact.mean_gap / rms, gap, 2e-5 + 0.05 * coarse),
            ("xu", contact.area, float(theory.xu_area(load)), 0.04 + 0.25 * coarse / area),
        ):
            section.compare(name, value, reference, tolerance, load=load, grid=grid)


def _outside_codes(section: Section) -> None:
    """Add the lines of one map that two other codes have solved."""
    expected = closed_forms.OUTSIDE_CODES
    contacts = solve(ensemble_map(256, seed=0), list(expected), 1e-9)
    for contact, (load, (touching, peak, gap)) in zip(contacts, expected.items(), strict=True):
        section.compare("points", np.count_nonzero(contact.pressure), touching, 0.5 / touching, load=load)
        section.compare("peak", contact.pressure.max(), peak, 1e-7, load=load)
        section.compare("mean gap", contact.mean_gap, gap, 1e-7, load=load)


def _ensemble(section: Section, points: int) -> None:
    """Add line, figure and table of the area of several maps against the load, with the theories."""
    loads = np.array(DEFAULT_PLAN)
    maps = [ensemble_map(points, seed) for seed in range(_MAPS)]
    areas = np.array([[contact.area for contact in solve(height, list(loads), 1e-4)] for height in maps])
    summits = [summit_statistics(height) for height in maps]
    mean = areas.mean(axis=0)
    low, high = np.sqrt(8 / np.pi), np.sqrt(2 * np.pi)
    slope, middle = mean[0] / loads[0], (low + high) / 2
    section.compare("slopes", slope, middle, (high - low) / 2, maps=_MAPS, load=loads[0])
    line_loads = np.geomspace(loads[0], loads[-1], 80)
    image = drawing.area_chart(line_loads, _theories(line_loads, summits), loads, areas)
    caption = (
        f"Area divided by load for {_MAPS} self-affine maps (H = 0.8, waves of 8 to {points // 4} points, "
        f"{points} × {points}): marks are the mean, the band is the range."
    )
    section.figures.append(Figure("Contact area over load", image, caption))
    section.tables.append(_deviations(loads, areas, _theories(loads, summits)))


def _deviations(loads: np.ndarray, areas: np.ndarray, theories: dict[str, np.ndarray]) -> Table:
    """Return the table of how far the theories are from the mean of the areas (map, load)."""
    mean = areas.mean(axis=0)
    columns = [
        [number(load) for load in loads],
        [percent(area) for area in mean],
        [percent(spread) for spread in areas.std(axis=0, ddof=1) / mean],
        *(["–" if np.isnan(off) else percent(off) for off in area / mean - 1] for area in theories.values()),
    ]
    return Table(
        "How far the theories are off",
        ["p′", "A/A₀ solved", "scatter of the maps", *(f"{name}, off by" for name in theories)],
        [list(row) for row in zip(*columns, strict=True)],
        "Relative deviation of each theory from the mean of the solved maps. Where a theory says nothing: –.",
    )


def _theories(loads: np.ndarray, summits: list[dict[str, float]]) -> dict[str, np.ndarray]:
    """Return the areas of each theory at the loads; Greenwood-Williamson as the mean over the maps."""
    asperities = [theory.greenwood_williamson_area(loads, one, contact_modulus=1.0) for one in summits]
    return {
        "Persson": theory.persson_area(loads),
        "Xu et al.": theory.xu_area(loads),
        "Bush-Gibson-Thomas": theory.bush_gibson_thomas_area(loads),
        "Greenwood-Williamson": np.mean(asperities, axis=0),
    }
