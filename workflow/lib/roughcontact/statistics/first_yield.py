"""The load of first yield: the mean pressure at which the largest pressure reaches the hardness."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_positive
from roughcontact.arguments.kinds import facts_of
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.si import as_si
from roughcontact.arguments.stacks import bodies_for_solver
from roughcontact.contact.solve import MAX_LOAD, solve_contact
from roughcontact.errors import HeightMapError
from roughcontact.surface.roughness.parameters import rms_gradient

_SOLVER_SETTINGS = ("tolerance", "influence", "precision")
_CLOSE = 3e-3  # logarithm of largest pressure over hardness at which the search ends
_MAX_SOLVES = 40
# of the largest pressure against the load, in logarithms: 1/3 of a single summit (Hertz), 1 of a single point
_SLOPES = (0.05, 1.0)


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
    kind, area = facts_of(window.attrs), window.size * float(np.prod(spacing(window)))
    # above it the solver has only rounding errors, and the pressure is that of a flat map
    max_load = MAX_LOAD * modulus * rms_gradient(window) if kind.flat_map_is_uniform else np.inf

    def excess(load: float) -> float:
        """Return the logarithm of the largest pressure over the hardness."""
        pressure = float(np.exp(load))
        if pressure > max_load:
            return load - float(np.log(goal))
        solution = solve_contact(
            window,
            contact_modulus=modulus,
            tolerance=tolerance,
            on_failure="flag",
            reduce=_largest,
            **kind.arguments(pressure, area),
            **solver,
        )
        # the logarithm is nearly linear in that of the load
        return float(np.log(solution["max_pressure"].item() / goal))

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
        if abs(excess_at_load) < _CLOSE:
            return float(np.exp(np.clip(step, low, high)))
        previous = load, excess_at_load
        load = float(np.clip(step, low, high))
        if load in tried_loads:  # rounding repeats itself: halve the bracket
            load = (low + high) / 2
        if high - low < _CLOSE:
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
    order = np.argsort(statistics["mean_pressure"].values)
    loads, largest = (statistics[name].values[order] for name in ("mean_pressure", "max_pressure"))
    if "hardness" not in statistics:
        goals = statistics["hardness_over_modulus"].values * modulus
        loads, largest = _rising(loads, largest)
        at_goals = np.exp(np.interp(np.log(goals), np.log(largest), np.log(loads), left=np.nan, right=np.nan))
        return statistics.assign(first_yield_pressure_by_ratio=("hardness_over_modulus", at_goals))
    hardness = float(statistics["hardness"])
    elastic = largest < hardness * (1 - _CLOSE)
    start = float(loads[elastic][-1]) if elastic.any() else None
    kind = facts_of(window.attrs)
    if start is None and kind.may_leave_map:
        start = float(loads[0])
    try:
        pressures = first_yield_pressure(
            window,
            contact_modulus=modulus,
            hardness=hardness,
            start=start,
            threads=threads,
            **{key: contact[key] for key in _SOLVER_SETTINGS if key in contact},
            **bodies_for_solver(contact.get("bodies")),
        )
    except HeightMapError:
        if not kind.may_leave_map:
            raise
        return statistics  # the contact leaves the map before
    return statistics.assign(first_yield_pressure=pressures)


def _rising(loads: np.ndarray, largest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the loads at which the largest pressure is above that of all lower loads."""
    is_record = np.append(True, largest[1:] > np.maximum.accumulate(largest)[:-1])
    return loads[is_record], largest[is_record]


def _largest(solution: xr.Dataset) -> xr.Dataset:
    """Return the largest pressure of a load."""
    return xr.Dataset({"max_pressure": solution["pressure"].max(("y", "x"))})
