"""The surfaces that plastic flow leaves after the load, with the numbers of the way back: residual.nc."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from roughcontact.arguments.variables import describe
from roughcontact.statistics.contact_statistics import statistics_function
from roughcontact.statistics.unloading import unload
from roughcontact.surface.roughness.parameters import rms_curvature, rms_gradient, rms_height

_FLOW = ["plastic_depth", "mean_plastic_depth", "max_plastic_depth", "plastic_volume", "dissipated_energy"]


def evaluate_unloading(
    contact: xr.Dataset, window: xr.DataArray, settings: Mapping[str, Mapping[str, Any]], *, threads: int = 1
) -> xr.Dataset:
    """Return the surfaces that flow leaves after each load of `contact.unload`, and the way back from there.

    `height` and `plastic_depth` (y, x; m) are the residual surface and how much lower it is; the statistics
    (load), and the roughness beside that of the window, `{name}_before_load`, are those of that surface.
    """
    # without a stated peak the way back begins at the largest load
    peaks = settings["contact"]["unload"] or [float(contact["mean_pressure"].max())]
    roughness = (rms_height, rms_gradient, rms_curvature)
    initial_roughness = {f"{measure.__name__}_before_load": float(measure(window)) for measure in roughness}
    results = []
    for peak in sorted(peaks):
        unloading = unload(contact, peak_pressure=peak, threads=threads)
        count = statistics_function(
            unloading["height"],
            contact_modulus=settings["contact"]["contact_modulus"],
            bodies=settings["contact"]["bodies"],
            **settings["statistics"],
        )
        numbers = count(unloading)
        # maps, densities and profiles of the way back are left out: the file has the surface itself
        numbers = numbers[[name for name in numbers.variables if numbers[name].dims in ((), ("load",))]]
        further = {"height": unloading["height"].drop_attrs(), "peak_pressure": peak} | initial_roughness
        results.append(numbers.merge(unloading[_FLOW]).assign(further))
    if len(results) == 1:
        return describe(results[0])
    # other peaks have other loads below them
    by_load = [
        result.reset_coords("mean_pressure").assign_coords(load=result["mean_pressure"].values)
        for result in results
    ]
    together = xr.concat(by_load, "peak", join="outer", data_vars="all", coords="minimal", compat="override")
    return describe(together.drop_vars("load"))
