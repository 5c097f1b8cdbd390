"""Numbers of a body of finite size: its contact, and Hertz's of the smooth body beside it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.finite_body import form_radii, recover_roughness
from roughcontact.arguments.maps import spacing
from roughcontact.contact.dataset import carrying, recorded_elasticity
from roughcontact.contact.elasticity.closed_forms import hertz, hertz_ellipse
from roughcontact.contact.free_boundary import FreeBody
from roughcontact.statistics.theory import SEPARATIONS, summit_moment
from roughcontact.surface.roughness.summits import summit_statistics

# what no body of finite size has, and none with layers
_MEANINGLESS = (
    *(f"{passage}_{axis}" for passage in ("gap_percolates", "critical_constriction") for axis in "xy"),
    *("loading_stiffness", "thermal_conductance", "electrical_conductance", "conductance_error_bound"),
)
_RINGS, _CONVERGED = 150, 1e-10  # of a rough ball after Greenwood and Tripp
_STIFFNESS_TOLERANCE = 1e-3  # of a punch; the error of its stiffness is about the square of that


def finite_body_columns(columns: Mapping[str, Any], contact: xr.Dataset, load: int) -> dict[str, Any]:
    """Return the numbers of one load of a finite body that differ from those of a periodic map, and its size.

    The stiffness by area is that of a flat punch on the points in contact (Barber 2003, Proc. R. Soc. A 459,
    53), the energy half the mean of pressure times displacement. `loaded_radius` is 3F/(4 E* u) with the
    displacement u in the middle, NaN with layers.
    """
    from scipy.ndimage import map_coordinates  # imported late, as few maps are bodies

    height, elasticity = contact["height"], recorded_elasticity(contact)
    radii = form_radii(height.attrs)
    steps, force, approach = spacing(height), float(contact["force"][load]), float(contact["approach"][load])
    pressure, map_area = contact["pressure"].isel(load=load).values, height.size * steps[0] * steps[1]
    # a flat punch in the shape of the contact, its surroundings too low to touch
    punch = np.where(pressure > 0, 0.0, -max(height.shape) * max(steps))
    body = FreeBody(punch, steps, elasticity)
    # the response of a fixed contact is linear: any force serves
    punch_approach = body.solve(force, tolerance=_STIFFNESS_TOLERANCE).approach
    displacement = height.values - approach + contact["gap"].isel(load=load).values
    at_hardness = carrying(pressure, float(contact.get("hardness", np.inf)))
    if at_hardness.any():  # the depth of flow is no elastic displacement
        displacement[at_hardness] = body.elastic_displacement(pressure)[at_hardness]
    in_the_middle = map_coordinates(displacement, [[(n - 1) / 2] for n in height.shape], order=3).item()
    area, homogeneous = float(columns["relative_contact_area"]) * map_area, elasticity.medium.is_homogeneous
    numbers = {name: np.nan for name in _MEANINGLESS if name in columns} | {
        "contact_stiffness": force / -punch_approach / map_area,
        "elastic_energy": 0.5 * float((pressure * displacement).mean()),
        "mutual_approach": float(height.max()) - approach,
        "contact_area": area,
        "contact_radius": np.sqrt(area / np.pi),
        "loaded_radius": 0.75 * force / (elasticity.modulus * in_the_middle) if homogeneous else np.nan,
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
    radii = form_radii(body.attrs)
    if not radii or "bodies" in numbers.attrs:
        return {}
    return hertz_ellipse(float(numbers["force"][load]), radii, float(numbers["contact_modulus"]))


def greenwood_tripp(
    force: float, radius: float, summits: dict[str, float], *, contact_modulus: float
) -> dict[str, float]:
    """Return the contact of a rough ball after Greenwood and Tripp [1]_: independent summits on a soft ball.

    The nominal pressure p(r) = (4/3) E* η √β s^(3/2) F_{3/2}(t) presses the summits, of density η, mean
    radius β and spread s, by the separation s t(r) = r²/(2R) - δ + w(r), w the displacement of the
    half-space under p. Rings of constant p, Powell's hybrid method.

    Parameters
    ----------
    force : float, N
    radius : float, m
        of the ball.
    summits : dict
        of the roughness without the ball, as `roughness.summits.summit_statistics` returns it.
    contact_modulus : float, Pa

    Returns
    -------
    dict
        `contact_area` (m2) of all summits, NaN beyond that of the loaded circle; `max_pressure` (Pa),
        nominal, in the middle; `loaded_radius` (m), (3/8) F/∫ p dr, which is that of the contact where p is
        Hertz's. NaN for a map without summits, or none above rounding.

    References
    ----------
    .. [1] Greenwood and Tripp (1967), J. Appl. Mech. 34, 153; Johnson (1985), Contact Mechanics, 13.5.

    Examples
    --------
    A spread of 5 % of Hertz's approach lowers the largest pressure by about 7 % (Johnson, μ = 4):

    >>> density = 4 / (8 / 3 * 0.05 * np.sqrt(2 * 1e-3))
    >>> summits = {"density": density, "mean_radius": 1e-3, "height_std": 0.05}
    >>> rough = greenwood_tripp(4 / 3, 1.0, summits, contact_modulus=1.0)
    >>> print(f"{rough['max_pressure'] / (2 / np.pi):.2f}")
    0.93
    """
    from scipy.optimize import root
    from scipy.special import ellipe, ellipk

    density, tip, spread = (summits[name] for name in ("density", "mean_radius", "height_std"))
    if not (spread > 0 and tip > 0):
        return dict.fromkeys(("contact_area", "max_pressure", "loaded_radius"), np.nan)
    smooth = hertz(force, radius, contact_modulus)
    # farther out than Hertz's circle, by what summits of the tail still touch
    reach = np.sqrt(1.5 * smooth["contact_radius"] ** 2 + 12 * radius * spread)
    edges = reach * np.linspace(0, 1, _RINGS + 1)
    r, areas = (edges[1:] + edges[:-1]) / 2, np.pi * np.diff(edges**2)
    # displacement by a disc of constant pressure, in complete elliptic integrals (Johnson 1985, section 3.4)
    larger = np.maximum(r[:, None], edges)
    m = (np.minimum(r[:, None], edges) / larger) ** 2
    discs = larger * (ellipe(m) - np.where(edges > r[:, None], 0.0, (1 - m) * ellipk(m)))
    influence = np.diff(4 / (np.pi * contact_modulus * spread) * discs, axis=1)
    scale = 4 / 3 * contact_modulus * density * np.sqrt(tip) * spread**1.5
    # never zero, so that the first guess has a logarithm
    share = np.sqrt(np.maximum(1 - (r / smooth["contact_radius"]) ** 2, 1e-6))
    guess = smooth["max_pressure"] * (smooth["contact_radius"] / edges[-1]) ** 2 * share / scale
    # the table, continued to where every summit is pressed deep
    separations = np.concatenate([-np.geomspace(1e6, 8, 400)[:-1], SEPARATIONS])
    t = np.interp(-np.log(guess), -np.log(summit_moment(1.5, separations)), separations)
    bulk = r**2 / (2 * radius * spread)
    approach = bulk[0] + influence[0] @ (scale * summit_moment(1.5, t)) - t[0]

    def excess(solution: np.ndarray) -> np.ndarray:
        pressure = scale * summit_moment(1.5, solution[:-1])
        balance = solution[:-1] - bulk + solution[-1] - influence @ pressure
        return np.append(balance, areas @ pressure / force - 1)

    def jacobian(solution: np.ndarray) -> np.ndarray:
        slope = 1.5 * scale * summit_moment(0.5, solution[:-1])
        rings = np.hstack([np.eye(_RINGS) + influence * slope, np.ones((_RINGS, 1))])
        # one Newton step solves all rings and the approach together
        return np.vstack([rings, np.append(-areas * slope / force, 0.0)])

    solution = root(excess, np.append(t, approach), jac=jacobian, tol=_CONVERGED)
    # it does not converge where rounding hides the summits
    t = np.where(solution.success, solution.x[:-1], np.nan)
    pressure = scale * summit_moment(1.5, t)
    loaded_radius = float(3 * force / (8 * (pressure @ np.diff(edges))))
    area = float(np.pi * density * tip * spread * (areas @ summit_moment(1.0, t)))
    return {
        "contact_area": area if area <= np.pi * loaded_radius**2 else np.nan,
        "max_pressure": float(pressure[0]),
        "loaded_radius": loaded_radius,
    }
