"""The inverse question: the load at which a contact reaches a given area or gap, closes, or yields."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_positive
from roughcontact.arguments.choices import LoadTarget, check_choice
from roughcontact.arguments.kinds import facts_of
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.si import as_si
from roughcontact.arguments.stacks import bodies_for_solver, top_material
from roughcontact.contact.loads import check_loads, plan_loads
from roughcontact.contact.problem import nondimensionalise
from roughcontact.contact.solve import MAX_LOAD, solve_contact
from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.statistics import subsurface
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.statistics.load_pairs import loads_reaching
from roughcontact.statistics.sealing.connectivity import percolates
from roughcontact.surface.roughness.parameters import rms_gradient

TARGETS = ("target_area", "target_gap", "target")  # keys of the settings, as arguments of `target_loads`
_SOLVER = ("tolerance", "influence", "precision")
_CLOSE = 1e-4  # of the logarithm of the load, to which it is found
_CLOSE_TO_YIELD = 3e-3  # logarithm of largest pressure over hardness at which the search ends
_MAX_SOLVES = 40
# of the largest pressure against the load, in logarithms: 1/3 of a single summit (Hertz), 1 of a single point
_SLOPES = (0.05, 1.0)
_MIN_LOAD = 0.01  # load in units of E* g over the number of points, which a single point carries
_FULL = 50.0  # excess of full contact over any target, in the logarithm

Excess = Callable[[float], float]  # of a load over the one that is sought


def target_loads(
    window: xr.DataArray,
    *,
    contact_modulus: float,
    target_area: float | Sequence[float] | None = None,
    target_gap: float | Sequence[float] | None = None,
    target: LoadTarget | Sequence[LoadTarget] | None = None,
    hardness: float | None = None,
    bodies: subsurface.Bodies | None = None,
    **solver: Any,
) -> list[float]:
    """Return the mean pressures (Pa) at which the contact of a periodic map (y, x; m) reaches given targets.

    They are relative contact areas, mean gaps (m), and by name `percolation`, where the gap closes along x
    and along y (one load where both are the same, none where it is closed at first touch), and `first_yield`,
    where the stress of von Mises reaches a yield stress (Pa), or without one the largest pressure the
    hardness (Pa). Loads are bracketed and found to 1e-4 of themselves, just beyond a gap that closes at once;
    `solver` are arguments of `solve_contact`.
    """
    modulus = check_positive("contact_modulus", contact_modulus, unit="Pa")
    solver |= bodies_for_solver(bodies)
    gradient = nondimensionalise(window).gradient
    if gradient == 0:
        raise HeightMapError(
            "the map is flat and in full contact at every load: there is none to search for; leave target, "
            "target_area and target_gap out and give mean_pressure in Pa"
        )
    unit = modulus * gradient
    state = partial(_state, window, contact_modulus=modulus, hardness=hardness, **solver)
    crossing = partial(_crossing, lower_limit=_MIN_LOAD * unit / window.size, limit=hardness or math.inf)

    def area_excess(target_value: float, load: float) -> float:
        """Return by how much the area exceeds the wanted one, in the logarithm."""
        # in logarithms area and load are nearly in proportion
        return math.log(relative_contact_area(state(load)[0] > 0) / target_value)

    def gap_excess(target_value: float, load: float) -> float:
        """Return by how much the mean gap falls short of the wanted one, in the logarithm."""
        pressure, gap = state(load)
        mean = float(gap[pressure == 0].sum()) / gap.size
        # full contact has no logarithm of its gap
        return min(math.log(target_value / mean), _FULL) if mean > 0 else _FULL

    def closed(axis: int, load: float) -> float:
        """Return 1 where no region of the gap runs around along an axis, else -1."""
        pressure, gap = state(load)
        return -1.0 if percolates((pressure == 0) & (gap > 0))[axis] else 1.0

    from scipy.special import erfinv  # imported late, as few ask for an area

    loads = []
    areas = [] if target_area is None else check_loads("target_area", target_area, unit="shares of the area")
    for target_value in areas:
        if target_value >= 1:
            raise SettingsError(
                f"target_area = {target_value:g}: must be less than 1, all of the area", keys=["target_area"]
            )
        # the search starts where the theory of Xu et al. (2024) has this area
        start = unit * float(erfinv(target_value)) * math.sqrt((0.42 + 0.58 * target_value) / 2)
        load = crossing(partial(area_excess, target_value), start)
        if load is None:
            raise SettingsError(
                f"target_area = {target_value:g}: a single point of the map, 1/{window.size} of it, is more",
                keys=["target_area"],
            )
        loads.append(load)
    max_gap = float(window.max() - window.mean())  # of the surfaces at first touch
    for target_value in [] if target_gap is None else check_loads("target_gap", target_gap, unit="m"):
        if target_value >= max_gap:
            raise SettingsError(
                f"target_gap = {target_value:g} m: must be less than the mean gap of the unloaded surfaces, "
                f"{max_gap:.3g} m",
                keys=["target_gap"],
            )
        load = crossing(partial(gap_excess, target_value), 0.05 * unit)
        loads += [] if load is None else [load]
    # those of which there may be none, one or two come last: first yields stand at one place in all results
    for event in sorted([target] if isinstance(target, str) else target or [], key="percolation".__eq__):
        check_choice("target", event, LoadTarget)
        if event == "percolation":
            crossings = (crossing(partial(closed, axis), 0.25 * unit, steady=False) for axis in (1, 0))
            loads += dict.fromkeys(load for load in crossings if load is not None)
        else:
            body = subsurface.strained_body(bodies) or {}
            loads.append(_first_yield(window, modulus, hardness=hardness, body=body, **solver))
    return loads


def wanted_loads(window: xr.DataArray, contact: Mapping[str, Any], *, threads: int = 1) -> list[float]:
    """Return the mean pressures (Pa) of the section `contact`: as stated, relative, planned, by target."""
    material = _settings_of(contact, "contact_modulus", "hardness")
    load_settings = _settings_of(contact, "mean_pressure", "relative_pressure")
    targets = _settings_of(contact, *TARGETS)
    loads = plan_loads(window, **material, **load_settings) if load_settings or not targets else []
    if targets:
        solver = _settings_of(contact, *_SOLVER, "bodies")
        loads_of_targets = target_loads(window, **material, **targets, threads=threads, **solver)
        loads += [load for load in loads_of_targets if load not in loads]
    if not loads:
        raise SettingsError(
            f"{' and '.join(targets)}: what is asked for is there as soon as the surfaces touch, at any "
            "load; give mean_pressure",
            keys=list(targets),
        )
    return loads


def _settings_of(contact: Mapping[str, Any], *keys: str) -> dict[str, Any]:
    """Return those of the settings that have a value."""
    return {key: contact[key] for key in keys if contact.get(key) is not None}


def _state(window: xr.DataArray, load: float, /, **solver: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return pressure and gap at a mean pressure (Pa) over the map."""
    kind, area = facts_of(window.attrs), window.size * float(np.prod(spacing(window)))
    solution = solve_contact(window, on_failure="flag", **kind.arguments(load, area), **solver)
    return solution["pressure"].values[0], solution["gap"].values[0]


