"""Combination of uncertainty sources into intervals, and the table of their components.

A component (4, load), on the scale of a quantity, holds half-widths below and above, which add as squares and
are infinite where nothing bounds them, and shifts of both ends, of known direction and unknown extent, which
add.
"""

from collections.abc import Iterable, Mapping
from typing import get_args

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact.arguments import answers
from roughcontact.arguments.choices import UncertaintySource
from roughcontact.uncertainty import scales
from roughcontact.uncertainty.scales import CONSTRICTIONS, from_scale, to_scale

Component = np.ndarray
Components = Mapping[str, Component]  # by quantity
Ends = tuple[np.ndarray, np.ndarray]  # lower and upper (load)
SOURCES: tuple[UncertaintySource, ...] = get_args(UncertaintySource)
COMBINED = "combined"
SIDES = ("down", "up", "shift_down", "shift_up")
SIGNS = np.array([[-1.0], [1.0], [-1.0], [1.0]])
_NORMAL = 1.959963984540054  # coverage factor of 95 % for infinite degrees of freedom
_COMMENT = (
    "half-widths of 95 % intervals, in the unit of the quantity; the larger one where an interval is "
    "asymmetric; combined: root of the sum of squares of the sources on the scale of the quantity; NaN: not "
    "requested, not available from this map, or not bounded above by it"
)
_ENDINGS = ("uncertainty", "components", "estimate", "as_solved", "alone", "lower", "upper")
# what `uncertainty_table` needs of a budget
TABLE_VARIABLES = {"mean_pressure", *(f"{name}_{ending}" for name in scales.ALL for ending in _ENDINGS)}


def half_widths(below: np.ndarray, above: np.ndarray) -> Component:
    """Return a component from half-widths; a negative one, of a truth that lies apart, moves both ends."""
    shift = np.where(above < 0, above, np.where(below < 0, -below, 0.0))
    return np.stack([below + shift, above - shift, -shift, shift])


def symmetric(width: np.ndarray) -> Component:
    """Return a component with the same half-width below and above."""
    return half_widths(width, width)


def one_sided(shift: np.ndarray) -> Component:
    """Return a component that moves the lower end by a negative shift, the upper end by a positive one."""
    zero = np.zeros_like(shift)
    return np.stack([zero, zero, np.maximum(-shift, 0.0), np.maximum(shift, 0.0)])


def added_up(components: Iterable[Component]) -> Component:
    """Return the sum of independent components: half-widths in quadrature, shifts added."""
    stack = np.stack(list(components))
    return np.concatenate([np.sqrt(np.sum(stack[:, :2] ** 2, axis=0)), np.sum(stack[:, 2:], axis=0)])


def sum_of_causes(causes: Iterable[Components]) -> Components:
    """Return the components of independent causes of one source, added up."""
    causes = list(causes)
    names = {name: None for cause in causes for name in cause}
    return {name: added_up(cause[name] for cause in causes if name in cause) for name in names}


def component_from_units(name: str, value: np.ndarray, sides: Component) -> Component:
    """Return a component from one whose half-widths and shifts are in the unit of a quantity.

    Examples
    --------
    >>> sides = half_widths(np.zeros(1), np.array([1.0]))
    >>> component_from_units("mean_gap", np.array([1.0]), sides).round(3).ravel()
    array([0.   , 0.693, 0.   , 0.   ])
    """
    lower_limit = 0.0 if name in CONSTRICTIONS else scales.SMALLEST * value
    with np.errstate(invalid="ignore"):
        bounds = np.maximum(value + SIGNS * sides, lower_limit)
        change = SIGNS * (to_scale(name, bounds) - to_scale(name, value))
    return np.where(np.isinf(sides), np.inf, np.where(sides == 0, 0.0, change))


def component_in_units(name: str, value: np.ndarray, component: Component) -> Component:
    """Return a component in the unit of a quantity from one on its scale."""
    with np.errstate(invalid="ignore", over="ignore"):
        change = SIGNS * (from_scale(name, to_scale(name, value) + SIGNS * component) - value)
    return np.where(np.isinf(component), np.inf, np.where(component == 0, 0.0, change))


def interval_bounds(name: str, middle: np.ndarray, total: Component) -> Ends:
    """Return both ends (load) in the unit of a quantity, without limits, about a result on its scale."""
    with np.errstate(invalid="ignore"):
        lower, upper = middle - total[0] - total[2], middle + total[1] + total[3]
    return from_scale(name, lower), from_scale(name, upper)


def monotonic(name: str, bounds: Ends, load: np.ndarray) -> Ends:
    """Return ends that rise or fall with the load as the quantity does: one load bounds the others."""
    if not (trend := answers.QUANTITIES[name].trend):
        return bounds
    order = np.argsort(trend * load, kind="stable")
    lower, upper = np.empty_like(bounds[0]), np.empty_like(bounds[1])
    lower[order] = np.fmax.accumulate(bounds[0][order])
    upper[order[::-1]] = np.fmin.accumulate(bounds[1][order[::-1]])
    return lower, upper


