"""Combination of uncertainty sources into intervals, and the table of their components."""

from collections.abc import Mapping
from typing import NamedTuple, get_args

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact.choices import UncertaintySource
from roughcontact.uncertainty.scales import (
    ANSWERS,
    AREA,
    CONDUCTANCE,
    CONSTRICTIONS,
    GAP,
    PEAK,
    PRESSURE,
    QUANTITIES,
    from_scale,
    to_scale,
)

SOURCES: tuple[UncertaintySource, ...] = get_args(UncertaintySource)
COMBINED = "combined"
_NORMAL = 1.959963984540054  # coverage factor of 95 % for infinite degrees of freedom
# A: evaluated from a scatter; B: from bounds, models and statements
_TYPES = ["A" if source == "window" else "B" for source in SOURCES]
# whether a quantity rises with the load, or falls; the pressure in contact may do either
_RISING = {AREA: True, PEAK: True, CONDUCTANCE: True, GAP: False, **dict.fromkeys(CONSTRICTIONS, False)}
_LEAST = 1e-6  # of a result: the logarithm of smaller values is meaningless
_OF_THE_TABLE = {
    "mean_pressure",
    *(
        f"{name}_{ending}"
        for name in (*QUANTITIES, *ANSWERS)
        for ending in ("uncertainty", "components", "estimate", "as_solved", "lower", "upper")
    ),
}
_COMMENT = (
    "half-widths of 95 % intervals, in the unit of the quantity; the larger one where an interval is "
    "asymmetric; combined: root of the sum of squares of the sources on the scale of the quantity; NaN: not "
    "requested, not available from this map, or not bounded above by it"
)


class Component(NamedTuple):
    """What one source contributes to the interval of one quantity, on its scale; arrays (load).

    Attributes
    ----------
    down, up : array
        half-widths, combined as the root of the sum of squares; infinite where nothing bounds them.
    shift_down, shift_up : array
        changes of known direction and unknown extent (noise, lens, tip), which are added.
    """

    down: np.ndarray
    up: np.ndarray
    shift_down: np.ndarray
    shift_up: np.ndarray


Components = Mapping[str, Component]  # by quantity


def component(down: np.ndarray, up: np.ndarray) -> Component:
    """Return a component without shifts."""
    return Component(down, up, np.zeros_like(down), np.zeros_like(up))


def component_from_units(name: str, value: np.ndarray, ends: Mapping[str, np.ndarray]) -> Component:
    """Return a component from `down`, `up`, `shift_down` and `shift_up` in the unit of a quantity.

    Those that are missing are 0.

    Examples
    --------
    >>> found = component_from_units("mean_gap", np.array([1.0]), {"up": np.array([1.0])})
    >>> float(found.up[0].round(3)), float(found.down[0])
    (0.693, 0.0)
    """
    least = 0 * value if name in CONSTRICTIONS else _LEAST * value
    middle, sides = to_scale(name, value), []
    for side, sign in zip(Component._fields, (-1, 1, -1, 1), strict=True):
        by = np.asarray(ends.get(side, 0 * value), float)
        with np.errstate(invalid="ignore"):
            moved = np.abs(to_scale(name, np.maximum(value + sign * by, least)) - middle)
        sides.append(np.where(np.isposinf(by), np.inf, np.where(by == 0, 0.0, moved)))
    return Component(*sides)


