"""A form wider than its map: each place of the smooth contact has the map under Hertz's pressure there.

All places have the same map: the ends of its intervals are integrated as they are. With a stated uncertainty
of E*, hardness or force all of Hertz's contact is solved again. Resistances are those of the spots and, in
series, of Hertz's contact, 1/(2 a k) of a circle, else E*/k dδ/dF (Holm 1967, Electric Contacts; Greenwood
1966, Br. J. Appl. Phys. 17, 1621): a lower bound by Rayleigh; a flux in proportion to the pressure, with 6/5
of the second, gives an upper one (Thomson).
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import scipy
import xarray as xr

from roughcontact.arguments.answers import ENDS, OPPOSITE_ENDS
from roughcontact.arguments.kinds import LOCAL_SCALE, facts_of_settings
from roughcontact.arguments.ranges import ends
from roughcontact.contact.elasticity.closed_forms import hertz_ellipse
from roughcontact.contact.solve import NEAR_HARDNESS, solve_contact
from roughcontact.errors import SettingsError
from roughcontact.evaluation.kinds.periodic_map import PeriodicMap, Settings, SolvedMap
from roughcontact.statistics.conductance import conductance_columns, conductivity_ranges
from roughcontact.statistics.precision import widened
from roughcontact.uncertainty.budget import MATERIAL_UNCERTAINTIES, OF_MATERIAL, error_budget
from roughcontact.uncertainty.budget_inputs import budget_inputs
from roughcontact.uncertainty.combination import added_up, component_from_units, half_widths, interval_bounds
from roughcontact.uncertainty.ensemble import Values, solve_member
from roughcontact.uncertainty.inputs import HARDNESS, add_correction_source, effect
from roughcontact.uncertainty.scales import AREA, CONDUCTANCE, GAP, to_scale

_NODES = 6  # of Gauss and Jacobi, over the pressure
_OF_MAP = (AREA, GAP, CONDUCTANCE)
_CONDUCTANCE = f"local_{CONDUCTANCE}"


class LocalScale(PeriodicMap):
    """A kind of periodic map, whose loads are the largest pressures of a smooth form."""

    facts = LOCAL_SCALE

    def __init__(self, base: PeriodicMap):
        self._base = base

    @classmethod
    def includes(cls, height: xr.DataArray, settings: Settings) -> bool:
        """Return whether the settings have a form of local scale."""
        return facts_of_settings(settings) is LOCAL_SCALE

    def level(self, height: xr.DataArray, options: Mapping[str, Any]) -> xr.DataArray:
        """Return the map, levelled as of its own kind."""
        return self._base.level(height, options)

    def window(self, levelled: xr.DataArray, settings: Settings) -> xr.DataArray:
        """Return the map that is solved, as of its own kind."""
        return self._base.window(levelled, settings)

    def loads(self, window: xr.DataArray, settings: Settings, solver: Mapping[str, Any]) -> dict[str, Any]:
        """Return the largest nominal pressure of the form under each force."""
        return {"mean_pressure": _hertz_pressures(settings["contact"], settings["form"]["radius"])}

    loads_after_creep = loads  # a softer form spreads the force over a larger contact

    def budget(self, solution: SolvedMap) -> xr.Dataset:
        """Return the error budget of the map, and the whole contact under each force."""
        return self._base.budget(solution).assign(_whole_contact(self._base, solution))


def _hertz_pressures(contact: Mapping[str, Any], radius: Sequence[float]) -> list[float]:
    """Return the largest nominal pressure (Pa) of a form, of one radius or two (m), under each force (N)."""
    pressures = _hertz(contact["force"], radius, contact["contact_modulus"])["pressure"]
    if (largest := pressures.max()) >= (hardness := contact.get("hardness") or np.inf):
        force = max(contact["force"])
        raise SettingsError(
            f"contact.force = {force:g} N: the smooth form has a pressure of {largest:.3g} Pa (Hertz), not "
            f"below the hardness {hardness:g} Pa; stay below {force * (hardness / largest) ** 3:.3g} N",
            keys=["force", "hardness"],
        )
    return list(map(float, pressures))


def _whole_contact(base: PeriodicMap, solution: SolvedMap) -> dict[str, tuple[str, np.ndarray]]:
    """Return variables (load) of the whole contact under the forces, with the ends of their intervals.

    `base` is the kind of the map itself; bodies of known conductivities have resistances.
    """
    settings, options = base.budget_arguments(solution)
    surface, window, sources = base.measured_surface(solution), solution.window, options.pop("sources")
    forces, bodies = (solution.settings["contact"][key] for key in ("force", "bodies"))
    radius = solution.settings["form"]["radius"]
    contact = {key: value for key, value in settings["contact"].items() if key not in MATERIAL_UNCERTAINTIES}
    inputs: dict[str, Any] = {"mean_pressure": np.asarray(forces, float)}
    inputs |= {name: contact.get(name) for name in ("contact_modulus", HARDNESS)}
    smooth, at_places = _places(inputs, radius, contact)
    curve = solve_contact(window, **at_places, reduce=budget_inputs)
    all_sources, settings_of_map = add_correction_source(sources, window), {**settings, "contact": at_places}
    of_map = [source for source in all_sources if source not in OF_MATERIAL.values()]
    budget = error_budget(surface, window, settings_of_map, sources=of_map, solved=curve, **options)
    estimate, lower, upper = (
        {name: budget.get(f"{name}{kind}", curve[name]).values for name in _OF_MAP}
        for kind in ("_estimate", *ENDS[1:])
    )
    # nothing bounds what has no end, nor the conductance of full contact
    upper = {k: np.where(np.isnan(top) & ~np.isnan(lower[k]), np.inf, top) for k, top in upper.items()}
    lower[CONDUCTANCE] = np.where(estimate[AREA] >= 1, np.inf, lower[CONDUCTANCE])
    values, below = _whole(estimate, smooth), _whole(lower, smooth, flux_as_pressure=True)
    above, as_solved = _whole(upper, smooth), _whole({name: curve[name].values for name in _OF_MAP}, smooth)
    by_input: list[list[tuple[np.ndarray, Values]]] = []  # both ends of each input that is uncertain
    ranges = {name: settings["contact"].get(setting) for setting, name in MATERIAL_UNCERTAINTIES.items()}
    for name, source in OF_MATERIAL.items():
        if source in sources and ranges[name]:
            by_input.append([])
            for factor in ends(1.0, ranges[name]):
                changed = inputs | {name: factor * np.asarray(inputs[name])}
                variation, loads = _places(changed, radius, contact | {HARDNESS: changed[HARDNESS]})
                results = solve_member(window, loads, names=_OF_MAP, tolerance=contact["tolerance"])
                by_input[-1].append((np.log(factor), _whole(results, variation)))
    columns = {"force": inputs["mean_pressure"], "hertz_radius": np.sqrt(smooth["area"] / np.pi)}
    columns |= {"hertz_approach": smooth["approach"], f"hertz_{CONDUCTANCE}": smooth["conductance"], **values}
    for name, value in values.items() if of_map or by_input else ():
        sides = [(value, value - below[name], above[name] - value)]
        sides += [(as_solved[name], *effect(as_solved[name], bounds, name)[:2]) for bounds in by_input]
        # each number of the whole contact has a logarithmic scale, as the gap
        total = added_up(component_from_units(GAP, middle, half_widths(*widths)) for middle, *widths in sides)
        bounds = interval_bounds(GAP, to_scale(GAP, value), total)
        for key, joint, single in zip(ENDS[1:], bounds, (below[name], above[name]), strict=True):
            bound = np.where((value > 0) & (single > 0), joint, single)  # alone: that of the map
            columns[f"{name}{key}"] = np.where(np.isinf(bound), np.nan, bound)
    with np.errstate(divide="ignore"):
        for key, opposite in OPPOSITE_ENDS.items() if f"{_CONDUCTANCE}_lower" in columns else [("", "")]:
            area, conductance = columns[f"local_contact_area{opposite}"], columns[f"{_CONDUCTANCE}{opposite}"]
            hardness = ends(contact.get(HARDNESS) or np.inf, ranges[HARDNESS] if key == "_upper" else None)[1]
            pressure = np.minimum(columns["force"] / area, hardness)
            columns[f"local_mean_contact_pressure{key}"] = np.where(area > 0, pressure, np.nan)
            of_bodies = conductance_columns(conductance, contact_modulus=1.0, bodies=bodies)
            del of_bodies[CONDUCTANCE]
            for name, of_ends in of_bodies.items():
                kind, resistance = name.replace("conductance", "resistance"), 1 / of_ends
                columns[f"local_{kind}{key}"] = np.where(np.isinf(resistance), np.nan, resistance)
    for name, (mean, *limits) in conductivity_ranges(bodies).items():
        is_thermal = name.startswith("thermal")
        keys = [f"local_{'thermal' if is_thermal else 'electrical'}_resistance{suffix}" for suffix in ENDS]
        if keys[1] in columns:
            factors = sorted((limit / mean) ** (-1 if is_thermal else 1) for limit in limits)
            columns |= dict(zip(keys[1:], widened([columns[key] for key in keys], factors), strict=True))
    return {name: ("load", column) for name, column in columns.items()}


def _places(
    inputs: Mapping[str, Any], radius: Sequence[float], contact: Mapping[str, Any]
) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Return Hertz's contact (load) by inputs, and arguments of `solve_contact` for all of its places."""
    modulus = inputs["contact_modulus"]
    smooth = _hertz(inputs["mean_pressure"], radius, modulus)
    pressures = np.outer(smooth["pressure"], _nodes()[0]).ravel()
    largest = (1 - 2 * NEAR_HARDNESS) * (contact.get("hardness") or np.inf)
    loads = np.minimum(pressures, largest).tolist()
    return smooth, {**contact, "contact_modulus": modulus, "mean_pressure": loads}


