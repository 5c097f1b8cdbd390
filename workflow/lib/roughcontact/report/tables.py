"""The tables of the report, as text: numbers against load, materials."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.quantities import Unit, number, percent, with_interval
from roughcontact.report.units import unit_of
from roughcontact.statistics.contact_checks import rubber_like
from roughcontact.variables import VARIABLES, Numbers

# the tables of numbers: title, and for each column variable, short name, unit (a share is given in percent);
# columns that the statistics lack are left out
_AREA = "relative_contact_area"
_LOAD = ("mean_pressure", "mean pressure p̄", "Pa")
_GROUPS = {
    "Contact": (
        ("relative_pressure", "p̄/(E*\N{NO-BREAK SPACE}g)", "1"),
        ("relative_contact_area", "contact area A/A₀", "%"),
        ("relative_contact_area_pixels", "pixels in contact", "%"),
        ("contact_clusters", "contact patches", "1"),
        ("largest_patch_area", "largest patch", "m2"),
        ("contact_perimeter", "contact perimeter", "m along"),
    ),
    "Pressure": (
        ("mean_contact_pressure", "pressure in contact", "Pa"),
        ("pressure_std", "its standard deviation", "Pa"),
        ("max_pressure", "largest pressure", "Pa"),
        ("max_pressure_over_modulus", "largest over E*", "1"),
        ("load_share_above_hardness", "load at the hardness", "%"),
        ("area_share_above_hardness", "contact area at it", "%"),
    ),
    "Stress below the surface": (
        ("max_von_mises_stress", "largest von Mises stress", "Pa"),
        ("max_von_mises_depth", "its depth", "m along"),
    ),
    "Gap and conductance": (
        ("mean_gap", "mean gap ū", "m"),
        ("contact_stiffness", "elastic stiffness −dp̄/dū", "Pa m-1"),
        ("loading_stiffness", "stiffness of further loading", "Pa m-1"),
        ("elastic_energy", "elastic energy", "J m-2"),
        ("conductance_per_conductivity", "conductance by conductivity", "m-1"),
        ("thermal_conductance", "thermal conductance", "W m-2 K-1"),
        ("gas_conductance", "conductance of the gas", "W m-2 K-1"),
        ("joint_conductance", "conductance of the joint", "W m-2 K-1"),
        ("thermal_resistance", "thermal resistance", "m2 K W-1"),
        ("electrical_conductance", "electrical conductance", "S m-2"),
        ("electrical_resistance", "specific contact resistance", "Ohm m2"),
    ),
    "Friction": (
        ("friction_coefficient", "coefficient of friction τA/p̄", "1"),
        ("mean_flash_temperature", "mean flash temperature", "K"),
        ("max_flash_temperature", "largest flash temperature", "K"),
    ),
    "Sealing": (
        ("critical_constriction_x", "narrowest place along x", "m"),
        ("critical_constriction_y", "narrowest place along y", "m"),
        ("flow_factor_xx", "flow factor along x", "1"),
        ("flow_factor_yy", "flow factor along y", "1"),
        ("leak_rate_x", "leak rate along x", "m2 s-1"),
        ("leak_rate_y", "leak rate along y", "m2 s-1"),
    ),
    "Solution": (
        ("error_bound", "error bound of the pressure", "1"),
        ("contact_on_filled_points", "contact on filled points", "%"),
    ),
}
# of bodies with layers, for each material and for each interface
_OF_LAYERS = (
    ("material_von_mises_stress", "von Mises in {}", "Pa"),
    ("interface_shear_stress", "shear below {}", "Pa"),
    ("interface_normal_stress", "normal stress below {}", "Pa"),
)
TITLES = {name: title for columns in _GROUPS.values() for name, title, _ in columns}
UNITS = {name: unit for columns in ((_LOAD,), *_GROUPS.values()) for name, _, unit in columns}

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

    Each has a `title`, a `header` of (title, unit, meaning), mean pressure first, and `rows` of `cells` and
    `flags`.
    """
    tables = []
    for title, group in _GROUPS.items():
        available: list[tuple] = [column for column in group if column[0] in numbers]
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


def _column(
    numbers: xr.Dataset, name: str, title: str, unit: str, *index: int
) -> tuple[tuple[str, str, str], list[str]]:
    """Return the head of a column (title, unit, meaning) and its cells, those of a layer by its place."""
    values = numbers[name].values.astype(float)
    values = values[:, index[0]] if index else values
    selected = unit_of(numbers, unit)
    head = title, selected.symbol, VARIABLES[name][1]
    if f"{name}_lower" in numbers:
        ends = (numbers[f"{name}_{end}"].values for end in ("lower", "upper"))
        return head, [selected.interval(*entry) for entry in zip(values, *ends, strict=True)]
    if name.endswith(("conductance", "_resistance")) and f"{_AREA}_lower" in numbers:
        cells = [as_the_area(numbers, name, selected, load) for load in range(values.size)]
        return (f"{title}, no ±", *head[1:]), cells
    if name == "contact_clusters":  # a whole number
        return head, [f"{value:.0f}" for value in values]
    return head, [number(value * selected.factor) for value in values]


def as_the_area(numbers: Numbers, name: str, unit: Unit, index: int) -> str:
    """Return a number of a load that has no interval with the digits that the contact area carries."""
    area, *ends = (float(numbers[f"{_AREA}{end}"][index]) for end in ("", "_lower", "_upper"))
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
