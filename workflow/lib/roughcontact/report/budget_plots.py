"""Figures of the error budget: the ± of each quantity by source, results by the shortest wave."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, COMPARED, ENDS, TITLES, UNITS
from roughcontact.arguments.quantities import prefix
from roughcontact.arguments.variables import has_number
from roughcontact.report.charts import Axis, Chart, curves_chart, log_axis
from roughcontact.report.glance import asked_columns
from roughcontact.report.template import sentence
from roughcontact.report.units import is_unbounded, largest_source, stated_loads, unit_of
from roughcontact.uncertainty.combination import COMBINED, SOURCES

_SOURCE_LABELS = {
    "discretisation": "grid",
    "material": "modulus and load",
    "unresolved": "unresolved waves",
}
_BEYOND = {  # measurands beyond band and map, by the ending of their names
    "_octave": "with waves one octave shorter",
    "_joint": "of a joint as large as the overview",
    "_next": "of the next map",
}
_MIN_SHARE = 0.01  # percent; less is not drawn


def shown_budget(numbers: xr.Dataset, loads: Sequence[int] = ()) -> dict[str, Any] | None:
    """Return figures, intervals and notes of the error budget of a surface; None where it has none.

    `loads` are the indices of those whose intervals are listed. `images` has the figure (data URI) of each
    quantity, `intervals` their table, `notes` are on missing parts.
    """
    if "source" not in numbers.dims:
        return None
    attempts = ["window"] if "window_reason" in numbers.attrs else []  # not known leaves the interval open
    present = {*present_sources(numbers), *attempts}
    absent = ", ".join(_SOURCE_LABELS.get(source, source) for source in SOURCES if source not in present)
    open_ends = [TITLES[name] for name in COMPARED if is_unbounded(numbers, name)]
    notes = [numbers.attrs.get(key) for key in ("window_flag", "window_reason")]
    notes += [f"Not in the ±: {absent}." if absent else "", sentence("or_more", open_ends)]
    return {
        "images": [(TITLES[name], budget_against_load(numbers, name).source()) for name in COMPARED],
        "intervals": interval_table(numbers.isel(load=list(loads))),
        "notes": [*filter(None, notes)],
    }


def largest_parts(numbers: xr.Dataset) -> str:
    """Return the sources with the largest part of the ± of what is asked for, by loads where they differ."""
    loads: dict[str, list[str]] = {}
    for index, load in enumerate(stated_loads(numbers).texts):
        if source := largest_source(numbers, _first_asked(numbers), index):
            loads.setdefault(_SOURCE_LABELS.get(source, source), []).append(load)
    by_load = [f"{source} ({', '.join(at)})" for source, at in loads.items()]
    subject = f"for the {TITLES[_first_asked(numbers)]}: " if loads else ""
    return subject + "; ".join(loads if len(loads) == 1 else by_load)


def _first_asked(numbers: xr.Dataset) -> str:
    """Return the number whose ± is told, the first with sources that is asked for."""
    return next((name for name in asked_columns([numbers]) if name in COMPARED), AREA)


def present_sources(numbers: xr.Dataset) -> list[str]:
    """Return the sources of the ± of a surface, without those not judged."""
    of_sources = numbers[f"{AREA}_uncertainty"].drop_sel(source=COMBINED)
    return of_sources["source"].values[of_sources.notnull().any("load")].tolist()


def budget_against_load(numbers: xr.Dataset, name: str) -> Chart:
    """Draw the relative half-widths (percent) of each source against the load, of one quantity.

    All sources together are a solid line upwards and a dashed one downwards.
    """
    present, (_, loads, label, _) = present_sources(numbers), stated_loads(numbers)
    value, budget = np.abs(numbers[name].values), numbers[f"{name}_uncertainty"]
    lower, upper = value - numbers[f"{name}_lower"].values, numbers[f"{name}_upper"].values - value
    half_widths = np.array([*budget.sel(source=present).transpose("source", "load").values, upper, lower])
    shares = 100 * np.divide(half_widths, value, out=np.full(half_widths.shape, np.nan), where=value > 0)
    shares[~(shares >= _MIN_SHARE)] = np.nan
    highest = np.max(shares, initial=100.0, where=np.isfinite(shares))
    y = Axis("± in percent of the value", _MIN_SHARE, 2 * highest, log=True)
    chart = Chart(log_axis(label, loads), y, title=TITLES[name])
    *of_sources, upwards, downwards = shares
    for index, (source, share) in enumerate(zip(present, of_sources, strict=True)):
        chart.series(index, loads, share, label=_SOURCE_LABELS.get(source, source))
    style = {"width": 2.2, "colour": "#000000"}
    chart.line(loads, upwards, label="all together, up", **style)
    chart.line(loads, downwards, label="down", dash="5 3", **style)
    return chart


def beyond_in_words(numbers: xr.Dataset) -> dict[str, str]:
    """Return what is asked for beyond band and map at each load, by what that is."""
    name = _first_asked(numbers)
    lines = {}
    for key, words in _measurands_beyond(numbers).items():
        texts = map(" at ".join, zip(_ends(numbers, name, key), stated_loads(numbers).texts, strict=True))
        lines[words.capitalize()] = f"{TITLES[name]} {', '.join(texts)}"
    return lines


def interval_table(numbers: xr.Dataset) -> dict[str, Any] | None:
    """Return the table of all intervals; None where there are none beyond this map."""
    if not numbers.sizes["load"] or f"{AREA}_next_lower" not in numbers:
        return None
    measurands = {"": "the ±", **_measurands_beyond(numbers), "_map": "this map"}
    rows: list[Sequence[str]] = []
    for name in COMPARED:
        results = [f"{TITLES[name]} at {load}" for load in stated_loads(numbers).texts]
        as_solved = numbers.get(f"{name}_as_solved", numbers[name]).values.tolist()
        texts = map(unit_of(numbers, UNITS[name]).text, as_solved)
        rows += zip(results, texts, *(_ends(numbers, name, key) for key in measurands), strict=True)
    return {"header": ["result", "as solved", *measurands.values()], "rows": rows}


def _measurands_beyond(numbers: xr.Dataset) -> dict[str, str]:
    """Return what there are intervals of the area for beyond band and map, by the ending of their names."""
    return {
        key: words
        for key, words in _BEYOND.items()
        if any(has_number(numbers, f"{AREA}{key}{end}") for end in ENDS[1:])
    }


def _ends(numbers: xr.Dataset, name: str, key: str) -> list[str]:
    """Return the intervals of a result for a measurand at each load; of the joint only some are known."""
    unknown = np.full(numbers.sizes["load"], np.nan)
    bounds = (np.asarray(numbers.get(f"{name}{key}{end}", unknown)) for end in ENDS[1:])
    return [*map(unit_of(numbers, UNITS[name]).ends, *bounds)]


def cutoff_chart(numbers: xr.Dataset, name: str) -> Chart | None:
    """Draw a result against the shortest wave that is kept, one line for a few of the loads.

    None where it was not computed, or not for two waves.
    """
    if f"{name}_at_cutoff" not in numbers or numbers.sizes["cutoff"] < 2:
        return None
    wavelengths = numbers["cutoff_wavelength"].values
    factor, unit = prefix(float(wavelengths[0]), "m")
    stated = stated_loads(numbers).texts
    loads = np.unique(np.linspace(0, len(stated) - 1, min(len(stated), 4)).round().astype(int))
    text, unit_shown = TITLES[name], unit_of(numbers, UNITS[name])
    at_cutoff = numbers[f"{name}_at_cutoff"].values * unit_shown.factor
    curves = {stated[load]: [wavelengths * factor, at_cutoff[load]] for load in loads}
    if not (at_cutoff[loads] > 0).any():
        return None
    x = log_axis(f"shortest wave kept ({unit})", wavelengths * factor, room=1.3)
    return curves_chart(x, f"{text} ({unit_shown.symbol})", curves, title=text)
