"""What the load leaves, on the page: results on both ways of the load, and the residual surface in words."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.quantities import number, percent, quantity
from roughcontact.report.charts import COLOURS, DASHED, Chart, log_axis
from roughcontact.report.units import unit_of
from roughcontact.results.storage import read_dataset

_AREA = "relative_contact_area"
_LABELS = {  # of results, each with its SI unit
    _AREA: ("contact area A/A₀", "%"),
    "mean_gap": ("mean gap ū", "m"),
    "contact_stiffness": ("stiffness −dp̄/dū", "Pa m-1"),
    "thermal_conductance": ("thermal conductance", "W m-2 K-1"),
    "electrical_conductance": ("electrical conductance", "S m-2"),
    "leak_rate_x": ("leak rate along x", "m2 s-1"),
    "leak_rate_y": ("leak rate along y", "m2 s-1"),
}


def unloading_of(name: str, loaded: xr.Dataset, residual: str | Path, folder: Path) -> dict[str, Any]:
    """Return charts by label, a sentence for each peak of the load, and the link from `folder`."""
    link = Path(os.path.relpath(residual, folder)).as_posix()
    left = read_dataset(residual)
    peaks = [left.isel(peak=index) for index in range(left.sizes["peak"])] if "peak" in left.dims else [left]
    ways = [peak.isel(load=np.isfinite(peak["mean_pressure"].values)) for peak in peaks]
    charts = {label: _both_ways(loaded, ways, result) for result, (label, _) in _LABELS.items()}
    images = {label: chart.source() for label, chart in charts.items() if chart}
    sentences = [_sentence(loaded, way) for way in ways]
    return {"name": name, "images": images, "sentences": sentences, "link": link}


def _both_ways(loaded: xr.Dataset, ways: Sequence[xr.Dataset], result: str) -> Chart | None:
    """Draw one result on loading and on unloading against the load, both logarithmic, if all have it."""
    curves = [loaded.sortby("mean_pressure"), *ways]
    if not all(result in curve for curve in curves):
        return None
    (pascals, pressure), (factor, unit) = (unit_of(loaded, si) for si in ("Pa", _LABELS[result][1]))
    loads = np.concatenate([curve["mean_pressure"].values for curve in curves]) * pascals
    values = np.concatenate([curve[result].values for curve in curves]) * factor
    if not (values > 0).any():
        return None
    chart = Chart(
        log_axis(f"mean pressure p̄ ({pressure})", loads),
        log_axis(f"{_LABELS[result][0]} ({unit})", values, room=1.6),
    )
    for index, curve in enumerate(curves):
        way = f"unloading from {quantity(float(curve['peak_pressure']), 'Pa')}" if index else "loading"
        x, y = curve["mean_pressure"].values * pascals, curve[result].values * factor
        chart.line(x, y, colour=COLOURS[index % len(COLOURS)], dash=DASHED if index else "", label=way)
    return chart


def _sentence(loaded: xr.Dataset, way: xr.Dataset) -> str:
    """Return what was lowered by how much, and the area of both ways at the lowest load."""
    mean, largest = (quantity(float(way[f"{which}_plastic_depth"]), "m") for which in ("mean", "max"))
    volume = number(float(way["plastic_volume"]) * 1e18)
    heights = [quantity(float(way[f"rms_height{time}"]), "m") for time in ("_before_load", "")]
    gradients = [number(float(way[f"rms_gradient{time}"])) for time in ("_before_load", "")]
    back = way.isel(load=int(np.argmin(way["mean_pressure"].values)))
    loads, areas = (loaded.sortby("mean_pressure")[name].values for name in ("mean_pressure", _AREA))
    before = float(np.interp(float(back["mean_pressure"]), loads, areas))
    peak, load = (quantity(float(value), "Pa") for value in (way["peak_pressure"], back["mean_pressure"]))
    return (
        f"After {peak}: flow has lowered the heights by {mean} in the mean and {largest} at most "
        f"({volume} µm³), the rms height from {heights[0]} to {heights[1]}, the rms gradient from "
        f"{gradients[0]} to {gradients[1]}. At {load} {percent(before)} of the area touch on loading, "
        f"{percent(float(back[_AREA]))} on unloading."
    )