def _whole(curve: Values, smooth: Values, *, flux_as_pressure: bool = False) -> dict[str, np.ndarray]:
    """Return the numbers (load) of the whole contact from those of the map (load and place)."""
    shares, weights = _nodes()
    area, gap, conductance = (curve[name].reshape(-1, shares.size) for name in _OF_MAP)
    conductance = np.where(np.isnan(conductance) & (area >= 1), np.inf, conductance)  # of full contact
    with np.errstate(divide="ignore"):
        resistance = 1 / (smooth["area"] * (conductance @ weights)) + 1 / smooth["conductance"]
        if flux_as_pressure:  # 3/2 s times its mean
            of_spots = ((1.5 * shares) ** 2 / conductance) @ weights / smooth["area"]
            resistance = of_spots + 1.2 / smooth["conductance"]
    return {
        "local_contact_area": smooth["area"] * (area @ weights),
        "local_mean_gap": gap @ weights,
        _CONDUCTANCE: 1 / resistance,
    }


def _nodes() -> tuple[np.ndarray, np.ndarray]:
    """Return pressures s over the largest, and their shares 2 s ds of Hertz's ellipse, whatever its axes."""
    roots, weights = scipy.special.roots_jacobi(_NODES, 0, 1)
    return (1 + roots) / 2, weights / 2


def _hertz(forces: Any, radius: Sequence[float], modulus: float) -> dict[str, np.ndarray]:
    """Return pressure (Pa), area (m2), approach (m), conductance over conductivity (m) by force (load; N)."""
    unit, scale = hertz_ellipse(1.0, radius, modulus), np.cbrt(np.asarray(forces, float))
    return {
        "pressure": unit["max_pressure"] * scale,
        "area": np.pi * unit["major"] * unit["minor"] * scale**2,
        "approach": unit["approach"] * scale**2,
        "conductance": 1.5 * scale / (unit["approach"] * modulus),
    }
