"""The cases of a study side by side: of one surface load by load, of many by medians and spread."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.quantities import Unit, number, quantity, with_interval
from roughcontact.report.tables import TITLES, UNITS
from roughcontact.report.units import interval_at, middle_of, unit_of
from roughcontact.uncertainty.differences import case_differences, case_pairs, shared_loads

_COMPARED = ("relative_contact_area", "mean_contact_pressure", "max_pressure", "mean_gap")
_PERCENT = Unit(1.0, "%")  # of numbers in percent
_SPREAD = (0.1, 0.9)  # quantiles over the surfaces

_DUST = 1e-9  # percent: a difference that small is rounding
_MANIFOLD = 900.0  # percent: a larger difference is a factor
_FINEST = 0.1  # percent: half-width of a difference of which two digits are shown; one of 0.01 % is none

Cases = Mapping[str, xr.Dataset]  # of a surface
Load = tuple[xr.Dataset, int]  # statistics, and the place of a load among theirs
Row = dict[str, int]  # case -> place of a load among its own


class _Changes(NamedTuple):
    """The difference between two cases in percent, both ends of its interval, and the first number."""

    change: np.ndarray
    low: np.ndarray
    high: np.ndarray
    first: np.ndarray


class _Shared(NamedTuple):
    """The loads that the cases of a surface share."""

    rows: list[Row]
    indices: dict[tuple[str, str], list[tuple[int, int]]]  # of each pair of cases
    changes: dict[tuple[str, str], xr.Dataset]  # of `case_differences` at these


def case_table(cases: Mapping[str, xr.Dataset], *, equal_loads: bool = False) -> dict[str, Any] | None:
    """Return the numbers of one surface under several cases, with their differences; None for a single case.

    The pairs of `case_pairs` are compared at `shared_loads`, in order where all cases ask for `equal_loads`,
    without what both share (`case_differences`). `groups` has `title` and `rows` of each quantity, `apart` a
    sentence on pairs that share no load.
    """
    return _table([cases], _value, _change, equal_loads=equal_loads) if len(cases) > 1 else None


def case_medians(
    surfaces: Sequence[Mapping[str, xr.Dataset]], *, equal_loads: bool = False
) -> dict[str, Any] | None:
    """Return medians over many surfaces under each case, and those of the differences between cases.

    As of `case_table`, with the 10th and 90th percentile, and how many differences exceed their ±; surfaces
    that lack a case or share other loads are left out. None for a single case, or no surface under all.
    """
    names = list(dict.fromkeys(name for surface in surfaces for name in surface))
    complete = [{name: result[name] for name in names} for result in surfaces if len(result) == len(names)]
    if len(names) < 2 or not complete:
        return None
    return _table(complete, _median_value, _median_change, equal_loads=equal_loads)


def _table(
    surfaces: Sequence[Cases],
    value: Callable[[Sequence[Load], str, Unit], str],
    change: Callable[[_Changes], str],
    *,
    equal_loads: bool,
) -> dict[str, Any]:
    """Return the table of cases, with cells of numbers by `value` and of differences by `change`."""
    shared = [_shared(surface, equal_loads=equal_loads) for surface in surfaces]
    first = next((loads for loads in shared if loads.rows), shared[0])
    # those whose cases share as many loads; their indices differ where targets lie between
    retained = [
        (cases, loads)
        for cases, loads in zip(surfaces, shared, strict=True)
        if [row.keys() for row in loads.rows] == [row.keys() for row in first.rows]
    ]
    compared = [cases for cases, _ in retained]
    names, pairs = list(compared[0]), [pair for pair, indices in first.indices.items() if indices]
    middle = middle_of([cases[names[0]] for cases in compared])
    groups = []

    def pressure_of(numbered: tuple[int, Row]) -> float:
        """Return the lowest mean pressure of a row."""
        return min(float(compared[0][name]["mean_pressure"][index]) for name, index in numbered[1].items())

    for name in _COMPARED if first.rows else ():
        unit, rows = unit_of(middle, UNITS[name]), []
        for number_of_row, row in sorted(enumerate(first.rows), key=pressure_of):
            at_load = {
                case: [(cases[case], loads.rows[number_of_row][case]) for cases, loads in retained]
                for case in row
            }
            cells = [value(at_load[case], name, unit) if case in row else "–" for case in names]
            for pair in pairs:
                indices = row.get(pair[0], -1), row.get(pair[1], -1)
                if indices not in first.indices[pair]:
                    cells.append("–")
                    continue
                position = first.indices[pair].index(indices)
                ratios = [_interval(loads.changes[pair], name, position) for _, loads in retained]
                cells.append(change(_changes([at_load[case] for case in pair], name, ratios)))
            rows.append([_load(at_load), *cells])
        groups.append({"title": TITLES[name], "rows": rows})
    disjoint = [pair for pair, indices in first.indices.items() if not indices]
    return {
        "cases": names,
        "load": "load" if any("force" in data for data in compared[0].values()) else "mean pressure p̄",
        "differences": [f"{second} against {first}" for first, second in pairs],
        "groups": groups,
        "apart": _without_common_load(compared[0], disjoint, alone=not pairs) if disjoint else "",
        "surfaces": len(compared),
    }


def _shared(cases: Cases, *, equal_loads: bool) -> _Shared:
    """Return the loads at which the cases of a surface are compared, and the changes there."""
    rows: list[Row] = []
    shared, changes = {}, {}
    # as stated: between them, where loads rise, lie those of targets, at other places under other cases
    stated = {name: data.get("place", data["mean_pressure"]).values for name, data in cases.items()}
    for pair in case_pairs(list(cases)):
        datasets = [cases[name] for name in pair]
        in_order = equal_loads and datasets[0].sizes["load"] == datasets[1].sizes["load"]
        indices = [np.argsort(stated[name]) for name in pair] if in_order else shared_loads(datasets)
        changes[pair] = case_differences(
            *(data.isel(load=selected) for data, selected in zip(datasets, indices, strict=True))
        )
        shared[pair] = [(int(first), int(second)) for first, second in zip(*indices, strict=True)]
        for places in shared[pair]:
            loads = dict(zip(pair, places, strict=True))
            joined = (row for row in rows if row.items() & loads.items() and row | loads == loads | row)
            if not (row := next(joined, {})):
                rows.append(row)
            row |= loads
    rows.sort(key=lambda row: min(stated[name][index] for name, index in row.items()))
    return _Shared(rows, shared, changes)


def _without_common_load(cases: Cases, pairs: Sequence[tuple[str, str]], *, alone: bool) -> str:
    """Return what is said of pairs of cases that share no load, of all pairs where they are `alone`."""
    spans = []
    for name in dict.fromkeys(name for pair in pairs for name in pair):
        extreme_loads = (quantity(float(cases[name]["mean_pressure"][end]), "Pa") for end in (0, -1))
        spans.append(f"{name}: {' to '.join(dict.fromkeys(extreme_loads))}")
    owner = "The cases" if alone else ", ".join(" and ".join(pair) for pair in pairs)
    return (
        f"{owner} have no load in common ({'; '.join(spans)}), so that their numbers cannot be compared: "
        "give them the same contact.mean_pressure, relative_pressure or target."
    )


def _load(at_load: Mapping[str, Sequence[Load]]) -> str:
    """Return the load that all surfaces share under the cases of a row, else the median pressure of each."""
    of_pressure = unit_of(next(iter(at_load.values()))[0][0], "Pa").text
    for name, show in (
        ("force", lambda force: quantity(force, "N")),
        ("mean_pressure", of_pressure),
        ("relative_pressure", lambda pressure: f"{number(pressure)} E* g"),
    ):
        if all(name in data for loads in at_load.values() for data, _ in loads):
            values = np.array([_values(loads, name) for loads in at_load.values()])
            if np.allclose(values, values[0, 0], rtol=1e-6, atol=0):
                return show(float(values[0, 0]))
    pressures = [_values(loads, "mean_pressure") for loads in at_load.values()]
    return " / ".join(of_pressure(float(median)) for median in np.median(pressures, axis=1))


def _value(loads: Sequence[Load], name: str, unit: Unit) -> str:
    """Return a number of a surface at a load, with its interval."""
    ((data, index),) = loads
    return _in_brackets(unit.interval(*interval_at(data, name, index)), unit.symbol)


def _median_value(loads: Sequence[Load], name: str, unit: Unit) -> str:
    """Return the median of a number of many surfaces."""
    return _quantiles(_values(loads, name), unit)


def _values(loads: Sequence[Load], name: str) -> np.ndarray:
    """Return a number of each of some loads."""
    return np.array([float(data[name].values[index]) for data, index in loads])


def _changes(loads: Sequence[Sequence[Load]], name: str, ratios: Sequence[tuple[float, float]]) -> _Changes:
    """Return the differences between the `loads` of two cases; `ratios` has both ends of each ratio."""
    first, second = (_values(of_case, name) for of_case in loads)
    with np.errstate(divide="ignore", invalid="ignore"):
        change, low, high = (100 * (ratio - 1) for ratio in (second / first, *np.transpose(ratios)))
    change, low, high = (np.where(np.abs(percent) < _DUST, 0.0, percent) for percent in (change, low, high))
    return _Changes(change, low, high, first)


def _change(changes: _Changes) -> str:
    """Return the difference of a surface with its interval."""
    change, low, high, first = (values[0] for values in changes)
    if not first > 0:
        return "–"
    if change > _MANIFOLD:
        times = (1 + float(percent) / 100 for percent in (change, low, high))
        return _in_brackets(with_interval(*times), "times as large")
    return _in_brackets(with_interval(change, low, high, finest=_FINEST), "%")


def _median_change(changes: _Changes) -> str:
    """Return the median of the differences, and of how many surfaces they are larger than their interval."""
    change, low, high, _ = changes
    available = np.isfinite(low) & np.isfinite(high)
    clear = available & ((low > 0) | (high < 0))
    excess = f"; beyond ± {clear.sum()} of {available.sum()}" if available.any() else ""
    return _quantiles(change, _PERCENT, decimals=2) + excess


def _in_brackets(text: str, unit: str) -> str:
    """Return a number before its unit, in brackets where half-widths stand beside it."""
    return f"({text}) {unit}" if " " in text and not text.endswith(")") else f"{text} {unit}"


def _interval(result: xr.Dataset, name: str, load: int) -> tuple[float, float]:
    """Return both ends of a ratio to the first case; NaN where they are not known."""
    if name not in result["quantity"].values:
        return np.nan, np.nan
    row = list(result["quantity"].values).index(name)
    low, high = (float(result[f"ratio_{end}"].values[row, load]) for end in ("lower", "upper"))
    return low, high


def _quantiles(values: np.ndarray, unit: Unit, *, decimals: int | None = None) -> str:
    """Return the median of some numbers, and the range of most of them, `decimals` as of `number`."""
    available = values[np.isfinite(values)] * unit.factor
    if not available.size:
        return "–"
    low, middle, high = (
        number(float(end), decimals=decimals) for end in np.quantile(available, [_SPREAD[0], 0.5, _SPREAD[1]])
    )
    return f"{middle} {unit.symbol} ({low} to {high})"
