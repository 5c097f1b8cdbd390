"""Numbers of a body of finite size: its contact, and Hertz's of the smooth body beside it."""

import numpy as np
import xarray as xr

from roughcontact.contact.dataset import influence_of, layers_of
from roughcontact.contact.free_boundary import FreeBody
from roughcontact.maps import roughness_of, spacing
from roughcontact.references.closed_forms import hertz_ellipse
from roughcontact.roughness.summits import summit_statistics
from roughcontact.statistics.theory import greenwood_tripp

THEORIES = ("area_persson", "area_xu", "area_bush_gibson_thomas", "area_greenwood_williamson")
_PASSAGE = ("gap_percolates", "critical_constriction")
_STIFFNESS_TOLERANCE = 1e-3  # of a punch; the error of its stiffness is about the square of that


def of_finite_body(statistics: xr.Dataset, contact: xr.Dataset) -> xr.Dataset:
    """Return the statistics of a finite body: stiffness, conductances, energy of its own, and its size.

    The stiffness by area is that of a flat punch on the points in contact (Barber 2003, Proc. R. Soc. A 459,
    53), the energy half the mean of pressure times displacement. `loaded_radius` is 3F/(4 E* u) with the
    displacement u in the middle. Theories of endless surfaces are NaN; with layers those of half-spaces and
    the conductances, too.
    """
    from scipy.ndimage import map_coordinates  # imported late, as few maps are bodies

    height, modulus = contact["height"], float(contact["contact_modulus"])
    steps, layers = spacing(height), layers_of(contact)
    map_area = height.size * steps[0] * steps[1]
    area = statistics["relative_contact_area"].values * map_area
    forces = contact["force"].values
    stiffness, energy, loaded_radius = (np.empty_like(area) for _ in range(3))
    for load, force in enumerate(forces):
        pressure = contact["pressure"].isel(load=load).values
        approach = float(contact["approach"][load])
        punch = np.where(pressure > 0, 0.0, -max(height.shape) * max(steps))
        body = FreeBody(punch, steps, modulus=modulus, influence=influence_of(contact), layers=layers)
        solution = body.solve(float(force), tolerance=_STIFFNESS_TOLERANCE)
        stiffness[load] = force / -solution.approach / map_area
        displacement = height.values - approach + contact["gap"].isel(load=load).values
        in_the_middle = map_coordinates(displacement, [[(n - 1) / 2] for n in height.shape], order=3)
        loaded_radius[load] = 0.75 * force / (modulus * in_the_middle.item())
        energy[load] = 0.5 * float((pressure * (height.values - approach)).mean())
    scale = xr.Variable("load", stiffness / statistics["contact_stiffness"].values)
    columns_ = {str(name): statistics[name].variable for name in statistics}
    columns_ |= {name: values * scale for name, values in columns_.items() if "conductance" in name}
    columns_ |= {name: values / scale for name, values in columns_.items() if name.endswith("_resistance")}
    undefined = (
        *THEORIES,
        "loading_stiffness",
        *(name for name in columns_ if layers and ("conductance" in name or name.endswith("_resistance"))),
        *(f"{passage}_{axis}" for passage in _PASSAGE for axis in "xy"),
    )
    columns_ |= {
        name: xr.full_like(columns_[name], np.nan, dtype=float) for name in undefined if name in columns_
    }
    columns = {
        "contact_stiffness": stiffness,
        "elastic_energy": energy,
        "contact_area": area,
        "contact_radius": np.sqrt(area / np.pi),
        "loaded_radius": loaded_radius,
    }
    if layers is not None:  # Hertz's theory is that of half-spaces
        columns["loaded_radius"][:] = np.nan
    elif "form_radius_x" in height.attrs:
        radii = float(height.attrs["form_radius_x"]), float(height.attrs["form_radius_y"])
        smooth = [hertz_ellipse(float(force), radii, modulus) for force in forces]
        columns["hertz_radius"] = np.array(
            [(ellipse["major"] * ellipse["minor"]) ** 0.5 for ellipse in smooth]
        )
        columns["hertz_max_pressure"] = np.array([ellipse["max_pressure"] for ellipse in smooth])
        columns["hertz_approach"] = np.array([ellipse["approach"] for ellipse in smooth])
        if radii[0] == radii[1]:  # the theory is of a ball
            summits = summit_statistics(roughness_of(height))
            rough = [greenwood_tripp(float(f), radii[0], summits, contact_modulus=modulus) for f in forces]
            for name in rough[0]:
                columns[f"greenwood_tripp_{name}"] = np.array([numbers[name] for numbers in rough])
    columns_ |= {name: xr.Variable("load", values) for name, values in columns.items()}
    return statistics.assign(columns_).assign_coords(force=("load", forces))


def hertz_axes(body: xr.DataArray, numbers: xr.Dataset, load: int) -> tuple[float, float] | None:
    """Return the semi-axes (x, y; m) of the contact of the smooth body (Hertz); None without one."""
    if "form_radius_x" not in body.attrs or "bodies" in numbers.attrs:
        return None
    radii = body.attrs["form_radius_x"], body.attrs["form_radius_y"]
    smooth = hertz_ellipse(float(numbers["force"][load]), radii, float(numbers["contact_modulus"]))
    axes = smooth["major"], smooth["minor"]
    return axes if radii[0] >= radii[1] else axes[::-1]
