"""What the load leaves, on the page: contact on both ways of the load, and the residual surface in words."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from roughcontact.quantities import number, percent, quantity
from roughcontact.report.charts import COLOURS, DASHED, Axis, Chart
from roughcontact.report.units import unit_of

_AREA = "relative_contact_area"


class Unloading(NamedTuple):
    """The part of the page of one result: two charts, a sentence for each peak of the load, the file."""

    name: str
    images: list[str]
    sentences: list[str]
    link: str


def unloading_of(name: str, loaded: xr.Dataset, residual: xr.Dataset, *, link: str) -> Unloading:
    """Return what the load leaves of a result, from its statistics and its residual.nc."""
    peaks = [residual]
    if "peak" in residual.dims:
        peaks = [residual.isel(peak=index) for index in range(residual.sizes["peak"])]
    ways = [peak.isel(load=np.isfinite(peak["mean_pressure"].values)) for peak in peaks]
    factor, unit = unit_of(loaded, "m")
    images = [
        _both_ways(loaded, ways, _AREA, "contact area A/A₀ (%)", 100.0).source("lower right"),
        _both_ways(loaded, ways, "mean_gap", f"mean gap ū ({unit})", factor).source("lower left"),
    ]
    return Unloading(name, images, [_sentence(loaded, way) for way in ways], link)


def _both_ways(loaded: xr.Dataset, ways: list[xr.Dataset], result: str, label: str, factor: float) -> Chart:
    """Draw one result on loading and on unloading against the load, both logarithmic."""
    pascals, unit = unit_of(loaded, "Pa")
    curves = [loaded.sortby("mean_pressure"), *ways]
    loads = np.concatenate([curve["mean_pressure"].values for curve in curves]) * pascals
    values = np.concatenate([curve[result].values for curve in curves]) * factor
    chart = Chart(
        Axis(f"mean pressure p̄ ({unit})", loads.min() / 1.5, loads.max() * 1.5, log=True),
        Axis(label, values[values > 0].min() / 1.6, values.max() * 1.6, log=True),
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
    after = percent(float(back[_AREA]))
    return (
        f"After {peak}: flow has lowered the heights by {mean} in the mean and {largest} at most "
        f"({volume} µm³), the rms height from {heights[0]} to {heights[1]}, the rms "
        f"gradient from {gradients[0]} to {gradients[1]}. "
        f"At {load} {percent(before)} of the area touch on loading, {after} on unloading."
    )
