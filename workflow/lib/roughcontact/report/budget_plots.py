"""Figures and tables of the error budget: the ± of each quantity by source, results by the shortest wave."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, COMPARED, CONDUCTANCE, ENDS, TITLES, UNITS
from roughcontact.arguments.quantities import number, percent, prefix
from roughcontact.report.charts import Axis, Chart, curves_chart, log_axis
from roughcontact.report.units import is_unbounded, largest_source, number_text, stated_loads, unit_of

_SOURCE_LABELS = {
    "solver": "solver",
    "discretisation": "grid",
    "window": "window",
    "instrument": "instrument",
    "material": "modulus and load",
    "hardness": "hardness",
    "unresolved": "unresolved waves",
    "combined": "all together",
}
_BY_CUTOFF = (*COMPARED, CONDUCTANCE)  # of the magnification curve
_BEYOND = {  # measurands beyond band and map
    "octave": "with waves one octave shorter",
    "joint": "of a joint as large as the overview",
    "next": "of the next map",
}
_CONVERGED = 0.03  # change over the shortest octave that counts as none
_MIN_SHARE = 0.01  # percent; less is not drawn


def shown_budget(numbers: xr.Dataset, loads: Sequence[int] = ()) -> dict[str, Any] | None:
    """Return figures, tables and notes of the error budget of a surface; None where it has none.

    `loads` are the indices of those whose components and intervals are listed. `images` has the figure (data
    URI) of each quantity, `header` and `rows` the table, as `components` and `intervals`; `beyond` is on the
    area beyond band and map, `magnification` on the shortest wave, `notes` on missing parts, `converged` on
    the waves.
    """
    if "source" not in numbers.dims:
        return None
    present, stated = present_sources(numbers), stated_loads(numbers)
    budget = numbers[f"{AREA}_uncertainty"].sel(source=present).values.T
    share = unit_of(numbers, "%")
    rows = []
    for index, load in enumerate(stated.texts):
        components = dict(zip(present, budget[:, index].tolist(), strict=True))
        rows.append(
            [
                load,
                number_text(numbers, AREA, share, index),
                *(_contribution(100 * component, source) for source, component in components.items()),
                _SOURCE_LABELS.get(largest_source(numbers, AREA, index), "–"),
            ]
        )
    attempts = ["window"] if "window_reason" in numbers.attrs else []  # not known leaves the interval open
    absent = [_SOURCE_LABELS[s] for s in _SOURCE_LABELS if s not in (*present, *attempts, "combined")]
    notes = [numbers.attrs.get(key) for key in ("window_flag", "window_reason")]
    notes += [f"Not in the ±: {', '.join(absent)}." if absent else "", _note_on_open_ends(numbers)]
    part = numbers.isel(load=list(loads))
    excess, intervals = wider_intervals(part)
    by_cutoff = [cutoff_chart(numbers, name) for name in _BY_CUTOFF]
    labels = [_SOURCE_LABELS[source] for source in present]
    return {
        "images": [(TITLES[name], budget_against_load(numbers, name).source()) for name in COMPARED],
        "beyond": [f"{name}: {text}" for name, text in excess.items()],
        "intervals": intervals,
        "magnification": [(chart.title, chart.source()) for chart in by_cutoff if chart],
        "converged": _note_on_convergence(numbers),
        "header": [stated.name, "contact area", *labels, "largest part"],
        "rows": rows,
        "notes": [*filter(None, notes)],
    }


def _contribution(half_width: float, source: str) -> str:
    """Return the contribution of a source; one that changes nothing is not written as ± 0."""
    if np.isnan(half_width):
        return "–"
    if half_width > 0:
        return f"± {number(half_width, digits=2)}"
    return "no pixel in doubt" if source == "solver" else "no difference"


def largest_parts(numbers: xr.Dataset) -> str:
    """Return the sources with the largest part of the ± of the contact area, by loads where they differ."""
    if "source" not in numbers.dims:
        return ""
    loads: dict[str, list[str]] = {}
    for index, load in enumerate(stated_loads(numbers).texts):
        if source := largest_source(numbers, AREA, index):
            loads.setdefault(_SOURCE_LABELS[source], []).append(load)
    if len(loads) == 1:
        return next(iter(loads))
    return "; ".join(f"{source} ({', '.join(at)})" for source, at in loads.items())


def present_sources(numbers: xr.Dataset) -> list[str]:
    """Return the sources of the ± of a surface, in the order of the report, without those not judged."""
    half_widths = numbers[f"{AREA}_uncertainty"].transpose("source", "load").values
    available = np.isfinite(half_widths).any(axis=1)[:-1]  # the last one is combined
    sources = numbers["source"].values[:-1][available]
    return [source for source in _SOURCE_LABELS if source in sources]


def budget_against_load(numbers: xr.Dataset, name: str) -> Chart:
    """Draw the relative half-widths (percent) of each source against the load, of one quantity.

    All sources together are a solid line upwards and a dashed one downwards.
    """
    present, loads = present_sources(numbers), stated_loads(numbers)
    value, budget = np.abs(numbers[name].values), numbers[f"{name}_uncertainty"]
    lower, upper = value - numbers[f"{name}_lower"].values, numbers[f"{name}_upper"].values - value
    half_widths = np.array([*budget.sel(source=present).transpose("source", "load").values, upper, lower])
    shares = 100 * np.divide(half_widths, value, out=np.full(half_widths.shape, np.nan), where=value > 0)
    shares[~(shares >= _MIN_SHARE)] = np.nan
    highest = np.max(shares, initial=100.0, where=np.isfinite(shares))
    chart = Chart(
        log_axis(loads.axis, loads.values),
        Axis("± in percent of the value", _MIN_SHARE, 2 * highest, log=True),
        title=TITLES[name],
    )
    for index, (source, share) in enumerate(zip(present, shares[:-2], strict=True)):
        chart.series(index, loads.values, share, label=_SOURCE_LABELS[source])
    chart.line(
        loads.values, shares[-2], width=2.2, colour="#000000", label=f"{_SOURCE_LABELS['combined']}, up"
    )
    chart.line(loads.values, shares[-1], width=2.2, colour="#000000", dash="5 3", label="down")
    return chart


def _note_on_open_ends(numbers: xr.Dataset) -> str:
    """Return a sentence on upper ends that are not known, empty where all are."""
    open_bounds = [TITLES[name] for name in COMPARED if is_unbounded(numbers, name)]
    if not open_bounds:
        return ""
    return (
        f"“Or more”: nothing in this map bounds it upwards ({', '.join(open_bounds)}). Either the "
        "instrument hides short waves, which carry the largest pressure, or the map has too few parts."
    )


def wider_intervals(numbers: xr.Dataset) -> tuple[dict[str, str], dict[str, Any] | None]:
    """Return the contact area beyond band and map, by what that is, and the table of all intervals."""
    if not numbers.sizes["load"] or f"{AREA}_next_lower" not in numbers:
        return {}, None
    beyond = {
        key: text
        for key, text in _BEYOND.items()
        if f"{AREA}_{key}_lower" in numbers
        and np.isfinite([numbers[f"{AREA}_{key}{end}"] for end in ENDS[1:]]).any()
    }
    text = {"": "the ±", **beyond, "map": "this map"}
    loads = stated_loads(numbers).texts
    rows: list[list[str]] = []
    unknown = xr.full_like(numbers["mean_pressure"], np.nan)  # of the joint only some quantities are known
    for name in COMPARED:
        unit, solved = unit_of(numbers, UNITS[name]), numbers.get(f"{name}_as_solved", numbers[name]).values
        prefixes = [f"{name}_{key}" if key else name for key in text]
        ends = [[numbers.get(f"{prefix}{end}", unknown).values for end in ENDS[1:]] for prefix in prefixes]
        for index, load in enumerate(loads):
            texts = [unit.ends(lower[index], upper[index]) for lower, upper in ends]
            rows.append([f"{TITLES[name]} at {load}", unit.text(float(solved[index])), *texts])
    header = ["result", "as solved", *text.values()]
    lines = {
        header[column].capitalize(): f"{TITLES[AREA]} "
        + ", ".join(f"{row[column]} at {load}" for row, load in zip(rows, loads, strict=False))
        for column in range(3, 3 + len(beyond))
    }
    return lines, {"header": header, "rows": rows}


def _note_on_convergence(numbers: xr.Dataset) -> str:
    """Return a sentence on the results that still change over the shortest octave of waves."""
    if "cutoff_wavelength" not in numbers or numbers.sizes["cutoff"] < 2:
        return ""
    changes = {}
    for name in _BY_CUTOFF:
        if f"{name}_at_cutoff" in numbers:
            fine, coarse = numbers[f"{name}_at_cutoff"].values.T[:2]
            usable = np.isfinite(fine) & (coarse > 0)
            if usable.any():  # else not judged: of full contact, or of bodies with layers
                changes[TITLES[name]] = float(np.abs(fine[usable] / coarse[usable] - 1).max())
    moving = [f"{title} (by up to {percent(by)})" for title, by in changes.items() if by > _CONVERGED]
    converged_titles = [title for title, by in changes.items() if by <= _CONVERGED]
    result = []
    if moving:
        result.append(
            f"Not converged, the shortest octave of waves still changes them: {', '.join(moving)}. Waves "
            "that this map does not show may do so again: see the interval with an octave more."
        )
    if converged_titles:
        result.append(f"Converged, within {percent(_CONVERGED)}: {', '.join(converged_titles)}.")
    return " ".join(result)


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
    curves = {stated[load]: [numbers[f"{name}_at_cutoff"].values[load] * unit_shown.factor] for load in loads}
    if not any((values > 0).any() for (values,) in curves.values()):
        return None
    x = log_axis(f"shortest wave kept ({unit})", wavelengths * factor, room=1.3)
    return curves_chart(x, wavelengths * factor, f"{text} ({unit_shown.symbol})", curves, title=text)
