"""Rough maps: the rough reference case, a map that other codes solved, an ensemble beside the theories."""

import numpy as np
import xarray as xr

from roughcontact.contact.loads import DEFAULT_PLAN
from roughcontact.contact.solve import solve_contact
from roughcontact.quantities import number, percent
from roughcontact.references import closed_forms, synthetic
from roughcontact.roughness import parameters
from roughcontact.roughness.summits import summit_statistics
from roughcontact.statistics import theory
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.validation import drawing
from roughcontact.validation.lines import Evidence, Figure, Line, Part, Table, compare

TITLE = "Rough maps, other codes, and the statistical theories"
_MAPS = 6
_SOLVER = "tests/unit/test_contact_closed_forms.py"

MAP = Evidence(
    "F = fft2(default_rng(0).standard_normal((64, 64))) K^−1.8, 2 ≤ K ≤ 16 waves per side, zero-padded; side "
    "1",
    "rough reference case, see docs/explanation/validation.md",
    "references.synthetic.rough_reference_surface",
    "tests/unit/test_synthetic.py::test_rough_reference_case_is_the_published_one",
)
INDEPENDENT = Evidence(
    "area corrected by the perimeter, mean gap over the rms height 0.023699516",
    "an independent code at 1024 × 1024",
    "references.closed_forms.ROUGH_AREA_AND_GAP",
    f"{_SOLVER}::test_rough_reference_case",
)
TWO_CODES = Evidence(
    "self-affine map, 256 × 256, H = 0.8, waves of 8 to 64 points, g = 1, seed 0",
    "Tamaas 2.9.0 (PolonskyKeerRey, 1e-12); ContactMechanics 1.8.3 agrees; docs/explanation/validation.md "
    "says how to repeat it",
    "references.closed_forms.OUTSIDE_CODES",
    "tests/unit/test_crosscheck.py::test_the_stored_numbers_of_the_other_codes",
)
XU = Evidence(
    "A = erf(√2 p′ / √(0.42 + 0.58 A))",
    "Xu, Li, Chen and Zhou (2024)",
    "statistics.theory.xu_area",
    "tests/unit/test_theory.py::test_xu_solves_its_equation",
)
SLOPES = Evidence(
    "√(8/π) p′ < A/A₀ < √(2π) p′ at low load",
    "Persson (2001); Bush, Gibson and Thomas (1975)",
    "statistics.theory.persson_area, statistics.theory.bush_gibson_thomas_area",
    "tests/unit/test_theory.py::test_persson_slope_and_full_contact",
)


