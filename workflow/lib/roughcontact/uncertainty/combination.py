"""Combination of uncertainty sources into intervals, and the table of their components."""

from collections.abc import Mapping
from typing import get_args

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from roughcontact.choices import UncertaintySource
from roughcontact.uncertainty.answers import ANSWERS, quantities_in
from roughcontact.uncertainty.headline import QUANTITIES

SOURCES: tuple[UncertaintySource, ...] = get_args(UncertaintySource)
COMBINED = "combined"
_NORMAL = 1.959963984540054  # coverage factor of 95 % for infinite degrees of freedom
# A: evaluated from a scatter; B: from bounds, models and statements
_TYPES = ["A" if source == "window" else "B" for source in SOURCES]
_PARTS = ("down", "up", "bias", "shift_down", "shift_up")
# sources of the interval of this map in the band of waves that it holds
_OF_THE_MAP = tuple(source for source in SOURCES if source not in ("window", "unresolved"))
_OF_THE_TABLE = {
    *("mean_pressure", "degrees_of_freedom", "coverage_factor"),
    *(
        f"{name}_{ending}"
        for name in (*QUANTITIES, *ANSWERS)
        for ending in ("uncertainty", "components", "estimate", "lower", "upper")
    ),
}
_COMMENT = (
    "half-widths of 95 % intervals, in the unit of the quantity; the larger one where an interval is "
    "asymmetric; combined: root of the sum of squares of the sources given (for the pressure in contact the "
    "known bias of whole pixels is added linearly); NaN: not requested, not available from this map, or not "
    "bounded above by it"
)
_ENDS = {
    "lower": "lower end of the 95 % interval, all sources combined",
    "upper": "upper end of the 95 % interval, all sources combined; NaN beside a lower end: not bounded",
    "map_lower": "lower end of the 95 % interval of this map, for the waves that it holds",
    "map_upper": "upper end of the 95 % interval of this map, for the waves that it holds; NaN: not bounded",
}


