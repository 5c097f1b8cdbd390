"""Figures and tables of the error budget: the ± of each quantity by source, results by the shortest wave."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.quantities import Unit, number, percent, prefix
from roughcontact.report.charts import Axis, Chart, load_label, log_axis
from roughcontact.report.tables import TITLES, UNITS
from roughcontact.report.units import interval_at, unit_of
from roughcontact.uncertainty.combination import COMBINED, uncertainty_table
from roughcontact.uncertainty.measurands import beyond_the_map

_HEADLINE = ("relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure")
_SOURCE_LABELS = {
    "solver": "solver",
    "discretisation": "grid",
    "window": "window",
    "instrument": "instrument",
    "material": "material",
    "unresolved": "unresolved waves",
    "combined": "all together",
}
# of the magnification curve
_BY_CUTOFF = (
    "relative_contact_area",
    "mean_contact_pressure",
    "max_pressure",
    "mean_gap",
    "conductance_per_conductivity",
)
_CONVERGED = 0.03  # change over the shortest octave that counts as none
_SMALLEST_SHARE = 0.01  # percent; less is not drawn
_ROUNDING = 1e-9  # of a result


def shown_budget(
    numbers: xr.Dataset, loads: Sequence[int] = (), *, extent: float = 3.0
) -> dict[str, Any] | None:
    """Return figures, tables and notes of the error budget of a surface; None where it has none.

    `loads` are the indices of those whose components and intervals are listed. `images` has the figure (data
    URI) of each quantity, `header` and `rows` the table, as `components` and `intervals`; `beyond` is on the
    area beyond band and map, `magnification` on the shortest wave, `notes` on missing parts, `converged` on
    the waves.
    """
    if "source" not in numbers.dims:
        return None
    present, pressure = present_sources(numbers), unit_of(numbers, "Pa")
    budget = numbers["relative_contact_area_uncertainty"].sel(source=present).values.T
    share = unit_of(numbers, "%")
    rows = []
    for index, load in enumerate(numbers["mean_pressure"].values):
        components = dict(zip(present, budget[:, index].tolist(), strict=True))
        rows.append(
            [
                pressure.text(float(load)),
                share.interval(*interval_at(numbers, "relative_contact_area", index)),
                *(_contribution(100 * component, source) for source, component in components.items()),
                _largest(components),
            ]
        )
    attempted = ["window"] if "window_reason" in numbers.attrs else []  # not known leaves the interval open
    absent = [_SOURCE_LABELS[s] for s in _SOURCE_LABELS if s not in (*present, *attempted, "combined")]
    notes = [numbers.attrs.get(key) for key in ("window_flag", "window_reason")]
    notes += [f"Not in the ±: {', '.join(absent)}." if absent else "", _note_on_open_ends(numbers)]
    listed = numbers.isel(load=list(loads))
    excess, intervals = _intervals(listed, extent)
    by_cutoff = [against_cutoff(numbers, name) for name in _BY_CUTOFF]
    labels = [_SOURCE_LABELS[source] for source in present]
    return {
        "images": [(TITLES[name], budget_against_load(numbers, name).source()) for name in _HEADLINE],
        "components": _component_table(listed) if len(loads) else None,
        "beyond": excess,
        "intervals": intervals,
        "magnification": [(chart.title, chart.source()) for chart in by_cutoff if chart],
        "converged": _note_on_convergence(numbers),
        "header": ["mean pressure p̄", "contact area A/A₀", *labels, "largest part"],
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


def _largest(components: Mapping[str, float]) -> str:
    """Return the name of the source with the largest contribution, a dash where all is exact."""
    available = {source: component for source, component in components.items() if component > 0}
    return _SOURCE_LABELS[max(available, key=available.__getitem__)] if available else "–"


def present_sources(numbers: xr.Dataset) -> list[str]:
    """Return the sources of the ± of a surface, in the order of the report, without those not judged."""
    half_widths = numbers["relative_contact_area_uncertainty"].transpose("source", "load").values
    available = np.isfinite(half_widths).any(axis=1)[:-1]  # the last one is combined
    judged = numbers["source"].values[:-1][available]
    return [source for source in _SOURCE_LABELS if source in judged]


def budget_against_load(numbers: xr.Dataset, name: str) -> Chart:
    """Draw the relative half-widths (percent) of each source against the load, of one quantity.

    All sources together are a solid line upwards and a dashed one downwards.
    """
    present = present_sources(numbers)
    pascals = unit_of(numbers, "Pa")
    load = numbers["mean_pressure"].values * pascals.factor
    value, budget = np.abs(numbers[name].values), numbers[f"{name}_uncertainty"]
    lower, upper = value - numbers[f"{name}_lower"].values, numbers[f"{name}_upper"].values - value
    components = budget.sel(source=present).transpose("source", "load").values
    shares = np.array([_in_percent(component, value) for component in (*components, upper, lower)])
    highest = np.max(shares, initial=100.0, where=np.isfinite(shares))
    chart = Chart(
        log_axis(load_label(pascals), load),
        Axis("± in percent of the value", _SMALLEST_SHARE, 2 * highest, log=True),
        title=TITLES[name],
    )
    for index, (source, share) in enumerate(zip(present, shares[:-2], strict=True)):
        chart.series(index, load, share, label=_SOURCE_LABELS[source])
    chart.line(load, shares[-2], width=2.2, colour="#000000", label=f"{_SOURCE_LABELS['combined']}, up")
    chart.line(load, shares[-1], width=2.2, colour="#000000", dash="5 3", label="down")
    return chart


def _note_on_open_ends(numbers: xr.Dataset) -> str:
    """Return a sentence on upper ends that are not known, empty where all are."""
    unknown = [
        TITLES[name]
        for name in _HEADLINE
        if (numbers[f"{name}_lower"].notnull() & numbers[f"{name}_upper"].isnull()).any()
    ]
    if not unknown:
        return ""
    return (
        f"“Or more”: nothing in this map bounds it upwards ({', '.join(unknown)}). Either the "
        "instrument hides short waves, which carry the largest pressure, or the map has too few parts."
    )


def _component_table(numbers: xr.Dataset) -> dict[str, Any]:
    """Return the components of every interval (`uncertainty_table`) as text: `header` and `rows`."""
    rows, table = [], uncertainty_table(numbers)
    pressure, units = unit_of(numbers, "Pa"), {name: unit_of(numbers, UNITS[name]) for name in _HEADLINE}
    for row in table[table["quantity"].isin(_HEADLINE)].to_dict("records"):
        name, combined = str(row["quantity"]), row["source"] == COMBINED
        unit = units[name]
        rows.append(
            [
                f"{TITLES[name]} at {pressure.text(float(row['mean_pressure_Pa']))}",
                _SOURCE_LABELS[str(row["source"])],
                "–" if combined else str(row["evaluation_type"]),
                _correction(float(row["correction"]), float(row["value"]), unit),
                _both_sides(row, "standard_uncertainty", unit),
                unit.ends(row["lower"], row["upper"]) if combined else _both_sides(row, "one_sided", unit),
            ]
        )
    one_sided = "one-sided, below / above; all together: interval"
    header = ["result", "source", "type", "correction", "u, below / above", one_sided]
    return {"header": header, "rows": rows}


def _correction(change: float, value: float, unit: Unit) -> str:
    """Return what was added to a result as solved; a dash for nothing, but for rounding."""
    if not abs(change) > _ROUNDING * value:
        return "–"
    return f"{'+' if change > 0 else '−'}{number(abs(change) * unit.factor, digits=2)} {unit.symbol}"


def _intervals(numbers: xr.Dataset, extent: float) -> tuple[list[str], dict[str, Any] | None]:
    """Return lines on the contact area beyond band and map, and the table of all intervals."""
    if not numbers.sizes["load"] or f"{_HEADLINE[0]}_next_lower" not in numbers:
        return [], None
    beyond = {
        key: text
        for key, text in beyond_the_map(extent).items()
        if np.isfinite([numbers[f"{_HEADLINE[0]}_{key}_{end}"] for end in ("lower", "upper")]).any()
    }
    text = {"": "the ±", **beyond, "map": "this map"}
    loads = [unit_of(numbers, "Pa").text(float(load)) for load in numbers["mean_pressure"].values]
    rows: list[list[str]] = []
    for name in _HEADLINE:
        unit, solved = unit_of(numbers, UNITS[name]), numbers.get(f"{name}_as_solved", numbers[name]).values
        lower, upper = (
            np.array([numbers["_".join(filter(None, (name, key, end)))].values for key in text])
            for end in ("lower", "upper")
        )
        for index, load in enumerate(loads):
            texts = [unit.ends(*pair) for pair in zip(lower[:, index], upper[:, index], strict=True)]
            rows.append([f"{TITLES[name]} at {load}", unit.text(float(solved[index])), *texts])
    header = ["result", "as solved", *text.values()]
    lines = [
        f"{header[column].capitalize()}: {TITLES[_HEADLINE[0]]} "
        + ", ".join(f"{row[column]} at {load}" for row, load in zip(rows, loads, strict=False))
        for column in range(3, 3 + len(beyond))
    ]
    return lines, {"header": header, "rows": rows}


def _both_sides(row: Any, name: str, unit: Unit) -> str:
    """Return an uncertainty below and above a result, two digits; a dash where both vanish."""
    sides = [float(row[f"{name}_{side}"]) * unit.factor for side in ("lower", "upper")]
    texts = [number(side, digits=2) if np.isfinite(side) else "no bound" for side in sides]
    return f"{' / '.join(texts)} {unit.symbol}" if any(sides) else "–"


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
    settled = [title for title, by in changes.items() if by <= _CONVERGED]
    result = []
    if moving:
        result.append(
            f"Not converged, the shortest octave of waves still changes them: {', '.join(moving)}. Waves "
            "that this map does not show may do so again: see the interval with an octave more."
        )
    if settled:
        result.append(f"Converged, within {percent(_CONVERGED)}: {', '.join(settled)}.")
    return " ".join(result)


def against_cutoff(numbers: xr.Dataset, name: str) -> Chart | None:
    """Draw a result against the shortest wave that is kept, one line for a few of the loads.

    None where it was not computed, or not for two waves.
    """
    if f"{name}_at_cutoff" not in numbers or numbers.sizes["cutoff"] < 2:
        return None
    wavelengths = numbers["cutoff_wavelength"].values
    factor, unit = prefix(float(wavelengths[0]), "m")
    pressures = numbers["mean_pressure"].values
    loads = np.unique(np.linspace(0, pressures.size - 1, min(pressures.size, 4)).round().astype(int))
    text, selected = TITLES[name], unit_of(numbers, UNITS[name])
    displayed = numbers[f"{name}_at_cutoff"].values[loads] * selected.factor
    displayed = np.where(np.isfinite(displayed) & (displayed > 0), displayed, np.nan)
    if np.isnan(displayed).all():
        return None
    chart = Chart(
        log_axis(f"shortest wave kept ({unit})", wavelengths * factor, room=1.3),
        log_axis(f"{text} ({selected.symbol})", displayed),
        title=text,
    )
    for index, (load, values) in enumerate(zip(loads, displayed, strict=True)):
        label = unit_of(numbers, "Pa").text(float(pressures[load]))
        chart.series(index, wavelengths * factor, values, label=label)
    return chart


def _in_percent(half_width: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Return half-widths in percent of the value, NaN where there is nothing to draw."""
    share = 100 * np.divide(half_width, value, out=np.full(value.shape, np.nan), where=value > 0)
    return np.where(share >= _SMALLEST_SHARE, share, np.nan)
