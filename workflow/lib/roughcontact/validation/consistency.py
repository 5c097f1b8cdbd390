"""Consistency: numbers that are computed apart and must fit together, whatever the surface."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from roughcontact.contact.response import linear_response
from roughcontact.contact.solve import solve_contact
from roughcontact.elasticity.energy import elastic_energy
from roughcontact.maps import height_map, spacing
from roughcontact.references import synthetic
from roughcontact.roughness import parameters
from roughcontact.validation import drawing
from roughcontact.validation.lines import Evidence, Figure, Line, Part, compare

TITLE = "Energy, gap and stiffness belong together"
_POINTS = 128
_LOADS = (0.02, 0.05, 0.2, 0.5, 1.0)
_STEP = 1e-5  # relative step of load: so small that no point comes or goes

_CODE = "tests/unit/test_validation.py::test_consistency_of_the_closed_forms"
WORK = Evidence(
    "dU/dū = −p̄: the work of the load is stored",
    "Persson (2007), Phys. Rev. Lett. 99, 125502",
    "elasticity.energy.elastic_energy, gap of solve_contact",
    _CODE,
)
STIFFNESS = Evidence(
    "−dū/dp̄ = ⟨x, G x⟩, x the increment of pressure on the contact set, mean 1, that leaves no gap",
    "linear response of a fixed contact set: Hertz contacts stay, edges carry no pressure",
    "contact.response.linear_response",
    _CODE,
)
TILED = Evidence(
    "the same surface, repeated, is the same problem (q = 0: zero)",
    "periodicity",
    "contact.solve.solve_contact",
    "tests/unit/test_contact_dataset.py::test_relative_numbers_do_not_depend_on_units_position_or_orientation",
)


def part(*, finest_grid: int) -> Part:
    """Return the lines and figures of this part.

    Parameters
    ----------
    finest_grid : int
        points along the finest grid.
        Maps of 128 points serve whatever it is.

    Returns
    -------
    Part
    """
    height = synthetic.rough_reference_surface(_POINTS)
    sweep, figure = _sweep(height)
    text = (
        "Pressure, gap and energy come from different sums over the solution. Along a sweep of loads they "
        "must fit: the energy grows by the work of the load, and the gap answers to the load as the contact "
        "set does. And nothing may change when the map is solved together with copies of itself. The rough "
        f"reference case, {_POINTS} × {_POINTS} points."
    )
    return Part("consistency", TITLE, text, [*_differences(height), *sweep, *_tiling()], [figure])


def _solved(
    height: xr.DataArray, loads: Sequence[float], tolerance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (energies, mean gaps, contact sets) at the loads, E* = 1."""
    contact = solve_contact(height, contact_modulus=1.0, mean_pressure=loads, tolerance=tolerance)
    pressures, gaps = contact["pressure"].values, contact["gap"].values
    energies = [elastic_energy(p, spacing(height), contact_modulus=1.0) for p in pressures]
    means = [gap[p == 0].sum() / gap.size for p, gap in zip(pressures, gaps, strict=True)]
    return np.array(energies), np.array(means), pressures > 0


def _differences(height: xr.DataArray) -> list[Line]:
    """Return the lines of small differences around several loads."""
    gradient = parameters.rms_gradient(height)
    lines = []
    for relative in _LOADS:
        load = relative * gradient
        energies, gaps, sets = _solved(height, [load * (1 - _STEP), load * (1 + _STEP)], 1e-12)
        lines += [
            compare(
                f"p′ = {relative:g}: −dU/dū / E*, against p̄ / E*",
                -(energies[1] - energies[0]) / (gaps[1] - gaps[0]),
                load,
                tolerance=1e-6,
                reason="rounding in differences over 2e-5 of the load",
                evidence=WORK,
            ),
            compare(
                f"p′ = {relative:g}: −dū/dp̄ × E* / length, against the response of the contact set",
                -(gaps[1] - gaps[0]) / (2 * _STEP * load),
                linear_response(sets[0], spacing(height), 1.0, 1e-5),
                tolerance=1e-5,
                reason="rounding, and the 1e-5 of the iteration for the response",
                evidence=STIFFNESS,
            ),
        ]
    return lines


def _sweep(height: xr.DataArray) -> tuple[list[Line], Figure]:
    """Return lines and figure of a whole sweep of loads: sums over it against the difference of its ends."""
    gradient = parameters.rms_gradient(height)
    relative = np.geomspace(0.01, 1.0, 49)
    loads = relative * gradient
    energies, gaps, sets = _solved(height, list(loads), 1e-8)
    compliances = np.array([linear_response(touching, spacing(height), 1.0, 1e-3) for touching in sets])
    middle = np.sqrt(loads[1:] * loads[:-1])
    work = -(middle * np.diff(gaps)).sum()
    closed = float(np.trapezoid(compliances * loads, np.log(loads)))
    slopes = -np.diff(energies) / np.diff(gaps)
    lines = [
        compare(
            "Sweep, p′ from 0.01 to 1: energy gained, against Σ p̄ Δū",
            energies[-1] - energies[0],
            work,
            tolerance=1e-3,
            reason="sum over 48 steps of load",
            evidence=WORK,
        ),
        compare(
            "Sweep, p′ from 0.01 to 1: gap closed, against the integral of the response",
            gaps[0] - gaps[-1],
            closed,
            tolerance=1e-2,
            reason="sum over 48 steps of load",
            evidence=STIFFNESS,
        ),
    ]
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
    return lines, Figure("Along a sweep of loads", image, caption)


def _tiling() -> list[Line]:
    """Return the lines of a map solved alone and together with copies of itself."""
    single = synthetic.rough_reference_surface(64)
    load = 0.2 * parameters.rms_gradient(single)

    def numbers(height: xr.DataArray) -> dict[str, float]:
        contact = solve_contact(height, contact_modulus=1.0, mean_pressure=load, tolerance=1e-10)
        pressure, gap = contact["pressure"].values[0], contact["gap"].values[0]
        return {
            "approach": float(contact["approach"][0]),
            "mean gap": gap[pressure == 0].sum() / gap.size,
            "energy": elastic_energy(pressure, spacing(height), contact_modulus=1.0),
            "share of points in contact": np.count_nonzero(pressure) / pressure.size,
        }

    alone = numbers(single)
    lines = []
    for copies in ((2, 2), (3, 1)):
        together = numbers(height_map(np.tile(single.values, copies), spacing(single)))
        lines += [
            compare(
                f"{copies[0]} × {copies[1]} copies at p′ = 0.2: {name}",
                together[name],
                alone[name],
                tolerance=1e-9,
                reason="ten times the solver's tolerance of 1e-10",
                evidence=TILED,
            )
            for name in alone
        ]
    return lines
