"""The intervals of the quantities: of the surface, the next map, shorter waves, the joint, and this map."""

import math
from collections.abc import Mapping
from itertools import product

import numpy as np

from roughcontact.arguments.choices import UncertaintySource
from roughcontact.uncertainty import calibration, combination
from roughcontact.uncertainty.calibration import ALONE, JOINT, MEASURANDS
from roughcontact.uncertainty.combination import SIGNS, Component, Components
from roughcontact.uncertainty.discretisation import CORRECTED
from roughcontact.uncertainty.ensemble import Result, Values
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, GAP, PEAK, PRESSURE, from_scale, to_scale
from roughcontact.uncertainty.subwindows import Scatter

Windows = Mapping[calibration.Measurand, Components]  # measurand -> components of the source `window`


def window_components(
    scatter: Scatter, middle: Values, gap: np.ndarray, *, rms_height: float = math.inf
) -> Windows:
    """Return by how much the truth of each measurand may differ from this map, on the scales.

    `middle` are corrected results, `gap` the mean gap (load; m), `rms_height` (m) that of the map.
    """
    measurands = (*MEASURANDS, *(key for key in (ALONE, JOINT) if key in scatter.arms))
    windows: dict[calibration.Measurand, dict[str, Component]] = {key: {} for key in measurands}
    area, has_scatter = from_scale(AREA, middle[AREA]), bool(scatter.arms or scatter.features)
    gap_over_height = gap / (rms_height or math.inf)  # of a flat map, whose gap is closed
    for measurand, name in product(measurands, middle):
        # without subwindows nothing bounds what other places would give
        below = above = np.full(gap.shape, np.inf)
        if measurand == "map" and (scatter.of_positions or not has_scatter):
            below = above = np.zeros(gap.shape)
        elif arm := scatter.arms.get(measurand, {}).get(name):  # whatever the size of the map
            below, above = arm
        elif measurand == JOINT:  # of which the map says nothing
            continue
        elif has_scatter:
            below, above = calibration.arms(measurand, name, scatter.features[name], area, gap_over_height)
        if name in CONSTRICTIONS and has_scatter:  # counted in mean gaps
            below, above = below * gap, above * gap
        if name in scatter.open_ended and measurand != "map":
            above = np.where(scatter.open_ended[name], np.inf, above)
        windows[measurand][name] = combination.half_widths(below, above)
    return windows