def combine(
    found: Mapping[UncertaintySource, xr.Dataset], result: xr.Dataset, *, hardness: float | None = None
) -> xr.Dataset:
    """Return combined uncertainties and interval ends from the half-widths of each source.

    Let Q be a result, U_i the half-widths without a known bias b_i, and s_i one-sided shifts:

        lower = (Q - sqrt(sum U_i²)) prod (1 - s_i/Q)
        upper = (Q + sum b_i + sqrt(sum U_i²)) prod (1 + s_i/Q)

    each with the values of its side; where Q = 0 the shifts are added. A source that is absent, or NaN at a
    load, does not count; only `window`, NaN where a map is too small for parts, leaves both ends open. b_i is
    the amount by which the result is known to be too low ([1]_, F.2.4.5): only the pressure in contact, a
    mean over whole pixels, has such a bias. Shifts are changes of known direction and unknown extent: noise,
    lens, tip, waves that are not resolved. The interval is limited to physical values: the area lies between
    0 and 1, the pressure in contact is at least the load, and no pressure exceeds the hardness.

    Parameters
    ----------
    found : dict
        source -> Dataset (load) with the half-widths of `QUANTITIES`, also as `{name}_down` and `{name}_up`
        where they differ, the known bias b_i as `{name}_bias`, and the shifts as `{name}_shift_down` and
        `{name}_shift_up`; attributes `degrees_of_freedom` and `coverage_factor` where these are finite.
    result : Dataset
        `QUANTITIES` (load), and `mean_pressure`.
    hardness : float, Pa, optional
        upper limit of the pressure.

    Returns
    -------
    Dataset
        `{name}_uncertainty` with dims (load, source), `source` being the seven and `combined`: the larger
        half-width; NaN where none is known or where one side is unbounded (infinite). With the same dims what
        it is made of: `{name}_components`, along `component` down, up, bias, shift_down and shift_up. Along
        `load` the ends of the combined interval, `{name}_lower` and `{name}_upper`, and of that of the
        map, `{name}_map_lower` and `{name}_map_upper`; NaN for an unbounded end. Along `source`
        `degrees_of_freedom` and `coverage_factor`.

    References
    ----------
    .. [1] JCGM 100:2008, Guide to the expression of uncertainty in measurement.

    Examples
    --------
    >>> import xarray as xr
    >>> solver, pixels = (xr.Dataset({name: ("load", [u]) for name in QUANTITIES}) for u in (0.3, 0.4))
    >>> result = xr.Dataset({name: ("load", [0.6]) for name in QUANTITIES})
    >>> result["mean_pressure"] = ("load", [0.2])
    >>> found = combine({"solver": solver, "discretisation": pixels}, result)
    >>> found["mean_gap_uncertainty"].values
    array([[0.3, 0.4, nan, nan, nan, nan, nan, 0.5]])
    >>> [round(found[f"relative_contact_area_{end}"].item(), 2) for end in ("lower", "upper")]
    [0.1, 1.0]
    """
    load = result["mean_pressure"].values
    least = {"mean_contact_pressure": load, "max_pressure": load}
    limit = np.inf if hardness is None else hardness
    most = {"relative_contact_area": 1.0, "max_pressure": limit, "mean_contact_pressure": limit}
    columns: dict[str, tuple] = _degrees_of_freedom(found)
    for name in quantities_in(result):
        value = result[name].values
        columns[f"{name}_estimate"] = ("load", value)
        parts = _components(name, found, load.size)
        nothing = np.full(load.size, np.nan)
        # a result at a physical limit, up to rounding, stays inside its own interval
        low, high = np.minimum(value, least.get(name, 0.0)), np.maximum(value, most.get(name, np.inf))
        for ending, sources in (("", SOURCES), ("map_", _OF_THE_MAP)):
            down, up = _half_widths(value, parts, [SOURCES.index(source) for source in sources])
            if not ending:
                made_of = np.stack([np.column_stack([parts[key], nothing]) for key in _PARTS], axis=2)
                columns[f"{name}_components"] = (("load", "source", "component"), _bounded(made_of))
                shown = _bounded(np.column_stack([parts["shown"], np.maximum(down, up)]))
                columns[f"{name}_uncertainty"] = (("load", "source"), shown, {"comment": _COMMENT})
            ends = {"lower": np.maximum(value - down, low), "upper": np.minimum(value + up, high)}
            for end, values in ends.items():
                comment = {"comment": _ENDS[f"{ending}{end}"]}
                columns[f"{name}_{ending}{end}"] = ("load", _bounded(values), comment)
    return xr.Dataset(columns, coords={"source": [*SOURCES, COMBINED], "component": list(_PARTS)})


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
        `value`, `standard_uncertainty_lower`, `standard_uncertainty_upper`, `degrees_of_freedom`,
        `sensitivity` (each component is evaluated in the unit of the result: 1), `coverage_factor`, `bias`,
        `one_sided_lower`, `one_sided_upper`, `lower`, `upper`. Of the source `combined` the standard
        uncertainties are the root of the sum of squares, the degrees of freedom those of Welch and
        Satterthwaite ([1]_, G.4.1), and the ends those of the interval.

    References
    ----------
    .. [1] JCGM 100:2008, Guide to the expression of uncertainty in measurement.

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
    load, value, lower, upper = (
        np.broadcast_to(values[key][:, None], shape)
        for key in ("mean_pressure", *(f"{name}_{end}" for end in ("estimate", "lower", "upper")))
    )
    freedom, factor = (
        np.broadcast_to(values[key], shape).copy() for key in ("degrees_of_freedom", "coverage_factor")
    )
    down, up, bias, shift_down, shift_up = np.moveaxis(values[f"{name}_components"], 2, 0)
    combined = np.broadcast_to(values["source"] == COMBINED, shape)
    unbounded = ~combined & (np.isnan(up) | np.isnan(shift_up))
    known = combined | unbounded | ~np.isnan(values[f"{name}_uncertainty"])
    below = np.where(~combined & np.isnan(down), np.inf, down / factor)
    above = np.where(unbounded, np.inf, up / factor)
    lower_parts, upper_parts = (np.where(known & ~combined, part, 0.0) for part in (below, above))
    below[:, -1], above[:, -1] = (np.sqrt(np.sum(part**2, axis=1)) for part in (lower_parts, upper_parts))
    freedom[:, -1], factor[:, -1] = _effective(lower_parts, upper_parts, freedom)
    columns = {
        "quantity": np.full(shape, name, dtype=object),
        "mean_pressure_Pa": load,
        "source": np.broadcast_to(values["source"].astype(object), shape),
        "evaluation_type": np.broadcast_to(np.array([*_TYPES, np.nan], dtype=object), shape),
        "value": value,
        "standard_uncertainty_lower": below,
        "standard_uncertainty_upper": above,
        "degrees_of_freedom": freedom,
        "sensitivity": np.where(combined, np.nan, 1.0),
        "coverage_factor": factor,
        "bias": bias,
        "one_sided_lower": shift_down,
        "one_sided_upper": np.where(unbounded, np.inf, shift_up),
        "lower": np.where(combined, lower, np.nan),
        "upper": np.where(combined, upper, np.nan),
    }
    return {key: column[known] for key, column in columns.items()}


