"""The tables of the report, as text: numbers against load, creep."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import COLUMNS, CREEPING, ENDS, TITLES, UNITS
from roughcontact.arguments.kinds import PERIODIC_MAP
from roughcontact.arguments.quantities import number
from roughcontact.arguments.variables import VARIABLES, Numbers, has_number
from roughcontact.report.units import lacks_interval, number_text, stated_loads, unit_of
from roughcontact.statistics.kinds import facts_of_numbers, reason_without_flow

_STRESSES = "Stress below the surface"  # title of the table of
# of bodies with layers, for each material and for each interface
_OF_LAYERS = (
    ("material_von_mises_stress", "von Mises in {}", "Pa"),
    ("interface_shear_stress", "shear below {}", "Pa"),
    ("interface_normal_stress", "normal stress below {}", "Pa"),
)

Table = dict[str, Any]


def number_tables(numbers: xr.Dataset, flags: Sequence[Sequence[str]]) -> list[Table]:
    """Return the tables of numbers against load, each quantity in the same unit everywhere.

    Columns are those of `COLUMNS` that `numbers` has. A table has a `title`, a `header` of (title, unit,
    meaning), the load first, and `rows` of `cells` and `flags`.
    """
    kind = facts_of_numbers(numbers)
    load = next(column[1:] for column in COLUMNS if column.name == kind.load)
    # the load is in all tables; what is relative to the gradient of the map is not that of a body
    left_out = {*PERIODIC_MAP.scaled_columns} - {*kind.scaled_columns} | {kind.load}
    columns_of: dict[str, list[tuple]] = {column.table: [] for column in COLUMNS if column.table}
    for table, *column in COLUMNS:
        if table and column[0] in numbers and column[0] not in left_out:
            columns_of[table].append(tuple(column))
    columns_of[_STRESSES] += _of_layers(numbers)
    if reason_without_flow(numbers):
        del columns_of["Sealing"]
    tables = []
    for title, available in columns_of.items():
        if not available:
            continue
        header, columns = zip(*(_column(numbers, *column) for column in (load, *available)), strict=True)
        cells = zip(*columns, map(", ".join, flags), strict=True)
        rows = [{"cells": row, "flags": remarks} for *row, remarks in cells]
        body = numbers.attrs.get("stresses_of") if title == _STRESSES else None
        tables.append({"title": f"{title}: {body}" if body else title, "header": header, "rows": rows})
    return tables


def material_name(numbers: xr.Dataset, index: int) -> str:
    """Return the name of a material of a body with layers, from the surface inwards.

    Examples
    --------
    >>> one_layer = xr.Dataset(coords={"interface_depth": ("interface", [1e-6])})
    >>> material_name(one_layer, 0), material_name(one_layer, 1)
    ('layer 1', 'the base')
    """
    return f"layer {index + 1}" if index < numbers.sizes["interface"] else "the base"


def _of_layers(numbers: xr.Dataset) -> list[tuple[str, str, str, int]]:
    """Return the columns (name, title, unit, place) of the materials and interfaces of a body."""
    return [
        (name, title.format(material_name(numbers, index)), unit, index)
        for name, title, unit in _OF_LAYERS
        if name in numbers
        for index in range(numbers[name].shape[-1])
    ]


def _column(
    numbers: xr.Dataset, name: str, title: str, unit: str, *index: int
) -> tuple[tuple[str, str, str], list[str]]:
    """Return the head of a column (title, unit, meaning) and its cells, those of a layer by its place."""
    unit_shown = unit_of(numbers, unit)
    head = title, unit_shown.symbol, VARIABLES[name][1]
    if index:
        return head, [number(value * unit_shown.factor) for value in numbers[name].values[:, index[0]]]
    if lacks_interval(numbers, name):
        head = (f"{title}, no ±", *head[1:])
    return head, [number_text(numbers, name, unit_shown, load) for load in range(numbers.sizes["load"])]


def creep_table(numbers: xr.Dataset, load_indices: Sequence[int]) -> Table | None:
    """Return the table of what a contact has become under constant loads; None where no body creeps."""
    if "time" not in numbers.dims:
        return None
    names = [name for name in CREEPING if name in TITLES and has_number(numbers, f"{name}_after")]
    units = {name: unit_of(numbers, UNITS[name]) for name in names}
    head = [f"{TITLES[name]} ({unit.symbol})".removesuffix(" ()") for name, unit in units.items()]
    of_times: list[tuple[str, Numbers]] = [("at once", numbers)]
    for column, time in enumerate(numbers["time"].values):
        after = {
            f"{name}{suffix}": numbers[f"{name}_after{suffix}"].values[:, column]
            for name in names
            for suffix in ENDS
            if f"{name}_after{suffix}" in numbers
        }
        of_times.append((_duration(float(time)), after))
    rows = []
    for index in load_indices:
        for time_text, values in of_times:
            flows = not np.isfinite(np.asarray(values[names[0]])[index])
            cells = ("–" if flows else number_text(values, name, units[name], index) for name in names)
            rows.append([stated_loads(numbers).texts[index], time_text, *cells])
    return {"header": [facts_of_numbers(numbers).load_symbol, "after", *head], "rows": rows}


def _duration(seconds: float) -> str:
    """Return a time in words: years, or hours and minutes from two on.

    Examples
    --------
    >>> [_duration(seconds) for seconds in (5.0, 3600.0, 3.6e6, 315576000.0)]
    ['5 s', '60 min', '1000 h', '10 years']
    """
    longest_first = (("years", 31557600.0, 1), ("h", 3600.0, 2), ("min", 60.0, 2), ("s", 1.0, 0))
    name, length = next((name, length) for name, length, least in longest_first if seconds >= least * length)
    return f"{seconds / length:.4g} {name}"
