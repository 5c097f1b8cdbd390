"""The cases of a study side by side: of one surface load by load, of many by medians and spread."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.quantities import Unit, number, quantity, with_interval
from roughcontact.report.units import middle_of, unit_of
from roughcontact.uncertainty.differences import case_differences, shared_loads

# quantity, its name, its unit (a share is given in percent)
_COMPARED = (
    ("relative_contact_area", "contact area A/A₀", "%"),
    ("mean_contact_pressure", "pressure in contact", "Pa"),
    ("max_pressure", "largest pressure", "Pa"),
    ("mean_gap", "mean gap ū", "m"),
)
_PERCENT = Unit(1.0, "%")  # of numbers in percent
_SPREAD = (0.1, 0.9)  # quantiles over the surfaces

_DUST = 1e-9  # percent: a difference that small is rounding

Group = dict[str, Any]
Ways = tuple[float, float]  # half-widths of an interval, down and up


def case_table(cases: Mapping[str, xr.Dataset], *, alike: bool = False) -> dict[str, Any] | None:
    """Return the numbers of one surface under several cases, with their differences from the first.

    `cases` maps names to statistics of the surface, loads rising. Loads are compared in order where all cases
    ask for the same ones (`alike`), and are as many; else those that all share (`shared_loads`). The ± of a
    difference leaves out what both cases share (`case_differences`).

    Returns
    -------
    dict or None
        `cases`, their names; `differences`, those of the columns beside them; `groups`, for each quantity its
        `title` and `rows` of cells: mean pressure (in E* g, or that of each case, where the cases differ in
        it), the value under each, the difference of each other one in percent; `apart`, a sentence instead,
        where they share no load. None for a single case.

    Examples
    --------
    >>> one = xr.Dataset({name: ("load", [0.1]) for name, _, _ in _COMPARED}).assign(
    ...     mean_pressure=("load", [1e6])
    ... )
    >>> table = case_table({"soft": one, "hard": one * 2}, alike=True)
    >>> table["groups"][0]["rows"]
    [['1.00 MPa / 2.00 MPa', '10.0 %', '20.0 %', '100 %']]
    >>> case_table({"soft": one, "hard": one * 2})["apart"][:55]
    'The cases have no load in common (soft: 1.00 MPa; hard:'
    """
    if len(cases) < 2:
        return None
    solved, cases = cases, _at_shared_loads(cases, alike=alike)
    first = next(iter(cases.values()))
    if not (loads := first.sizes["load"]):
        return _table(list(cases), []) | {"apart": _apart(solved)}
    names_of_loads = [_load([[data] for data in cases.values()], load) for load in range(loads)]
    changes = [case_differences(first, other) for other in list(cases.values())[1:]]
    groups = []
    for name, title, unit in _COMPARED:
        rows = []
        for load in range(loads):
            values = [float(data[name][load]) for data in cases.values()]
            ways = [_ways(data, name, load) for data in cases.values()]
            rows.append(
                [
                    names_of_loads[load],
                    *(_shown(*pair, unit_of(first, unit)) for pair in zip(values, ways, strict=True)),
                    *(
                        _difference(values[0], value, _ends(change, name, load))
                        for value, change in zip(values[1:], changes, strict=True)
                    ),
                ]
            )
        groups.append({"title": title, "rows": rows})
    return _table(list(cases), groups)


def case_medians(
    surfaces: Sequence[Mapping[str, xr.Dataset]], *, alike: bool = False
) -> dict[str, Any] | None:
    """Return medians over many surfaces under each case, and those of the differences from the first case.

    Each of `surfaces` maps names of cases to statistics, loads rising; those that lack a case are left out.
    The result is as of `case_table`, each cell with the 10th and 90th percentile, a difference also with the
    number of surfaces for which it exceeds its ±, where that is known; `surfaces` is the number of surfaces
    compared. None where there is a single case, or no surface under all of them.
    """
    names = list(dict.fromkeys(name for surface in surfaces for name in surface))
    complete = [surface for surface in surfaces if len(surface) == len(names)]
    if len(names) < 2 or not complete:
        return None
    solved, complete = complete, [_at_shared_loads(surface, alike=alike) for surface in complete]
    complete = [surface for surface in complete if surface[names[0]].sizes["load"]]
    if not complete:
        return _table(names, []) | {"apart": _apart(solved[0])}
    loads = min(data.sizes["load"] for surface in complete for data in surface.values())
    by_case = [[surface[name] for surface in complete] for name in names]
    names_of_loads = [_load(by_case, load) for load in range(loads)]
    middle = middle_of(by_case[0])
    changed = {
        name: [case_differences(surface[names[0]], surface[name]) for surface in complete]
        for name in names[1:]
    }
    groups = []
    for quantity_name, title, unit in _COMPARED:
        values = np.array(
            [[surface[name][quantity_name].values[:loads] for name in names] for surface in complete], float
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            changes = 100 * (values[:, 1:] / values[:, :1] - 1)
        rows = [
            [
                names_of_loads[load],
                *(_quantiles(column, unit_of(middle, unit)) for column in values[:, :, load].T),
                *(
                    _quantiles(np.where(np.abs(column) < _DUST, 0.0, column), _PERCENT)
                    + _clear(changed[name], quantity_name, load)
                    for name, column in zip(names[1:], changes[:, :, load].T, strict=True)
                ),
            ]
            for load in range(loads)
        ]
        groups.append({"title": title, "rows": rows})
    return _table(names, groups) | {"surfaces": len(complete)}


def _table(names: list[str], groups: list[Group]) -> dict[str, Any]:
    """Return a table of cases: their names, those of the differences from the first, and what it holds."""
    return {
        "cases": names,
        "differences": [f"{name} against {names[0]}" for name in names[1:]],
        "groups": groups,
    }


def _at_shared_loads(cases: Mapping[str, xr.Dataset], *, alike: bool) -> dict[str, xr.Dataset]:
    """Return the cases at the loads that are compared."""
    if alike and len({data.sizes["load"] for data in cases.values()}) == 1:
        return dict(cases)
    places = shared_loads(list(cases.values()))
    return {name: data.isel(load=own) for (name, data), own in zip(cases.items(), places, strict=True)}


def _apart(cases: Mapping[str, xr.Dataset]) -> str:
    """Return what is said of cases that share no load."""
    spans = []
    for name, data in cases.items():
        ends = (quantity(float(data["mean_pressure"][end]), "Pa") for end in (0, -1))
        spans.append(f"{name}: {' to '.join(dict.fromkeys(ends))}")
    return (
        f"The cases have no load in common ({'; '.join(spans)}), so that their numbers cannot be compared: "
        "give them the same contact.mean_pressure, relative_pressure or target."
    )


def _load(cases: Sequence[Sequence[xr.Dataset]], load: int) -> str:
    """Return the load that all surfaces share under all cases, else the median pressure of each case."""
    pressures = np.array([[float(data["mean_pressure"][load]) for data in case] for case in cases])
    if np.allclose(pressures, pressures[0, 0], rtol=1e-6):
        return unit_of(cases[0][0], "Pa").text(float(pressures[0, 0]))
    if all("relative_pressure" in data for case in cases for data in case):
        relative = np.array([[float(data["relative_pressure"][load]) for data in case] for case in cases])
        if np.allclose(relative, relative[0, 0], rtol=1e-6):
            return f"{number(float(relative[0, 0]))} E* g"
    show = unit_of(cases[0][0], "Pa").text
    return " / ".join(show(float(median)) for median in np.median(pressures, axis=1))


def _ways(data: xr.Dataset, name: str, load: int) -> Ways:
    """Return the two half-widths of the interval of a number, down and up; NaN where there is none."""
    if f"{name}_lower" in data:
        value = float(data[name][load])
        return value - float(data[f"{name}_lower"][load]), float(data[f"{name}_upper"][load]) - value
    if f"{name}_uncertainty" not in data:
        return np.nan, np.nan
    half = float(data[f"{name}_uncertainty"].sel(source="combined")[load])
    return half, half


def _shown(value: float, ways: Ways, unit: Unit) -> str:
    """Return a number with its interval."""
    down, up = ways
    return _in_brackets(value * unit.factor, down * unit.factor, up * unit.factor, unit.shown)


def _in_brackets(value: float, down: float, up: float, unit: str) -> str:
    """Return a number with its interval, in brackets where there is one, before its unit."""
    text = with_interval(value, value - down, value + up)
    return f"({text}) {unit}" if " " in text else f"{text} {unit}"


def _difference(first: float, other: float, ends: tuple[float, float]) -> str:
    """Return the difference from the first case in percent, with its interval."""
    if not first > 0:
        return "–"
    change, *sides = (
        0.0 if abs(percent) < _DUST else percent
        for percent in (100 * (ratio - 1) for ratio in (other / first, *ends))
    )
    return _in_brackets(change, change - sides[0], sides[1] - change, "%")


def _ends(found: xr.Dataset, name: str, load: int) -> tuple[float, float]:
    """Return both ends of a ratio to the first case; NaN where they are not known."""
    if name not in found["quantity"].values:
        return np.nan, np.nan
    row = list(found["quantity"].values).index(name)
    low, high = (float(found[f"ratio_{end}"].values[row, load]) for end in ("lower", "upper"))
    return low, high


def _clear(found: Sequence[xr.Dataset], name: str, load: int) -> str:
    """Return the number of surfaces whose difference between two cases is larger than its interval."""
    ends = np.array([_ends(one, name, load) for one in found])
    known = np.isfinite(ends).all(axis=1)
    clear = known & ((ends[:, 0] > 1) | (ends[:, 1] < 1))
    return f"; beyond ± {clear.sum()} of {known.sum()}" if known.any() else ""


def _quantiles(values: np.ndarray, unit: Unit) -> str:
    """Return the median of some numbers, and the range of most of them."""
    known = values[np.isfinite(values)] * unit.factor
    if not known.size:
        return "–"
    low, middle, high = (number(float(end)) for end in np.quantile(known, [_SPREAD[0], 0.5, _SPREAD[1]]))
    return f"{middle} {unit.shown} ({low} to {high})"
