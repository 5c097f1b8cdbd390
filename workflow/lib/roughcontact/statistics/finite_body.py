"""Numbers of a body of finite size: its contact, and Hertz's of the smooth body beside it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import form_radii, recover_roughness, spacing
from roughcontact.contact.dataset import carrying, recorded_elasticity
from roughcontact.contact.elasticity.closed_forms import hertz_ellipse
from roughcontact.contact.free_boundary import FreeBody
from roughcontact.statistics.theory import greenwood_tripp
from roughcontact.surface.roughness.summits import summit_statistics

# what no body of finite size has, and none with layers
_MEANINGLESS = (
    *(f"{passage}_{axis}" for passage in ("gap_percolates", "critical_constriction") for axis in "xy"),
    *("loading_stiffness", "thermal_conductance", "electrical_conductance", "conductance_error_bound"),
)
_STIFFNESS_TOLERANCE = 1e-3  # of a punch; the error of its stiffness is about the square of that


def finite_body_columns(columns: Mapping[str, Any], contact: xr.Dataset, load: int) -> dict[str, Any]:
    """Return the numbers of one load of a finite body that differ from those of a periodic map, and its size.

    The stiffness by area is that of a flat punch on the points in contact (Barber 2003, Proc. R. Soc. A 459,
    53), the energy half the mean of pressure times displacement. `loaded_radius` is 3F/(4 E* u) with the
    displacement u in the middle, NaN with layers.
    """
    from scipy.ndimage import map_coordinates  # imported late, as few maps are bodies

    height, elasticity, radii = contact["height"], recorded_elasticity(contact), form_radii(contact["height"])
    steps, force, approach = spacing(height), float(contact["force"][load]), float(contact["approach"][load])
    pressure, map_area = contact["pressure"].isel(load=load).values, height.size * steps[0] * steps[1]
    punch = np.where(pressure > 0, 0.0, -max(height.shape) * max(steps))
    body = FreeBody(punch, steps, elasticity)
    punch_approach = body.solve(force, tolerance=_STIFFNESS_TOLERANCE).approach
    displacement = height.values - approach + contact["gap"].isel(load=load).values
    at_hardness = carrying(pressure, float(contact.get("hardness", np.inf)))
    if at_hardness.any():  # the depth of flow is no elastic displacement
        displacement[at_hardness] = body.elastic_displacement(pressure)[at_hardness]
    in_the_middle = map_coordinates(displacement, [[(n - 1) / 2] for n in height.shape], order=3).item()
    area = float(columns["relative_contact_area"]) * map_area
    numbers = {name: np.nan for name in _MEANINGLESS if name in columns} | {
        "contact_stiffness": force / -punch_approach / map_area,
        "elastic_energy": 0.5 * float((pressure * displacement).mean()),
        "contact_area": area,
        "contact_radius": np.sqrt(area / np.pi),
        "loaded_radius": 0.75 * force / (elasticity.modulus * in_the_middle)
        if elasticity.medium.is_homogeneous
        else np.nan,
    }
    if smooth := hertz_contact(height, contact, load):
        numbers["hertz_radius"] = (smooth["major"] * smooth["minor"]) ** 0.5
        numbers |= {f"hertz_{name}": smooth[name] for name in ("max_pressure", "approach")}
        if radii[0] == radii[1]:  # the theory is of a ball
            summits = summit_statistics(recover_roughness(height))
            rough = greenwood_tripp(force, radii[0], summits, contact_modulus=elasticity.modulus)
            numbers |= {f"greenwood_tripp_{name}": value for name, value in rough.items()}
    return numbers


def hertz_contact(body: xr.DataArray, numbers: xr.Dataset, load: int) -> dict[str, float]:
    """Return the `hertz_ellipse` of the smooth body on a half-space; empty without radii, or with layers."""
    radii = form_radii(body)
    if not radii or "bodies" in numbers.attrs:
        return {}
    return hertz_ellipse(float(numbers["force"][load]), radii, float(numbers["contact_modulus"]))