def limited(name: str, bounds: Ends, value: np.ndarray, load: np.ndarray, hardness: float) -> Ends:
    """Return ends within physical limits; NaN where an upper end is unbounded, both where none is known.

    A result at a physical limit, up to rounding, stays inside its own interval.
    """
    limits = answers.QUANTITIES[name].limits
    lowest, highest = limits(load, hardness) if limits else (0.0, np.inf)
    lower = np.fmin(np.fmax(bounds[0], lowest), value)
    upper = np.fmax(np.fmin(bounds[1], highest), value)
    is_unknown = np.isnan(value)
    return np.where(is_unknown, np.nan, lower), np.where(is_unknown | np.isinf(upper), np.nan, upper)


def columns_of_components(
    name: str, value: np.ndarray, components: Mapping[UncertaintySource, Component], bounds: Ends
) -> dict[str, tuple]:
    """Return `{name}_uncertainty` and `{name}_components` in the unit of the quantity, by source.

    `bounds` are those of the combined interval.
    """
    shape = (value.size, len(SOURCES) + 1)
    widths, sides = np.full(shape, np.nan), np.zeros((*shape, len(SIDES)))
    sides[:, -1] = np.nan
    for source, component in components.items():
        in_units, column = component_in_units(name, value, component), SOURCES.index(source)
        sides[:, column] = in_units.T
        widths[:, column] = np.maximum(*(in_units[:2] + in_units[2:]))
    is_unbounded = np.isinf(sides).any(axis=(1, 2))
    widths[:, -1] = np.where(is_unbounded, np.inf, np.maximum(value - bounds[0], bounds[1] - value))
    widths, sides = (np.where(np.isinf(values), np.nan, values) for values in (widths, sides))
    return {
        f"{name}_uncertainty": (("load", "source"), widths, {"comment": _COMMENT}),
        f"{name}_components": (("load", "source", "component"), sides),
        f"{name}_estimate": ("load", value),
    }


def uncertainty_table(budget: xr.Dataset) -> pd.DataFrame:
    """Return the components of every interval of an `error_budget`: a row by quantity, load and source.

    `evaluation_type` is A (statistical) or B, `correction` what its source added to the result; of
    `combined` the standard uncertainties are the root of the sum of squares (JCGM 100:2008, 5.1.2).
    Half-widths are quantiles of errors, or bounds, of 95 % (`coverage_factor` 1.96); a negative one-sided
    number moves its end towards the value.
    """
    plain = {str(name): variable.values for name, variable in budget.variables.items()}
    tables = [_rows(plain, name) for name in scales.ALL if f"{name}_uncertainty" in plain]
    if not tables:
        return pd.DataFrame(columns=["quantity", "mean_pressure_Pa", "source"])
    return pd.DataFrame({key: np.concatenate([table[key] for table in tables]) for key in tables[0]})


def _rows(values: Mapping[str, np.ndarray], name: str) -> dict[str, np.ndarray]:
    """Return the columns of the table of one quantity: load by load its sources, and them combined."""
    widths, estimate = values[f"{name}_uncertainty"], values[f"{name}_estimate"][:, None]
    source, nan = values["source"].astype(object), np.nan
    width_below, width_above, shift_down, shift_up = np.moveaxis(values[f"{name}_components"], 2, 0)
    is_total = source == COMBINED
    is_unbounded = ~is_total & (np.isnan(width_above) | np.isnan(shift_up))
    present = is_total | is_unbounded | ~np.isnan(widths)
    below = np.where(~is_total & np.isnan(width_below), np.inf, width_below / _NORMAL)
    above = np.where(is_unbounded, np.inf, width_above / _NORMAL)
    for side in (below, above):
        side[:, -1] = np.sqrt(np.sum(np.where(present & ~is_total, side, 0.0) ** 2, axis=1))
    # what the overview shows of other places is not of the pixels
    of_map = values.get(f"{name}_alone", estimate[:, 0])[:, None]
    of_map = np.where(np.isnan(of_map), estimate, of_map)  # of a map beside others with an overview
    of_pixels = of_map - values.get(f"{name}_as_solved", of_map[:, 0])[:, None]
    of_places = np.where(source == "window", estimate - of_map, 0.0)
    columns = {
        "quantity": np.array(name, dtype=object),
        "mean_pressure_Pa": values["mean_pressure"][:, None],
        "source": source,
        "evaluation_type": np.where(is_total, nan, np.where(source == "window", "A", "B").astype(object)),
        "value": estimate,
        "correction": np.where(is_total, nan, np.where(source == "discretisation", of_pixels, of_places)),
        "standard_uncertainty_lower": below,
        "standard_uncertainty_upper": above,
        "coverage_factor": _NORMAL,
        "one_sided_lower": shift_down,
        "one_sided_upper": np.where(is_unbounded, np.inf, shift_up),
        "lower": np.where(is_total, values[f"{name}_lower"][:, None], nan),
        "upper": np.where(is_total, values[f"{name}_upper"][:, None], nan),
    }
    return {key: np.broadcast_to(column, widths.shape)[present] for key, column in columns.items()}
