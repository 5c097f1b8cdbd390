"""The cases of a study side by side: of one surface load by load, of many by medians and spread."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import COMPARED, GAP, TITLES, UNITS
from roughcontact.arguments.quantities import Unit, number, quantity, with_interval
from roughcontact.report.units import median_numbers, number_text, unit_of
from roughcontact.statistics.decisions import CLOSED
from roughcontact.statistics.load_pairs import paired_loads, same_load
from roughcontact.uncertainty.differences import case_differences, case_pairs

_PERCENT = Unit(1.0, "%")  # of numbers in percent
_QUANTILES = (0.1, 0.5, 0.9)  # over the surfaces

_DUST = 1e-9  # percent: a difference that small is rounding
_MANIFOLD = 900.0  # percent: a larger difference is a factor
_FINEST = 0.1  # percent: half-width of a difference of which two digits are shown; one of 0.01 % is none

Cases = Mapping[str, xr.Dataset]  # of a surface
Load = tuple[xr.Dataset, int]  # statistics, and the place of a load among theirs
Row = dict[str, int]  # case -> place of a load among its own
# by surface: the difference between two cases in percent, both ends of its interval, and the first number
Changes = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


class _Shared(NamedTuple):
    """The loads that the cases of a surface share."""

    rows: list[Row]
    indices: dict[tuple[str, str], list[tuple[int, int]]]  # of each pair of cases
    changes: dict[tuple[str, str], xr.Dataset]  # of `case_differences` at these


def case_table(cases: Mapping[str, xr.Dataset], *, equal_loads: bool = False) -> dict[str, Any] | None:
    """Return the numbers of one surface under several cases, with their differences; None for a single case.

    The pairs of `case_pairs` are compared at their `paired_loads`, as stated where all cases ask for
    `equal_loads`, without what both share (`case_differences`). `groups` has `title` and `rows` of each
    quantity, `apart` a sentence on pairs that share no load.
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
    change: Callable[[Changes], str],
    *,
    equal_loads: bool,
) -> dict[str, Any]:
    """Return the table of cases, with cells of numbers by `value` and of differences by `change`."""
    all_loads = [_shared(surface, equal_loads=equal_loads) for surface in surfaces]
    reference_loads = next((loads for loads in all_loads if loads.rows), all_loads[0])
    # those whose cases share as many loads; their indices differ where targets lie between
    selection = [
        (cases, loads)
        for cases, loads in zip(surfaces, all_loads, strict=True)
        if [row.keys() for row in loads.rows] == [row.keys() for row in reference_loads.rows]
    ]
    all_cases = [cases for cases, _ in selection]
    names, pairs = list(all_cases[0]), [pair for pair, indices in reference_loads.indices.items() if indices]
    middle = median_numbers([cases[names[0]] for cases in all_cases])
    pressures = {name: data["mean_pressure"].values for name, data in all_cases[0].items()}
    lowest = [min(pressures[name][i] for name, i in row.items()) for row in reference_loads.rows]
    groups = []
    for name in COMPARED if lowest else ():
        unit, rows = unit_of(middle, UNITS[name]), []
        for row_index in np.argsort(lowest, kind="stable").tolist():
            row = reference_loads.rows[row_index]
            at_load = {
                case: [(cases[case], table.rows[row_index][case]) for cases, table in selection]
                for case in row
            }
            cells = [value(at_load[case], name, unit) if case in row else "–" for case in names]
            for pair in pairs:
                pair_indices = reference_loads.indices[pair]
                indices = row.get(pair[0], -1), row.get(pair[1], -1)
                if indices not in pair_indices:
                    cells.append("–")
                    continue
                ratios = [
                    _interval(table.changes[pair], name, pair_indices.index(indices))
                    for _, table in selection
                ]
                cells.append(change(_changes([at_load[case] for case in pair], name, ratios)))
            rows.append([_load(at_load), *cells])
        groups.append({"title": TITLES[name], "rows": rows})
    disjoint = [pair for pair, indices in reference_loads.indices.items() if not indices]
    return {
        "cases": names,
        "load": "load" if any("force" in data for data in all_cases[0].values()) else "mean pressure",
        "differences": [f"{case} against {reference}" for reference, case in pairs],
        "groups": groups,
        "apart": _disjoint_loads_in_words(all_cases[0], disjoint, all_pairs=not pairs) if disjoint else "",
        "surfaces": len(all_cases),
    }


