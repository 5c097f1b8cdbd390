"""What differs on the page: ratios of two groups, maps or cases at two or three loads."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, COMPARED, GAP, PEAK, TITLES
from roughcontact.arguments.quantities import with_interval
from roughcontact.report import glance
from roughcontact.report.glance import Cell
from roughcontact.report.template import sentence
from roughcontact.report.units import common_pressure, hardness_reached, stated_loads
from roughcontact.statistics.decisions import CLOSED
from roughcontact.statistics.kinds import load_in_words
from roughcontact.statistics.load_pairs import paired_loads
from roughcontact.uncertainty.differences import case_differences, case_pairs
from roughcontact.uncertainty.group_tables import NamedGroup

IN_LINE = 3  # comparisons, or groups
_FINEST = 1e-3  # of a ratio: half-width of which two digits are shown

Row = dict[str, Any]
Load = tuple[xr.Dataset, int]  # statistics of a surface, and the place of a load among theirs


def comparison_rows(
    comparisons: Mapping[tuple[str, str], xr.Dataset],
    groups: Sequence[NamedGroup],
    maps: Mapping[str, xr.Dataset] | None = None,
) -> list[Row]:
    """Return for each two groups `first`, `second`, the `loads` in words, and `rows` of quantities.

    The loads are those that are shown, by the areas of the one that is named first. A row has `cells` of the
    ratio at each load with its interval, or why there is none, and `outcomes`; `of_maps` tells two maps.
    """
    of_groups = {group.label: group.answer for group in groups}
    answers = {**(maps or {}), **of_groups}
    rows = []
    for (label, partner), comparison in comparisons.items():
        results = answers[label], answers[partner]
        reference, areas = (results[0][name].values for name in ("mean_pressure", AREA))
        shown = glance.shown_loads(np.interp(comparison["mean_pressure"].values, reference, areas))
        result = comparison.isel(load=shown)
        loads = result["mean_pressure"].values.tolist()
        at_loads = [[(data, nearest_load(data, load)) for data in results] for load in loads]
        texts = [load_in_words(load, results[0])[1] for load in loads]
        row: Row = {"loads": texts, "of_maps": label not in of_groups}
        rows.append(row | _ratios(label, partner, result, at_loads))
    return rows


def case_rows(cases: Mapping[str, xr.Dataset], *, surface: str = "", equal_loads: bool = False) -> list[Row]:
    """Return what one `surface` gives under every two of its cases, as of `comparison_rows`.

    The pairs of `case_pairs` are compared at their `paired_loads`, as stated where all cases ask for
    `equal_loads`, without what both share (`case_differences`); a pair that shares no load has no `loads`.

    Examples
    --------
    >>> load = {"mean_pressure": ("load", [1e6]), "contact_modulus": 1e9, GAP: ("load", [1e-6])}
    >>> soft, hard = (xr.Dataset(load | {AREA: ("load", [area])}) for area in (0.2, 0.1))
    >>> (row,) = case_rows({"soft": soft, "hard": hard})
    >>> row["second"], row["loads"], row["rows"][0]["quantity"], row["rows"][0]["cells"][0].text
    ('hard', ['1.00 MPa'], 'contact area', '0.500')
    """
    rows = []
    for pair in case_pairs(list(cases)):
        results = [cases[name] for name in pair]
        partners = np.array(paired_loads(*results, as_stated=equal_loads))
        partners = partners[:, results[0]["mean_pressure"].values[partners[0]].argsort()]
        partners = partners[:, glance.shown_loads(results[0][AREA].values[partners[0]])]
        shared = [data.isel(load=indices) for data, indices in zip(results, partners, strict=True)]
        texts = [stated_loads(data, common_pressure(results)).texts for data in results]
        indices = partners.T.tolist()
        loads = [" / ".join(dict.fromkeys([texts[0][first], texts[1][second]])) for first, second in indices]
        at_loads = [list(zip(results, of_load, strict=True)) for of_load in indices]
        ratios = _ratios(*pair, case_differences(*shared), at_loads)
        rows.append({"surface": surface, "loads": loads} | ratios)
    return rows


def nearest_load(answer: xr.Dataset, load: float) -> int:
    """Return the place of the load (Pa) of a group or map that is next to one."""
    return int(np.abs(answer["mean_pressure"].values - load).argmin())


def differences_in_words(differences: Sequence[Row]) -> str:
    """Return what comes of the contact area in up to three rows of `comparison_rows`, in one line.

    It is that of the lightest and of the heaviest load, of several rows without what would decide; empty
    for more.

    Examples
    --------
    >>> area = {"quantity": TITLES[AREA], "cells": [Cell("1.5", "1.2 to 1.8"), Cell("–")]}
    >>> row = {"first": "A", "second": "B", "loads": ["1 MPa", "2 MPa"]}
    >>> differences_in_words([row | {"rows": [area | {"outcomes": ["differ", "inconclusive: few"]}]}])
    'Contact area, B against A: differ (1.5 times as large, 1.2 to 1.8) at 1 MPa; inconclusive: few at 2 MPa.'
    """
    of_area = [row | part for row in differences for part in row["rows"] if part["quantity"] == TITLES[AREA]]
    return sentence("differ", of_area, len(differences) > 1) if len(differences) <= IN_LINE else ""


def _ratios(reference: str, label: str, result: xr.Dataset, at_loads: Sequence[Sequence[Load]]) -> Row:
    """Return the row of two results, whose numbers `at_loads` say where there is no ratio."""
    names = [name for name in COMPARED if name in result["quantity"].values]
    rows = [
        _comparison(result.sel(quantity=name), name, [_without_ratio(name, results) for results in at_loads])
        for name in names
    ]
    return {"first": reference, "second": label, "rows": rows}


def _without_ratio(name: str, results: Sequence[Load]) -> str:
    """Return why a number of two results at a load is not compared; empty where it is."""
    if name == PEAK and all(PEAK in data and hardness_reached(data)[index] for data, index in results):
        return "both the hardness"
    # finer than atoms nothing is known
    closed = name == GAP and any(float(data[GAP][index]) < CLOSED for data, index in results)
    return glance.CLOSED_IN_WORDS if closed else ""


def _comparison(part: xr.Dataset, name: str, without_ratio: Sequence[str]) -> Row:
    """Return the row of a quantity: at each load its ratio with the interval, and the outcome.

    `without_ratio` says for each load why nothing is compared there, empty where it is. Cases, which differ
    by what they state, have empty outcomes.
    """
    cells = []
    for index, reason in enumerate(without_ratio):
        ratio, low, high = (float(part[key][index]) for key in ("ratio", "ratio_lower", "ratio_upper"))
        text, *interval = with_interval(ratio, low, high, finest=_FINEST).split()
        interval_text = with_interval(np.nan, low, high, finest=_FINEST) if interval else ""
        cells.append(Cell("–", reason) if reason else Cell(text, interval_text))
    outcomes = np.where(np.array(without_ratio, str) == "", part.get("outcome", ""), "").tolist()
    return {"quantity": TITLES[name], "cells": cells, "outcomes": outcomes}
