"""The intervals of the quantities: of the surface, the next map, longer and shorter waves, and this map."""

from collections.abc import Mapping
from typing import NamedTuple, get_args

import numpy as np

from roughcontact.choices import HeadlineMeasurand, UncertaintySource
from roughcontact.uncertainty import calibration
from roughcontact.uncertainty.combination import (
    SIGNS,
    Component,
    Components,
    Ends,
    added_up,
    columns_of_components,
    ends_of,
    half_widths,
    limited,
    monotonic,
)
from roughcontact.uncertainty.discretisation import CORRECTED
from roughcontact.uncertainty.ensemble import Values
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, GAP, PEAK, PRESSURE, from_scale, to_scale
from roughcontact.uncertainty.subwindows import Scatter

MEASURANDS = get_args(calibration.Measurand)
Windows = Mapping[calibration.Measurand, Components]  # measurand -> components of the source `window`
Octave = Mapping[str, tuple[np.ndarray, Component]]  # quantity -> shift (load), and the component about it


class Limits(NamedTuple):
    """What bounds every interval: the loads (Pa), a stated hardness (Pa), the gap (m) in full contact."""

    load: np.ndarray
    hardness: float | None = None
    widest_gap: np.ndarray | None = None


def window_components(
    scatter: Scatter, middle: Values, gap: np.ndarray, *, extent: float, open_ended: Values
) -> Windows:
    """Return by how much the truth of each measurand may differ from this map, on the scales.

    `middle` are corrected results, `gap` the mean gap (load; m), `extent` the length of the longer surface
    over that of the map, `open_ended` whether grooves lead out of the map (load).
    """
    windows: dict[calibration.Measurand, dict[str, Component]] = {}
    for measurand in MEASURANDS:
        components = windows[measurand] = {}
        for name in middle:
            if measurand == "map" and scatter.of_positions:
                below = above = np.zeros(gap.shape)
            elif scatter.arms:  # of surfaces behind profiles, whatever their size
                below, above = scatter.arms[name]
            elif scatter.features:
                area, features = from_scale(AREA, middle[AREA]), scatter.features[name]
                below, above = calibration.arms(measurand, name, features, area, extent=extent)
            else:  # without subwindows nothing bounds what other places would give
                below = above = np.full(gap.shape, 0.0 if measurand == "map" else np.inf)
            if name in CONSTRICTIONS and (scatter.arms or scatter.features):  # counted in mean gaps
                below, above = below * gap, above * gap
            if name in open_ended and measurand != "map":
                above = np.where(open_ended[name], np.inf, above)
            components[name] = half_widths(below, above)
    return windows


def interval_columns(
    as_solved: Values,
    middle: Values,
    components: Mapping[UncertaintySource, Components],
    limits: Limits,
    *,
    windows: Windows,
    octave: Octave | None,
    measurand: HeadlineMeasurand = "surface",
) -> dict[str, tuple]:
    """Return the ends of all intervals of the quantities, and what they are made of.

    `as_solved` are results (load), `middle` corrected ones on their scales. Measurands not in `windows`, and
    shorter waves without `octave`, have no interval (an empty `octave`: the settings chose the band);
    `measurand` is that of `_lower` and `_upper`.
    """
    shorter = {name: centre + octave[name][0] for name, centre in middle.items()} if octave else middle
    middle, shorter = (_consistent(as_solved, centres, limits) for centres in (middle, shorter))
    beyond = _with_pressure({name: pair[1] for name, pair in (octave or {}).items()}, shorter[AREA])
    components = {source: _with_pressure(causes, middle[AREA]) for source, causes in components.items()}
    windows = {key: _with_pressure(component, middle[AREA]) for key, component in windows.items()}
    columns: dict[str, tuple] = {}
    for name, result in as_solved.items():
        value = _in_its_unit(name, middle[name], result, limits.hardness)
        if name in (AREA, PRESSURE):  # full contact, up to the rounding of its scale
            value = np.where(as_solved[AREA] >= 1, result, value)
        sources = {source: causes[name] for source, causes in components.items() if name in causes}
        window = {key: [causes[name]] if name in causes else [] for key, causes in windows.items()}
        ends = {}
        for prefix, key in ({"": measurand} | {f"{key}_": key for key in MEASURANDS[1:]}).items():
            causes = [*sources.values(), *window[key]] if key in window else []
            ends[prefix] = _ends(name, middle[name], value, causes, limits)
        ends["octave_"] = ends[""]  # where the settings chose the band
        if name in beyond or octave is None:
            moved = _in_its_unit(name, shorter[name], result, limits.hardness)
            causes = [*sources.values(), *window[measurand], beyond[name]] if octave else []
            ends["octave_"] = _ends(name, shorter[name], moved, causes, limits)
        for key, pair in ends.items():
            columns |= {f"{name}_{key}{end}": ("load", pair[i]) for i, end in enumerate(("lower", "upper"))}
        if name in (*CORRECTED, PRESSURE):
            columns[f"{name}_as_solved"] = ("load", result)
        if window[measurand]:
            sources["window"] = window[measurand][0]
        columns |= columns_of_components(name, value, sources, ends[""])
    return columns


def _consistent(as_solved: Values, middle: Values, limits: Limits) -> dict[str, np.ndarray]:
    """Return results on their scales with the pressure in contact, each as large as the others ask for."""
    middle = dict(middle)
    if limits.hardness is not None:  # by the edges of its pixels alone the area may be too small for the load
        middle[AREA] = np.fmax(middle[AREA], to_scale(AREA, limits.load / limits.hardness))
    middle[PRESSURE] = np.log(limits.load) - np.log(from_scale(AREA, middle[AREA]))
    # where few points touch, the pixels of the area and of the peak are corrected one without the other
    if PEAK in middle:
        middle[PEAK] = np.fmax(middle[PEAK], middle[PRESSURE])
        if limits.hardness is not None:  # points that flow do so with finer pixels too
            flows = as_solved[PEAK] >= limits.hardness
            middle[PEAK] = np.where(flows, to_scale(PEAK, as_solved[PEAK]), middle[PEAK])
    return middle


def _with_pressure(components: Components, area: np.ndarray) -> Components:
    """Return components of one source with that of the pressure in contact, by default from the area's."""
    if PRESSURE in components or AREA not in components:
        return components
    with np.errstate(divide="ignore"):
        ratio = from_scale(AREA, area) / from_scale(AREA, area + SIGNS * components[AREA])
    return {**components, PRESSURE: (-SIGNS * np.log(ratio))[[1, 0, 3, 2]]}


def _in_its_unit(name: str, centre: np.ndarray, result: np.ndarray, hardness: float | None) -> np.ndarray:
    """Return a corrected result in its unit; as solved in full contact, which has no gap on its scale."""
    value = np.where(np.isnan(centre), result, from_scale(name, centre))
    return value if hardness is None or name not in (PRESSURE, PEAK) else np.fmin(value, hardness)


def _ends(
    name: str, centre: np.ndarray, value: np.ndarray, components: list[Component], limits: Limits
) -> Ends:
    """Return both ends of an interval, in the unit of the quantity; NaN without any source."""
    if not components:
        return (np.full(value.shape, np.nan),) * 2
    ends = ends_of(name, centre, added_up(components))
    if name == GAP and limits.widest_gap is not None:
        ends = np.where(value > 0, ends[0], 0.0), np.where(value > 0, ends[1], limits.widest_gap)
    ends = monotonic(name, ends, limits.load)
    return limited(name, ends, value=value, load=limits.load, hardness=limits.hardness)
