"""What the load leaves, on the page: results on both ways of the load, and the residual surface in words."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, TITLES, UNITS
from roughcontact.arguments.quantities import quantity
from roughcontact.report.charts import COLOURS, DASHED, Chart, load_label, log_axis
from roughcontact.report.template import sentence
from roughcontact.report.units import unit_of
from roughcontact.results.storage import read_dataset

_DRAWN = (AREA, "mean_gap", "contact_stiffness", "thermal_conductance", "electrical_conductance")
_LEAK_RATES = ("leak_rate_x", "leak_rate_y")


def unloading_section(name: str, loading: xr.Dataset, residual: str | Path, folder: Path) -> dict[str, Any]:
    """Return charts by label, a sentence for each peak of the load, and the link from `folder`."""
    link = Path(os.path.relpath(residual, folder)).as_posix()
    as_solved = {
        key.removesuffix("_as_solved"): loading[key]
        for key in map(str, loading)
        if key.endswith("_as_solved")
    }
    loading = loading.assign(as_solved)  # the way back has no correction for the grid either
    residual_data = read_dataset(residual)
    if "peak" not in residual_data.dims:
        residual_data = residual_data.expand_dims("peak")
    peaks = [residual_data.isel(peak=index) for index in range(residual_data.sizes["peak"])]
    unloadings = [peak.isel(load=np.isfinite(peak["mean_pressure"].values)) for peak in peaks]
    charts = {
        TITLES[name]: _loading_and_unloading(loading, unloadings, name) for name in (*_DRAWN, *_LEAK_RATES)
    }
    images = {label: chart.source() for label, chart in charts.items() if chart}
    sentences = [_lowered(loading, unloading) for unloading in unloadings]
    return {"name": name, "images": images, "sentences": sentences, "link": link}


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
    once = {
        str(name): number.values.item() for name, number in unloading.variables.items() if not number.dims
    }
    return sentence("flow_has_lowered", once, load, areas_by_way)
