"""After the load: the surface that plastic flow has left, and the contact while the load is taken off.

Both are in residual.nc, with the numbers of the way back.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_periodic_solution
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.si import as_si
from roughcontact.arguments.variables import describe
from roughcontact.contact.dataset import recorded_elasticity, recorded_problem
from roughcontact.contact.elasticity.halfspace import HalfSpace
from roughcontact.contact.loads import check_loads
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import SettingsError
from roughcontact.statistics.contact_geometry import point_area, relative_contact_area
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.surface.roughness.parameters import rms_curvature, rms_gradient, rms_height

_FLOW = ["plastic_depth", "mean_plastic_depth", "max_plastic_depth", "plastic_volume", "dissipated_energy"]


@as_si
def unload(
    contact: xr.Dataset,
    *,
    mean_pressure: float | str | Sequence[float | str] | None = None,
    peak_pressure: float | str | None = None,
    tolerance: float = 1e-6,
    threads: int = 1,
) -> xr.Dataset:
    """Take the largest load of a contact with a hardness off, and return the contact at lower loads.

    Where the pressure reached the hardness, the heights are lowered by the overlap that the elastic bodies
    would have [1]_. The elastic contact of that residual surface returns the pressure of the largest load,
    and gives every lower one. Flow is confined to the pixels at the hardness: no material piles up beside
    them, it does not harden, and the hardness is the same whatever the shape of a summit.

    Parameters
    ----------
    contact : Dataset
        of `solve_contact` with a `hardness`, with its maps; its largest load counts.
    mean_pressure : float or sequence of float, Pa, optional
        loads on the way back, none above the largest one; by default all loads of `contact`, falling.
    peak_pressure : float, Pa, optional
        the largest load, which is taken off; by default the largest of `contact`.
    tolerance : float
        of the solver; at 1e-6 no pressure exceeds the hardness by more than a hundred thousandth.
    threads : int
        of the solver.

    Returns
    -------
    Dataset
        as of `solve_contact`, so that `contact_statistics` counts in it, with `relative_contact_area`,
        `residual_height` and `plastic_depth` (y, x) m, the heights that are left and by how much they were
        lowered, their `mean_plastic_depth` and `max_plastic_depth` (m), `plastic_volume` (m3, of maps), and
        `dissipated_energy` (J m-2): the hardness times the mean depth, the area between the curves of mean
        pressure over approach of one cycle. `height` is the residual height: a map to solve again.

    Raises
    ------
    SettingsError
        for a contact without hardness or maps, or a load above its largest one.

    References
    ----------
    .. [1] A. Almqvist, F. Sahlin, R. Larsson, S. Glavatskih (2007), On the dry elasto-plastic contact of
       nominally flat surfaces, Tribol. Int. 40, 574.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> loaded = solve_contact(height, contact_modulus=1.0, mean_pressure=[0.05, 0.1], hardness=0.5)
    >>> unloaded = unload(loaded, mean_pressure=[0.1, 0.05])
    >>> areas = [float((dataset["pressure"] > 0).mean()) for dataset in (loaded, unloaded)]
    >>> print(areas[1] >= areas[0], float(unloaded["pressure"].max() / 0.5) <= 1 + 1e-5)
    True True
    """
    check_periodic_solution(contact)
    if "hardness" not in contact:
        raise SettingsError(
            "the contact has no hardness: an elastic one is unloaded the way it was loaded; solve it with "
            "hardness=... to see what flow leaves"
        )
    hardness = float(contact["hardness"])
    pressures = sorted(contact["mean_pressure"].values.tolist(), reverse=True)
    top = pressures[0] if peak_pressure is None else check_loads("peak_pressure", peak_pressure, unit="Pa")[0]
    # the top first: unloading starts from where loading ended
    loads = [top, *(load for load in pressures if load < top)]
    if mean_pressure is not None:
        loads = check_loads("mean_pressure", mean_pressure, unit="Pa")
    if max(loads) > top:
        raise SettingsError(
            f"mean_pressure = {max(loads):g} Pa is more than the largest load, {top:g} Pa: "
            "the surface would flow further; solve_contact loads it",
            keys=("mean_pressure",),
        )
    problem = recorded_problem(contact) | {"tolerance": tolerance, "threads": threads}
    height = contact["height"]
    # once more to this tolerance: what the overlap has of an error, the pressures of all lower loads have
    loading = solve_contact(height, mean_pressure=top, hardness=hardness, **problem)
    depth = plastic_depth(loading.isel(load=0).drop_vars("mean_pressure"), threads=threads)
    residual = (height - depth).assign_attrs(height.attrs)
    unloading = solve_contact(residual, mean_pressure=loads, **problem)
    mean_depth = float(depth.mean())
    areas = [relative_contact_area(touching) for touching in unloading["contact"].values > 0]
    return describe(
        unloading.assign(
            relative_contact_area=("load", areas),
            residual_height=residual,
            plastic_depth=depth,
            mean_plastic_depth=mean_depth,
            max_plastic_depth=float(depth.max()),
            plastic_volume=float(depth.sum()) * point_area(height.shape, spacing(height)),
            dissipated_energy=hardness * mean_depth,
        )
    )


def plastic_depth(loading: xr.Dataset, *, threads: int = 1) -> xr.DataArray:
    """Return by how much (m) flow has lowered the heights at one load: the overlap of the elastic bodies.

    The solver gives points at the hardness a gap of zero; the overlap there is that of G p - h + approach,
    whose constant follows from all other points, where the gap is known.
    """
    # in double: the depth is a difference of heights and displacement
    height, pressure = loading["height"], np.require(loading["pressure"].values, dtype=float)
    (ny, nx), (dy, dx) = height.shape, spacing(height)
    elasticity = recorded_elasticity(loading)
    body = HalfSpace((ny, nx), (ny * dy, nx * dx), elasticity, threads=threads)
    separation = body.displacement(pressure) / elasticity.modulus - height.values
    at_hardness = pressure >= float(loading["hardness"])
    # the offset from points that have not yielded, where the gap is known
    gap = separation + np.mean((loading["gap"].values - separation)[~at_hardness])
    depth = np.where(at_hardness, np.maximum(-gap, 0.0), 0.0)
    return xr.DataArray(depth, coords=height.coords, dims=height.dims, name="plastic_depth")


def evaluate_unloading(
    contact: xr.Dataset, window: xr.DataArray, settings: Mapping[str, Mapping[str, Any]], *, threads: int = 1
) -> xr.Dataset:
    """Return the surfaces that flow leaves after each load of `contact.unload`, and the way back from there.

    `height` and `plastic_depth` (y, x; m) are the residual surface and how much lower it is; the statistics
    (load), and the roughness beside that of the window, `{name}_before_load`, are those of that surface.
    """
    # without a stated peak the way back begins at the largest load
    peaks = settings["contact"]["unload"] or [float(contact["mean_pressure"].max())]
    bodies = settings["contact"]["bodies"]
    roughness = (rms_height, rms_gradient, rms_curvature)
    initial_roughness = {f"{measure.__name__}_before_load": float(measure(window)) for measure in roughness}
    results = []
    for peak in sorted(peaks):
        unloading = unload(contact, peak_pressure=peak, threads=threads)
        numbers = contact_statistics(unloading, bodies=bodies, **settings["statistics"])
        # maps, densities and profiles of the way back are left out: the file has the surface itself
        numbers = numbers.drop_dims([dim for dim in numbers.sizes if dim != "load"])
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
