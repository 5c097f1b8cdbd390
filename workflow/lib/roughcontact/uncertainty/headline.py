"""The four numbers that the error budget is for, counted in a solution without all the others."""

import numpy as np
import xarray as xr

from roughcontact.statistics.contact_geometry import relative_contact_area

# names of `roughcontact.variables`
QUANTITIES = ("relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure")


def headline(contact: xr.Dataset) -> xr.Dataset:
    """Return the four quantities of each load, as `contact_statistics` defines them.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.

    Returns
    -------
    Dataset, dim load: `relative_contact_area` (1), `mean_gap` (m), `max_pressure` and `mean_contact_pressure`
    (Pa)
    """
    rows = [_one_load(*fields) for fields in fields_of(contact)]
    return xr.Dataset({name: ("load", [row[name] for row in rows]) for name in QUANTITIES})


def fields_of(contact: xr.Dataset):
    """Yield (pressure, gap), arrays (ny, nx) in Pa and m, of each load of a solution."""
    yield from zip(contact["pressure"].values, contact["gap"].values, strict=True)


def _one_load(pressure: np.ndarray, gap: np.ndarray) -> dict:
    """Return the four quantities of one load."""
    touching = pressure > 0
    return {
        "relative_contact_area": relative_contact_area(touching),
        "mean_gap": gap[~touching].sum() / gap.size,
        "max_pressure": pressure.max(),
        "mean_contact_pressure": pressure[touching].mean(),
    }
