"""The tables of the report, as text: numbers against load, materials."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.quantities import Unit, number, percent, with_interval
from roughcontact.report.units import interval_at, interval_of, unit_of
from roughcontact.statistics.contact_checks import rubber_like
from roughcontact.variables import VARIABLES, Numbers

_AREA = "relative_contact_area"
_LOAD = ("mean_pressure", "mean pressure p̄", "Pa")
# of bodies with layers, for each material and for each interface
_OF_LAYERS = (
    ("material_von_mises_stress", "von Mises in {}", "Pa"),
    ("interface_shear_stress", "shear below {}", "Pa"),
    ("interface_normal_stress", "normal stress below {}", "Pa"),
)
_COLUMNS = [
    line.split("\t")
    for line in Path(__file__).with_name("tables.tsv").read_text(encoding="utf-8").splitlines()
    if not line.startswith("#")
]
TITLES = {name: title for _, name, title, _ in _COLUMNS}
UNITS = {_LOAD[0]: _LOAD[2]} | {name: unit for _, name, _, unit in _COLUMNS}

# materials with the hardness over modulus of `bearing.HARDNESS_OVER_MODULUS`
_MATERIALS = (
    "annealed pure metals",
    "structural steels, aluminium alloys",
    "hardened steels, carbides",
    "ceramics, glasses, glassy polymers",
)

Table = dict[str, Any]


def number_tables(numbers: xr.Dataset, flags: Sequence[Sequence[str]]) -> list[Table]:
    """Return the tables of numbers against load, each quantity in the same unit everywhere.

    Columns are those of `tables.tsv` that `numbers` has. A table has a `title`, a `header` of (title, unit,
    meaning), mean pressure first, and `rows` of `cells` and `flags`.
    """
    tables = []
    for title in dict.fromkeys(table for table, *_ in _COLUMNS):
        available: list[tuple] = [
            tuple(column) for table, *column in _COLUMNS if table == title and column[0] in numbers
        ]
        if title == "Stress below the surface":
            available += _of_layers(numbers)
        if title == "Sealing" and is_profile(numbers):
            continue
        if not available:
            continue
        header, columns = zip(*(_column(numbers, *column) for column in (_LOAD, *available)), strict=True)
        rows = [
            {"cells": cells, "flags": ", ".join(text)} for *cells, text in zip(*columns, flags, strict=True)
        ]
        body = numbers.attrs.get("stresses_of") if title == "Stress below the surface" else None
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


def is_profile(numbers: Numbers) -> bool:
    """Return whether a surface is a profile: its window has a length along one axis alone."""
    return any(np.isnan(float(numbers.get(f"window_length_{axis}", 0.0))) for axis in "xy")


def has_number(numbers: Numbers, name: str) -> bool:
    """Return whether a number is present, at one load at least."""
    return name in numbers and bool(np.isfinite(np.asarray(numbers[name], float)).any())


def is_finite_body(numbers: Numbers) -> bool:
    """Return whether numbers are those of a body of finite size."""
    return has_number(numbers, "contact_radius")


def _column(
    numbers: xr.Dataset, name: str, title: str, unit: str, *index: int
) -> tuple[tuple[str, str, str], list[str]]:
    """Return the head of a column (title, unit, meaning) and its cells, those of a layer by its place."""
    values = numbers[name].values.astype(float)
    values = values[:, index[0]] if index else values
    selected = unit_of(numbers, unit)
    head = title, selected.symbol, VARIABLES[name][1]
    if f"{name}_lower" in numbers:
        return head, [selected.interval(*entry) for entry in zip(*interval_of(numbers, name), strict=True)]
    if name.endswith(("conductance", "_resistance")) and f"{_AREA}_lower" in numbers:
        cells = [as_the_area(numbers, name, selected, load) for load in range(values.size)]
        return (f"{title}, no ±", *head[1:]), cells
    if name == "contact_clusters":  # a whole number
        return head, [f"{value:.0f}" for value in values]
    return head, [number(value * selected.factor) for value in values]


def as_the_area(numbers: Numbers, name: str, unit: Unit, index: int) -> str:
    """Return a number of a load that has no interval with the digits that the contact area carries."""
    area, *ends = interval_at(numbers, _AREA, index)
    value = float(numbers[name][index]) * unit.factor
    return with_interval(value, *(value * end / area for end in ends)).split()[0]


def material_table(numbers: xr.Dataset, displayed: Sequence[int]) -> Table | None:
    """Return the table of yield by hardness of classes, None with a hardness and for rubber-like bodies."""
    if "first_yield_pressure_by_ratio" not in numbers or rubber_like(numbers):
        return None
    modulus, loads = float(numbers["contact_modulus"]), numbers["mean_pressure"].values
    pressure = unit_of(numbers, "Pa").text
    header = ["H/E*", "hardness H", "as of", "first yield at p̄"]
    header += [f"load, area above H at {pressure(float(loads[index]))}" for index in displayed]
    rows = []
    for ratio, text in zip(numbers["hardness_over_modulus"].values, _MATERIALS, strict=True):
        of_class = numbers.sel(hardness_over_modulus=ratio)
        first = float(of_class["first_yield_pressure_by_ratio"])
        if np.isfinite(first):
            yields = pressure(first)
        elif float(numbers["max_pressure_over_modulus"].max()) < ratio:
            yields = f"above {pressure(float(loads[-1]))}"
        else:
            yields = f"below {pressure(float(loads[0]))}"
        shares = (of_class[f"{name}_share_above_ratio"].values[displayed] for name in ("load", "area"))
        texts = [", ".join(map(percent, pair)) for pair in zip(*shares, strict=True)]
        rows.append([number(float(ratio), digits=1), pressure(ratio * modulus), text, yields, *texts])
    return {"header": header, "rows": rows}
