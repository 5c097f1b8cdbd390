"""Uncertainty and sensitivity of the results to load, contact modulus, hardness and the scales of the map.

The contact is solved with a stated input at both ends of its range (JCGM 100:2008, 5.1.3, note 2): the
changes are half-widths, the slope between them the sensitivity d ln Q/d ln(input).
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.ranges import Shares, ends
from roughcontact.arguments.relaxation import Relaxation
from roughcontact.contact.solve import NEAR_HARDNESS
from roughcontact.errors import SettingsError
from roughcontact.uncertainty.combination import Component, Components, component_from_units, half_widths
from roughcontact.uncertainty.ensemble import Result, Values, solve_member
from roughcontact.uncertainty.scales import AREA, CONDUCTANCE, PEAK, PRESSURE, headline_names

AMPLIFICATIONS = ("amplification_z", "amplification_xy")
_LOAD, _MODULUS, _HEIGHTS, HARDNESS = "mean_pressure", "contact_modulus", AMPLIFICATIONS[0], "hardness"
_MODULI = (_MODULUS, "youngs_modulus")
INPUTS = (_LOAD, _MODULUS, *AMPLIFICATIONS, HARDNESS)


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
    components: dict[str, dict[str, Component]] = {source: {} for source in INPUTS}
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
                components[source][name] = component_from_units(name, value, half_widths(below, above))
    return sensitivities, components


def _end(source: str, factor: float, result: Result, solution: xr.Dataset) -> tuple[np.ndarray, Values]:
    """Return ln of the input over its stated value (load), and the results, with it a factor larger."""
    if source == HARDNESS:
        return _end_of_hardness(factor, result, solution)
    load, window, variation = solution[_LOAD].values, result.window, dict(result.contact)
    change = np.full(load.shape, math.log(factor))
    if source == _LOAD:
        variation = varied({**result.contact, _LOAD: load}, source, factor)
        change = np.log(variation[_LOAD] / load)
    elif source == _MODULUS:
        variation[_MODULUS] = factor * float(solution[_MODULUS])
        variation["bodies"] = stiffer(json_attribute(solution.attrs, "bodies") or None, factor)
    else:
        window = amplified(window, source, factor)
    tolerance = variation.get("tolerance", 1e-4)
    values = solve_member(window, variation, tolerance=tolerance, names=headline_names(solution))
    if CONDUCTANCE in values:  # infinite, not unknown, in full contact
        infinite = np.isnan(values[CONDUCTANCE]) & np.isfinite(values[AREA])
        values[CONDUCTANCE] = np.where(infinite, np.inf, values[CONDUCTANCE])
    return change, values


def _end_of_hardness(factor: float, result: Result, solution: xr.Dataset) -> tuple[np.ndarray, Values]:
    """Return ln of the factor (load), and the results of the contact with a hardness a factor larger.

    Where no point reaches the lower of both hardnesses, nothing changes, and nothing is solved.
    """
    names, hardness = headline_names(solution), factor * result.hardness
    solved_values = {name: solution[name].values for name in names}
    change = np.full(result.load.shape, math.log(factor))
    flows = solved_values[PEAK] >= (1 - NEAR_HARDNESS) * min(hardness, result.hardness)
    if not flows.any():
        return change, solved_values
    load = np.minimum(result.load, (1 - 2 * NEAR_HARDNESS) * hardness)
    contact = {**result.contact, "hardness": hardness, "mean_pressure": load}
    values = result._replace(contact=contact, values=solved_values).again(result.window)
    ends_at_loads = {name: np.where(flows, value, solved_values[name]) for name, value in values.items()}
    # edges of pixels make an area too small for the load
    return change, ends_at_loads | {AREA: np.fmax(ends_at_loads[AREA], load / hardness)}


def amplified(window: xr.DataArray, name: str, factor: float) -> xr.DataArray:
    """Return a window whose heights or, by the name of their amplification, lengths are so many times."""
    if name == _HEIGHTS:
        return window.copy(data=factor * window.values)
    return window.assign_coords({axis: factor * window[axis] for axis in window.dims})


def varied(arguments: Mapping[str, Any], name: str, factor: float) -> dict[str, Any]:
    """Return arguments of a contact with a load, all moduli or a hardness `factor` times as large.

    A contact of which all yields carries no more.

    Examples
    --------
    >>> yielding = varied({"mean_pressure": 9e6, "hardness": 1e7}, "hardness", 0.5)
    >>> f"{yielding['mean_pressure']:.6g}"
    '4.99999e+06'
    """
    changed = (
        {**arguments, name: factor * arguments[name]} if name != _MODULUS else stiffer(arguments, factor)
    )
    if changed.get(HARDNESS):
        heaviest = (1 - 2 * NEAR_HARDNESS) * changed[HARDNESS]
        changed[_LOAD] = np.minimum(changed[_LOAD], heaviest)
    return changed


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
    is_unsolved = np.isnan(changes).any(axis=0) & ~np.isnan(value)
    below, above = (
        np.where(is_unsolved, np.inf, side) for side in (-changes.min(axis=0), changes.max(axis=0))
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.log(upper / lower) / (high - low)
    return below, above, np.where(np.isfinite(slope), slope, np.nan)