def _first_yield(
    window: xr.DataArray, modulus: float, *, hardness: float | None, body: subsurface.Body, **solver: Any
) -> float:
    """Return the load of first yield, below the surface where a yield stress is known."""
    limit = min(subsurface.yield_stresses(body))
    if limit == math.inf or top_material(body).get("poissons_ratio") is None:
        if hardness is None:
            raise SettingsError(
                "target = 'first_yield' needs the yield_stress of a body, or a hardness; the body its "
                "poissons_ratio, too",
                keys=["target"],
            )
        return first_yield_pressure(window, contact_modulus=modulus, hardness=hardness, **solver)
    steps = spacing(window)

    def excess(load: float) -> float:
        """Return by how much the largest stress exceeds the yield stress, in the logarithm."""
        pressure, _ = _state(window, load, contact_modulus=modulus, **solver)
        stress = subsurface.stress_columns(pressure, steps, **body)
        return math.log(subsurface.stress_over_yield(stress, body).max())

    # a single point carries at most the load of all
    load = _crossing(excess, limit / math.sqrt(window.size))
    assert load is not None  # `excess` falls without end with the load
    return load


def _crossing(
    excess: Excess, start: float, *, lower_limit: float = 0.0, limit: float = math.inf, steady: bool = True
) -> float | None:
    """Return the load from which on `excess`, which rises with the load, is not negative.

    None where it is so at `lower_limit` already, below what a single point carries. `limit` is a load from
    which on the contact is full whatever the map; a `steady` excess is interpolated.
    """

    @cache
    def value_at(logarithm: float) -> float:
        load = math.exp(logarithm)
        return _FULL if load >= limit else excess(load)

    step = math.log(2)
    low = high = math.log(start)
    # by factors of two to a bracket
    while value_at(low) >= 0:
        if math.exp(low) < lower_limit:
            return None
        low, high = low - step, low
    while high == low or value_at(high) < 0:
        low, high = high, high + step
    if steady:  # a step has no root for an interpolation: it is bisected
        from scipy.optimize import brentq  # imported late: it takes longer than solving a small map

        return math.exp(brentq(value_at, low, high, xtol=_CLOSE / 2))
    while high - low > _CLOSE:
        middle = (low + high) / 2
        low, high = (middle, high) if value_at(middle) < 0 else (low, middle)
    return math.exp(high)