def _shared(cases: Cases, *, equal_loads: bool) -> _Shared:
    """Return the loads at which the cases of a surface are compared, and the changes there."""
    rows: list[Row] = []
    pairwise, changes = {}, {}
    # as stated: between them, where loads rise, lie those of targets, at other places under other cases
    order = {name: data.get("place", data["mean_pressure"]).values for name, data in cases.items()}
    for pair in case_pairs(list(cases)):
        indices = paired_loads(*(cases[name] for name in pair), as_stated=equal_loads)
        shared = (cases[name].isel(load=positions) for name, positions in zip(pair, indices, strict=True))
        changes[pair] = case_differences(*shared)
        pairwise[pair] = [(int(i), int(j)) for i, j in zip(*indices, strict=True)]
        for pair_indices in pairwise[pair]:
            loads = dict(zip(pair, pair_indices, strict=True))
            matches = (row for row in rows if row.items() & loads.items() and row | loads == loads | row)
            if not (row := next(matches, {})):
                rows.append(row)
            row |= loads
    rows.sort(key=lambda row: min(order[name][index] for name, index in row.items()))
    return _Shared(rows, pairwise, changes)


def _disjoint_loads_in_words(cases: Cases, pairs: Sequence[tuple[str, str]], *, all_pairs: bool) -> str:
    """Return what is said of pairs of cases that share no load, of all pairs where they are `all_pairs`."""
    spans = []
    for name in dict.fromkeys(name for pair in pairs for name in pair):
        first_and_last = cases[name]["mean_pressure"].values[[0, -1]].tolist()
        spans.append(f"{name}: {' to '.join(dict.fromkeys(quantity(load, 'Pa') for load in first_and_last))}")
    owner = "The cases" if all_pairs else ", ".join(" and ".join(pair) for pair in pairs)
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
            if same_load(values, values[0, 0]).all():
                return show(float(values[0, 0]))
    pressures = [_values(loads, "mean_pressure") for loads in at_load.values()]
    return " / ".join(of_pressure(float(median)) for median in np.median(pressures, axis=1))


def _value(loads: Sequence[Load], name: str, unit: Unit) -> str:
    """Return a number of a surface at a load, with its interval."""
    ((data, index),) = loads
    return _bracketed(number_text(data, name, unit, index), unit.symbol)


def _median_value(loads: Sequence[Load], name: str, unit: Unit) -> str:
    """Return the median of a number of many surfaces."""
    return _quantiles(_values(loads, name), unit)


def _values(loads: Sequence[Load], name: str) -> np.ndarray:
    """Return a number of each of some loads."""
    return np.array([float(data[name].values[index]) for data, index in loads])


def _changes(loads: Sequence[Sequence[Load]], name: str, ratios: Sequence[tuple[float, float]]) -> Changes:
    """Return the differences between the `loads` of two cases; `ratios` has both ends of each ratio."""
    reference, values = (_values(of_case, name) for of_case in loads)
    if name == GAP:  # finer than atoms nothing is known
        reference = np.where(reference < CLOSED, 0.0, reference)
    with np.errstate(divide="ignore", invalid="ignore"):
        change, low, high = (100 * (ratio - 1) for ratio in (values / reference, *np.transpose(ratios)))
    change, low, high = (np.where(np.abs(percent) < _DUST, 0.0, percent) for percent in (change, low, high))
    return change, low, high, reference


def _change(changes: Changes) -> str:
    """Return the difference of a surface with its interval."""
    change, low, high, reference = (values[0] for values in changes)
    if not reference > 0:
        return "–"
    if change > _MANIFOLD:
        times = (1 + float(percent) / 100 for percent in (change, low, high))
        return _bracketed(with_interval(*times), "times as large")
    return _bracketed(with_interval(change, low, high, finest=_FINEST), "%")


def _median_change(changes: Changes) -> str:
    """Return the median of the differences, and of how many surfaces they are larger than their interval."""
    change, low, high, _ = changes
    available = np.isfinite(low) & np.isfinite(high)
    clear = available & ((low > 0) | (high < 0))
    excess = f"; beyond ± {clear.sum()} of {available.sum()}" if available.any() else ""
    return _quantiles(change, _PERCENT, decimals=2) + excess


def _bracketed(text: str, unit: str) -> str:
    """Return a number before its unit, in brackets where half-widths stand beside it."""
    has_sides = " " in text and not text.endswith(")") and not text.startswith("<")
    return f"({text}) {unit}" if has_sides else f"{text} {unit}"


def _interval(result: xr.Dataset, name: str, load: int) -> tuple[float, float]:
    """Return both ends of a ratio to the first case; NaN where they are not known."""
    if name not in result["quantity"].values:
        return np.nan, np.nan
    row = list(result["quantity"].values).index(name)
    low, high = (float(result[f"ratio_{bound}"].values[row, load]) for bound in ("lower", "upper"))
    return low, high


def _quantiles(values: np.ndarray, unit: Unit, *, decimals: int | None = None) -> str:
    """Return the median of some numbers, and the range of most of them, `decimals` as of `number`."""
    available = values[np.isfinite(values)] * unit.factor
    if not available.size:
        return "–"
    quantiles = np.quantile(available, _QUANTILES).tolist()
    low, middle, high = (number(quantile, decimals=decimals) for quantile in quantiles)
    return f"{middle} {unit.symbol} ({low} to {high})"
