"""Numbers of a body of finite size: its contact, and Hertz's of the smooth body beside it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.dataset import elasticity_of
from roughcontact.contact.free_boundary import FreeBody
from roughcontact.maps import radii_of, roughness_of, spacing
from roughcontact.references.closed_forms import hertz_ellipse
from roughcontact.roughness.summits import summit_statistics
from roughcontact.statistics.theory import greenwood_tripp

THEORIES = ("area_persson", "area_xu", "area_bush_gibson_thomas", "area_greenwood_williamson")
# what no body of finite size has, and none with layers
_MEANINGLESS = (
    *(f"{passage}_{axis}" for passage in ("gap_percolates", "critical_constriction") for axis in "xy"),
    *("loading_stiffness", "thermal_conductance", "electrical_conductance"),
)
_STIFFNESS_TOLERANCE = 1e-3  # of a punch; the error of its stiffness is about the square of that


def of_finite_body(columns: Mapping[str, Any], contact: xr.Dataset, load: int) -> dict[str, Any]:
    """Return the numbers of one load of a finite body that differ from those of a periodic map, and its size.

    The stiffness by area is that of a flat punch on the points in contact (Barber 2003, Proc. R. Soc. A 459,
    53), the energy half the mean of pressure times displacement. `loaded_radius` is 3F/(4 E* u) with the
    displacement u in the middle, NaN with layers.
    """
    from scipy.ndimage import map_coordinates  # imported late, as few maps are bodies

    height, elasticity, radii = contact["height"], elasticity_of(contact), radii_of(contact["height"])
    steps, force, approach = spacing(height), float(contact["force"][load]), float(contact["approach"][load])
    pressure, map_area = contact["pressure"].isel(load=load).values, height.size * steps[0] * steps[1]
    punch = np.where(pressure > 0, 0.0, -max(height.shape) * max(steps))
    punch_approach = FreeBody(punch, steps, elasticity).solve(force, tolerance=_STIFFNESS_TOLERANCE).approach
    displacement = height.values - approach + contact["gap"].isel(load=load).values
    in_the_middle = map_coordinates(displacement, [[(n - 1) / 2] for n in height.shape], order=3).item()
    area = float(columns["relative_contact_area"]) * map_area
    numbers = {name: np.nan for name in _MEANINGLESS if name in columns} | {
        "contact_stiffness": force / -punch_approach / map_area,
        "elastic_energy": 0.5 * float((pressure * (height.values - approach)).mean()),
        "contact_area": area,
        "contact_radius": np.sqrt(area / np.pi),
        "loaded_radius": np.nan if elasticity.layers else 0.75 * force / (elasticity.modulus * in_the_middle),
    }
    if smooth := hertz_contact(height, contact, load):
        numbers["hertz_radius"] = (smooth["major"] * smooth["minor"]) ** 0.5
        numbers |= {f"hertz_{name}": smooth[name] for name in ("max_pressure", "approach")}
        if radii[0] == radii[1]:  # the theory is of a ball
            summits = summit_statistics(roughness_of(height))
            rough = greenwood_tripp(force, radii[0], summits, contact_modulus=elasticity.modulus)
            numbers |= {f"greenwood_tripp_{name}": value for name, value in rough.items()}
    return {**columns, **numbers}


def hertz_contact(body: xr.DataArray, numbers: xr.Dataset, load: int) -> dict[str, float]:
    """Return the `hertz_ellipse` of the smooth body on a half-space; empty without radii, or with layers."""
    radii = radii_of(body)
    if not radii or "bodies" in numbers.attrs:
        return {}
    return hertz_ellipse(float(numbers["force"][load]), radii, float(numbers["contact_modulus"]))