def _effective(lower: np.ndarray, upper: np.ndarray, freedom: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return effective degrees of freedom and coverage factor from standard uncertainties (load, source)."""
    larger = np.maximum(lower, upper)
    with np.errstate(invalid="ignore", divide="ignore"):
        fourth = np.sum(np.where(larger > 0, larger**4 / freedom, 0.0), axis=1)
        effective = np.maximum(*(np.sum(part**2, axis=1) for part in (lower, upper))) ** 2 / fourth
    finite = np.isfinite(effective)
    factor = np.where(finite, scipy.special.stdtrit(np.where(finite, effective, 1.0), 0.975), _NORMAL)
    return np.where(finite, effective, np.inf), factor


def _degrees_of_freedom(found: Mapping[UncertaintySource, xr.Dataset]) -> dict[str, tuple]:
    """Return degrees of freedom and coverage factors along `source`."""
    freedom, factor = np.full((2, len(SOURCES) + 1), np.nan)
    for source, dataset in found.items():
        column = SOURCES.index(source)
        freedom[column] = dataset.attrs.get("degrees_of_freedom", np.inf)
        factor[column] = dataset.attrs.get("coverage_factor", _NORMAL)
    return {
        "degrees_of_freedom": ("source", freedom),
        "coverage_factor": ("source", factor),
    }


def _components(
    name: str, found: Mapping[UncertaintySource, xr.Dataset], loads: int
) -> dict[str, np.ndarray]:
    """Return the parts (load, source) of the uncertainty of one quantity, NaN where a source says nothing.

    `shown` is the larger half-width; `down` and `up` are the half-widths without the known `bias`, which is
    added linearly above; `shift_down` and `shift_up` are one-sided.
    """
    parts = {key: np.zeros((loads, len(SOURCES))) for key in _PARTS}
    parts["shown"] = np.full((loads, len(SOURCES)), np.nan)
    for source, dataset in found.items():
        if name not in dataset:  # the answers have no solver uncertainty
            continue
        column = SOURCES.index(source)
        parts["shown"][:, column] = dataset[name].values
        if f"{name}_bias" in dataset:
            parts["bias"][:, column] = dataset[f"{name}_bias"].values
        for side in ("down", "up"):
            shift, width = f"{name}_shift_{side}", f"{name}_{side}"
            if shift in dataset:
                parts[f"shift_{side}"][:, column] = dataset[shift].values
            if width in dataset or shift not in dataset:
                parts[side][:, column] = dataset[width if width in dataset else name].values
            parts[side][:, column] -= parts["bias"][:, column]
            if source == "window":  # without parts of a map nothing bounds what other places would give
                unknown = np.isnan(dataset[name].values)
                parts[side][:, column] = np.where(unknown, np.inf, parts[side][:, column])
    absent = np.isnan(parts["shown"])
    for key in _PARTS:
        parts[key] = np.where(absent & ~np.isinf(parts[key]), 0.0, parts[key])
    return parts


def _half_widths(
    value: np.ndarray, parts: Mapping[str, np.ndarray], columns: list[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the distances of both ends of an interval from the result; NaN without sources."""
    down, up = (np.sqrt(np.sum(parts[side][:, columns] ** 2, axis=1)) for side in ("down", "up"))
    up = up + parts["bias"][:, columns].sum(axis=1)
    below, above = parts["shift_down"][:, columns], parts["shift_up"][:, columns]
    positive = value > 0
    scale = np.where(positive, value, 1.0)[:, None]
    with np.errstate(invalid="ignore"):
        reduction = 1 - np.prod(np.maximum(1 - below / scale, 0.0), axis=1)
        growth = np.prod(1 + above / scale, axis=1) - 1
        down = np.where(
            np.isinf(down), down, down + np.where(positive, (value - down) * reduction, below.sum(axis=1))
        )
        up = np.where(np.isinf(up), up, up + np.where(positive, (value + up) * growth, above.sum(axis=1)))
    nothing = np.isnan(parts["shown"][:, columns]).all(axis=1)
    return np.where(nothing, np.nan, down), np.where(nothing, np.nan, up)


def _bounded(values: np.ndarray) -> np.ndarray:
    """Return the values with infinite ones replaced by NaN."""
    return np.where(np.isinf(values), np.nan, values)
