"""Consistency: numbers that are computed apart and must fit together, whatever the surface."""

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import height_map, spacing
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.synthetic import rough_reference_surface
from validation import drawing
from validation.lines import Figure, Section
from validation.problems import solve

_POINTS = 128
_STEP = 1e-5  # relative step of load: so small that no point comes or goes


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the lines and the figure of the rough reference case on 128 x 128 points."""
    height = rough_reference_surface(_POINTS)
    _differences(section, height)
    _sweep(section, height)
    _tiling(section)


def _differences(section: Section, height: xr.DataArray) -> None:
    """Add the lines of small differences around several loads."""
    for relative in (0.02, 0.05, 0.2, 0.5, 1.0):
        load = relative * rms_gradient(height)
        below, above = solve(height, [load * (1 - _STEP), load * (1 + _STEP)], 1e-12)
        closed = -(above.mean_gap - below.mean_gap)
        section.compare("work", (above.energy - below.energy) / closed, load, 1e-6, load=relative)
        response = below.compliance(1e-5)
        section.compare("stiffness", closed / (2 * _STEP * load), response, 1e-5, load=relative)


def _sweep(section: Section, height: xr.DataArray) -> None:
    """Add lines and figure of a whole sweep of loads: sums over it against the difference of its ends."""
    gradient = rms_gradient(height)
    relative = np.geomspace(0.01, 1.0, 49)
    loads = relative * gradient
    contacts = solve(height, list(loads), 1e-8)
    energies, gaps = (np.array([getattr(c, name) for c in contacts]) for name in ("energy", "mean_gap"))
    compliances = np.array([contact.compliance(1e-3) for contact in contacts])
    middle = np.sqrt(loads[1:] * loads[:-1])
    work = -(middle * np.diff(gaps)).sum()
    closed = float(np.trapezoid(compliances * loads, np.log(loads)))
    section.compare("sweep of energy", energies[-1] - energies[0], work, 1e-3)
    section.compare("sweep of gap", gaps[0] - gaps[-1], closed, 1e-2)
    slopes = -np.diff(energies) / np.diff(gaps)
    image = drawing.chart(
        [
            ("dU/dū = −p̄", relative, relative),
            ("response of the contact set × p̄ / ū₀", relative, compliances * loads / gaps[0]),
        ],
        [
            ("−ΔU/Δū / (E* g)", middle / gradient, slopes / gradient),
            ("−Δū/Δ ln p̄ / ū₀", middle / gradient, -np.diff(gaps) / np.diff(np.log(loads)) / gaps[0]),
        ],
        x="relative pressure p′ = p̄ / (E* g)",
        y="relative to E* g, and to the first gap ū₀",
        scales=("log", "log"),
    )
    caption = "Differences along the sweep (marks) against what they must be (lines)."
    section.figures.append(Figure("Along a sweep of loads", image, caption))


def _tiling(section: Section) -> None:
    """Add the lines of a map solved alone and together with copies of itself."""
    single = rough_reference_surface(64)
    load = 0.2 * rms_gradient(single)

    def numbers(height: xr.DataArray) -> dict[str, float]:
        (contact,) = solve(height, [load], 1e-10)
        return {
            "approach": contact.approach,
            "mean gap": contact.mean_gap,
            "energy": contact.energy,
            "share of points in contact": contact.touching.mean(),
        }

    alone = numbers(single)
    for rows, columns in ((2, 2), (3, 1)):
        together = numbers(height_map(np.tile(single.values, (rows, columns)), spacing(single)))
        for quantity, expected in alone.items():
            fields = {"rows": rows, "columns": columns, "quantity": quantity}
            section.compare("tiled", together[quantity], expected, 1e-9, **fields)
