"""What the error budget takes from a solution, so that its fields need not be kept."""

import numpy as np
import xarray as xr

from roughcontact.sealing.percolation import half_way_levels
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.uncertainty.headline import fields_of
from roughcontact.uncertainty.inputs import STIFFNESS
from roughcontact.uncertainty.scales import ANSWERS, CONDUCTANCE, CONSTRICTIONS, QUANTITIES
from roughcontact.uncertainty.solver import solver_uncertainty


def budget_inputs(contact: xr.Dataset, statistics: xr.Dataset | None = None) -> xr.Dataset:
    """Return what the error budget takes from a solution.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.
    statistics : Dataset, optional
        `contact_statistics` of the same loads, computed here where they are not given.

    Returns
    -------
    Dataset
        dim load: `QUANTITIES` and `ANSWERS`, `index_of_the_peak` (of the point of the largest pressure,
        counted row by row), constrictions of paths half as long as the map, `loading_stiffness`, and
        `{name}_uncertainty` of the solver.

    Examples
    --------
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> contact = solve_contact(height, contact_modulus=1.0, mean_pressure=[0.1])
    >>> budget_inputs(contact)["relative_contact_area"].round(2).values
    array([0.34])
    """
    if statistics is None:
        statistics = contact_statistics(contact, flow="never", stress="never")
    plain = {name: statistics[name].values for name in (*QUANTITIES, *ANSWERS)}
    # of full contact it is infinite
    plain[CONDUCTANCE] = np.where(np.isfinite(plain[CONDUCTANCE]), plain[CONDUCTANCE], np.nan)
    plain[STIFFNESS] = statistics[STIFFNESS if STIFFNESS in statistics else "contact_stiffness"].values
    of_solver = solver_uncertainty(contact, energy=statistics["elastic_energy"].values)
    plain |= {f"{name}_uncertainty": of_solver[name].values for name in QUANTITIES}
    plain["index_of_the_peak"] = np.array([pressure.argmax() for pressure, _ in fields_of(contact)])
    for name, values in half_length_constrictions(contact).items():
        plain[name] = values
    return xr.Dataset(
        {name: ("load", values) for name, values in plain.items()}
        | {"contact_modulus": contact["contact_modulus"].variable},
        coords={"mean_pressure": contact["mean_pressure"].variable},
        attrs=contact.attrs,
    )


def half_length_constrictions(contact: xr.Dataset) -> dict[str, np.ndarray]:
    """Return the critical constrictions (load; m) of gap paths half as long as the map.

    `{name}_half_way`, as `roughcontact.sealing.percolation.half_way_levels` defines it.

    Examples
    --------
    >>> fields = {"pressure": [[[0.0, 3.0], [0.0, 0.0]]], "gap": [[[0.5, 0.0], [0.2, 0.3]]]}
    >>> contact = xr.Dataset({name: (("load", "y", "x"), values) for name, values in fields.items()})
    >>> half_length_constrictions(contact)["critical_constriction_y_half_way"].tolist()
    [0.5]
    """
    rows = [half_way_levels(np.where(pressure > 0, 0.0, gap)) for pressure, gap in fields_of(contact)]
    return {f"{name}_half_way": np.array([row[name] for row in rows]) for name in CONSTRICTIONS}