def ends_of(
    name: str,
    middle: np.ndarray,
    components: list[Component],
    arms: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return both ends of an interval in the unit of a quantity, without limits; infinite if unbounded.

    Parameters
    ----------
    name : str
    middle : array (load)
        the result on its scale.
    components : list of Component
    arms : pair of arrays (load), optional
        how far the truth lies below and above the result, by calibration; negative where it is apart from the
        result, which then moves to the nearer end.
    """
    down, up = (np.sqrt(sum(getattr(one, side) ** 2 for one in components)) for side in ("down", "up"))
    if arms is not None:
        below, above = arms
        moved = np.where(above < 0, above, np.where(below < 0, -below, 0.0))
        middle = middle + moved
        down, up = np.hypot(down, below + moved), np.hypot(up, above - moved)
    with np.errstate(invalid="ignore"):
        lower = middle - down - sum(one.shift_down for one in components)
        upper = middle + up + sum(one.shift_up for one in components)
    return from_scale(name, lower), from_scale(name, upper)


def monotonic(
    name: str, ends: tuple[np.ndarray, np.ndarray], load: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return ends that rise or fall with the load as the quantity does: one load bounds the others.

    Examples
    --------
    >>> lower, upper = monotonic("mean_gap", (np.ones(2), np.array([3.0, 9.0])), np.array([1.0, 2.0]))
    >>> upper.tolist()
    [3.0, 3.0]
    """
    if name not in _RISING:
        return ends
    order = np.argsort(load if _RISING[name] else -load, kind="stable")
    lower, upper = np.empty_like(ends[0]), np.empty_like(ends[1])
    lower[order] = np.fmax.accumulate(ends[0][order])
    upper[order[::-1]] = np.fmin.accumulate(ends[1][order[::-1]])
    return lower, upper


def limited(
    name: str,
    ends: tuple[np.ndarray, np.ndarray],
    *,
    value: np.ndarray,
    load: np.ndarray,
    hardness: float | None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return ends within physical limits; NaN where an upper end is unbounded, and both where none is known.

    The area lies between 0 and 1, the pressure in contact is at least the load, and no pressure exceeds the
    hardness. A result at a physical limit, up to rounding, stays inside its own interval.
    """
    least = load if name in (PRESSURE, PEAK) else np.zeros_like(load)
    most = np.inf if hardness is None or name not in (PRESSURE, PEAK) else hardness
    most = 1.0 if name == AREA else most
    lower = np.fmin(np.fmax(ends[0], least), value)
    upper = np.fmax(np.fmin(ends[1], most), value)
    unknown = np.isnan(value)
    return np.where(unknown, np.nan, lower), np.where(unknown | np.isinf(upper), np.nan, upper)


def columns_of_components(
    name: str,
    value: np.ndarray,
    found: Mapping[UncertaintySource, Components],
    ends: tuple[np.ndarray, np.ndarray],
) -> dict[str, tuple]:
    """Return `{name}_uncertainty` and `{name}_components` in the unit of the quantity, by source.

    `ends` are those of the combined interval.
    """
    middle = to_scale(name, value)
    shape = (value.size, len(SOURCES), len(Component._fields))
    parts, shown = np.zeros(shape), np.full((value.size, len(SOURCES) + 1), np.nan)
    for column, source in enumerate(SOURCES):
        if name not in found.get(source, {}):
            continue
        one = found[source][name]
        with np.errstate(invalid="ignore", over="ignore"):
            for place, (by, sign) in enumerate(zip(one, (-1, 1, -1, 1), strict=True)):
                moved = np.abs(from_scale(name, middle + sign * by) - value)
                parts[:, column, place] = np.where(np.isinf(by), np.inf, np.where(by == 0, 0.0, moved))
        shown[:, column] = np.maximum(
            parts[:, column, 0] + parts[:, column, 2], parts[:, column, 1] + parts[:, column, 3]
        )
    unbounded = np.isinf(parts).any(axis=(1, 2))
    shown[:, -1] = np.where(unbounded, np.inf, np.maximum(value - ends[0], ends[1] - value))
    parts = np.concatenate([parts, np.full((value.size, 1, shape[2]), np.nan)], axis=1)
    return {
        f"{name}_uncertainty": (("load", "source"), _bounded(shown), {"comment": _COMMENT}),
        f"{name}_components": (("load", "source", "component"), _bounded(parts)),
        f"{name}_estimate": ("load", value),
    }


def labels() -> dict[str, list[str]]:
    """Return the coordinates of the components."""
    return {"source": [*SOURCES, COMBINED], "component": list(Component._fields)}


def _bounded(values: np.ndarray) -> np.ndarray:
    """Return the values with infinite ones replaced by NaN."""
    return np.where(np.isinf(values), np.nan, values)


def is_of_budget(name: str) -> bool:
    """Return whether `uncertainty_table` needs the variable.

    Examples
    --------
    >>> is_of_budget("mean_gap_lower"), is_of_budget("mean_gap_parts")
    (True, False)
    """
    return name in _OF_THE_TABLE


def uncertainty_table(budget: xr.Dataset) -> pd.DataFrame:
    """Return the components of every interval, one row for each quantity, load and source.

    Parameters
    ----------
    budget : Dataset
        from `error_budget`, or statistics that contain it.

    Returns
    -------
    DataFrame
        columns `quantity`, `mean_pressure_Pa`, `source`, `evaluation_type` (A: statistical, B: other),
        `value`, `correction` (what was added to the result as solved, of the source `discretisation`),
        `standard_uncertainty_lower`, `standard_uncertainty_upper`, `coverage_factor` (1.96: the half-widths
        are quantiles of errors, or bounds, of 95 %), `one_sided_lower`, `one_sided_upper`, `lower`, `upper`.
        Of the source `combined` the standard uncertainties are the root of the sum of squares, and the ends
        those of the interval.

    References
    ----------
    JCGM 100:2008, Guide to the expression of uncertainty in measurement, 5.1.2.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> from roughcontact.uncertainty.budget import error_budget
    >>> height = rough_reference_surface(64)
    >>> settings = {"window": {}, "contact": {"contact_modulus": 1.0, "mean_pressure": [0.1]}}
    >>> table = uncertainty_table(error_budget(height, height, settings, sources=["solver"]))
    >>> table["source"].unique().tolist()
    ['solver', 'combined']
    """
    plain = {str(name): variable.values for name, variable in budget.variables.items()}
    tables = [_rows(plain, name) for name in (*QUANTITIES, *ANSWERS) if f"{name}_uncertainty" in plain]
    if not tables:
        return pd.DataFrame(columns=["quantity", "mean_pressure_Pa", "source"])
    return pd.DataFrame({key: np.concatenate([table[key] for table in tables]) for key in tables[0]})


def _rows(values: Mapping[str, np.ndarray], name: str) -> dict[str, np.ndarray]:
    """Return the columns of the table of one quantity: load by load its sources, and them combined."""
    shape = values[f"{name}_uncertainty"].shape
    estimate = values[f"{name}_estimate"]
    load, value, lower, upper = (
        np.broadcast_to(column[:, None], shape)
        for column in (
            values["mean_pressure"],
            estimate,
            values[f"{name}_lower"],
            values[f"{name}_upper"],
        )
    )
    down, up, shift_down, shift_up = np.moveaxis(values[f"{name}_components"], 2, 0)
    source = np.broadcast_to(values["source"].astype(object), shape)
    combined = source == COMBINED
    unbounded = ~combined & (np.isnan(up) | np.isnan(shift_up))
    known = combined | unbounded | ~np.isnan(values[f"{name}_uncertainty"])
    below = np.where(~combined & np.isnan(down), np.inf, down / _NORMAL)
    above = np.where(unbounded, np.inf, up / _NORMAL)
    for side in (below, above):
        side[:, -1] = np.sqrt(np.sum(np.where(known & ~combined, side, 0.0) ** 2, axis=1))
    correction = np.where(
        source == "discretisation", value - values.get(f"{name}_as_solved", estimate)[:, None], 0.0
    )
    columns = {
        "quantity": np.full(shape, name, dtype=object),
        "mean_pressure_Pa": load,
        "source": source,
        "evaluation_type": np.broadcast_to(np.array([*_TYPES, np.nan], dtype=object), shape),
        "value": value,
        "correction": np.where(combined, np.nan, correction),
        "standard_uncertainty_lower": below,
        "standard_uncertainty_upper": above,
        "coverage_factor": np.full(shape, _NORMAL),
        "one_sided_lower": shift_down,
        "one_sided_upper": np.where(unbounded, np.inf, shift_up),
        "lower": np.where(combined, lower, np.nan),
        "upper": np.where(combined, upper, np.nan),
    }
    return {key: column[known] for key, column in columns.items()}