def part(*, finest_grid: int) -> Part:
    """Return the lines and figures of this part.

    Parameters
    ----------
    finest_grid : int
        points along the finest grid.

    Returns
    -------
    Part
    """
    case = _reference_case(finest_grid // 2)
    codes = _outside_codes()
    ensemble, figure, table = _ensemble(finest_grid // 4)
    text = (
        "A rough map has no closed form: here other codes give the numbers. Below, the contact area of "
        "several self-affine maps over the load, with the statistical theories. Persson and Xu know only "
        "the rms gradient; Bush, Gibson and Thomas hold at low load; Greenwood and Williamson get the "
        "summits of each map itself. The table shows how far each is off: they are no reference, and none "
        "of them enters the solution."
    )
    return Part("rough", TITLE, text, [*case, *codes, *ensemble], [figure], [table])


def ensemble_map(points: int, seed: int) -> xr.DataArray:
    """Return a self-affine map of unit side and gradient, H = 0.8, waves of 8 points to a quarter side.

    Parameters
    ----------
    points : int
        along each side.
    seed : int

    Returns
    -------
    DataArray (y, x)

    Examples
    --------
    >>> from roughcontact.roughness.parameters import rms_gradient
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


def _reference_case(points: int) -> list[Line]:
    """Return the lines of the rough reference case."""
    height = synthetic.rough_reference_surface(points)
    gradient, rms = parameters.rms_gradient(height), parameters.rms_height(height)
    lines = [
        compare(
            f"Rough reference case: {what}",
            value,
            known,
            tolerance=tolerance,
            reason="all digits that are known",
            evidence=MAP,
        )
        for what, value, known, tolerance in (
            ("rms height", rms, 0.023699516, 3e-8),
            ("rms gradient g", gradient, 0.55501825, 1e-8),
        )
    ]
    known = closed_forms.ROUGH_AREA_AND_GAP
    contact = solve_contact(
        height, contact_modulus=1.0, mean_pressure=[p * gradient for p in known], tolerance=1e-6
    )
    same = points == 1024
    for index, (load, (area, gap)) in enumerate(known.items()):
        pressure, gaps = (contact[name].values[index] for name in ("pressure", "gap"))
        found = relative_contact_area(pressure > 0)
        for what, value, expected, coarse in (
            ("contact area", found, area, 0.25 / points),
            ("mean gap / rms height", gaps[pressure == 0].sum() / pressure.size / rms, gap, 0.05 / points),
        ):
            lines.append(
                compare(
                    f"Rough reference case, p′ = {load:g}: {what}",
                    value,
                    expected,
                    measure="absolute",
                    tolerance=2e-5 + (0 if same else coarse),
                    reason="fifth decimal" + ("" if same else f", and the coarser grid, n = {points}"),
                    evidence=INDEPENDENT,
                )
            )
        lines.append(
            compare(
                f"Rough reference case, p′ = {load:g}: contact area, theory of Xu et al.",
                found,
                float(theory.xu_area(load)),
                tolerance=0.04 + (0 if same else 0.25 / points / area),
                reason="the theory is an estimate, 4 % here"
                + ("" if same else f"; coarser grid, n = {points}"),
                evidence=XU,
            )
        )
    return lines


def _outside_codes() -> list[Line]:
    """Return the lines of one map that two other codes have solved."""
    height = ensemble_map(256, seed=0)
    known = closed_forms.OUTSIDE_CODES
    contact = solve_contact(height, contact_modulus=1.0, mean_pressure=list(known), tolerance=1e-9)
    lines = []
    for index, (load, (touching, peak, gap)) in enumerate(known.items()):
        pressure, gaps = (contact[name].values[index] for name in ("pressure", "gap"))
        for what, value, expected, tolerance, reason in (
            (
                "points in contact",
                float(np.count_nonzero(pressure)),
                touching,
                0.5 / touching,
                "the very same points",
            ),
            ("largest pressure / E*", pressure.max(), peak, 1e-7, "ten times the digits of the iterations"),
            ("mean gap / length", gaps[pressure == 0].sum() / pressure.size, gap, 1e-7, "as above"),
        ):
            lines.append(
                compare(
                    f"Self-affine map, p̄ = {load:g} E*: {what}",
                    value,
                    expected,
                    tolerance=tolerance,
                    reason=reason,
                    evidence=TWO_CODES,
                )
            )
    return lines


def _ensemble(points: int) -> tuple[list[Line], Figure, Table]:
    """Return (lines, figure, table) of the area of several maps against the load, with the theories."""
    loads = np.array(DEFAULT_PLAN)
    solved_areas, summits = [], []
    for seed in range(_MAPS):
        height = ensemble_map(points, seed)
        contact = solve_contact(height, contact_modulus=1.0, mean_pressure=list(loads), tolerance=1e-4)
        solved_areas.append([relative_contact_area(touching > 0) for touching in contact["contact"].values])
        summits.append(summit_statistics(height))
    areas = np.array(solved_areas)
    mean = areas.mean(axis=0)
    theories = _theories(loads, summits)
    low, high = np.sqrt(8 / np.pi), np.sqrt(2 * np.pi)
    line = compare(
        f"{_MAPS} self-affine maps, p′ = {loads[0]:g}: (A/A₀)/p′, between Persson and Bush-Gibson-Thomas",
        mean[0] / loads[0],
        (low + high) / 2,
        measure="absolute",
        tolerance=(high - low) / 2,
        reason="half the distance of the two theories, which enclose it",
        evidence=SLOPES,
    )
    bands = f"H = 0.8, waves of 8 to {points // 4} points, {points} × {points}"
    line_loads = np.geomspace(loads[0], loads[-1], 80)
    figure = Figure(
        "Contact area over load",
        drawing.area_chart(line_loads, _theories(line_loads, summits), loads, areas),
        f"Area divided by load for {_MAPS} self-affine maps ({bands}): marks are the mean, the band is the "
        "range.",
    )
    rows = [
        [
            number(load),
            percent(solved),
            percent(spread),
            *(
                "–" if np.isnan(values[index]) else percent(values[index] / solved - 1)
                for _, values in theories
            ),
        ]
        for index, (load, solved, spread) in enumerate(
            zip(loads, mean, areas.std(axis=0, ddof=1) / mean, strict=True)
        )
    ]
    table = Table(
        "How far the theories are off",
        ["p′", "A/A₀ solved", "scatter of the maps", *(f"{name}, off by" for name, _ in theories)],
        rows,
        "Relative deviation of each theory from the mean of the solved maps. Where a theory says nothing: –.",
    )
    return [line], figure, table


def _theories(loads: np.ndarray, summits: list[dict[str, float]]) -> list[tuple[str, np.ndarray]]:
    """Return (name, areas at the loads) of each theory; Greenwood-Williamson as the mean over the maps."""
    asperities = [theory.greenwood_williamson_area(loads, one, contact_modulus=1.0) for one in summits]
    return [
        ("Persson", theory.persson_area(loads)),
        ("Xu et al.", theory.xu_area(loads)),
        ("Bush-Gibson-Thomas", theory.bush_gibson_thomas_area(loads)),
        ("Greenwood-Williamson", np.mean(asperities, axis=0)),
    ]
