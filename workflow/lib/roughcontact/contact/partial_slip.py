"""Partial slip: traction, stick and slip of a contact under a tangential load, from two normal solves."""

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from roughcontact.arguments.bodies import check_poissons_ratio
from roughcontact.arguments.checking import check_periodic_solution, check_positive
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.si import as_si
from roughcontact.arguments.variables import describe
from roughcontact.contact.dataset import recorded_elasticity, recorded_problem
from roughcontact.contact.elasticity.energy import elastic_energy
from roughcontact.contact.loads import check_loads
from roughcontact.contact.response import linear_response
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import SettingsError

APPROXIMATION = (
    "Exact for profiles, and for similar bodies with Poisson's ratios of 0. On a rough ball with ratios of "
    "0.3 tractions differ by 5 % from those of a solver with both tangential components (ASPHER 0.1.3)."
)


@as_si
def partial_slip(
    contact: xr.Dataset,
    *,
    friction_coefficient: float,
    tangential_load: float | Sequence[float],
    poissons_ratio: float | None = None,
    threads: int = 1,
) -> xr.Dataset:
    """Return traction, stick and slip where a tangential load follows a constant normal one.

    By the theorem of Jäger and Ciavarella [1]_ [2]_ the traction is the friction coefficient times what the
    pressure exceeds that of the lower normal load P - Q/mu by, and the contact at that load sticks.

    Parameters
    ----------
    contact : Dataset
        of `solve_contact` at one load, with its maps, without hardness and layers.
    friction_coefficient : float
        mu, positive.
    tangential_load : float or sequence of float
        Q/(mu P), between 0 and 1; 1 is full slip.
    poissons_ratio : float, optional
        of both bodies: with it the tangential displacement and the energy of a cycle are known.
    threads : int
        of the solver.

    Returns
    -------
    Dataset
        over `tangential_load`: `shear_traction` (Pa) and `stick` (y, x), `stick_share` of the contact area,
        `tangential_error_bound` of the relative error of the traction in the energy norm, and with a
        Poisson's ratio `tangential_displacement` (m) of the bodies, that of a uniform traction left out,
        `tangential_stiffness` (Pa m-1) of further loading, and `dissipated_energy` (J m-2) in a cycle
        between Q and -Q [3]_.

    Raises
    ------
    SettingsError
        for a coefficient that is not positive, a load not between 0 and 1, or a contact that does not serve.

    References
    ----------
    .. [1] J. Jäger (1998), A new principle in contact mechanics, J. Tribol. 120, 677.
    .. [2] M. Ciavarella (1998), The generalized Cattaneo partial slip plane contact problem, Int. J. Solids
       Struct. 35, 2349.
    .. [3] R. D. Mindlin and H. Deresiewicz (1953), J. Appl. Mech. 20, 327; unloading is that of Masing.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> normal = solve_contact(rough_reference_surface(64), contact_modulus=1.0, mean_pressure=0.1)
    >>> slip = partial_slip(normal, friction_coefficient=0.3, tangential_load=[0.2, 1.0])
    >>> slip["shear_traction"].mean(("y", "x")).values.round(6), slip["stick_share"].values.round(2)
    (array([0.006, 0.03 ]), array([0.84, 0.  ]))
    """
    check_periodic_solution(contact)
    friction = check_positive("friction_coefficient", friction_coefficient, unit="relative terms")
    shares = check_loads("tangential_load", tangential_load, unit="mu times the normal load, 1 is full slip")
    if max(shares) > 1:
        text = f"tangential_load = {max(shares):g}: is Q/(mu P), at most 1, which is full slip"
        raise SettingsError(f"{text}; more the contact does not bear", keys=["tangential_load"])
    ratio = None if poissons_ratio is None else check_poissons_ratio("poissons_ratio", poissons_ratio)
    if contact.sizes["load"] != 1 or "hardness" in contact:
        property_ = "a hardness" if "hardness" in contact else f"{contact.sizes['load']} loads"
        raise SettingsError(
            f"the contact has {property_}: give an elastic one at a single load, contact.isel(load=[0])"
        )
    elasticity = recorded_elasticity(contact)
    if not elasticity.medium.is_homogeneous:
        raise SettingsError(
            "the contact has layers, whose tangential compliance is not in proportion to the normal one, as "
            "the theorem needs it; give one of half-spaces"
        )
    normal = contact.isel(load=0)
    load, height = float(normal["mean_pressure"]), contact["height"]
    pressure = normal["pressure"].values
    problem = recorded_problem(contact) | {"tolerance": contact.attrs["tolerance"], "threads": threads}

    def energy(field: np.ndarray) -> float:
        return elastic_energy(field, spacing(height), elasticity)

    rows = []
    total = energy(pressure)
    for share in shares:
        # at full slip there is no lower load: no pressure, and the gap of the first touch
        lower, lower_gap, error = np.zeros_like(pressure), height.values.max() - height.values, 0.0
        if share < 1:
            partner = solve_contact(height, mean_pressure=load * (1 - share), **problem).isel(load=0)
            lower, lower_gap = partner["pressure"].values, partner["gap"].values
            error = float(partner["error_bound"]) * math.sqrt(energy(lower))
        stick, change = lower > 0, energy(pressure - lower)
        bound = float(normal["error_bound"]) * math.sqrt(total) + error
        row = {
            "shear_traction": (("y", "x"), friction * (pressure - lower)),
            "stick": (("y", "x"), stick.astype(np.int8)),
            "stick_share": float(stick.sum() / (pressure > 0).sum()),
            # of uniform pressures, under a flat map, without any error
            "tangential_error_bound": bound / math.sqrt(change) if change > 0 else 0.0,
        }
        if ratio is not None:
            # by the gap, not by the approach, which depends on the rule for the mean displacement
            recovery = float(lower_gap.mean() - normal["gap"].mean())
            # tangential over normal compliance, Mindlin (1949)
            compliance = (2 - ratio) / (2 * (1 - ratio))
            row["tangential_displacement"] = friction * compliance * recovery
            # four times a cycle points slip by mu times the compliance times their gap at the lower load
            slip_volume = float((pressure * lower_gap)[~stick].sum()) / stick.size
            row["dissipated_energy"] = 4 * friction**2 * compliance * slip_volume
            row["tangential_stiffness"] = 0.0  # of full slip
            if stick.any():
                response = linear_response(stick, spacing(height), elasticity, threads=threads)[0]
                row["tangential_stiffness"] = 1 / (compliance * response) if response > 0 else math.inf
        rows.append(xr.Dataset(row, coords=height.coords))
    slip = xr.concat(rows, dim=xr.Variable("tangential_load", shares), coords="minimal", compat="override")
    return describe(slip.assign_attrs(approximation=APPROXIMATION))