def interval_columns(
    result: Result,
    as_solved: Values,
    middle: Values,
    components: Mapping[UncertaintySource, Components],
    scatter: Scatter | None,
    octave: Components | None,
    hardest: float = math.inf,
) -> dict[str, tuple]:
    """Return the ends of all intervals of the quantities, and what they are made of.

    `as_solved` are results (load), `middle` corrected ones on their scales. Without `octave` shorter waves
    have no interval; of an empty one, where the settings chose the band, it is that of the surface.
    `hardest` is the upper end of the hardness (Pa).
    """
    centres, values = _consistent(result, as_solved, middle)
    for name in {AREA, PRESSURE} & {*as_solved}:  # full contact, up to the rounding of its scale
        values[name] = np.where(as_solved[AREA] >= 1, as_solved[name], values[name])
    windows: Windows = {key: {} for key in MEASURANDS}
    widest = np.zeros(result.load.size)  # gap of a member
    if scatter:
        windows = window_components(scatter, middle, as_solved[GAP], rms_height=float(result.window.std()))
        widest = np.fmax.reduce(scatter.members[GAP], axis=0, initial=0.0)
    components = {source: add_pressure(causes, centres[AREA]) for source, causes in components.items()}
    windows = {key: add_pressure(component, centres[AREA]) for key, component in windows.items()}
    # measurand -> what adds up; without the source `window` nothing is known of other places
    causes: dict[str, list[Components]] = {
        key: [*components.values(), component] if scatter or key != "next" else []
        for key, component in windows.items()
    }
    causes["octave"] = [] if octave is None else [*causes["surface"], add_pressure(octave, centres[AREA])]
    columns: dict[str, tuple] = {}
    if scatter and scatter.overview:  # the map, without what its overview shows of other places
        of_map = {name: centre - scatter.shift.get(name, 0.0) for name, centre in middle.items()}
        in_units = _consistent(result, as_solved, of_map)[1]
        columns |= {f"{name}_{ALONE}": ("load", in_units[name]) for name in (*scatter.shift, PRESSURE)}
    for name, plain in as_solved.items():
        value = values[name]
        for key, parts in causes.items():
            if key == JOINT and name not in windows[JOINT]:
                continue
            lower = upper = np.full(value.shape, np.nan)
            if present := [part[name] for part in parts if name in part]:
                bounds = combination.interval_bounds(name, centres[name], combination.added_up(present))
                if name == GAP and scatter:  # closed by full contact, it may be open elsewhere
                    bounds = np.where(value > 0, bounds[0], 0.0), np.where(value > 0, bounds[1], widest)
                bounds = combination.monotonic(name, bounds, result.load)
                lower, upper = combination.limited(name, bounds, value, result.load, hardest)
            prefix = name if key == "surface" else f"{name}_{key}"
            columns |= {f"{prefix}_lower": ("load", lower), f"{prefix}_upper": ("load", upper)}
        if scatter and name in scatter.joint:
            centre = centres[name] + scatter.joint[name]
            joint = from_scale(name, area_for_the_load(result, {AREA: centre}) if name == AREA else centre)
            columns[f"{name}_{JOINT}"] = "load", np.where(np.isnan(joint), value, joint)
        if name in (*CORRECTED, PRESSURE, *(scatter.shift if scatter else ())):
            columns[f"{name}_as_solved"] = ("load", plain)
        by_source = {**components, "window": windows["surface"]}
        of_name = {source: parts[name] for source, parts in by_source.items() if name in parts}
        bounds = columns[f"{name}_lower"][1], columns[f"{name}_upper"][1]
        columns |= combination.columns_of_components(name, value, of_name, bounds)
    return columns


def area_for_the_load(result: Result, middle: Values) -> np.ndarray:
    """Return the contact area (load) on its scale, which edges of pixels may make too small for the load."""
    return np.fmax(middle[AREA], to_scale(AREA, result.load / result.hardness))


def _consistent(
    result: Result, as_solved: Values, middle: Values
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return results on their scales with the pressure in contact, as large as the others ask for; in units.

    In full contact, which has no gap on its scale, they are as solved.
    """
    area = area_for_the_load(result, middle)
    centres = {**middle, AREA: area, PRESSURE: np.log(result.load) - np.log(from_scale(AREA, area))}
    # where few points touch, the pixels of the area and of the peak are corrected one without the other
    if PEAK in middle:
        flows = as_solved[PEAK] >= result.hardness  # points that flow do so with finer pixels too
        highest = np.fmax(middle[PEAK], centres[PRESSURE])
        centres[PEAK] = np.where(flows, to_scale(PEAK, as_solved[PEAK]), highest)
    values = {}
    for name, plain in as_solved.items():
        values[name] = np.where(np.isnan(centres[name]), plain, from_scale(name, centres[name]))
        if name in (PRESSURE, PEAK):
            values[name] = np.minimum(values[name], result.hardness)
    return centres, values


def add_pressure(components: Components, area: np.ndarray) -> Components:
    """Return components of one source with that of the pressure in contact, by default from the area's."""
    if PRESSURE in components or AREA not in components:
        return components
    with np.errstate(divide="ignore"):
        ratio = from_scale(AREA, area) / from_scale(AREA, area + SIGNS * components[AREA])
    return {**components, PRESSURE: (-SIGNS * np.log(ratio))[[1, 0, 3, 2]]}
