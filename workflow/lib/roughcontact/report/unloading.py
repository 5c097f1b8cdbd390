"""What the load leaves, on the page: results on both ways of the load, and the residual surface in words."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, TITLES, UNITS
from roughcontact.arguments.quantities import quantity
from roughcontact.report.charts import COLOURS, DASHED, Chart, load_label, log_axis
from roughcontact.report.course import course_section
from roughcontact.report.template import sentence
from roughcontact.report.units import unit_of
from roughcontact.results.storage import read_dataset

_DRAWN = (
    *(AREA, "mean_gap", "contact_stiffness", "thermal_conductance", "electrical_conductance"),
    *("leak_rate_x", "leak_rate_y"),
)


def unloading_section(name: str, loading: xr.Dataset, residual: str | Path, folder: Path) -> dict[str, Any]:
    """Return charts by label, a sentence for each peak of the load, and the link from `folder`."""
    suffix = "_as_solved"  # the way back has no correction for the grid either
    as_solved = [key for key in map(str, loading) if key.endswith(suffix)]
    loading = loading.assign({key.removesuffix(suffix): loading[key] for key in as_solved})
    residual_data = read_dataset(residual)
    if "peak" not in residual_data.dims:
        residual_data = residual_data.expand_dims("peak")
    peaks = [residual_data.isel(peak=index) for index in range(residual_data.sizes["peak"])]
    unloadings = [peak.isel(load=np.isfinite(peak["mean_pressure"].values)) for peak in peaks]
    charts = {TITLES[result]: _loading_and_unloading(loading, unloadings, result) for result in _DRAWN}
    images = {label: chart.source() for label, chart in charts.items() if chart}
    sentences = [_lowered(loading, unloading) for unloading in unloadings]
    return course_section(name, residual, folder, images=images, sentences=sentences)


def _loading_and_unloading(
    loading: xr.Dataset, unloadings: Sequence[xr.Dataset], result: str
) -> Chart | None:
    """Draw one result on loading and on unloading against the load, both logarithmic, if all have it."""
    curves = [loading.sortby("mean_pressure"), *unloadings]
    if not all(result in curve for curve in curves):
        return None
    pascals, unit = unit_of(loading, "Pa"), unit_of(loading, UNITS[result])
    loads = [curve["mean_pressure"].values * pascals.factor for curve in curves]
    values = [curve[result].values * unit.factor for curve in curves]
    if not (np.concatenate(values) > 0).any():
        return None
    y_axis = log_axis(f"{TITLES[result]} ({unit.symbol})", np.concatenate(values), room=1.6)
    chart = Chart(log_axis(load_label(pascals), np.concatenate(loads)), y_axis)
    for index, (curve, x, y) in enumerate(zip(curves, loads, values, strict=True)):
        unloading = f"unloading from {quantity(float(curve['peak_pressure']), 'Pa')}" if index else "loading"
        chart.line(x, y, colour=COLOURS[index % len(COLOURS)], dash=DASHED if index else "", label=unloading)
    return chart


def _lowered(loading: xr.Dataset, unloading: xr.Dataset) -> str:
    """Return what flow has lowered by how much, and the area of both ways at the lowest load, in words."""
    lightest = unloading.isel(load=int(np.argmin(unloading["mean_pressure"].values)))
    loads, areas = (loading.sortby("mean_pressure")[name].values for name in ("mean_pressure", AREA))
    load = float(lightest["mean_pressure"])
    ways = {"on loading": np.interp(load, loads, areas, left=np.nan), "on unloading": lightest[AREA]}
    areas_by_way = {way: float(area) for way, area in ways.items() if np.isfinite(area)}
    numbers = {
        str(name): value.values.item() for name, value in unloading.variables.items() if not value.dims
    }
    return sentence("flow_has_lowered", numbers, load, areas_by_way)
