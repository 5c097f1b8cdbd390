"""The groups of maps on the page: their answers at two or three loads, pictures, and what differs."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.quantities import Unit, counted_noun, percent, with_interval
from roughcontact.report.glance import HEADINGS as OF_MAPS
from roughcontact.report.glance import (
    Cell,
    glance_units,
    interval_cell,
    is_limited,
    largest_cell,
    shown_loads,
)
from roughcontact.report.load_plots import group_areas
from roughcontact.report.tables import TITLES
from roughcontact.report.units import unit_of
from roughcontact.statistics.outcome import VERDICTS
from roughcontact.uncertainty.group_tables import NamedGroup
from roughcontact.uncertainty.groups import is_range

# of the table at a glance, but for what a map has not
HEADINGS = (*OF_MAPS[:2], "of the next map", "scatter s", *OF_MAPS[2:4], *OF_MAPS[6:])
_AREA = "relative_contact_area"
_PEAK = "max_pressure"
_FURTHER_QUANTITIES = ("mean_contact_pressure", "mean_gap", _PEAK, "conductance_per_conductivity")
_COMPARED = (_AREA, "mean_contact_pressure", "mean_gap", _PEAK)
_FINEST = 1e-3  # of a ratio: half-width of which two digits are shown

Row = dict[str, Any]


def group_rows(
    groups: Sequence[NamedGroup], verdicts: Mapping[tuple[str, str | None], str] | None = None
) -> list[Row]:
    """Return for each group its `name`, what it is `of`, its `remarks`, and `rows` of cells by `HEADINGS`.

    `verdicts` are those of the maps, by name and case, in words.
    """
    if not groups:
        return []
    units = glance_units([group.answer for group in groups])
    return [
        {
            "name": group.label,
            "of": _composition(group) + _verdicts(group, verdicts or {}),
            "remarks": json.loads(group.answer.attrs["remarks"]),
            "rows": [
                _cells(group.answer, of_group, index) for index in shown_loads(group.answer[_AREA].values)
            ],
        }
        for group, of_group in zip(groups, units, strict=True)
    ]


def group_pictures(groups: Sequence[NamedGroup]) -> list[tuple[str, str]]:
    """Return (image, caption) of the maps of the groups at two or three loads, and of area against load."""
    pressure = min((unit_of(group.answer, "Pa") for group in groups), key=lambda unit: unit.factor)
    displayed = [
        (group.label, group.answer.isel(load=shown_loads(group.answer[_AREA].values))) for group in groups
    ]
    caption = (
        "Open marks: each map. Filled: the group, with the 95 % interval of its mean (of a pair of faces: of "
        "the next placement; of two maps: their range). Groups stand beside one another at each load."
    )
    values = group_areas(displayed, pressure, curves=False), caption
    if all(group.answer.sizes["load"] == 1 for group in groups):  # no line, no band
        return [values]
    curves = group_areas([(group.label, group.answer) for group in groups], pressure, curves=True)
    return [values, (curves, "Lines: the groups. Bands: the same intervals.")]


def comparison_rows(
    compared: Mapping[tuple[str, str], xr.Dataset],
    groups: Sequence[NamedGroup],
    maps: Mapping[str, xr.Dataset] | None = None,
) -> list[Row]:
    """Return for each two groups `first`, `second`, the `loads` in words, and `rows` of quantities.

    A row has `cells` of the ratio at each load with its interval, and `outcomes`; `of_maps` tells two maps.
    """
    of_groups = {group.label: group.answer for group in groups}
    answers = {**(maps or {}), **of_groups}
    rows = []
    for (first, second), result in compared.items():
        pressure = unit_of(answers[first], "Pa")
        loads, areas = (answers[first][name].values for name in ("mean_pressure", _AREA))
        area = np.interp(result["mean_pressure"].values, loads, areas)
        displayed = result.isel(load=shown_loads(area))
        loads = displayed["mean_pressure"].values.tolist()
        limited = [all(_limited_at(answers[name], load) for name in (first, second)) for load in loads]
        rows.append(
            {
                "first": first,
                "second": second,
                "loads": [pressure.text(load) for load in loads],
                "rows": [
                    _comparison(displayed.sel(quantity=name), name, limited)
                    for name in _COMPARED
                    if name in result["quantity"].values
                ],
                "of_maps": first not in of_groups,
            }
        )
    return rows


def _limited_at(answer: xr.Dataset, load: float) -> bool:
    """Return whether the largest pressure of a group or map is the hardness, at the load (Pa) next to one."""
    index = int(np.abs(answer["mean_pressure"].values - load).argmin())
    return _PEAK in answer and is_limited(answer, index)


def _composition(group: NamedGroup) -> str:
    """Return what a group is made of, in words."""
    maps = group.answer.sizes["map"]
    if group.placements:
        return counted_noun(maps, "placement") + " of two faces"
    components = len(set(group.answer["part"].values))
    return counted_noun(maps, "map") + (
        f" of {counted_noun(components, 'part')}" if components < maps else ""
    )


def _verdicts(group: NamedGroup, verdicts: Mapping[tuple[str, str | None], str]) -> str:
    """Return how many maps of a group have each verdict."""
    of_maps = [verdicts.get((str(name), group.case)) for name in group.answer["map"].values]
    counts = {label: of_maps.count(label) for label in VERDICTS.values()}
    text = ", ".join(f"{label} {count}" for label, count in counts.items() if count)
    return f" ({text})" if text else ""


def _cells(answer: xr.Dataset, units: Mapping[str, Unit], index: int) -> list[Cell]:
    """Return the cells of a group at a load."""
    return [
        Cell(units["mean_pressure"].text(float(answer["mean_pressure"][index]))),
        _mean(answer, _AREA, units, index),
        Cell(_range(answer, _AREA, "next_", units, index)),
        _scatter(answer.isel(load=index)),
        *(_mean(answer, name, units, index) if name in answer else Cell("–") for name in _FURTHER_QUANTITIES),
    ]


def _mean(answer: xr.Dataset, name: str, units: Mapping[str, Unit], index: int) -> Cell:
    """Return the mean of a group with its ±; with the range of its maps where these are two."""
    if not np.isfinite(float(answer[name][index])):
        return Cell("–")
    if name == _PEAK and is_limited(answer, index):
        return largest_cell(answer, units, index)
    if is_range(answer):
        displayed = units[name].text(float(answer[name][index]))
        return Cell(displayed, f"range {_range(answer, name, '', units, index)}")
    return interval_cell(answer, name, units, index)


def _range(answer: xr.Dataset, name: str, prefix: str, units: Mapping[str, Unit], index: int) -> str:
    """Return an interval by its ends."""
    return units[name].ends(*(float(answer[f"{name}_{prefix}{end}"][index]) for end in ("lower", "upper")))


def _scatter(load: xr.Dataset) -> Cell:
    """Return the standard deviations of the area between parts and between maps."""
    available = {
        text: float(load[f"{_AREA}_{key}"])
        for key, text in (("between", "parts"), ("within", "maps"))
        if np.isfinite(load[f"{_AREA}_{key}"])
    }
    if len(available) == 1:
        return Cell(percent(*available.values()))
    return Cell(", ".join(f"{text} {percent(value)}" for text, value in available.items()) or "–")


def _comparison(displayed: xr.Dataset, name: str, limited: Sequence[bool]) -> Row:
    """Return the row of a quantity: its ratio at each load with the interval, and the outcomes.

    `limited` says at which loads it is the hardness of both, so that nothing is compared.
    """
    cells, outcomes = [], []
    for index, outcome in enumerate(displayed["outcome"].values.tolist()):
        if name == _PEAK and limited[index]:
            cells.append(Cell("–"))
            outcomes.append("both the hardness")
            continue
        ratio, low, high = (float(displayed[key][index]) for key in ("ratio", "ratio_lower", "ratio_upper"))
        text, *_ = with_interval(ratio, low, high, finest=_FINEST).split()
        known = np.isfinite([low, high]).any()
        cells.append(Cell(text, with_interval(np.nan, low, high, finest=_FINEST) if known else ""))
        outcomes.append(str(outcome))
    equal = len(set(outcomes)) == 1
    return {"quantity": TITLES[name], "cells": cells, "outcomes": outcomes[:1] if equal else outcomes}
