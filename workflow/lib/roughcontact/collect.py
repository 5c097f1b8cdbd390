"""All surfaces (and cases) of a run in one dataset and one table."""

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact.storage import read_dataset
from roughcontact.variables import VARIABLES

# how a unit is spelled in a column's name; a number of unit 1 has none
_SUFFIX = {
    "m": "_m",
    "Pa": "_Pa",
    "m-1": "_per_m",
    "Pa-1": "_per_Pa",
    "Pa m-1": "_Pa_per_m",
    "J m-2": "_J_per_m2",
}

_LEADING = ("mean_pressure", "relative_pressure", "relative_contact_area", "relative_contact_area_pixels")


def collect_statistics(entries: list[dict]) -> xr.Dataset:
    """Return the statistics of all surfaces, and of all cases where there are any, in one dataset.

    Parameters
    ----------
    entries : list of dict
        ``{"surface": name, "case": name or None, "statistics": path}``, in the order they shall be listed.

    Returns
    -------
    Dataset, dims (surface, load, ...), or (case, surface, load, ...) where entries have cases. Labels are the
    coordinates `surface_name` (surface) and `case_name` (case). Surfaces may have different loads and bins: shorter ones
    are padded with NaN, and `mean_pressure` and the bins depend on the surface.
    """
    surfaces = list(dict.fromkeys(entry["surface"] for entry in entries))
    cases = list(dict.fromkeys(entry["case"] for entry in entries))
    place = {}
    for entry in entries:
        dataset = read_dataset(entry["statistics"])
        place[cases.index(entry["case"]), surfaces.index(entry["surface"])] = dataset.reset_coords()
    sizes = {}
    variables = {}
    for dataset in place.values():
        for name, size in dataset.sizes.items():
            sizes[name] = max(size, sizes.get(name, 0))
        variables |= {name: variable.dims for name, variable in dataset.variables.items()}
    # the bins' centres follow from their bounds, and a dimension's own coordinate cannot differ per surface
    variables = {name: dims for name, dims in variables.items() if name not in sizes}

    columns = {}
    for name, dims in variables.items():
        values = np.full((len(cases), len(surfaces), *(sizes[dim] for dim in dims)), np.nan)
        for (case, surface), dataset in place.items():
            if name in dataset:
                part = dataset[name].values
                values[(case, surface, *(slice(size) for size in part.shape))] = part
        columns[name] = (("case", "surface", *dims), values)
    collected = xr.Dataset(
        columns,
        coords={"surface_name": ("surface", np.array(surfaces, dtype=object))},
    ).set_coords(
        [name for name in ("mean_pressure", "pressure_bin_bounds", "gap_bin_bounds") if name in columns]
    )
    if cases == [None]:
        return collected.isel(case=0)
    return collected.assign_coords(case_name=("case", np.array(cases, dtype=object)))


def summary_table(statistics: xr.Dataset) -> pd.DataFrame:
    """Return one row per (case,) surface and load of `collect_statistics`, every column named with its unit.

    Densities stay in the netCDF file. Loads that only pad a shorter list are left out.
    """
    names = [
        name
        for name in statistics.variables
        if name not in ("surface_name", "case_name")
        and not {"pressure_bin", "gap_bin"} & set(statistics[name].dims)
    ]
    names.sort(key=lambda name: _LEADING.index(name) if name in _LEADING else len(_LEADING))
    labels = [name for name in ("case_name", "surface_name") if name in statistics.coords]
    order = [dim for dim in ("case", "surface", "load") if dim in statistics.dims]
    table = statistics[names].reset_coords().to_dataframe(dim_order=order).reset_index()
    frame = pd.DataFrame(
        {name.removesuffix("_name"): statistics[name].values[table[name[:-5]]] for name in labels}
    )
    for name in names:
        unit = VARIABLES[name][0]
        frame[name + ("" if unit == "1" else _SUFFIX[unit])] = table[name].to_numpy()
    frame = frame[np.isfinite(table["mean_pressure"].to_numpy())].reset_index(drop=True)
    # padding made counts and flags floating; without it they are whole numbers again
    for name in ("contact_clusters", "iterations", "converged"):
        if name in frame and frame[name].notna().all():
            frame[name] = frame[name].astype(int)
    return frame
