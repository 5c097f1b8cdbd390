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
_PASSAGES = [f"{passage}_{axis}" for passage in ("gap_percolates", "critical_constriction") for axis in "xy"]
_STIFFNESS_TOLERANCE = 1e-3  # of a punch; the error of its stiffness is about the square of that


def of_finite_body(statistics: xr.Dataset, contact: xr.Dataset) -> xr.Dataset:
    """Return the statistics of a finite body: stiffness, conductances, energy of its own, and its size.

    The stiffness by area is that of a flat punch on the points in contact (Barber 2003, Proc. R. Soc. A 459,
    53), the energy half the mean of pressure times displacement. `loaded_radius` is 3F/(4 E* u) with the
    displacement u in the middle. Theories of endless surfaces are NaN; with layers those of half-spaces and
    the conductances, too.
    """
    from scipy.ndimage import map_coordinates  # imported late, as few maps are bodies

    height, modulus, layers = contact["height"], float(contact["contact_modulus"]), layers_of(contact)
    steps, forces = spacing(height), contact["force"].values
    map_area = height.size * steps[0] * steps[1]
    names = () if layers else ("form_radius_x", "form_radius_y")  # Hertz's theory is that of half-spaces
    radii = [float(height.attrs[name]) for name in names if name in height.attrs]
    summits = summit_statistics(roughness_of(height)) if radii and radii[0] == radii[1] else None
    rows = []
    for load, force in enumerate(map(float, forces)):
        pressure = contact["pressure"].isel(load=load).values
        approach = float(contact["approach"][load])
        punch = np.where(pressure > 0, 0.0, -max(height.shape) * max(steps))
        body = FreeBody(punch, steps, modulus, influence=influence_of(contact), layers=layers)
        solution = body.solve(force, tolerance=_STIFFNESS_TOLERANCE)
        displacement = height.values - approach + contact["gap"].isel(load=load).values
        in_the_middle = map_coordinates(displacement, [[(n - 1) / 2] for n in height.shape], order=3)
        area = float(statistics["relative_contact_area"][load]) * map_area
        numbers = {
            "contact_stiffness": force / -solution.approach / map_area,
            "elastic_energy": 0.5 * float((pressure * (height.values - approach)).mean()),
            "contact_area": area,
            "contact_radius": np.sqrt(area / np.pi),
            "loaded_radius": np.nan if layers else 0.75 * force / (modulus * in_the_middle.item()),
        }
        if radii:
            smooth = hertz_ellipse(force, (radii[0], radii[1]), modulus)
            numbers["hertz_radius"] = (smooth["major"] * smooth["minor"]) ** 0.5
            numbers |= {f"hertz_{name}": smooth[name] for name in ("max_pressure", "approach")}
        if summits:  # the theory is of a ball
            rough = greenwood_tripp(force, radii[0], summits, contact_modulus=modulus)
            numbers |= {f"greenwood_tripp_{name}": value for name, value in rough.items()}
        rows.append(numbers)
    columns = {name: xr.Variable("load", [row[name] for row in rows]) for name in rows[0]}
    scale = columns["contact_stiffness"] / statistics["contact_stiffness"].variable
    before = {str(name): statistics[name].variable for name in statistics}
    gas = before.pop("gas_conductance", None)
    transport = {name: values * scale for name, values in before.items() if "conductance" in name}
    transport |= {name: values / scale for name, values in before.items() if name.endswith("_resistance")}
    if gas is not None and "joint_conductance" in before:  # of gas and film nothing is scaled
        film = 1 / (before["joint_conductance"] - gas) - before["thermal_resistance"]
        transport["joint_conductance"] = 1 / (transport["thermal_resistance"] + film) + gas
    undefined = {*before} & {*THEORIES, *_PASSAGES, "loading_stiffness", *(transport if layers else ())}
    blank = {name: xr.full_like(before[name], np.nan, dtype=float) for name in undefined}
    return statistics.assign(transport | blank | columns).assign_coords(force=("load", forces))


def hertz_axes(body: xr.DataArray, numbers: xr.Dataset, load: int) -> tuple[float, float] | None:
    """Return the semi-axes (x, y; m) of the contact of the smooth body (Hertz); None without one."""
    if "form_radius_x" not in body.attrs or "bodies" in numbers.attrs:
        return None
    radii = body.attrs["form_radius_x"], body.attrs["form_radius_y"]
    smooth = hertz_ellipse(float(numbers["force"][load]), radii, float(numbers["contact_modulus"]))
    axes = smooth["major"], smooth["minor"]
    return axes if radii[0] >= radii[1] else axes[::-1]
