"""The four headline quantities of the error budget, computed from a solution on their own."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from roughcontact.statistics.contact_geometry import relative_contact_area

# names of `roughcontact.variables`
QUANTITIES = ("relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure")


def headline(contact: xr.Dataset) -> xr.Dataset:
    """Return the four headline quantities of each load, as `contact_statistics` defines them.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.

    Returns
    -------
    Dataset
        dim load: `relative_contact_area` (1), `mean_gap` (m), `max_pressure` and `mean_contact_pressure`
        (Pa).

    Examples
    --------
    >>> import xarray as xr
    >>> fields = {"pressure": [[[0.0, 3.0, 1.0, 0.0]]], "gap": [[[0.5, 0.0, 0.0, 0.3]]]}
    >>> found = headline(xr.Dataset({name: (("load", "y", "x"), v) for name, v in fields.items()}))
    >>> [round(found[name].item(), 3) for name in ("mean_gap", "max_pressure", "mean_contact_pressure")]
    [0.2, 3.0, 2.0]
    """
    rows = [_one_load(*fields) for fields in fields_of(contact)]
    return xr.Dataset({name: ("load", [row[name] for row in rows]) for name in QUANTITIES})


def fields_of(contact: xr.Dataset) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield pressure and gap of each load of a solution.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.

    Yields
    ------
    pressure : array (ny, nx), Pa
    gap : array (ny, nx), m
    """
    yield from zip(contact["pressure"].values, contact["gap"].values, strict=True)


def _one_load(pressure: np.ndarray, gap: np.ndarray) -> dict[str, float]:
    """Return the four headline quantities of one load."""
    touching = pressure > 0
    return {
        "relative_contact_area": relative_contact_area(touching),
        "mean_gap": gap[~touching].sum() / gap.size,
        "max_pressure": pressure.max(),
        "mean_contact_pressure": pressure[touching].mean(),
    }