@as_si
def first_yield_pressure(
    window: xr.DataArray,
    *,
    contact_modulus: float,
    hardness: float,
    start: float | None = None,
    tolerance: float = 1e-4,
    **solver: Any,
) -> float:
    """Return the mean pressure at which the largest contact pressure reaches the hardness.

    Below it the contact is elastic everywhere. It depends on the resolution of the map: the sharpest of its
    highest summits decides, as the pixels resolve it.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic, no NaN, or a body of finite size (attribute `boundary`: free).
    contact_modulus : float, Pa
        E*.
    hardness : float, Pa
        H.
    start : float, Pa, optional
        an initial estimate of the mean pressure.
    tolerance : float
        of the solutions.
    **solver
        further arguments of `solve_contact`: `bodies`, `influence`, `precision`, `threads`.

    Returns
    -------
    float, Pa
        between H/N for N points, all of the load on one of them, and H, under which a flat map flows as a
        whole.

    Raises
    ------
    SettingsError
        for a modulus or hardness that is no positive number.

    Examples
    --------
    Under a wave the largest pressure is 2 √(p̄ p*), p* = π E* D/λ (Westergaard 1939).

    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 512), 1e-3 / 512, amplitude=1e-6, wavelength=1e-3)
    >>> found = first_yield_pressure(wave, contact_modulus=1e9, hardness=2e6)
    >>> print(f"{found / (2e6**2 / (4 * 3.14159e6)):.3f}")
    1.000
    """
    modulus = check_positive("contact_modulus", contact_modulus, unit="Pa")
    goal = check_positive("hardness", hardness, unit="Pa")
    kind = facts_of(window.attrs)
    # above it the solver has only rounding errors, and the pressure is that of a flat map
    max_load = MAX_LOAD * modulus * rms_gradient(window) if kind.flat_map_is_uniform else np.inf

    def excess(load: float) -> float:
        """Return the logarithm of the largest pressure over the hardness."""
        pressure = float(np.exp(load))
        if pressure > max_load:
            return load - float(np.log(goal))
        pressures, _ = _state(window, pressure, contact_modulus=modulus, tolerance=tolerance, **solver)
        # the logarithm is nearly linear in that of the load
        return float(np.log(float(pressures.max()) / goal))

    # no point carries more than all of the load, and at least one carries the mean pressure
    low, high = float(np.log(goal / window.size)), float(np.log(goal))
    # without a start: nearer to the load that all points share than to that of one point
    load = low + 0.7 * (high - low) if start is None else float(np.clip(np.log(start), low, high))
    slope, previous, tried_loads = kind.power_of_largest_pressure, None, set()
    for _ in range(_MAX_SOLVES):
        excess_at_load = excess(load)
        tried_loads.add(load)
        low, high = (load, high) if excess_at_load < 0 else (low, load)
        if previous is not None and load != previous[0]:
            # a secant, within what slopes are possible
            slope = float(np.clip((excess_at_load - previous[1]) / (load - previous[0]), *_SLOPES))
        step = load - excess_at_load / slope
        if abs(excess_at_load) < _CLOSE_TO_YIELD:
            return float(np.exp(np.clip(step, low, high)))
        previous = load, excess_at_load
        load = float(np.clip(step, low, high))
        if load in tried_loads:  # rounding repeats itself: halve the bracket
            load = (low + high) / 2
        if high - low < _CLOSE_TO_YIELD:
            break
    return float(np.exp((low + high) / 2))


def add_first_yield(
    statistics: xr.Dataset, window: xr.DataArray, contact: Mapping[str, Any], *, threads: int = 1
) -> xr.Dataset:
    """Return the statistics with `first_yield_pressure` (Pa) of the solved map `window` (y, x; m).

    It is left out where the contact of a finite body reaches the border of the map before.
    Without a hardness, `first_yield_pressure_by_ratio` for each `hardness_over_modulus`, NaN beyond the
    solved loads; of the settings `contact`, `tolerance`, `influence` and `precision` count.
    """
    modulus = float(statistics["contact_modulus"])
    loads, largest = (statistics[name].values for name in ("mean_pressure", "max_pressure"))
    if "hardness" not in statistics:
        goals = statistics["hardness_over_modulus"].values * modulus
        at_goals = loads_reaching(goals, loads, largest)
        return statistics.assign(first_yield_pressure_by_ratio=("hardness_over_modulus", at_goals))
    hardness, kind = float(statistics["hardness"]), facts_of(window.attrs)
    elastic = loads[largest < hardness * (1 - _CLOSE_TO_YIELD)]
    start = float(elastic.max()) if elastic.size else None
    if start is None and kind.may_leave_map:
        start = float(loads.min())
    try:
        pressures = first_yield_pressure(
            window,
            contact_modulus=modulus,
            hardness=hardness,
            start=start,
            threads=threads,
            **_settings_of(contact, *_SOLVER),
            **bodies_for_solver(contact.get("bodies")),
        )
    except HeightMapError:
        if not kind.may_leave_map:
            raise
        return statistics  # the contact leaves the map before
    return statistics.assign(first_yield_pressure=pressures)
