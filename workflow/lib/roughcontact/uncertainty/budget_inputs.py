"""What the error budget takes from a solution, so that its fields need not be kept."""

from collections.abc import Collection

import numpy as np
import xarray as xr

from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.statistics.sealing.percolation import half_way_levels
from roughcontact.uncertainty.headline import headline_names, iterate_fields
from roughcontact.uncertainty.sample import constrictions_in_grooves
from roughcontact.uncertainty.scales import APPROACH, CONDUCTANCE, GAP
from roughcontact.uncertainty.solver import solver_uncertainty


def budget_inputs(
    contact: xr.Dataset, statistics: xr.Dataset | None = None, grooves: Collection[str] | None = None
) -> xr.Dataset:
    """Return what the error budget takes from a solution with its fields, along `load`.

    Headline quantities and answers, `{name}_uncertainty` of the solver, the texture aspect ratio `Str` of the
    map, and `{name}_half_way`, the constrictions (m) of gap paths half as long as the map, of the
    `constrictions_in_grooves`, here `grooves`.
    """
    if statistics is None:
        statistics = contact_statistics(contact, flow="never", stress="never")
    plain = {name: statistics[name].values for name in headline_names(statistics)}
    # of full contact it is infinite
    plain[CONDUCTANCE] = np.where(np.isfinite(plain[CONDUCTANCE]), plain[CONDUCTANCE], np.nan)
    widths = solver_uncertainty(contact, energy=statistics["elastic_energy"].values)
    widths |= {APPROACH: widths[GAP]} if APPROACH in plain else {}  # one offset moves both
    plain |= {f"{name}_uncertainty": width for name, width in widths.items()}
    if grooves is None:
        grooves = constrictions_in_grooves(contact["height"])
    if grooves:
        open_gaps = (np.where(pressure > 0, 0.0, gap) for pressure, gap in iterate_fields(contact))
        levels = [half_way_levels(gap) for gap in open_gaps]
        plain |= {f"{name}_half_way": np.array([level[name] for level in levels]) for name in grooves}
    inputs = contact[["contact_modulus", "mean_pressure"]]
    inputs = inputs.assign({name: ("load", values) for name, values in plain.items()})
    return inputs.assign(Str=((), float(statistics["Str"])))
