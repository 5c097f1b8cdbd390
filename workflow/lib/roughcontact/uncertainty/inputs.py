"""Uncertainty of what is stated: load, contact modulus, hardness, scales of the map, and its instrument.

The contact is solved with a stated input at both ends of its range (JCGM 100:2008, 5.1.3, note 2): the
changes are half-widths, the slope between them the sensitivity d ln Q/d ln(input).

Of the instrument there are noise, lens or lateral resolution, tip, and rounding.

* Noise adds to the gradient: g^2 = g_true^2 + g_noise^2. The window is solved plus and minus such noise,
  filtered as the map was; the exponent d ln Q/d ln g leads back to g_true (simulation and extrapolation, Cook
  and Stefanski 1994). On 43 maps with noise of 1 to 10 % of Sq the truth lay at 1.2 times this shift in the
  median, at twice in the outer tenth: it is doubled. A spectrum that is flat at its end may be noise, or
  folded waves: the shift is added as a bound. What stated noise does by chance is told by four draws of it.
* A lens, a tip and rounding to a `coarse_step` are undone (`window.transfer`: `restored`, `eroded`,
  `unrounded`), and the window is solved once more.

Each shifts one end of the interval (JCGM 100:2008, F.2.4.5). A map corrected for noise and lens has a
two-sided component, a share of the change by the correction (3.2.4).
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.choices import UncertaintySource
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.ranges import Shares, ends
from roughcontact.arguments.relaxation import Relaxation
from roughcontact.contact.solve import NEAR_HARDNESS
from roughcontact.errors import SettingsError
from roughcontact.statistics.instrument_checks import coarse_step, suspected_noise
from roughcontact.surface.window.instrument import check_instrument
from roughcontact.surface.window.transfer import add_noise, restored, share_of_noise, unrounded
from roughcontact.uncertainty import combination
from roughcontact.uncertainty.combination import Components, one_sided, symmetric
from roughcontact.uncertainty.ensemble import MARGIN, TOLERANCE, Result, Values, solve_member
from roughcontact.uncertainty.random_effects import width_of_next
from roughcontact.uncertainty.scales import AREA, CONDUCTANCE, PEAK, PRESSURE, headline_names

AMPLIFICATIONS = ("amplification_z", "amplification_xy")
_LOAD, _MODULUS, _HEIGHTS, HARDNESS = "mean_pressure", "contact_modulus", AMPLIFICATIONS[0], "hardness"
_MODULI = (_MODULUS, "youngs_modulus")
INPUTS = (_LOAD, _MODULUS, *AMPLIFICATIONS, HARDNESS)
_NOISE_MARGIN = 1.0  # of the shift by noise
_DRAWS = 4  # of noise, whose scatter is what noise does by chance
_MIN_NOISE, _MAX_NOISE = 1e-9, 0.95  # of g^2; a map with more noise says nothing of its surface
_CORRECTION_UNCERTAINTY = 0.5  # of what a correction changes; of the single highest point all of it


def input_uncertainty(
    result: Result, solution: xr.Dataset, ranges: Mapping[str, float | Shares | None]
) -> tuple[Mapping[str, np.ndarray], Mapping[str, Components]]:
    """Return the sensitivities of each result, and the components of each input that is stated.

    `ranges` are relative expanded uncertainties (95 %), of the hardness below and above it, `solution` the
    quantities along `load`. Sensitivities (load, input) are d ln Q/d ln(input), NaN of an input without a
    range; half-widths are infinite if an end could not be solved. `contact_modulus` stands for all moduli of
    bodies.
    """
    values = {name: solution[name].values for name in headline_names(solution)}
    sensitivities = {name: np.full((value.size, len(INPUTS)), np.nan) for name, value in values.items()}
    components: dict[str, dict[str, combination.Component]] = {source: {} for source in INPUTS}
    for column, source in enumerate(INPUTS):
        lowest, highest = ends(1.0, ranges.get(source))
        if not 0 < lowest <= highest:
            raise SettingsError(
                f"uncertainty of {source} = {ranges[source]}: give a relative one, from 0 to below 1, such "
                "as 0.05"
            )
        if lowest == highest:
            continue
        bounds = [_end(source, factor, result, solution) for factor in (lowest, highest)]
        limited_values = values
        if source == HARDNESS:
            limited_values = values | {AREA: np.fmax(values[AREA], result.load / result.hardness)}
        for name, value in limited_values.items():
            below, above, sensitivities[name][:, column] = effect(value, bounds, name)
            # what flows has the pressure of its area, whatever edges of pixels say
            if not np.isnan(above).all() and (source, name) != (HARDNESS, PRESSURE):
                sides = combination.half_widths(below, above)
                components[source][name] = combination.component_from_units(name, value, sides)
    return sensitivities, components


def _end(source: str, factor: float, result: Result, solution: xr.Dataset) -> tuple[np.ndarray, Values]:
    """Return ln of the input over its stated value (load), and the results, with it a factor larger.

    Where no point reaches the lower of two hardnesses, nothing changes, and nothing is solved.
    """
    solved_values = {name: solution[name].values for name in headline_names(solution)}
    load = solution[_LOAD].values
    change, flows = np.full(load.shape, math.log(factor)), np.full(load.shape, fill_value=True)
    if source == HARDNESS:
        flows = solved_values[PEAK] >= (1 - NEAR_HARDNESS) * min(factor, 1.0) * result.hardness
    if not flows.any():
        return change, solved_values
    contact = {**result.contact, _LOAD: load, "window": result.window}
    if source == _MODULUS:
        bodies = json_attribute(solution.attrs, "bodies") or None
        contact |= {_MODULUS: float(solution[_MODULUS]), "bodies": bodies}
    contact = varied(contact, source, factor)
    if source == _LOAD:
        change = np.log(contact[_LOAD] / load)
    tolerance = TOLERANCE if source == HARDNESS else contact.get("tolerance", 1e-4)
    values = solve_member(contact.pop("window"), contact, tolerance=tolerance, names=solved_values)
    if CONDUCTANCE in values:  # infinite, not unknown, in full contact
        infinite = np.isnan(values[CONDUCTANCE]) & np.isfinite(values[AREA])
        values[CONDUCTANCE] = np.where(infinite, np.inf, values[CONDUCTANCE])
    if source == HARDNESS:  # edges of pixels make an area too small for the load
        values = {name: np.where(flows, value, solved_values[name]) for name, value in values.items()}
        values[AREA] = np.fmax(values[AREA], contact[_LOAD] / contact[HARDNESS])
    return change, values


def varied(arguments: Mapping[str, Any], name: str, factor: float) -> dict[str, Any]:
    """Return arguments of a contact with a load, all moduli, a hardness or a scale `factor` times as large.

    A contact of which all yields carries no more.

    Examples
    --------
    >>> yielding = varied({"mean_pressure": 9e6, "hardness": 1e7}, "hardness", 0.5)
    >>> f"{yielding['mean_pressure']:.6g}"
    '4.99999e+06'
    """
    if name in AMPLIFICATIONS:
        window = arguments["window"]
        if name == _HEIGHTS:
            return {**arguments, "window": window.copy(data=factor * window.values)}
        lengths = {axis: factor * window[axis] for axis in window.dims}
        return {**arguments, "window": window.assign_coords(lengths)}
    is_modulus = name == _MODULUS
    changed_arguments = (
        stiffer(arguments, factor) if is_modulus else {**arguments, name: factor * arguments[name]}
    )
    if changed_arguments.get(HARDNESS):
        heaviest = (1 - 2 * NEAR_HARDNESS) * changed_arguments[HARDNESS]
        changed_arguments[_LOAD] = np.minimum(changed_arguments[_LOAD], heaviest)
    return changed_arguments


def stiffer(arguments: Any, factor: float) -> Any:
    """Return arguments, their bodies and layers included, with moduli `factor` times as large."""
    if isinstance(arguments, Relaxation):
        return arguments.stiffer(factor)
    if isinstance(arguments, list):
        return [stiffer(entry, factor) for entry in arguments]
    if isinstance(arguments, Mapping):
        # a rigid base has none
        return {
            key: factor * entry if key in _MODULI and entry else stiffer(entry, factor)
            for key, entry in arguments.items()
        }
    return arguments


def effect(
    value: np.ndarray, bounds: list[tuple[np.ndarray, Values]], name: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return half-widths below and above a result, and the slope of its logarithm, from both ends."""
    (low, lower), (high, upper) = ((change, values[name]) for change, values in bounds)
    changes = np.stack([lower - value, upper - value, np.zeros(value.shape)])
    # an end that could not be solved bounds nothing
    unsolved_loads = np.isnan(changes).any(axis=0) & ~np.isnan(value)
    below, above = (
        np.where(unsolved_loads, np.inf, side) for side in (-changes.min(axis=0), changes.max(axis=0))
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.log(upper / lower) / (high - low)
    return below, above, np.where(np.isfinite(slope), slope, np.nan)


def add_correction_source(
    sources: Sequence[UncertaintySource], window: xr.DataArray
) -> list[UncertaintySource]:
    """Return the sources of the ±, if any; that of a correction of the window counts, asked for or not."""
    includes_correction = sources and "corrected_for" in window.attrs and "instrument" not in sources
    return [*sources, "instrument"] if includes_correction else list(sources)


def instrument_components(
    result: Result,
    instrument: Mapping[str, Any],
    as_measured: xr.DataArray | None,
    true_shapes: Mapping[str, xr.DataArray],
) -> tuple[list[Components], dict[str, np.ndarray]]:
    """Return the components of each cause, on the scales, and of a corrected map the results without it.

    `as_measured` is the window before a correction, `true_shapes` its `undone`. None is there where nothing
    is stated, no noise suspected (`suspected_noise`) and no `coarse_step`.
    """
    window, noise = result.window, instrument.get("noise") or 0.0
    check_instrument(window if as_measured is None else as_measured, instrument)
    causes: list[Components] = []
    as_measured_values: dict[str, np.ndarray] = {}
    noise_estimate, step = suspected_noise(window.attrs), coarse_step(window.attrs)
    if as_measured is None and not (noise or noise_estimate or true_shapes or step):
        return causes, as_measured_values
    # solved as the others are: a point that their tolerance closes is no effect of the instrument
    result = result._replace(values=result.again(window))
    if as_measured is not None:
        as_measured_values = result.again(as_measured)
        causes.append(_correction_component(result, as_measured, as_measured_values, instrument))
        as_measured_values[PRESSURE] = result.load / as_measured_values[AREA]
    elif noise:
        causes.append(_noise_shift(result, noise, margin=_NOISE_MARGIN))
    if noise:
        causes.append(_chance_of_noise(result, noise))
    elif noise_estimate:
        causes.append(_noise_shift(result, noise_estimate, margin=0.0))
    shifts = [result.changes(result.again(shape)) for shape in true_shapes.values()]
    if step:
        changes = result.changes(result.again(unrounded(window, step)))
        # the highest point stays a kink of the smoothest map: its pressure falls at least as the gradient
        changes[PEAK] = np.minimum(changes[PEAK], -changes[AREA])
        shifts.append(changes)
    causes += [{name: one_sided((1 + MARGIN) * change) for name, change in shift.items()} for shift in shifts]
    return causes, as_measured_values


def _correction_component(
    result: Result, as_measured: xr.DataArray, as_measured_values: Values, instrument: Mapping[str, Any]
) -> Components:
    """Return the two-sided uncertainty of a correction, from the results before it."""
    noise = instrument.get("noise") or 0.0
    causes = [result.changes(as_measured_values)]
    # both may cancel: a further solution without the noise alone tells them apart
    if noise and (instrument.get("numerical_aperture") or instrument.get("resolution")):
        without_noise = restored(as_measured, {}, noise=noise, equalise=True)
        by_lens = result.changes(result.again(without_noise))
        causes = [{name: change - by_lens[name] for name, change in causes[0].items()}, by_lens]
    hidden = share_of_noise(as_measured, noise) >= _MAX_NOISE
    components = {}
    for name in result.values:
        share = _CORRECTION_UNCERTAINTY * (2 if name == PEAK else 1)
        changes = np.stack([cause[name] for cause in causes])
        changes = np.where(np.isneginf(changes), -1.0, changes)  # a gap that closes: as much as its height
        width = share * np.sqrt(np.sum(changes**2, axis=0))
        components[name] = symmetric(np.full_like(width, np.inf) if hidden else width)
    return components


def _noise_shift(result: Result, noise: float, *, margin: float) -> Components:
    """Return the one-sided uncertainty towards the results without noise (m, rms), extended by a margin."""
    share, exponent_back = max(share_of_noise(result.window, noise), _MIN_NOISE), math.inf
    if share < _MAX_NOISE:  # ln(g/g_true) over ln(g with more noise/g), both as expected
        exponent_back = -math.log1p(-share) / math.log1p(share)
    # waves of the map and of one draw may be in phase, which is most of the change by little noise: with the
    # opposite draw that cancels
    draws = [result.changes(result.again(add_noise(result.window, sign * noise))) for sign in (1, -1)]
    changes = {name: np.mean([draw[name] for draw in draws], axis=0) for name in result.values}
    factor = -(1 + margin) * exponent_back
    with np.errstate(invalid="ignore"):
        shifts = {name: np.where(change == 0, 0.0, factor * change) for name, change in changes.items()}
    return {name: one_sided(shift) for name, shift in shifts.items()}


def _chance_of_noise(result: Result, noise: float) -> Components:
    """Return what the noise (m, rms) of the map may do by chance: by Student's t, of other draws of it."""
    noisy = [add_noise(result.window, noise, seed=seed) for seed in range(1, _DRAWS + 1)]
    draws = [result.changes(result.again(window)) for window in noisy]
    return {name: symmetric(width_of_next(np.array([d[name] for d in draws]))) for name in result.values}
